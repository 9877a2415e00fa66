"""Estimated errors of a run, in units of y/eps, sup over the compared sites."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

ROUNDING = 4.0 * 2.0**-53
"""What one evaluation adds to a unit strain: a few roundings, of signs that vary."""

STEADY = 2.0**-53
"""The part whose sign does not vary (measured: 0.4 of it, on a kink's far field at t = 2e8)."""


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

    Where nothing moves, it is the same every time and adds up.

    >>> rounding_error(5.0, 10_000) < 1e-11
    True
    """
    return largest * (ROUNDING * math.sqrt(1.0 + evaluations) + STEADY * evaluations)


def clock_error(values: NDArray[np.float64], c: float, times: tuple[float, float]) -> float:
    """What two roundings of the time do to ``values``, of neighbouring sites, which move at c.

    Far from t = 0 a time stands for its unit in the last place, in which the wave goes on.

    >>> f"{clock_error(np.array([[0.0, 1.0]]), 1.0, (2.0**28, 2.0**28 + 1)):.2g}"
    '1.2e-07'
    """
    slope = float(np.max(np.abs(np.diff(values, axis=-1)), initial=0.0))
    return 2.0 * float(np.spacing(max(map(abs, times)))) * c * slope
