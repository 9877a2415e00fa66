"""Rational bounds of real numbers: intervals, each end of which may be open."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce
from operator import mul

from flint import arb, fmpq

MICRO = 10**6
"""Bounds of constants are rounded outwards to multiples of 1/MICRO."""

LARGEST = 20
"""Highest exponent whose bounds are computed; above it only the sign of the power is kept."""

_FAR = fmpq(20)
"""Largest argument at which exp is bounded; exp(_FAR) is below 2**53/MICRO."""

End = tuple[fmpq | None, bool]
"""One end of an interval (None: unbounded), and whether it is open."""


@dataclass(frozen=True)
class Interval:
    """Real numbers between ``low`` and ``high`` (None: unbounded); an open end is excluded."""

    low: fmpq | None = None
    high: fmpq | None = None
    low_open: bool = False
    high_open: bool = False

    @property
    def is_positive(self) -> bool:
        """Whether every number of the interval is greater than 0."""
        return self.low is not None and (self.low > 0 or (self.low == 0 and self.low_open))

    @property
    def is_not_negative(self) -> bool:
        """Whether every number of the interval is at least 0."""
        return self.low is not None and self.low >= 0

    @property
    def is_not_zero(self) -> bool:
        """Whether all numbers of the interval are greater than 0, or all are less than 0."""
        return self.is_positive or (-self).is_positive

    @property
    def is_below(self) -> bool:
        """Whether all numbers of the interval are at most 0, and not all are 0."""
        return self.high is not None and self.high <= 0 and not self.is_not_negative

    @property
    def ends(self) -> tuple[End, End]:
        """The lower and the upper end."""
        return (self.low, self.low_open), (self.high, self.high_open)

    def __neg__(self) -> Interval:
        low = None if self.high is None else -self.high
        high = None if self.low is None else -self.low
        return Interval(low, high, self.high_open, self.low_open)

    def __add__(self, other: Interval) -> Interval:
        low = None if self.low is None or other.low is None else self.low + other.low
        high = None if self.high is None or other.high is None else self.high + other.high
        opens = self.low_open or other.low_open, self.high_open or other.high_open
        return Interval(low, high, *opens)

    def __mul__(self, other: Interval) -> Interval:
        if self.is_below:
            return -(-self * other)
        if other.is_below:
            return -(self * -other)
        if self.is_not_negative and other.is_not_negative:
            (low, low_open), (high, high_open) = map(_product, self.ends, other.ends)
            return Interval(low, high, low_open, high_open)
        pairs = [_product(left, right) for left in self.ends for right in other.ends]
        known = [(value, is_open) for value, is_open in pairs if value is not None]
        if len(known) < len(pairs):
            return Interval()
        (low, low_open), (high, high_open) = min(known), max(known, key=_reach)
        return Interval(low, high, low_open, high_open)

    def __and__(self, other: Interval) -> Interval:
        pairs = zip(self.ends, other.ends, strict=True)
        lows, highs = ([end for end in pair if end[0] is not None] for pair in pairs)
        low, low_open = max(lows, default=(None, False))
        high, high_open = min(highs, key=_reach, default=(None, False))
        return Interval(low, high, low_open, high_open)

    def power(self, exponent: int) -> Interval:
        """Return an interval that contains x**exponent, an integer power, for each x in it."""
        if exponent <= 0:
            return self.power(-exponent).inverse() if exponent else Interval(fmpq(1), fmpq(1))
        if exponent % 2 == 0 or self.is_not_negative:
            magnitude = self.absolute()
            if exponent > LARGEST:
                return Interval(fmpq(0), None, magnitude.is_positive)
            return reduce(mul, [magnitude] * exponent)
        return -(-self).power(exponent) if self.is_below else Interval()

    def absolute(self) -> Interval:
        """Return an interval that contains the absolute values of its numbers."""
        if self.is_not_negative:
            return self
        if self.is_below:
            return -self
        if self.low is None or self.high is None:
            return Interval(fmpq(0))
        high, high_open = max((-self.low, self.low_open), (self.high, self.high_open), key=_reach)
        return Interval(fmpq(0), high, False, high_open)

    def inverse(self) -> Interval:
        """Return an interval that contains 1/x for each x != 0 in it."""
        if self.is_below:
            return -(-self).inverse()
        if not self.is_positive:
            return self.side()
        low = fmpq(0) if self.high is None else 1 / self.high
        high = None if self.low == 0 or self.low is None else 1 / self.low
        return Interval(low, high, self.high is None or self.high_open, self.low_open)

    def side(self) -> Interval:
        """Return the half-line from 0 that contains the interval; the line if it has both signs."""
        if self.is_below:
            return -(-self).side()
        return Interval(fmpq(0), None, self.is_positive) if self.is_not_negative else Interval()

    def exponential(self) -> Interval:
        """Return an interval with rational ends that contains exp(x) for each x in it."""
        least = None if self.low is None else of_constant(arb(min(self.low, _FAR)).exp()).low
        is_far = self.high is None or self.high > _FAR
        most = None if is_far else of_constant(arb(self.high).exp()).high
        return POSITIVE & Interval(least, most, self.low_open, self.high_open)

    def root(self) -> Interval:
        """Return an interval with x**(1/n) for each x >= 0 in it, for any n >= 1."""
        low = fmpq(1) if self.low is not None and self.low >= 1 else fmpq(0)
        high = fmpq(1) if self.high is not None and self.high <= 1 else None
        return Interval(low, high, low == 0 and self.is_positive)


def _product(left: End, right: End) -> End:
    """Return the product of two ends; it is open unless it is attained."""
    (a, a_open), (b, b_open) = left, right
    if a == 0 or b == 0:
        return fmpq(0), not ((a == 0 and not a_open) or (b == 0 and not b_open))
    return (None, False) if a is None or b is None else (a * b, a_open or b_open)


def _reach(end: End) -> tuple[fmpq, bool]:
    """Return the sort key of a finite upper end: of equal ends the closed one is larger."""
    return end[0] or fmpq(0), not end[1]


POSITIVE, UNIT = Interval(fmpq(0), None, True), Interval(fmpq(-1), fmpq(1))


def of_constant(value: arb) -> Interval:
    """Return rational bounds of the ball ``value``; a bound 0 is open if the ball excludes 0."""
    scaled = value * MICRO
    low, high = scaled.lower().floor().unique_fmpz(), scaled.upper().ceil().unique_fmpz()
    if low is None or high is None:
        return Interval()
    ends = fmpq(int(low), MICRO), fmpq(int(high), MICRO)
    return Interval(*ends, ends[0] == 0 and bool(value > 0), ends[1] == 0 and bool(value < 0))
