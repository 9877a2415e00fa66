"""What is eliminated from a series in eps: constants, by a condition; time derivatives, by a flow.

A rational condition is solved for one constant that it is linear in.  An evolution equation
``Y_T = F_0 + eps^2 F_2 + ...`` gives every jet with a time derivative a value without.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce as fold

from sympy import Symbol
from sympy.polys.fields import FracElement

from derive.algebra.jets import DifferentialPolynomial, Jet
from derive.algebra.series import EpsSeries


@dataclass(frozen=True)
class Elimination:
    """``constant**power = value``, a consequence of a solvability condition."""

    constant: Symbol
    value: FracElement
    power: int = 1

    def __call__(self, element: FracElement) -> FracElement:
        """``element`` with the constant replaced; of a square the root stays above the line."""
        above, below = element.numer, element.denom
        place = below.ring.symbols.index(self.constant)
        left = {monomial[place] % self.power for monomial in below}
        if self.power > 1 and left == {1}:
            root = below.ring.gens[place] ** (self.power - 1)
            above, below = above * root, below * root
        return self._replaced(above) / self._replaced(below)

    def polynomial(self, polynomial: DifferentialPolynomial) -> DifferentialPolynomial:
        """The differential polynomial with the constant replaced in its coefficients."""
        return polynomial.map_coefficients(self)

    def series(self, series: EpsSeries) -> EpsSeries:
        """The eps-series with the constant replaced in all its orders."""
        parts = ((order, self.polynomial(part)) for order, part in series.parts.items())
        return EpsSeries.collect(series.field, series.limit, parts)

    def _replaced(self, ring_element: FracElement) -> FracElement:
        field = self.value.field
        position = field.symbols.index(self.constant)
        total = field.zero
        for exponents, number in ring_element.terms():
            times, left = divmod(exponents[position], self.power)
            kept = (*exponents[:position], left, *exponents[position + 1 :])
            monomial = field.new(field.ring.term_new(kept, number))
            total += monomial * self.value**times if times else monomial
        return total


def solve_linear(
    condition: FracElement, constants: Sequence[Symbol], squared: Symbol | None = None
) -> Elimination | None:
    """Solve ``condition = 0`` for the first of ``constants`` that it is linear in.

    Constants that enter with a pure number as their factor are preferred, behind them the square of
    ``squared``.  None if there is nothing to solve for.
    """
    found = [_solved(condition, constant, 1) for constant in constants]
    candidates = [elimination for elimination in found if elimination]
    pure = [e for e in candidates if _is_number(condition.diff(_generator(condition, e.constant)))]
    square = squared and _solved(condition, squared, 2)
    return next(iter([*pure, *([square] if square else []), *candidates]), None)


def _generator(element: FracElement, constant: Symbol) -> FracElement:
    return element.field.gens[element.field.symbols.index(constant)]


def _is_number(element: FracElement) -> bool:
    return bool(element.numer.is_ground and element.denom.is_ground)


def _solved(condition: FracElement, constant: Symbol, power: int) -> Elimination | None:
    """Solve for ``constant**power``, if the condition is linear in it and has no other power."""
    field, place = condition.field, condition.field.symbols.index(constant)
    powers = {exponents[place] for exponents in condition.numer}
    if powers != {0, power} and powers != {1}:
        return None
    rest = field.zero
    slope = field.zero
    for exponents, number in condition.numer.terms():
        others = (*exponents[:place], 0, *exponents[place + 1 :])
        term = field.new(field.ring.term_new(others, number))
        slope, rest = (slope + term, rest) if exponents[place] else (slope, rest + term)
    return Elimination(constant, -rest / slope, power)


def vanishing_factor(coefficients: Iterable[FracElement]) -> FracElement | None:
    """The one common factor of ``coefficients`` that can vanish, or None.

    Factors that their symbols' assumptions keep from 0 (positive ones, sums of those) are left out.
    """
    values = list(coefficients)
    field = values[0].field
    common = fold(lambda left, right: left.gcd(right), (value.numer for value in values))
    factors = [
        factor for factor, _ in common.factor_list()[1] if factor.as_expr().is_zero is not False
    ]
    return field.new(factors[0]) if len(factors) == 1 else None


class TimeElimination:
    """Replaces every jet with a time derivative by its value along ``Y_T = flow``.

    ``flow`` is a series of polynomials without time derivatives.
    """

    def __init__(self, flow: EpsSeries, axes: int) -> None:
        self._flow = flow
        self._time = axes - 1
        self._known: dict[int, EpsSeries] = {1: flow}

    def series(self, series: EpsSeries) -> EpsSeries:
        """``series`` on solutions of the evolution equation."""
        total = EpsSeries(series.field, series.limit, {})
        for order, part in series.parts.items():
            total = total + self.polynomial(part, series.limit).delayed(order)
        return total

    def polynomial(self, polynomial: DifferentialPolynomial, limit: int) -> EpsSeries:
        """One polynomial on solutions, as a series up to ``eps^limit``."""
        field = polynomial.field
        total = EpsSeries(field, limit, {})
        for monomial, value in polynomial.terms.items():
            product = total.constant(value)
            for jet in monomial:
                product = product * self._jet(jet, limit)
            total = total + product
        return total

    def _jet(self, jet: Jet, limit: int) -> EpsSeries:
        """The value of one jet."""
        count = jet[self._time]
        field = self._flow.field
        if count == 0:
            return EpsSeries(field, limit, {0: DifferentialPolynomial.monomial(field, (jet,))})
        result = self._time_derivative(count)
        for axis, times in enumerate(jet[: self._time]):
            result = result.derivative(axis, times)
        return EpsSeries.collect(field, limit, result.parts.items())

    def _time_derivative(self, count: int) -> EpsSeries:
        """The ``count``-th time derivative of Y along the flow."""
        if count not in self._known:
            previous = self._time_derivative(count - 1)
            mixed = previous.derivative(self._time)
            self._known[count] = self.series(mixed)
        return self._known[count]
