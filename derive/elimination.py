"""Eliminating constants: solve a rational condition for one constant and substitute it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import reduce as fold

from sympy import Symbol
from sympy.polys.fields import FracElement

from derive.differential import DifferentialPolynomial
from derive.series import EpsSeries


@dataclass(frozen=True)
class Elimination:
    """``constant = value``, a consequence of a solvability condition."""

    constant: Symbol
    value: FracElement

    def __call__(self, element: FracElement) -> FracElement:
        """``element`` with the constant replaced."""
        return self._replaced(element.numer) / self._replaced(element.denom)

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
            rest = (*exponents[:position], 0, *exponents[position + 1 :])
            monomial = field.new(field.ring.term_new(rest, number))
            power = exponents[position]
            total += monomial * self.value**power if power else monomial
        return total


def solve_linear(condition: FracElement, constants: Sequence[Symbol]) -> Elimination | None:
    """Solve ``condition = 0`` for the first of ``constants`` that it is linear in.

    Constants that enter with a pure number as their factor are preferred.  None if there is no
    such constant.
    """
    candidates = []
    for constant in constants:
        solved = _solved(condition, constant)
        if solved is not None:
            candidates.append(solved)
    candidates.sort(key=lambda item: item[0])
    return candidates[0][1] if candidates else None


def _solved(condition: FracElement, constant: Symbol) -> tuple[bool, Elimination] | None:
    field = condition.field
    generator = field.ring.gens[field.symbols.index(constant)]
    if condition.numer.degree(generator) != 1:
        return None
    slope = condition.numer.diff(generator)
    rest = condition.numer - slope * generator
    return not slope.is_ground, Elimination(constant, -field.new(rest) / field.new(slope))


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
