"""Check an equation for a quotient of long polynomials in two generators, at many values of one.

U = N/D is substituted at more values of t than the degree of the residual in t.  A derivative of
order n is P/D**(n + 1), where

    P -> P_x D - (n + 1) P D_x    raises the order in x,   P = N_t D - N D_t belongs to U_t.

If N and D have degree at most d in t, the residual times D**top has degree at most top d in t, so
that it is 0 if it is the zero polynomial in x at top d + 1 values of t.  Exact, and far cheaper
than to multiply out.  If U(-x, -t) is U(x, t) and the terms' orders are all even or all odd, the
residual at -t is 0 if that at t is.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from operator import mul

from flint import fmpq, fmpq_mpoly, fmpq_poly

from .field import Field
from .limits import CertificateError
from .nodes import Nodes
from .ring import Element
from .statement import Statement

Rows = list[fmpq_poly]
"""Polynomial in x and t: its coefficients of 1, t, t**2, ... as polynomials in x."""

Rates = dict[int, tuple[fmpq, fmpq]]
"""Constant derivatives of the generators x and t in each variable."""

LONG = 20
"""Fewest terms of a numerator for which a quotient is evaluated instead of multiplied out."""

WORK_PER_TERM = 50
"""Operations charged per coefficient and value of t; rational solution 9 needs 40 of them."""

Shape = tuple[int, frozenset[int]]
"""Power of D in an equation's denominator, and parities of its terms' orders (0 even, 1 odd)."""


def shape(nodes: Nodes, node: int) -> Shape | None:
    """Return the shape of a polynomial in the derivatives of an unknown; else None."""
    match nodes.all[node]:
        case ("number", _):
            return 0, frozenset({0})
        case ("unknown", _, shifts) if not any(shifts):
            return 1, frozenset({0})
        case ("diff", inner, *along) if nodes.all[inner][0] == "unknown" and shape(nodes, inner):
            return 1 + len(along), frozenset({len(along) % 2})
        case ("Add", *inner):
            parts = [shape(nodes, term) for term in inner]
            known = [part for part in parts if part is not None]
            if len(known) == len(parts):
                return max(power for power, _ in known), frozenset().union(*(o for _, o in known))
        case ("Mul", *inner):
            return reduce(_times, [shape(nodes, factor) for factor in inner])
        case ("Pow", base, exponent) if exponent.q == 1 and exponent > 0:
            return reduce(_times, [shape(nodes, base)] * int(exponent.p))
    return None


def _times(left: Shape | None, right: Shape | None) -> Shape | None:
    if left is None or right is None:
        return None
    return left[0] + right[0], frozenset(a ^ b for a in left[1] for b in right[1])


class _Partials:
    """Numerators of U and its derivatives at one value of t, as polynomials in x."""

    def __init__(self, nodes: Nodes, N: Rows, D: Rows, t: int, rates: Rates) -> None:
        self._nodes, self._rates = nodes, rates
        n, self._below = _value(N, t), _value(D, t)
        first = _slope(N, t) * self._below - n * _slope(D, t)
        self._slope = self._below.derivative()
        self._found: dict[tuple[int, int], fmpq_poly] = {(0, 0): n, (0, 1): first}

    def value(self, node: int) -> tuple[fmpq_poly, int]:
        """Return the numerator of an equation, and the power of D in its denominator."""
        match self._nodes.all[node]:
            case ("number", value):
                return fmpq_poly([value]), 0
            case ("Add", *terms):
                parts = [self.value(term) for term in terms]
                top = max(power for _, power in parts)
                raised = (part * self._below ** (top - power) for part, power in parts)
                return sum(raised, fmpq_poly([0])), top
            case ("Mul", *factors):
                parts = [self.value(factor) for factor in factors]
                return reduce(mul, (part for part, _ in parts)), sum(power for _, power in parts)
            case ("Pow", base, exponent):
                part, power = self.value(base)
                return part ** int(exponent.p), power * int(exponent.p)
            case ("diff", _, *along):
                return self._jet(along), 1 + len(along)
        return self._found[0, 0], 1

    def _jet(self, along: Sequence[int]) -> fmpq_poly:
        """Return the numerator of the derivative of U in the variables ``along``."""
        weights = reduce(mul, (fmpq_poly([*self._rates[variable]]) for variable in along))
        terms = ((b, weight) for b, weight in enumerate(weights.coeffs()) if weight != 0)
        return sum((w * self._partial(len(along) - b, b) for b, w in terms), fmpq_poly([0]))

    def _partial(self, a: int, b: int) -> fmpq_poly:
        if b > 1:
            raise CertificateError("a quotient must have at most one derivative in t")
        if (a, b) not in self._found:
            lower = self._partial(a - 1, b)
            self._found[a, b] = lower.derivative() * self._below - (a + b) * lower * self._slope
        return self._found[a, b]


def _rows(polynomial: fmpq_mpoly, x: int, t: int) -> Rows:
    rows = [fmpq_poly()]
    for exponents, coefficient in polynomial.terms():
        powers = exponents[::-1]
        rows += [fmpq_poly() for _ in range(int(powers[t]) + 1 - len(rows))]
        rows[int(powers[t])][int(powers[x])] = coefficient
    return rows


def _value(rows: Rows, t: int) -> fmpq_poly:
    return reduce(lambda total, row: total * t + row, reversed(rows), fmpq_poly([0]))


def _slope(rows: Rows, t: int) -> fmpq_poly:
    return _value([power * row for power, row in enumerate(rows)][1:], t)


def long_quotient(field: Field, statement: Statement) -> tuple[Element, int, int, Rates] | None:
    """Return the image of a long quotient, the places of x and t, and their rates; else None."""
    if field.ring.relations or len(field.generators) != 2 or len(statement.formulas) > 1:
        return None
    image = field.image(statement.formulas[0])
    if len(image.numerator) < LONG:
        return None
    t, x = sorted(range(2), key=lambda place: image.numerator.degrees()[1 - place])
    rates: Rates = {}
    for variable in statement.variables:
        slopes = [field.slopes.slope(place, variable) for place in (x, t)]
        if any(slope.places for slope in slopes):
            return None
        rates[variable] = (slopes[0].numerator[0, 0], slopes[1].numerator[0, 0])
    return image, x, t, rates


def quotient_vanishes(field: Field, statement: Statement, equation: int) -> bool | None:
    """Return whether an equation holds for a long quotient; None for any other formula."""
    own_shape, found = shape(field.nodes, equation), long_quotient(field, statement)
    if own_shape is None or found is None:
        return None
    (top, orders), (image, x, t, rates) = own_shape, found
    parts = image.numerator, image.denominator()
    above, below = (_rows(part, x, t) for part in parts)
    last = (top * (max(len(above), len(below)) - 1) + 1) // 2
    is_even = not any(sum(exponents) % 2 for part in parts for exponents in part.monoms())
    first = 0 if is_even and len(orders) == 1 else -last
    length = max(map(len, (*above, *below)))
    field.ring.spend((last + 1 - first) * top * length * WORK_PER_TERM)
    values = (_Partials(field.nodes, above, below, t, rates) for t in range(first, last + 1))
    return not any(partials.value(equation)[0] for partials in values)
