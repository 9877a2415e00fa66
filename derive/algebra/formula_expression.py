"""SymPy expressions from formulas in text: SymPy simplifies while it builds them.

Expressions are kept small (`bounded_building`); a larger one is an error at its sign.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import sympy as sp

from longwave.derive.algebra import bounded_building
from longwave.derive.algebra import formula_tree as syntax
from longwave.derive.algebra.exact_numbers import Number as AnyNumber
from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.algebra.formula_text import Parser, Vocabulary, tokens
from longwave.support.user_files import shown

INFINITE_AT_ZERO = ("log", "coth", "csch", "cot", "csc")
"""Functions that have no value at 0."""


def read_formula(text: str, vocabulary: Vocabulary, name: str = "formula") -> sp.Expr:
    """Return the expression of ``text``. Raises FormulaError, which calls the text ``name``.

    >>> x = sp.Symbol("x")
    >>> read_formula("-x**2/4 + 0.1", Vocabulary({}, {"x": x}))
    1/10 - x**2/4
    """
    parser = Parser(text, tokens(text, name), vocabulary, name)
    return ExpressionBuilder.after(parser).expression(parser.whole())


def exact_value(name: str, value: AnyNumber, names: Mapping[str, sp.Expr] | None = None) -> sp.Expr:
    """Return a value exactly: a number, or a formula in text with ``names`` and square roots.

    >>> from longwave.derive.symbols import eps
    >>> exact_value("K3", "eps/2", {"eps": eps}), exact_value("k", 0.1)
    (eps/2, 1/10)
    """
    if not isinstance(value, str):
        return exact(name, value)
    words = Vocabulary({"sqrt": (sp.sqrt, 1)}, names=names or {})
    expression = read_formula(value, words, name)
    if expression.is_real is False or (expression.is_number and expression.is_finite is False):
        raise ValueError(f"{name} must be a finite real number, got {shown(value)} (such as 1/3)")
    if expression.is_number and expression and not 1e-50 < abs(expression.evalf(10)) < 1e50:
        raise ValueError(f"{name} must be 0 or within 1e-50 .. 1e50, got {shown(value)}")
    return expression


class ExpressionBuilder:
    """Builder of expressions in the words of a vocabulary.

    ``refused`` creates the error for a position in the text, from a message.  ``divisors`` collects
    the denominators, which must be nonzero even where they cancel.
    """

    def __init__(
        self,
        vocabulary: Vocabulary,
        refused: Callable[[int, str], ValueError] = lambda _, words: ValueError(words),
    ) -> None:
        self._words, self._refused = vocabulary, refused
        self.divisors: list[sp.Expr] = []

    @classmethod
    def after(cls, parser: Parser) -> ExpressionBuilder:
        """Return a builder with a parser's vocabulary, whose errors show the parser's text."""
        return cls(parser.vocabulary, parser.error_at)

    def expression(self, formula: syntax.FormulaTree) -> sp.Expr:
        """Return a formula's expression. Raises ValueError, with position, if it is too large."""
        parts = [self.expression(part) for part in formula.inner()]
        try:
            return self._build(formula, parts)
        except bounded_building.TooLarge as error:
            raise self._refused(formula.at, str(error)) from None

    def _build(self, formula: syntax.FormulaTree, parts: list[sp.Expr]) -> sp.Expr:
        match formula:
            case syntax.Number(value=value):
                return sp.Rational(value.numerator, value.denominator)
            case syntax.Name(name=name):
                return self._words.meaning(name)
            case syntax.Unknown():
                return self._field(formula)
            case syntax.Sum():
                return bounded_building.total(parts)
            case syntax.Product():
                return bounded_building.product(parts)
            case syntax.Power():
                if not parts[1].is_nonnegative:
                    self.divisors.append(parts[0])
                return bounded_building.power(*parts)
            case syntax.Call(name=name):
                if name in INFINITE_AT_ZERO:
                    self.divisors += parts
                return bounded_building.applied(self._words.functions[name][0], parts)
            case syntax.Derivative(steps=steps):
                variables = [self._words.variables[step] for step in steps]
                return bounded_building.derivative(parts[0], variables)
        raise TypeError(f"formula must be a node of a tree, got {type(formula).__name__}")

    def _field(self, formula: syntax.Unknown) -> sp.Expr:
        field, site = self._words.fields[formula.name], self._words.site
        arguments = (a + formula.shift if a == site else a for a in field.args)
        variables = [self._words.variables[step] for step in formula.steps]
        return bounded_building.derivative(field.func(*arguments), variables)
