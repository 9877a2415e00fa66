"""Estimated errors of a run, in units of y/eps, sup over the compared sites."""

import math
from dataclasses import dataclass

ROUNDING = 4.0 * 2.0**-53
"""What one evaluation adds to a unit strain: a few roundings, of signs that vary."""


@dataclass(frozen=True)
class Estimate:
    """By how much y/eps is estimated to miss the infinite lattice's, at most.

    ``total`` stands for everything that was chosen, and for rounding, whose part is ``rounding``.
    ``next_decade`` is the factor by which ten times more accuracy costs more.
    """

    total: float
    rounding: float
    next_decade: float


def rounding_error(largest: float, evaluations: int) -> float:
    """What rounding is taken to do to strains of that size in so many force evaluations a site.

    >>> rounding_error(5.0, 10_000) < 1e-12
    True
    """
    return ROUNDING * largest * math.sqrt(1.0 + evaluations)
