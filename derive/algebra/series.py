"""Truncated power series in eps whose coefficients are differential polynomials.

A first-order operator is data too: a tuple of ``(axis, exponent, factor)``, standing for the sum
of ``factor eps^exponent d_axis``.  A lattice shift is the exponential of such an operator and the
time derivative is such an operator.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from longwave.derive.algebra.jets import DifferentialPolynomial, Jet
from longwave.derive.algebra.rational_functions import RationalFunction, RationalFunctions

Operator = tuple[tuple[int, int, RationalFunction], ...]


@dataclass(frozen=True)
class EpsSeries:
    """``{order: polynomial}`` with every order above ``limit`` cut off."""

    field: RationalFunctions
    limit: int
    parts: Mapping[int, DifferentialPolynomial]

    @classmethod
    def collect(
        cls,
        field: RationalFunctions,
        limit: int,
        items: Iterable[tuple[int, DifferentialPolynomial]],
    ) -> EpsSeries:
        """Sum the (order, polynomial) pairs up to ``limit``, dropping what cancels."""
        total: dict[int, DifferentialPolynomial] = {}
        for order, part in items:
            if order <= limit:
                total[order] = total[order] + part if order in total else part
        return cls(field, limit, {order: total[order] for order in sorted(total) if total[order]})

    def __add__(self, other: EpsSeries) -> EpsSeries:
        return self.collect(self.field, self.limit, [*self.parts.items(), *other.parts.items()])

    def __mul__(self, other: EpsSeries) -> EpsSeries:
        return self.collect(
            self.field,
            self.limit,
            (
                (i + j, left * right)
                for i, left in self.parts.items()
                for j, right in other.parts.items()
                if i + j <= self.limit
            ),
        )

    def __rmul__(self, scalar: RationalFunction) -> EpsSeries:
        return self.collect(
            self.field, self.limit, ((i, scalar * part) for i, part in self.parts.items())
        )

    def apply(self, operator: Operator) -> EpsSeries:
        """The first-order operator applied to every order."""
        return self.collect(
            self.field,
            self.limit,
            (
                (order + exponent, factor * part.derivative(axis))
                for order, part in self.parts.items()
                for axis, exponent, factor in operator
                if order + exponent <= self.limit
            ),
        )

    def exponential(self, operator: Operator) -> EpsSeries:
        """``exp(operator)`` applied: the sum of its powers over their factorials."""
        total, power, count = self, self, 0
        while power.parts and operator:
            count += 1
            power = (self.field.one / count) * power.apply(operator)
            total = total + power
        return total

    def at(self, order: int) -> DifferentialPolynomial:
        """The coefficient of ``eps^order``."""
        return self.parts.get(order) or DifferentialPolynomial.zero(self.field)

    def upto(self, limit: int, since: int = 0) -> EpsSeries:
        """The series cut off above ``eps^limit`` and below ``eps^since``."""
        items = (item for item in self.parts.items() if item[0] >= since)
        return self.collect(self.field, limit, items)

    def plus(self, order: int, part: DifferentialPolynomial) -> EpsSeries:
        """The series and ``eps^order`` times a polynomial."""
        return self.collect(self.field, self.limit, [*self.parts.items(), (order, part)])

    def replaced(self, value: Callable[[Jet], EpsSeries | None]) -> EpsSeries:
        """The series with other series in the places of jets; where that is None a jet stays."""
        total = EpsSeries(self.field, self.limit, {})
        for order, part in self.parts.items():
            for monomial, number in part.terms.items():
                values = [(jet, value(jet)) for jet in monomial]
                rest = tuple(jet for jet, found in values if found is None)
                unchanged = DifferentialPolynomial(self.field, {rest: number})
                product = self.collect(self.field, self.limit, [(order, unchanged)])
                for _, found in values:
                    product = product if found is None else product * found
                total = total + product
        return total

    def derivative(self, axis: int, times: int = 1) -> EpsSeries:
        """``times`` derivatives along ``axis`` at unchanged order."""
        result = self
        for _ in range(times):
            result = result.apply(((axis, 0, self.field.one),))
        return result

    def delayed(self, by: int) -> EpsSeries:
        """The series times ``eps^by``."""
        return self.collect(self.field, self.limit, ((i + by, p) for i, p in self.parts.items()))
