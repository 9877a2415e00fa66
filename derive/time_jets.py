"""Time derivatives removed by an evolution equation ``Y_T = F_0 + eps^2 F_2 + ...``."""

from __future__ import annotations

from derive.differential import DifferentialPolynomial, Jet
from derive.series import EpsSeries


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
