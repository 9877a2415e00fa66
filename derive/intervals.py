"""Numbers that follow from measured constants, each with its interval.

The derivatives of the expression give the standard deviation. If the expression is too nonlinear
for them within the errors, samples of the constants give the interval.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist, quantiles

from sympy import Dummy, Expr, Symbol, lambdify

from longwave.derive.measured import Measured
from longwave.derive.reduction import Reduction

LEVEL = 0.95
"""Probability that a number lies in its interval."""

HALF_WIDTH = NormalDist().inv_cdf((1 + LEVEL) / 2)
"""Half-width of an interval of a normal distribution, in standard deviations."""

SAMPLE_COUNT = 20_000
"""Number of samples: the ends of an interval are then accurate to 0.02 standard deviations."""

MAX_LINEAR_ERROR = 0.05
"""Largest error of an interval's ends, relative to its width, for which they are computed from
derivatives; above it they come from samples."""

OPENING_FUNCTIONS = {"contact": lambda x: max(x, 0.0), "touching": lambda x: float(x > 0.0)}
"""Functions of open contacts, which Python's `math` lacks, by name."""

PLAIN_EXPONENTS = (-6, 3)
"""Smallest and largest power of ten of the last digit for which a number is printed without an
exponent."""


@dataclass(frozen=True)
class Interval:
    """A number that follows from measured constants, its standard deviation and 95 % interval.

    ``by_derivatives`` are the interval's ends from the derivatives. If ``sampled``, these are
    inaccurate, and ``ends`` and ``deviation`` come from samples.  ``lost`` is the fraction of
    samples at which the number does not exist.
    """

    value: float
    deviation: float
    ends: tuple[float, float]
    by_derivatives: tuple[float, float]
    sampled: bool
    lost: float

    def text(self) -> str:
        """Return the value with deviation and interval, in as many digits as they justify."""
        low, high = (rounded(end, self.deviation) for end in self.ends)
        line = rounded(self.value, self.deviation)
        if self.deviation:
            line += f" +- {rounded(self.deviation, self.deviation)}, {low} .. {high}"
        if self.sampled:
            low, high = (rounded(end, self.deviation) for end in self.by_derivatives)
            line += f" (sampled; by derivatives {low} .. {high})"
        return line + (f" (none at {self.lost:.2g} of the samples)" if self.lost else "")


class Intervals:
    """Intervals of expressions in measured constants, all from the same samples."""

    def __init__(self, measured: Measured, constants: Sequence[Symbol]) -> None:
        values = dict(measured.values)
        self._symbols = [symbol for symbol in constants if str(symbol) in values]
        order = [str(symbol) for symbol in self._symbols]
        self._at = {symbol: values[str(symbol)] for symbol in self._symbols}
        self._rows = [[measured.table[one][two] for two in order] for one in order]
        indices = [list(values).index(name) for name in order]
        self._samples = [tuple(s[i] for i in indices) for s in measured.samples(SAMPLE_COUNT)]

    def of(self, expression: Expr) -> Interval:
        """Return the interval of an expression in the constants."""
        gradient = self._gradient(expression)
        variance = sum(
            a * b * entry
            for a, row in zip(gradient, self._rows, strict=True)
            for b, entry in zip(gradient, row, strict=True)
        )
        deviation = math.sqrt(max(0.0, variance))
        mean = float(expression.xreplace(self._at))
        linear = (mean - HALF_WIDTH * deviation, mean + HALF_WIDTH * deviation)
        sampled = self._sampled_values(expression)
        lost = 1 - len(sampled) / SAMPLE_COUNT
        cuts = quantiles(sampled, n=round(2 / (1 - LEVEL))) if len(sampled) > 1 else [mean]
        ends = (cuts[0], cuts[-1])
        allowed = MAX_LINEAR_ERROR * (ends[1] - ends[0]) + 1e-12 * abs(mean)
        if not lost and all(abs(a - b) <= allowed for a, b in zip(ends, linear, strict=True)):
            return Interval(mean, deviation, linear, linear, sampled=False, lost=0.0)
        spread = (ends[1] - ends[0]) / (2 * HALF_WIDTH)
        return Interval(mean, spread, ends, linear, sampled=True, lost=lost)

    def _gradient(self, expression: Expr) -> list[float]:
        """Return the expression's derivatives in the constants, whose signs SymPy may assume."""
        signed = {
            symbol: Dummy(positive=True) if value > 0 else Dummy(negative=True) if value else symbol
            for symbol, value in self._at.items()
        }
        values = {signed[symbol]: value for symbol, value in self._at.items()}
        signed_expression = expression.xreplace(signed)
        return [float(signed_expression.diff(signed[s]).xreplace(values)) for s in self._symbols]

    def _sampled_values(self, expression: Expr) -> list[float]:
        """Return the values of the expression at the samples where it is a real number."""
        function = lambdify(self._symbols, expression, [OPENING_FUNCTIONS, "math"])
        values = []
        for sample in self._samples:
            try:
                value = function(*sample)
            except (ValueError, ZeroDivisionError, OverflowError):
                continue
            if not isinstance(value, complex) and math.isfinite(value):
                values.append(value)
        return values


def intervals_of_reduction(reduction: Reduction, measured: Measured) -> dict[str, Interval]:
    """Return the intervals of speed, coefficients and normal form, by name.

    ``measured`` has a value for each constant of the lattice and of the ansatz.
    """
    scaling = reduction.scaling
    scaling_constants = (s for s in scaling.constants if s != scaling.frame_symbol)
    intervals = Intervals(measured, [*reduction.lattice.basic_constants, *scaling_constants])
    symbolic = reduction.coefficients()
    expressions = {"c": symbolic.c, **symbolic.terms}
    if reduction.has_normal_form:
        expressions |= reduction.normal_form().values
    return {name: intervals.of(expression) for name, expression in expressions.items()}


def rounded(value: float, deviation: float) -> str:
    """Format a value to two digits of its standard deviation.

    >>> rounded(1.00105, 0.0017), rounded(1234.6, 32.0), rounded(0.0, 0.1), rounded(2.5, 0.0)
    ('1.0010', '1235', '0.00', '2.5')
    >>> rounded(12345.6, 3200.0), rounded(1.23456e9, 3.2e6)
    ('12300', '1.2346e+09')
    """
    if not deviation or not math.isfinite(deviation):
        return f"{value:.6g}"
    exponent = math.floor(math.log10(deviation)) - 1
    if PLAIN_EXPONENTS[0] <= exponent <= PLAIN_EXPONENTS[1]:
        return f"{round(value, -exponent):.{max(-exponent, 0)}f}"
    digits = math.floor(math.log10(abs(value) or deviation)) - exponent
    return f"{value:.{min(max(digits, 1), 15)}e}"
