"""Statements, and the texts of them as they were typed, with their trees."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

import sympy as sp
from sympy.core.function import AppliedUndef

from longwave.derive.algebra.formula_text import CONSTANTS, Parser, Vocabulary, tokens
from longwave.derive.algebra.formula_tree import (
    Call,
    FormulaTree,
    Name,
    Number,
    formula_text,
    mapped,
    rational,
)

from .domains import Domain
from .text_names import FUNCTIONS


@dataclass(frozen=True)
class StatementTexts:
    """Typed texts of a statement, part by part; a certificate holds these and no others."""

    variables: tuple[str, ...]
    equations: tuple[str, ...]
    solutions: tuple[str, ...]
    parameters: tuple[str, ...] = ()
    domain: tuple[str, ...] = ()

    def with_values(self, values: Mapping[str, str]) -> StatementTexts:
        """Return the texts with parameters that stand for formulas in the place of any values.

        >>> texts = StatementTexts(("x",), ("u_x - b",), ("u = x",), ("b: b>0",))
        >>> texts.with_values({"b": "1"}).parameters
        ('b = 1',)
        """
        kept = (
            p
            for p in self.parameters
            if p.replace("=", ":").partition(":")[0].strip() not in values
        )
        made = (f"{name} = {text}" for name, text in values.items())
        return replace(self, parameters=(*made, *kept))


@dataclass(frozen=True)
class StatementTrees:
    """The formulas of the texts: what must be 0, and what unknowns and defined names stand for."""

    variables: tuple[str, ...]
    equations: tuple[FormulaTree, ...]
    solutions: Mapping[str, FormulaTree]
    definitions: Mapping[str, FormulaTree]

    @property
    def formulas(self) -> tuple[FormulaTree, ...]:
        """All of them."""
        return (*self.equations, *self.solutions.values(), *self.definitions.values())

    @property
    def names(self) -> set[str]:
        """The variables, and the parameters that stand for values."""
        nodes = (node for formula in self.formulas for node in formula.nodes())
        found = {node.name for node in nodes if isinstance(node, Name)} | {*self.variables}
        return found - {*self.definitions, *CONSTANTS}

    def with_values(self, values: Mapping[str, str]) -> StatementTrees:
        """Return the trees with texts of formulas in the place of any values."""
        made = {name: tree_of(text) for name, text in values.items()}
        return replace(self, definitions={**self.definitions, **made})

    def with_ends(self) -> StatementTrees:
        """The trees with sin, tanh and the like for Jacobi functions of the parameter 0 or 1."""
        return replace(
            self,
            equations=tuple(mapped(formula, self._at_end) for formula in self.equations),
            solutions={name: mapped(f, self._at_end) for name, f in self.solutions.items()},
        )

    def _at_end(self, node: FormulaTree) -> FormulaTree | None:
        if not (isinstance(node, Call) and len(node.parts) == 2):
            return None
        z, m = node.parts
        parameter = rational(mapped(m, self.meaning))
        end = None if parameter is None else ENDS.get((node.name, parameter))
        if end is None:
            return None
        return Call((mapped(z, self._at_end),), end) if end else Number(Fraction(1))

    def meaning(self, node: FormulaTree) -> FormulaTree | None:
        """Return the formula of a defined name; None for anything else."""
        if isinstance(node, Name) and node.name in self.definitions:
            return mapped(self.definitions[node.name], self.meaning)
        return None


ENDS: Mapping[tuple[str, Fraction | int], str] = {
    ("jacobi_sn", 0): "sin",
    ("jacobi_cn", 0): "cos",
    ("jacobi_dn", 0): "",
    ("jacobi_sn", 1): "tanh",
    ("jacobi_cn", 1): "sech",
    ("jacobi_dn", 1): "sech",
}
"""What the Jacobi functions are at the ends of their parameter; nothing where it is 1."""


def typed_case(
    texts: StatementTexts, trees: StatementTrees, values: Mapping[str, str]
) -> tuple[StatementTexts, StatementTrees]:
    """The texts and trees with values for parameters; Jacobi functions are known at their ends."""
    texts, plain = texts.with_values(values), trees.with_values(values)
    trees = plain.with_ends()
    pairs = zip(texts.solutions, trees.solutions.items(), strict=True)
    return replace(
        texts,
        equations=tuple(
            text if new == old else formula_text(new)
            for text, old, new in zip(
                texts.equations, plain.equations, trees.equations, strict=True
            )
        ),
        solutions=tuple(
            text
            if new == plain.solutions[name]
            else f"{text.partition('=')[0].strip()} = {formula_text(new)}"
            for text, (name, new) in pairs
        ),
    ), trees


def tree_of(text: str, functions: Iterable[str] = ()) -> FormulaTree:
    """Return the tree of a formula in any names, ``functions`` of one argument among them."""
    own = {name: (sp.Function(name), 1) for name in functions}
    words = Vocabulary({**FUNCTIONS, **own}, unknown_name=sp.Symbol)
    return Parser(text, tokens(text), words, "value").whole()


@dataclass(frozen=True)
class Statement:
    """Do the ``solutions`` make every one of the ``equations`` vanish on the ``domains``?

    ``equations`` are left-hand sides in the applied unknowns; ``solutions`` has each of these with
    its formula.  ``domains`` has every variable and parameter that is not all real numbers;
    ``divisors`` is what the texts divide by or take the logarithm of; ``wanted`` are parameters of
    which the values are asked for, rather than taken as any.  ``texts`` and ``trees`` are what was
    typed.
    ``complexes`` are parameters that may have complex values; the symbols of all are real, and a
    proof is one for complex values only if the checker accepts it for them.  ``functions`` are the
    names of arbitrary functions.  ``weak`` asks for weak solutions (`verify.proof.weak`).
    """

    name: str
    equations: tuple[sp.Expr, ...]
    solutions: Mapping[AppliedUndef, sp.Expr]
    domains: Mapping[sp.Symbol, Domain]
    divisors: tuple[sp.Expr, ...] = ()
    wanted: tuple[sp.Symbol, ...] = ()
    texts: StatementTexts = field(default=StatementTexts((), (), ()), compare=False)
    trees: StatementTrees = field(default=StatementTrees((), (), {}, {}), compare=False)
    complexes: tuple[str, ...] = ()
    functions: tuple[str, ...] = ()
    weak: bool = False

    @property
    def variables(self) -> tuple[sp.Symbol, ...]:
        """The independent variables."""
        return tuple(next(iter(self.solutions)).args)
