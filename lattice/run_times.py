"""Checks of the times and tolerances of all runs."""

import math
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from longwave.support.array_types import Array
from longwave.support.real_arrays import real_array


def check_positive(name: str, value: float, remedy: str) -> None:
    """Raise ValueError unless 0 < value < inf."""
    if not isinstance(value, Real) or not 0.0 < value < math.inf:
        raise ValueError(f"{name} must satisfy 0 < {name} < inf, got {value!r} ({remedy})")


def checked_times(times: ArrayLike, begin: float) -> Array:
    """Return the times as an array; raise ValueError unless they increase from ``begin`` on."""
    moments = np.atleast_1d(real_array("every time", times))
    if moments.ndim != 1 or moments.size == 0:
        text = " ".join(repr(times).split())[:60]
        raise ValueError(
            f"times must be one or more finite numbers, got {text} (give a list of them)"
        )
    steps = np.diff(np.concatenate([[begin], moments]))
    if steps[0] < 0.0 or not np.all(steps[1:] > 0.0):
        index = int(np.argmax([steps[0] < 0.0, *(steps[1:] <= 0.0)]))
        raise ValueError(
            f"times must increase from state.t = {begin:g} on, got {moments[index]:g} at index "
            f"{index} (sort them; to go back in time negate the velocities)"
        )
    return moments
