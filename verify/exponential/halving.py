"""A run with half the step, again and again, until the step no longer matters."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PATIENCE = 4
"""Halvings without a new smallest difference after which rounding is what is left."""

BLOWN = 10
"""Halvings after which a solution that still blows up does so by itself."""


@dataclass(frozen=True)
class Halving:
    """The finer of the last two runs: its step, its values, and by how much the two differ.

    ``difference`` is about the error of the coarser run; that of ``values`` is smaller by 2^order.
    """

    step: float
    values: Array
    difference: float
    runs: int


def halve(solve: Callable[[float], Array], step: float, bound: float) -> Halving:
    """Halve ``step`` until the values of two successive runs differ by at most ``bound`` (sup).

    ``solve`` gives the values for a step. Values that are not finite count as infinitely far off.
    Raises ValueError if the difference stops falling above the bound, and FloatingPointError if
    the finest runs were not finite either.

    >>> result = halve(lambda h: np.array([1.0 + h**4]), 1.0, 1e-3)
    >>> result.step, result.runs
    (0.0625, 5)
    """
    coarse, runs = solve(step), 1
    best, since = np.inf, 0
    while since < PATIENCE:
        step /= 2.0
        fine = solve(step)
        runs += 1
        difference = sup_difference(fine, coarse)
        if difference <= bound:
            return Halving(step, fine, difference, runs)
        improved = difference < best or (best == np.inf and runs <= BLOWN)
        since = 0 if improved else since + 1
        best, coarse = min(best, difference), fine
    if not np.all(np.isfinite(coarse)):
        raise FloatingPointError(f"blow-up: steps down to {step:.3g} do not change it")
    raise ValueError(
        f"tolerance must leave more than {best:.2g} for the time step, got {bound:.2g} "
        "(halving it further no longer helps; rounding or an instability is what is left)"
    )


def sup_difference(fine: Array, coarse: Array) -> float:
    """Largest difference; infinity if anything is not finite.

    >>> sup_difference(np.array([1.0, np.nan]), np.zeros(2))
    inf
    """
    with np.errstate(invalid="ignore"):
        difference = float(np.max(np.abs(fine - coarse)))
    return difference if np.isfinite(difference) else np.inf
