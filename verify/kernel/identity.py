"""The last step of a proof: a polynomial in an unknown's derivatives is 0.

A quotient U = N/D of long polynomials in x and t is put in at more values of t than the residual's
degree.  A derivative of order n has the numerator P over D**(n + 1), where

    P -> P_x D - (n + 1) P D_x    raises the order in x,   P = N_t D - N D_t is the first in t.

If N and D have degree at most d in t, the residual times D**top has degree at most top d in t, so
that it is 0 if it is the zero polynomial in x at top d + 1 values of t.  Exact, and far cheaper
than to multiply out.  If U(-x, -t) is U(x, t) and the terms' orders are all even or all odd, the
residual at -t is 0 if that at t is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import comb, lcm

from flint import fmpq, fmpq_mpoly, fmpz, fmpz_poly

from .images import Images
from .limits import CertificateError
from .ring import Element, total
from .statement import Equation, Jet, Statement, Term
from .substitution import Substitution

Rows = list[fmpz_poly]
"""Polynomials in x, the factors of the powers of t."""

Rates = Sequence[tuple[fmpq, fmpq]]
"""For each variable, the constant derivatives of x and t."""


WORK_PER_TERM = 50
"""Operations on a coefficient for each value of t: order 9 of the rational family takes 40."""


class Quotient:
    """``image``, a quotient of polynomials in the ring's generators ``x`` and ``t``."""

    def __init__(self, image: Element, x: int, t: int) -> None:
        self._ring, self._x, self._t = image.ring, x, t
        parts = (image.numerator, image.denominator())
        scale = lcm(*(int(c.q) for part in parts for c in part.coeffs()))
        self._even = not any(sum(exponents) % 2 for part in parts for exponents in part.monoms())
        self._numerator, self._denominator = (self._rows(part, scale) for part in parts)
        rows = (self._numerator, self._denominator)
        self.degree = max(map(len, rows)) - 1
        self.length = max(len(row) for part in rows for row in part)

    def vanishes(self, terms: Sequence[Term], rates: Rates) -> bool:
        """Whether an equation with rational factors holds for the quotient."""
        scale = lcm(*(int(value.q) for value, _, _ in terms))
        weighted = [(int((value * scale).p), jets) for value, _, jets in terms]
        top = max(sum(sum(orders) + 1 for _, orders in jets) for _, jets in weighted)
        last = (top * self.degree + 1) // 2
        orders = {sum(sum(orders) for _, orders in jets) % 2 for _, jets in weighted}
        first = 0 if self._even and len(orders) == 1 else -last
        self._ring.spend((last + 1 - first) * top * self.length * WORK_PER_TERM)
        values = (self._residual(weighted, rates, top, t) for t in range(first, last + 1))
        return not any(values)

    def _residual(
        self, terms: Sequence[tuple[int, Sequence[Jet]]], rates: Rates, top: int, t: int
    ) -> fmpz_poly:
        """The residual times ``D**top`` at ``t``."""
        partials = _Partials(self._numerator, self._denominator, t)
        total = fmpz_poly([0])
        for factor, jets in terms:
            product, power = fmpz_poly([factor]), 0
            for _, orders in jets:
                product *= partials.jet(orders, rates)
                power += sum(orders) + 1
            total += product * partials.below ** (top - power)
        return total

    def _rows(self, polynomial: fmpq_mpoly, scale: int) -> Rows:
        found: list[dict[int, fmpz]] = [{}]
        for exponents, coefficient in polynomial.terms():
            powers = exponents[::-1]
            if any(n for place, n in enumerate(powers) if place not in (self._x, self._t)):
                raise CertificateError("a quotient must be in two generators")
            t = int(powers[self._t])
            found += [{} for _ in range(t + 1 - len(found))]
            found[t][int(powers[self._x])] = (coefficient * scale).p
        return [fmpz_poly([row.get(i, 0) for i in range(max(row, default=0) + 1)]) for row in found]


class _Partials:
    """Numerators of the partial derivatives at one value of t."""

    def __init__(self, N: Rows, D: Rows, t: int) -> None:
        n, self.below = _value(N, t), _value(D, t)
        first = _slope(N, t) * self.below - n * _slope(D, t)
        self._slope = self.below.derivative()
        self._found: dict[tuple[int, int], fmpz_poly] = {(0, 0): n, (0, 1): first}

    def jet(self, orders: Sequence[int], rates: Rates) -> fmpz_poly:
        """The numerator of a derivative along the variables, over D to the order + 1."""
        total: Mapping[tuple[int, int], int] = {(0, 0): 1}
        for order, (x, t) in zip(orders, rates, strict=True):
            expanded: dict[tuple[int, int], int] = {}
            for (a, b), factor in total.items():
                for i in range(order + 1):
                    weight = factor * comb(order, i) * int(x.p) ** (order - i) * int(t.p) ** i
                    place = (a + order - i, b + i)
                    expanded[place] = expanded.get(place, 0) + weight
            total = {place: weight for place, weight in expanded.items() if weight}
        return sum(
            (weight * self._partial(*place) for place, weight in total.items()), fmpz_poly([0])
        )

    def _partial(self, a: int, b: int) -> fmpz_poly:
        if b > 1:
            raise CertificateError("a quotient must have at most one derivative in t")
        if (a, b) not in self._found:
            lower = self._partial(a - 1, b)
            power = a + b
            self._found[a, b] = lower.derivative() * self.below - power * lower * self._slope
        return self._found[a, b]


def _value(rows: Rows, t: int) -> fmpz_poly:
    total = fmpz_poly([0])
    for row in reversed(rows):
        total = total * t + row
    return total


def _slope(rows: Rows, t: int) -> fmpz_poly:
    return _value([power * row for power, row in enumerate(rows)][1:], t)


def constant_rates(slopes: Sequence[tuple[Element, Element]]) -> Rates | None:
    """The integer derivatives of x and t along each variable; None if they are no integers."""
    rates = []
    for pair in slopes:
        values = []
        for element in pair:
            if element.powers or not element.numerator.is_constant():
                return None
            values.append(fmpq(0) if element.is_zero else element.numerator.leading_coefficient())
        if any(value.q != 1 for value in values):
            return None
        rates.append((values[0], values[1]))
    return rates


LONG = 20
"""Terms of a numerator from which a quotient in two generators is evaluated, not multiplied out."""


class Residual:
    """The left-hand sides of a statement's equations in a field."""

    def __init__(self, field: Images, statement: Statement) -> None:
        self._field, self._statement = field, statement
        self._jets: dict[Jet, Element] = {}
        own = statement.nodes, statement.variables, statement.formulas
        self.substituted = Substitution(*own)

    def vanishes(self, equation: Equation) -> bool:
        """Whether the numerator of an equation reduces to 0."""
        if isinstance(equation, int):
            residual = self.substituted(equation)
            self._field.walk([residual])
            return self._field.image(residual).is_zero
        quotient = self.quotient(equation)
        if quotient is not None:
            return quotient[0].vanishes(equation, quotient[1])
        parts = [self._term(term) for term in equation]
        return total(self._field.ring, parts).is_zero

    def quotient(self, terms: Sequence[Term]) -> tuple[Quotient, Rates] | None:
        """The formula as a long quotient in two generators, and their rates; None if it is none."""
        field = self._field
        if field.ring.relations or len(field.generators) != 2 or len(self._statement.formulas) > 1:
            return None
        image = field.image(self._statement.formulas[0])
        if len(image.numerator) < LONG or any(known for _, known, _ in terms):
            return None
        t, x = sorted(range(2), key=lambda place: image.numerator.degrees()[1 - place])
        slopes = [(field.slope(x, v), field.slope(t, v)) for v in self._statement.variables]
        rates = constant_rates(slopes)
        return None if rates is None else (Quotient(image, x, t), rates)

    def _term(self, term: Term) -> Element:
        value, known, jets = term
        result = self._field.ring.number(value)
        for node in known:
            result = result * self._field.image(node)
        for jet in jets:
            result = result * self.jet(jet)
        return result

    def jet(self, jet: Jet) -> Element:
        """A derivative of an unknown."""
        if jet not in self._jets:
            unknown, orders = jet
            place = next((i for i, n in enumerate(orders) if n), None)
            if place is None:
                self._jets[jet] = self._field.image(self._statement.formulas[unknown])
            else:
                lower = (*orders[:place], orders[place] - 1, *orders[place + 1 :])
                variable = self._statement.variables[place]
                self._jets[jet] = self._field.derivative(self.jet((unknown, lower)), variable)
        return self._jets[jet]
