"""Numbers that follow from measured constants, each with its interval.

The derivatives of the expression give the standard deviation; where it bends too much for them
within the errors, samples of the constants give the interval.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist, quantiles

from sympy import Dummy, Expr, Symbol, lambdify

from longwave.derive.measured import Measured
from longwave.derive.reduction import Reduction

LEVEL = 0.95
"""Of all intervals."""

WIDE = NormalDist().inv_cdf((1 + LEVEL) / 2)
"""Half an interval of a normal distribution, in its standard deviations."""

SAMPLES = 20_000
"""They find the ends of an interval to 0.02 standard deviations."""

SAME_ENDS = 0.05
"""Share of an interval's width by which derivatives may miss its ends."""


OPENING = {"contact": lambda x: max(x, 0.0), "touching": lambda x: float(x > 0.0)}
"""Functions that are not in Python's own `math`."""

LAST_PLACES = (-6, 3)
"""Of numbers without a power of ten: the power of their last digit."""


@dataclass(frozen=True)
class Interval:
    """A number that follows from measured constants, its standard deviation and 95 % interval.

    ``by_derivatives`` are the ends that the derivatives give; ``sampled`` says that they miss, and
    that ``ends`` and ``deviation`` are those of samples.  ``lost`` is the share of samples at which
    there is no such number.
    """

    value: float
    deviation: float
    ends: tuple[float, float]
    by_derivatives: tuple[float, float]
    sampled: bool
    lost: float

    def text(self) -> str:
        """The value with deviation and interval, in as many digits as they have."""
        low, high = (rounded(end, self.deviation) for end in self.ends)
        line = rounded(self.value, self.deviation)
        if self.deviation:
            line += f" +- {rounded(self.deviation, self.deviation)}, {low} .. {high}"
        if self.sampled:
            low, high = (rounded(end, self.deviation) for end in self.by_derivatives)
            line += f" (sampled; by derivatives {low} .. {high})"
        return line + (f" (none at {self.lost:.2g} of the samples)" if self.lost else "")


class Intervals:
    """The intervals of expressions in measured constants, all from the same samples."""

    def __init__(self, measured: Measured, constants: Sequence[Symbol]) -> None:
        values = dict(measured.values)
        self._symbols = [symbol for symbol in constants if str(symbol) in values]
        order = [str(symbol) for symbol in self._symbols]
        self._at = {symbol: values[str(symbol)] for symbol in self._symbols}
        self._rows = [[measured.table[one][two] for two in order] for one in order]
        places = [list(values).index(name) for name in order]
        self._samples = [tuple(s[i] for i in places) for s in measured.samples(SAMPLES)]

    def of(self, expression: Expr) -> Interval:
        """The interval of an expression in the constants."""
        gradient = self._gradient(expression)
        deviation = math.sqrt(
            max(
                0.0,
                sum(
                    a * b * entry
                    for a, row in zip(gradient, self._rows, strict=True)
                    for b, entry in zip(gradient, row, strict=True)
                ),
            )
        )
        mean = float(expression.xreplace(self._at))
        linear = (mean - WIDE * deviation, mean + WIDE * deviation)
        drawn = self._drawn(expression)
        lost = 1 - len(drawn) / SAMPLES
        cuts = quantiles(drawn, n=round(2 / (1 - LEVEL))) if len(drawn) > 1 else [mean]
        ends = (cuts[0], cuts[-1])
        allowed = SAME_ENDS * (ends[1] - ends[0]) + 1e-12 * abs(mean)
        if not lost and all(abs(a - b) <= allowed for a, b in zip(ends, linear, strict=True)):
            return Interval(mean, deviation, linear, linear, sampled=False, lost=0.0)
        spread = (ends[1] - ends[0]) / (2 * WIDE)
        return Interval(mean, spread, ends, linear, sampled=True, lost=lost)

    def _gradient(self, expression: Expr) -> list[float]:
        """The derivatives at the constants' values, whose signs hold in a neighbourhood of them."""
        near = {
            symbol: Dummy(positive=True) if value > 0 else Dummy(negative=True) if value else symbol
            for symbol, value in self._at.items()
        }
        at = {near[symbol]: value for symbol, value in self._at.items()}
        nearby = expression.xreplace(near)
        return [float(nearby.diff(near[symbol]).xreplace(at)) for symbol in self._symbols]

    def _drawn(self, expression: Expr) -> list[float]:
        """The expression at the samples where it is a real number."""
        function = lambdify(self._symbols, expression, [OPENING, "math"])
        found = []
        for sample in self._samples:
            try:
                value = function(*sample)
            except (ValueError, ZeroDivisionError, OverflowError):
                continue
            if not isinstance(value, complex) and math.isfinite(value):
                found.append(value)
        return found


def intervals_of_reduction(reduction: Reduction, measured: Measured) -> dict[str, Interval]:
    """The intervals of speed, coefficients and normal form, under the names that they have there.

    ``measured`` has a value for each constant of the lattice and of the ansatz.
    """
    own = (s for s in reduction.scaling.constants if s != reduction.scaling.frame_symbol)
    intervals = Intervals(measured, [*reduction.lattice.basic_constants, *own])
    symbolic = reduction.coefficients()
    found = {"c": symbolic.c, **symbolic.terms}
    if reduction.has_normal_form:
        found |= reduction.normal_form().values
    return {name: intervals.of(expression) for name, expression in found.items()}


def rounded(value: float, deviation: float) -> str:
    """The value to two digits of its standard deviation.

    >>> rounded(1.00105, 0.0017), rounded(1234.6, 32.0), rounded(0.0, 0.1), rounded(2.5, 0.0)
    ('1.0010', '1235', '0.00', '2.5')
    >>> rounded(12345.6, 3200.0), rounded(1.23456e9, 3.2e6)
    ('12300', '1.2346e+09')
    """
    if not deviation or not math.isfinite(deviation):
        return f"{value:.6g}"
    place = math.floor(math.log10(deviation)) - 1
    if LAST_PLACES[0] <= place <= LAST_PLACES[1]:
        return f"{round(value, -place):.{max(-place, 0)}f}"
    digits = math.floor(math.log10(abs(value) or deviation)) - place
    return f"{value:.{min(max(digits, 1), 15)}e}"
