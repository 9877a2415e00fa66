"""Elimination from a series in eps: constants by a condition, time derivatives by a flow.

A rational condition is solved for a constant in which it is linear.  An evolution equation
``Y_T = F_0 + eps^2 F_2 + ...`` expresses every jet with a time derivative by jets without.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from functools import reduce as fold

from sympy import Symbol

from longwave.derive.algebra.jets import EpsSeries, Jet
from longwave.derive.algebra.rational_functions import Factor, RationalFunction, Terms


@dataclass(frozen=True)
class Elimination:
    """``constant**power = value``, a consequence of a solvability condition."""

    constant: Symbol
    value: RationalFunction
    power: int = 1

    def __call__(self, element: RationalFunction) -> RationalFunction:
        """Replace ``constant**power`` in ``element``.

        A single factor ``constant`` that is left in the denominator moves to the numerator.
        """
        field, index = element.field, element.field.symbols.index(self.constant)
        numer, odd, even = element.numerator(), field.one, {}
        for factor, times in element.below.items():
            if any(exponents[index] % self.power for exponents, _ in factor.terms):
                odd = odd * field.polynomial(factor.polynomial) ** times
            else:
                even[factor] = times
        if {exponents[index] % self.power for exponents, _ in odd.terms()} == {1}:
            root = field(self.constant) ** (self.power - 1)
            numer, odd = numer * root, odd * root
        even_part = RationalFunction(field, numer.numer, element.content, even)
        return even_part.mapped(self._replaced, self._known) / self._replaced(odd.terms())

    @cached_property
    def _known(self) -> dict[Factor, RationalFunction]:
        """Cache of denominator factors: factor -> the factor with the constant replaced."""
        return {}

    def series(self, series: EpsSeries) -> EpsSeries:
        """Return the eps-series with the constant replaced in all its orders."""
        parts = ((order, part.map_coefficients(self)) for order, part in series.parts.items())
        return EpsSeries.collect(series.field, series.limit, parts)

    def _replaced(self, terms: Terms) -> RationalFunction:
        field = self.value.field
        index = field.symbols.index(self.constant)
        by_power: dict[int, Terms] = {}
        for exponents, number in terms:
            quotient, remainder = divmod(exponents[index], self.power)
            others = (*exponents[:index], remainder, *exponents[index + 1 :])
            by_power.setdefault(quotient, []).append((others, number))
        parts = (field.from_terms(part) * self.value**power for power, part in by_power.items())
        return sum(parts, field.zero)


def solve_linear(
    condition: RationalFunction, constants: Sequence[Symbol], squared: Symbol | None = None
) -> Elimination | None:
    """Solve ``condition = 0`` for one of the ``constants`` in which it is linear.

    Constants whose coefficient is a number are tried first, then ``squared**2``, then the other
    constants. None if the condition cannot be solved for any of them.
    """
    solutions = [_solved(condition, constant, 1) for constant in constants]
    candidates = [elimination for elimination in solutions if elimination]
    pure = [e for e in candidates if condition.diff(e.constant).is_number]
    square = squared and _solved(condition, squared, 2)
    return next(iter([*pure, *([square] if square else []), *candidates]), None)


def _solved(condition: RationalFunction, constant: Symbol, power: int) -> Elimination | None:
    """Solve ``condition = 0`` for ``constant**power``; None if ``constant`` has another power."""
    value = condition.solved_for(constant, power)
    if value is None and power == 1 and condition.powers_of(constant).keys() == {1}:
        value = condition.field.zero
    return None if value is None else Elimination(constant, value, power)


def vanishing_factors(coefficients: Iterable[RationalFunction]) -> list[RationalFunction] | None:
    """Return the factors that must be 0 for all coefficients to be 0; None if that is undecided.

    If the coefficients have a common factor that can be 0, it is returned; else each coefficient
    must have exactly one factor that can be 0.  Factors that are nonzero by their symbols'
    assumptions (positive symbols and their sums) are ignored.
    """
    values = list(coefficients)
    common = _can_vanish(fold(RationalFunction.common, values))
    if common:
        return common if len(common) == 1 else None
    factor_lists = [_can_vanish(value) for value in values]
    if any(len(factors) != 1 for factors in factor_lists):
        return None
    return [*dict.fromkeys(factors[0] for factors in factor_lists)]


def _can_vanish(value: RationalFunction) -> list[RationalFunction]:
    return [part for part in value.factors() if part.as_expr().is_zero is not False]


class TimeElimination:
    """Replacement of every jet with a time derivative by its value along ``Y_T = flow``.

    ``flow`` is a series of polynomials without time derivatives.
    """

    def __init__(self, flow: EpsSeries, axes: int) -> None:
        self._flow = flow
        self._time = axes - 1
        self._known: dict[int, EpsSeries] = {1: flow}

    def series(self, series: EpsSeries) -> EpsSeries:
        """Return ``series`` with its time derivatives replaced by ``Y_T = flow``."""
        return series.replaced(self._value)

    def _value(self, jet: Jet) -> EpsSeries | None:
        """Return the series that replaces a jet; None for a jet without time derivatives."""
        if not jet[self._time]:
            return None
        result = self._time_derivative(jet[self._time])
        for axis, times in enumerate(jet[: self._time]):
            result = result.derivative(axis, times)
        return result

    def _time_derivative(self, count: int) -> EpsSeries:
        """Return the ``count``-th time derivative of Y along the flow."""
        if count not in self._known:
            previous = self._time_derivative(count - 1)
            mixed = previous.derivative(self._time)
            self._known[count] = self.series(mixed)
        return self._known[count]
