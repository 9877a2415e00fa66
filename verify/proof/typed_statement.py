"""Statements, with their typed texts and the trees of these."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

import sympy as sp
from sympy.core.function import AppliedUndef

from longwave.derive.algebra import formula_tree as syntax
from longwave.derive.algebra.formula_text import CONSTANTS, Parser, Vocabulary, tokens
from longwave.derive.algebra.formula_tree import FormulaTree

from .domains import Domain
from .text_names import FUNCTIONS


@dataclass(frozen=True)
class StatementTexts:
    """Typed texts of a statement by part; a certificate states exactly these texts."""

    variables: tuple[str, ...]
    equations: tuple[str, ...]
    solutions: tuple[str, ...]
    parameters: tuple[str, ...] = ()
    domain: tuple[str, ...] = ()

    def with_values(self, values: Mapping[str, str]) -> StatementTexts:
        """Return the texts with formulas as the definitions of parameters that were free.

        >>> texts = StatementTexts(("x",), ("u_x - b",), ("u = x",), ("b: b>0",))
        >>> texts.with_values({"b": "1"}).parameters
        ('b = 1',)
        """
        others = (text for text in self.parameters if declared_name(text) not in values)
        definitions = (f"{name} = {text}" for name, text in values.items())
        return replace(self, parameters=(*definitions, *others))


def names_in(formula: FormulaTree) -> set[str]:
    """Return the names and unknowns in a formula."""
    return {node.name for node in formula.nodes() if isinstance(node, syntax.Name | syntax.Unknown)}


def declared_name(text: str) -> str:
    """Return the name that a text such as ``k: k>0`` or ``k = 2`` declares."""
    return text.replace("=", ":").partition(":")[0].strip()


@dataclass(frozen=True)
class StatementTrees:
    """Trees of the texts: left-hand sides, and the formulas of unknowns and of defined names."""

    variables: tuple[str, ...]
    equations: tuple[FormulaTree, ...]
    solutions: Mapping[str, FormulaTree]
    definitions: Mapping[str, FormulaTree]

    @property
    def formulas(self) -> tuple[FormulaTree, ...]:
        """All formulas of the statement."""
        return (*self.equations, *self.solutions.values(), *self.definitions.values())

    @property
    def names(self) -> set[str]:
        """Names of the variables and of the free parameters."""
        nodes = (node for formula in self.formulas for node in formula.nodes())
        names = {node.name for node in nodes if isinstance(node, syntax.Name)} | {*self.variables}
        return names - {*self.definitions, *CONSTANTS}

    def with_values(self, values: Mapping[str, str]) -> StatementTrees:
        """Return the trees with parameters defined by formulas, given as text."""
        trees = {name: tree_of(text) for name, text in values.items()}
        return replace(self, definitions={**self.definitions, **trees})

    def changed(self, image: Callable[[FormulaTree], FormulaTree]) -> StatementTrees:
        """Return the trees with ``image`` applied to each formula."""
        equations = tuple(map(image, self.equations))
        solutions = {name: image(formula) for name, formula in self.solutions.items()}
        definitions = {name: image(formula) for name, formula in self.definitions.items()}
        return StatementTrees(self.variables, equations, solutions, definitions)

    def elementary(self, node: FormulaTree) -> FormulaTree | None:
        """Return sin, tanh and the like for a Jacobi function of parameter 0 or 1, else None."""
        if not (isinstance(node, syntax.Call) and len(node.parts) == 2):
            return None
        z, m = node.parts
        parameter = syntax.rational(syntax.mapped(m, self.meaning))
        name = ELEMENTARY_JACOBI.get((node.name, parameter))
        if name is None:
            return None
        return (
            syntax.Call((syntax.mapped(z, self.elementary),), name)
            if name
            else syntax.Number(Fraction(1))
        )

    def meaning(self, node: FormulaTree) -> FormulaTree | None:
        """Return the formula of a defined name; None for anything else."""
        if isinstance(node, syntax.Name) and node.name in self.definitions:
            return syntax.mapped(self.definitions[node.name], self.meaning)
        return None


ELEMENTARY_JACOBI: Mapping[tuple[str, Fraction | int | None], str] = {
    ("jacobi_sn", 0): "sin",
    ("jacobi_cn", 0): "cos",
    ("jacobi_dn", 0): "",
    ("jacobi_sn", 1): "tanh",
    ("jacobi_cn", 1): "sech",
    ("jacobi_dn", 1): "sech",
}
"""Jacobi functions of parameter 0 or 1; "" means the constant 1."""


def typed_case(
    texts: StatementTexts, trees: StatementTrees, values: Mapping[str, str]
) -> tuple[StatementTexts, StatementTrees]:
    """Substitute values for parameters; Jacobi functions of parameter 0 or 1 become elementary."""
    texts, plain = texts.with_values(values), trees.with_values(values)
    changed = plain.changed(lambda formula: syntax.mapped(formula, plain.elementary))
    trees = replace(changed, definitions=plain.definitions)
    equations, solutions = [*texts.equations], [*texts.solutions]
    for place, (old, new) in enumerate(zip(plain.equations, trees.equations, strict=True)):
        if new != old:
            equations[place] = syntax.formula_text(new)
    for place, (name, formula) in enumerate(trees.solutions.items()):
        if formula != plain.solutions[name]:
            heading = solutions[place].partition("=")[0].strip()
            solutions[place] = f"{heading} = {syntax.formula_text(formula)}"
    return replace(texts, equations=tuple(equations), solutions=tuple(solutions)), trees


def tree_of(text: str, functions: Iterable[str] = ()) -> FormulaTree:
    """Parse a formula in any names; ``functions`` are names of functions of one argument."""
    own = {name: (sp.Function(name), 1) for name in functions}
    words = Vocabulary({**FUNCTIONS, **own}, unknown_name=sp.Symbol)
    return Parser(text, tokens(text), words, "value").whole()


@dataclass(frozen=True)
class Statement:
    """Statement that the ``solutions`` make all ``equations`` vanish on the ``domains``.

    ``equations`` are left-hand sides in the applied unknowns; ``solutions`` maps these to formulas.
    ``domains`` has the variables and parameters with a restricted domain.  ``divisors`` are the
    expressions by which the texts divide or whose logarithm they take.  ``solve_for`` has the
    parameters to solve for; all others are arbitrary.  ``texts`` and ``trees`` are the typed form.
    ``complexes`` are parameters that may be complex.  Their symbols are real, and a proof covers
    complex values only if the checker accepts it for them.  ``functions`` are the names of
    arbitrary functions.  ``weak`` asks for weak solutions (`verify.proof.weak`).
    """

    name: str
    equations: tuple[sp.Expr, ...]
    solutions: Mapping[AppliedUndef, sp.Expr]
    domains: Mapping[sp.Symbol, Domain]
    divisors: tuple[sp.Expr, ...] = ()
    solve_for: tuple[sp.Symbol, ...] = ()
    texts: StatementTexts = field(default=StatementTexts((), (), ()), compare=False)
    trees: StatementTrees = field(default=StatementTrees((), (), {}, {}), compare=False)
    complexes: tuple[str, ...] = ()
    functions: tuple[str, ...] = ()
    weak: bool = False

    @property
    def variables(self) -> tuple[sp.Symbol, ...]:
        """The independent variables."""
        return tuple(next(iter(self.solutions)).args)

    @property
    def expressions(self) -> tuple[sp.Expr, ...]:
        """Equations, formulas and divisors."""
        return (*self.equations, *self.solutions.values(), *self.divisors)

    @property
    def free_symbols(self) -> set[sp.Symbol]:
        """Symbols of the equations, formulas and divisors."""
        return {symbol for formula in self.expressions for symbol in formula.free_symbols}

    @property
    def domain_symbols(self) -> set[sp.Symbol]:
        """Symbols in the ends of domains."""
        return {symbol for domain in self.domains.values() for symbol in domain.symbols}

    def with_values(self, values: Mapping[sp.Symbol, sp.Expr]) -> Statement:
        """Return the statement with values for symbols in the equations, formulas and divisors."""
        equations = tuple(equation.xreplace(values) for equation in self.equations)
        solutions = {u: formula.xreplace(values) for u, formula in self.solutions.items()}
        divisors = tuple(divisor.xreplace(values) for divisor in self.divisors)
        return replace(self, equations=equations, solutions=solutions, divisors=divisors)
