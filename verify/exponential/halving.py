"""A run with half the step, again and again, until the step no longer matters."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from verify.exponential.adams import ORDER

Array = NDArray[np.float64]

PATIENCE = 4
"""Halvings without a new smallest difference after which rounding is what is left."""

BLOWN = 10
"""Halvings after which a solution that still blows up does so by itself."""


LEAST_RATIO = 8.0
"""Differences that fell by at least this much in each of the last two halvings follow the law."""

SAFETY = 2.0
"""Factor on an error that rests on that law."""


@dataclass(frozen=True)
class Halving:
    """The finer of the last two runs: its step, its values, and their estimated error."""

    step: float
    values: Array
    error: float
    runs: int


def halve(solve: Callable[[float], Array], step: float, bound: float) -> Halving:
    """Halve ``step`` until the estimated error (sup) is at most ``bound``.

    ``solve`` gives the values for a step. Values that are not finite count as infinitely far off.
    Raises ValueError if the difference of two runs stops falling above the bound, and
    FloatingPointError if the finest runs were not finite either.

    >>> result = halve(lambda h: np.array([1.0 + h**4]), 1.0, 1e-3)
    >>> result.step, result.runs
    (0.125, 4)
    """
    coarse, runs = solve(step), 1
    best, since, differences = np.inf, 0, [np.inf, np.inf]
    while since < PATIENCE:
        step /= 2.0
        fine = solve(step)
        runs += 1
        difference = sup_difference(fine, coarse)
        differences = [*differences[-2:], difference]
        error = _error(*differences)
        if error <= bound:
            return Halving(step, fine, error, runs)
        improved = difference < best or (best == np.inf and runs <= BLOWN)
        since = 0 if improved else since + 1
        best, coarse = min(best, difference), fine
    if not np.all(np.isfinite(coarse)):
        raise FloatingPointError(f"blow-up: steps down to {step:.3g} do not change it")
    raise ValueError(
        f"tolerance must leave more than {best:.2g} for the time step, got {bound:.2g} "
        "(halving it further no longer helps; rounding or an instability is what is left)"
    )


def _error(first: float, second: float, last: float) -> float:
    """Error of the finest of four runs, from the differences of each to the next.

    Where these do not follow the law it is the last one, which is about the coarser run's error.
    """
    if not (np.isfinite(first) and first * last > 0 and second > 0):
        return last
    ratio = min(first / second, second / last, 2.0**ORDER)
    return SAFETY * last / (ratio - 1.0) if ratio >= LEAST_RATIO else last


def sup_difference(fine: Array, coarse: Array) -> float:
    """Largest difference; infinity if anything is not finite.

    >>> sup_difference(np.array([1.0, np.nan]), np.zeros(2))
    inf
    """
    with np.errstate(invalid="ignore"):
        difference = float(np.max(np.abs(fine - coarse)))
    return difference if np.isfinite(difference) else np.inf
