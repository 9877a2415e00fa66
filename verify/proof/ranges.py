"""Real intervals with open, closed or infinite ends, and their exact arithmetic."""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

Number = Fraction | float
"""A rational number, or plus or minus infinity."""

End = tuple[Number, bool]
"""A value, and whether it is left out."""

INFINITY = math.inf
LARGEST_POWER = 64
"""Of higher powers only the sign is kept."""


@dataclass(frozen=True)
class Range:
    """All real numbers between two ends; an infinite end is open.

    >>> Range(Fraction(-2), Fraction(1)) ** 2
    Range(lower=Fraction(0, 1), upper=Fraction(4, 1), lower_open=False, upper_open=False)
    """

    lower: Number = -INFINITY
    upper: Number = INFINITY
    lower_open: bool = False
    upper_open: bool = False

    @property
    def is_positive(self) -> bool:
        """Whether every number in it is positive."""
        return self.lower > 0 or (self.lower == 0 and self.lower_open)

    @property
    def is_nonnegative(self) -> bool:
        """Whether no number in it is negative."""
        return self.lower >= 0

    @property
    def is_negative(self) -> bool:
        """Whether every number in it is negative."""
        return (-self).is_positive

    @property
    def is_nonpositive(self) -> bool:
        """Whether no number in it is positive."""
        return self.upper <= 0

    @property
    def excludes_zero(self) -> bool:
        """Whether 0 lies outside."""
        return self.is_positive or self.is_negative

    def __neg__(self) -> Range:
        return Range(-self.upper, -self.lower, self.upper_open, self.lower_open)

    def __add__(self, other: Range) -> Range:
        return Range(
            _sum(self.lower, other.lower),
            _sum(self.upper, other.upper),
            self.lower_open or other.lower_open,
            self.upper_open or other.upper_open,
        )

    def __mul__(self, other: Range) -> Range:
        ends = [
            _product(left, right)
            for left in ((self.lower, self.lower_open), (self.upper, self.upper_open))
            for right in ((other.lower, other.lower_open), (other.upper, other.upper_open))
        ]
        lower = min(value for value, _ in ends)
        upper = max(value for value, _ in ends)
        return Range(
            lower,
            upper,
            all(is_open for value, is_open in ends if value == lower),
            all(is_open for value, is_open in ends if value == upper),
        )

    def __pow__(self, exponent: int) -> Range:
        """The powers with an integer exponent; of a negative one, those of the reciprocals."""
        if exponent < 0:
            return (self**-exponent).reciprocal()
        if exponent > LARGEST_POWER:
            return self._sign_of_power(exponent)
        if exponent % 2:
            ends = [(value**exponent) for value in (self.lower, self.upper)]
            return Range(ends[0], ends[1], self.lower_open, self.upper_open)
        size = self.absolute()
        return Range(size.lower**exponent, size.upper**exponent, size.lower_open, size.upper_open)

    def _sign_of_power(self, exponent: int) -> Range:
        if exponent % 2 == 0 or self.is_nonnegative:
            return Range(Fraction(0), INFINITY, self.excludes_zero)
        if self.is_nonpositive:
            return Range(-INFINITY, Fraction(0), False, self.excludes_zero)
        return Range()

    def absolute(self) -> Range:
        """The absolute values."""
        if self.is_nonnegative:
            return self
        if self.is_nonpositive:
            return -self
        mirrored = -self
        upper = max(self.upper, mirrored.upper)
        opens = [side.upper_open for side in (self, mirrored) if side.upper == upper]
        return Range(Fraction(0), upper, False, all(opens))

    def reciprocal(self) -> Range:
        """The reciprocals of what is not 0; everything if both signs occur."""
        if self.is_nonnegative:
            return Range(
                _inverse(self.upper), _inverse(self.lower), self.upper_open, self.lower_open
            )
        if self.is_nonpositive:
            return -(-self).reciprocal()
        return Range()


def _product(left: End, right: End) -> End:
    """The product of two ends; 0 times infinity is 0, being approached only."""
    (a, a_open), (b, b_open) = left, right
    if a == 0 or b == 0:
        closed_zero = (a == 0 and not a_open) or (b == 0 and not b_open)
        return Fraction(0), not closed_zero
    if math.isinf(a) or math.isinf(b):
        return INFINITY if (a > 0) == (b > 0) else -INFINITY, True
    return a * b, a_open or b_open


def _sum(a: Number, b: Number) -> Number:
    """The sum of two lower or two upper ends, of which only one sign of infinity occurs."""
    return a if math.isinf(a) else b if math.isinf(b) else a + b


def _inverse(end: Number) -> Number:
    if end == 0:
        return INFINITY
    return Fraction(0) if end == INFINITY else 1 / end
