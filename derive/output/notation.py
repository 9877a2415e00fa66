"""Differential polynomials as text and LaTeX.

Terms are grouped by degree and number of time derivatives; a group that is a total X-derivative
of a single monomial is written as one, ``K3 (Y^2)_XX`` rather than ``2 K3 Y Y_XX + 2 K3 Y_X^2``.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby

from sympy import Expr, Symbol

from longwave.derive.algebra.formula_printing import Printed, latex_of, text_of
from longwave.derive.algebra.jets import DifferentialPolynomial, Jet, Monomial
from longwave.derive.algebra.rational_functions import RationalFunction

LONGEST_SUBSCRIPT = 4


@dataclass(frozen=True)
class Term:
    """``coefficient (monomial)_{outer}``: a monomial under ``outer`` further X-derivatives."""

    coefficient: RationalFunction
    monomial: Monomial
    outer: int = 0

    @property
    def negative(self) -> bool:
        """Whether the coefficient is printed with a minus sign."""
        return self.coefficient.is_negative

    @property
    def size(self) -> Expr:
        """The coefficient without its sign, factored."""
        element = -self.coefficient if self.negative else self.coefficient
        return element.factored()


def terms(polynomial: DifferentialPolynomial) -> list[Term]:
    """Return the printable terms: time derivatives first, then by falling degree."""
    ordered = sorted(polynomial.terms, key=_rank)
    result: list[Term] = []
    for _, group in groupby(ordered, key=lambda monomial: _rank(monomial)[:2]):
        members = set(group)
        result += _merge_terms(polynomial.select(members.__contains__))
    return result


def _rank(monomial: Monomial) -> tuple[int, int, Monomial]:
    return -sum(jet[-1] for jet in monomial), -len(monomial), monomial


def _merge_terms(part: DifferentialPolynomial) -> list[Term]:
    """Return the terms of ``part``: one under outer derivatives if possible, else each monomial."""
    inner, outer = part, 0
    while (
        len(next(iter(part.terms))) > 1 and (antiderivative := inner.antiderivative()) is not None
    ):
        inner, outer = antiderivative, outer + 1
    if len(part.terms) > 1 and len(inner.terms) == 1:
        [(monomial, value)] = inner.terms.items()
        return [Term(value, monomial, outer)]
    return [Term(part.terms[m], m) for m in sorted(part.terms, key=_rank)]


@dataclass(frozen=True)
class Notation:
    """Names of the unknown and of the slow axes."""

    axes: tuple[str, ...] = ("X", "T")
    unknown: str = "Y"

    def subscript(self, jet: Jet) -> str:
        """Return the subscript ``XXX``, or ``5X`` from five derivatives on.

        >>> Notation().subscript((3, 1)), Notation().subscript((6, 0))
        ('XXXT', '6X')
        """
        return "".join(
            name * count if count <= LONGEST_SUBSCRIPT else f"{count}{name}"
            for name, count in zip(self.axes, jet, strict=True)
        )

    def text(self, polynomial: DifferentialPolynomial) -> str:
        """Return one line of plain text, ``0`` for the zero polynomial."""
        return self.written(polynomial, text_of)

    def latex(self, polynomial: DifferentialPolynomial) -> str:
        """Return LaTeX without delimiters, ``0`` for the zero polynomial."""
        return self.written(polynomial, latex_of)

    def written(self, polynomial: DifferentialPolynomial, printed: Printed) -> str:
        """Return the polynomial, constants formatted by ``printed``: `text_of` or `latex_of`."""
        return signed_sum(
            (term.negative, _product(term.size, self._under(term, printed), printed))
            for term in terms(polynomial)
        )

    def _under(self, term: Term, printed: Printed) -> str:
        product = self.monomial(term.monomial, printed)
        outer = self.subscript((term.outer, *(0,) * (len(self.axes) - 1)))
        return derived(product, outer, printed) if outer else product

    def monomial(self, monomial: Monomial, printed: Printed = text_of) -> str:
        """Return a product of jets as text or LaTeX, such as ``Y^2 Y_X``."""
        opening, closing = ("", "") if printed is text_of else ("{", "}")
        factors = []
        for jet, repeated in groupby(monomial):
            power = len(list(repeated))
            subscript = self.subscript(jet)
            name = f"{self.unknown}_{opening}{subscript}{closing}" if subscript else self.unknown
            factors.append(name if power == 1 else f"{name}^{opening}{power}{closing}")
        return " ".join(factors)


class Displayed:
    """Base of records with a text in one line, their repr, and LaTeX, shown in notebooks."""

    def written(self, printed: Printed) -> str:
        """Return the record as text or LaTeX, with constants formatted by ``printed``."""
        raise NotImplementedError

    def text(self) -> str:
        """Return plain text in one line."""
        return self.written(text_of)

    def latex(self) -> str:
        """Return LaTeX without delimiters."""
        return self.written(latex_of)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.text()})"

    def _repr_latex_(self) -> str:
        return rf"$\displaystyle {self.latex()}$"


def signed_sum(signed: Iterable[tuple[bool, str]]) -> str:
    """Return a sum of (is negative, text) pairs, for text and LaTeX; ``0`` if there are none."""
    result = ""
    for negative, body in signed:
        if result:
            result += f" {'-' if negative else '+'} {body}"
        else:
            result = f"-{body}" if negative else body
    return result or "0"


def weighted_sum(parts: Iterable[tuple[int, str]]) -> str:
    """Return a sum of (integer weight, text) pairs, for text and LaTeX.

    >>> weighted_sum([(-2, "x"), (1, "y"), (-1, "z")])
    '-2 x + y - z'
    """
    return signed_sum(
        (weight < 0, body if abs(weight) == 1 else f"{abs(weight)} {body}")
        for weight, body in parts
    )


def power_of(symbol: Symbol, exponent: int, printed: Printed) -> str:
    """Return a power as a factor with a space after it; "" for the exponent 0.

    >>> power_of(Symbol("eps"), 3, latex_of) + "Y", power_of(Symbol("eps"), 0, text_of) + "Y"
    ('\\\\epsilon^{3} Y', 'Y')
    """
    return f"{printed(symbol**exponent)} " if exponent else ""


def idle_loss(kind: str, value: Expr) -> str:
    """Return the message for a loss that contributes no term to the derived equation."""
    return f"{kind} loss {text_of(value)} does not enter at this order"


def bracketed(expression: Expr, printed: Printed) -> str:
    """Format a constant as a factor of a product, as text or LaTeX: a sum gets brackets."""
    text = printed(expression)
    return f"({text})" if expression.is_Add else text


def derived(product: str, subscript: str, printed: Printed) -> str:
    """Return ``(product)_subscript``, derivatives of a product, as text or LaTeX."""
    return (
        f"({product})_{subscript}"
        if printed is text_of
        else rf"\left({product}\right)_{{{subscript}}}"
    )


def _product(size: Expr, monomial: str, printed: Printed) -> str:
    number = printed(size)
    if not monomial or number == "1":
        return monomial or number
    if printed is not text_of:
        return rf"\left({number}\right) {monomial}" if size.is_Add else f"{number} {monomial}"
    compound = any(mark in number for mark in "/+-")
    return f"({number}) {monomial}" if compound else f"{number} {monomial}"


def aligned(rows: Sequence[tuple[str, str]]) -> str:
    """Return a LaTeX ``aligned`` block of (label, equation) rows."""
    body = " \\\\\n".join(f"{label}&\\quad {equation}" for label, equation in rows)
    return f"\\begin{{aligned}}\n{body}\n\\end{{aligned}}"
