"""What all runs ask of their times and tolerances."""

import math
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.support.real_arrays import real_array

Array = NDArray[np.float64]


def check_positive(name: str, value: float, remedy: str) -> None:
    """Raise ValueError unless 0 < value < inf."""
    if not isinstance(value, Real) or not 0.0 < value < math.inf:
        raise ValueError(f"{name} must satisfy 0 < {name} < inf, got {value!r} ({remedy})")


def checked_times(times: ArrayLike, begin: float) -> Array:
    """The times as an array; ValueError unless they increase from the state's on."""
    wanted = np.atleast_1d(real_array("every time", times))
    if wanted.ndim != 1 or wanted.size == 0:
        shown = " ".join(repr(times).split())[:60]
        raise ValueError(
            f"times must be one or more finite numbers, got {shown} (give a list of them)"
        )
    steps = np.diff(np.concatenate([[begin], wanted]))
    if steps[0] < 0.0 or not np.all(steps[1:] > 0.0):
        place = int(np.argmax([steps[0] < 0.0, *(steps[1:] <= 0.0)]))
        raise ValueError(
            f"times must increase from state.t = {begin:g} on, got {wanted[place]:g} at place "
            f"{place} (sort them; to go back in time start from the velocity's negative)"
        )
    return wanted
