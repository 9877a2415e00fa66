"""Checks of the times, states and tolerances of all runs."""

from __future__ import annotations

import math
from numbers import Real
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from longwave.support.real_arrays import Array, real_array

if TYPE_CHECKING:
    from longwave.lattice.numeric_lattice import NumericLattice


def check_positive(name: str, value: float, remedy: str) -> None:
    """Raise ValueError unless 0 < value < inf; the message has ``name`` and ``remedy``."""
    if not isinstance(value, Real) or not 0.0 < value < math.inf:
        raise ValueError(f"{name} must satisfy 0 < {name} < inf, got {value!r} ({remedy})")


def checked_times(times: ArrayLike, begin: float) -> Array:
    """Return the times as an array; raise ValueError unless they increase from ``begin`` on."""
    moments = np.atleast_1d(real_array("every time", times))
    if moments.ndim != 1 or moments.size == 0:
        text = " ".join(repr(times).split())[:60]
        raise ValueError(f"times must be one or more finite numbers, got {text} (give a list)")
    steps = np.diff(np.concatenate([[begin], moments]))
    if steps[0] < 0.0 or not np.all(steps[1:] > 0.0):
        index = int(np.argmax([steps[0] < 0.0, *(steps[1:] <= 0.0)]))
        raise ValueError(
            f"times must increase from state.t = {begin:g} on, got {moments[index]:g} at index "
            f"{index} (sort them; to go back in time negate the velocities)"
        )
    return moments


def checked_fields(lattice: NumericLattice, f: ArrayLike, v: ArrayLike) -> tuple[Array, Array]:
    """Return fields and velocities of a state as contiguous doubles.

    Raises ValueError if their shape does not fit the lattice or a value is not finite.
    """
    named = {
        name: np.ascontiguousarray(real_array(f"every value of {name}", values, allows_nan=True))
        for name, values in (("state.f", f), ("state.v", v))
    }
    fields, axes = len(lattice.fields), lattice.dimension
    for name, values in named.items():
        fits = values.ndim == 1 + axes and values.shape == named["state.f"].shape
        if not fits or values.shape[0] != fields or not values.size:
            raise ValueError(
                f"{name} must have the shape (fields, *cells) of {fields} fields and {axes} axes, "
                f"got {values.shape} (a chain of one field has (1, cells))"
            )
        if not np.all(np.isfinite(values)):
            index = tuple(np.argwhere(~np.isfinite(values))[0].tolist())
            raise ValueError(
                f"{name} must be finite, got {values[index]} at index "
                f"{index[0] if len(index) == 1 else index} (check how the state was computed)"
            )
    return named["state.f"], named["state.v"]
