"""SymPy expressions from formulas in text: SymPy simplifies while it builds them.

Whatever is built stays small (`bounded_building`); what does not is an error at its sign.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import sympy as sp

from longwave.derive.algebra.bounded_building import (
    TooLarge,
    applied,
    derivative,
    power,
    product,
    total,
)
from longwave.derive.algebra.exact_numbers import Number as AnyNumber
from longwave.derive.algebra.exact_numbers import exact
from longwave.derive.algebra.formula_text import Parser, Vocabulary, tokens
from longwave.derive.algebra.formula_tree import (
    Call,
    Derivative,
    FormulaTree,
    Name,
    Number,
    Power,
    Product,
    Sum,
    Unknown,
)
from longwave.support.user_files import shown

INFINITE_AT_ZERO = ("log", "coth", "csch", "cot", "csc")
"""Functions that have no value at 0."""


def read_formula(text: str, vocabulary: Vocabulary, name: str = "formula") -> sp.Expr:
    """The expression that ``text`` spells; raises FormulaError, which calls the text ``name``.

    >>> x = sp.Symbol("x")
    >>> read_formula("-x**2/4 + 0.1", Vocabulary({}, {"x": x}))
    1/10 - x**2/4
    """
    parser = Parser(text, tokens(text, name), vocabulary, name)
    return ExpressionBuilder.after(parser).expression(parser.whole())


def exact_value(name: str, value: AnyNumber, names: Mapping[str, sp.Expr] | None = None) -> sp.Expr:
    """A value exactly: a number, or a formula in text with ``names`` and square roots.

    >>> from longwave.derive.symbols import eps
    >>> exact_value("K3", "eps/2", {"eps": eps}), exact_value("k", 0.1)
    (eps/2, 1/10)
    """
    if not isinstance(value, str):
        return exact(name, value)
    words = Vocabulary({"sqrt": (sp.sqrt, 1)}, names=names or {})
    found = read_formula(value, words, name)
    if found.is_real is False or (found.is_number and found.is_finite is False):
        raise ValueError(f"{name} must be a finite real number, got {shown(value)} (such as 1/3)")
    if found.is_number and found and not 1e-50 < abs(found.evalf(10)) < 1e50:
        raise ValueError(f"{name} must be 0 or within 1e-50 .. 1e50, got {shown(value)}")
    return found


def _refused(_: int, words: str) -> ValueError:
    return ValueError(words)


class ExpressionBuilder:
    """Builds expressions in the words of a vocabulary.

    ``refused`` makes the error for a place of the text, from words.  ``divisors`` is what must not
    be 0, also where it cancels.
    """

    def __init__(
        self, vocabulary: Vocabulary, refused: Callable[[int, str], ValueError] = _refused
    ) -> None:
        self._words, self._refused = vocabulary, refused
        self.divisors: list[sp.Expr] = []

    @classmethod
    def after(cls, parser: Parser) -> ExpressionBuilder:
        """Of what a parser has read, in its vocabulary."""
        return cls(parser.vocabulary, parser.error_at)

    def expression(self, formula: FormulaTree) -> sp.Expr:
        """The expression; raises ValueError, with the place, for one that is too large."""
        parts = [self.expression(part) for part in formula.inner()]
        try:
            return self._made(formula, parts)
        except TooLarge as error:
            raise self._refused(formula.at, str(error)) from None

    def _made(self, formula: FormulaTree, parts: list[sp.Expr]) -> sp.Expr:
        match formula:
            case Number(value=value):
                return sp.Rational(value.numerator, value.denominator)
            case Name(name=name):
                return self._words.meaning(name)
            case Unknown():
                return self._field(formula)
            case Sum():
                return total(parts)
            case Product():
                return product(parts)
            case Power():
                if not parts[1].is_nonnegative:
                    self.divisors.append(parts[0])
                return power(*parts)
            case Call(name=name):
                if name in INFINITE_AT_ZERO:
                    self.divisors += parts
                return applied(self._words.functions[name][0], parts)
            case Derivative(steps=steps):
                return derivative(parts[0], [self._words.variables[step] for step in steps])
        raise TypeError(f"formula must be a node of a tree, got {type(formula).__name__}")

    def _field(self, formula: Unknown) -> sp.Expr:
        found, site = self._words.fields[formula.name], self._words.site
        moved = (a + formula.shift if a == site else a for a in found.args)
        variables = [self._words.variables[step] for step in formula.steps]
        return derivative(found.func(*moved), variables)
