"""How a residual falls as the digits rise: what separates a solution from a near miss."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

SLACK_DIGITS = 4
"""Digits by which a fall may miss d2 - d1, for the luck of rounding at the worst point."""

MOST_DIGITS = 10_000
MINIMUM_GAP = 2 * SLACK_DIGITS + 1
"""Smallest distance of two precisions at which the fall still says something."""


@dataclass(frozen=True)
class Decay:
    """Decimal logarithms of the largest relative residual (``levels``) at each of ``digits``.

    A residual of exactly 0 has level -inf.
    """

    digits: tuple[int, ...]
    levels: tuple[float, ...]

    def falls(self) -> bool:
        """Whether each step from d1 to d2 digits lowers the residual by 10^(d2 - d1), less slack.

        A residual below 10^-d counts as 10^-d.

        >>> Decay((30, 50), (-28.3, -48.1)).falls()
        True
        >>> Decay((30, 50), (-28.3, -31.0)).falls()
        False
        """
        floored = [max(level, -d) for d, level in zip(self.digits, self.levels, strict=True)]
        steps = itertools.pairwise(zip(self.digits, floored, strict=True))
        return all(
            before - after >= high - low - SLACK_DIGITS for (low, before), (high, after) in steps
        )

    def text(self) -> str:
        """The residuals with their digits on one line.

        >>> Decay((30, 50), (-28.3, -48.1)).text()
        '5.0e-29, 7.9e-49 at 30, 50 digits'
        """
        residuals = ", ".join(scientific(level) for level in self.levels)
        return f"{residuals} at {', '.join(map(str, self.digits))} digits"


def scientific(level: float) -> str:
    """The number 10**level with two digits, also where it is too small for a float.

    >>> scientific(-400.5), scientific(float("-inf"))
    ('3.2e-401', '0')
    """
    if level == float("-inf"):
        return "0"
    exponent = int(level // 1)
    return f"{10 ** (level - exponent):.1f}e{exponent:+03d}"


def checked_digits(digits: Sequence[int]) -> tuple[int, ...]:
    """``digits`` if they are two or more precisions far enough apart for the fall to be seen.

    Raises ValueError otherwise.

    >>> checked_digits([30, 50])
    (30, 50)
    """
    gaps = [high - low for low, high in itertools.pairwise(digits)]
    if not gaps or digits[0] < 15 or min(gaps) < MINIMUM_GAP or digits[-1] > MOST_DIGITS:
        raise ValueError(
            f"digits must be two or more numbers from 15 to {MOST_DIGITS}, each at least "
            f"{MINIMUM_GAP} above the one before, got {','.join(map(str, digits)) or 'none'} "
            "(30,50,100 is usual)"
        )
    return tuple(digits)
