"""Points of space and time as doubles: checked, broadcast, cut into chunks for the cache."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from itertools import chain

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.support.compiled.cores import usable_cores
from longwave.support.real_arrays import real_array

Array = NDArray[np.float64]

CHUNK = 4096


@lru_cache(maxsize=1)
def _executor(_: int) -> ThreadPoolExecutor:
    """Of one process: in a fork of it there are no threads."""
    return ThreadPoolExecutor(usable_cores(), thread_name_prefix="wave")


def evaluate_points(function: Callable[..., Array], *points: Array) -> Array:
    """``function`` at points of one shape: ``(..., points)`` becomes ``(..., *shape)``.

    ``function`` takes flat contiguous arrays of one size. Chunks run in threads, as the compiled
    loops release the interpreter.

    >>> grid = check_points([1, 2], [[3], [4]])
    >>> evaluate_points(lambda x, t: np.stack([x, x * t]), *grid).tolist()
    [[[1.0, 2.0], [1.0, 2.0]], [[3.0, 6.0], [4.0, 8.0]]]
    """
    flat = [np.ravel(axis) for axis in points]
    slices = [slice(start, start + CHUNK) for start in range(0, max(flat[0].size, 1), CHUNK)]
    if len(slices) == 1:
        out = function(*(axis.copy() for axis in flat))
    else:
        go = map if usable_cores() == 1 else _executor(os.getpid()).map
        chunks = iter(go(lambda s: function(*(axis[s].copy() for axis in flat)), slices))
        first = next(chunks)
        out = np.empty((*first.shape[:-1], flat[0].size), first.dtype)
        for place, chunk in zip(slices, chain([first], chunks), strict=True):
            out[..., place] = chunk
    return out.reshape(*out.shape[:-1], *points[0].shape)


def check_points(
    position: ArrayLike, time: ArrayLike, across: ArrayLike | None = None
) -> tuple[Array, ...]:
    """Positions, times and places across, if there are any, as doubles, broadcast together.

    Integers must be doubles exactly; other numbers are rounded to the nearest double.

    Raises ValueError for what is no finite real number, and for shapes that do not broadcast.

    >>> check_points([1, 2], 1j)
    Traceback (most recent call last):
    ...
    ValueError: every time must be a real number, got complex128 (take its real part)
    """
    given = [("position", position), ("time", time)]
    given += [] if across is None else [("place across", across)]
    found = [real_array(f"every {name}", values) for name, values in given]
    try:
        return tuple(np.broadcast_arrays(*found))
    except ValueError:
        names = "position and time" if across is None else "position, time and place across"
        raise ValueError(
            f"{names} must broadcast, got the shapes {' and '.join(str(a.shape) for a in found)} "
            "(give one of them a further axis)"
        ) from None
