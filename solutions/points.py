"""Points of space and time as doubles: checked, broadcast, and split into chunks."""

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
"""Number of points that one thread evaluates at once."""


@lru_cache(maxsize=1)
def _executor(_: int) -> ThreadPoolExecutor:
    """Return the thread pool of this process; a forked process has none of its parent's threads."""
    return ThreadPoolExecutor(usable_cores(), thread_name_prefix="wave")


def evaluate_points(function: Callable[..., Array], *points: Array) -> Array:
    """Return ``function`` at points of one shape: ``(..., points)`` becomes ``(..., *shape)``.

    ``function`` takes flat contiguous arrays of one size. Chunks run in threads, as the compiled
    loops release the interpreter lock.

    >>> grid = check_points([1, 2], [[3], [4]])
    >>> evaluate_points(lambda x, t: np.stack([x, x * t]), *grid).tolist()
    [[[1.0, 2.0], [1.0, 2.0]], [[3.0, 6.0], [4.0, 8.0]]]
    """
    flat = [np.ravel(axis) for axis in points]
    slices = [slice(start, start + CHUNK) for start in range(0, max(flat[0].size, 1), CHUNK)]
    if len(slices) == 1:
        out = function(*(axis.copy() for axis in flat))
    else:
        map_chunks = map if usable_cores() == 1 else _executor(os.getpid()).map
        chunks = iter(map_chunks(lambda s: function(*(axis[s].copy() for axis in flat)), slices))
        first = next(chunks)
        out = np.empty((*first.shape[:-1], flat[0].size), first.dtype)
        for target, chunk in zip(slices, chain([first], chunks), strict=True):
            out[..., target] = chunk
    return out.reshape(*out.shape[:-1], *points[0].shape)


def check_points(
    position: ArrayLike, time: ArrayLike, transverse: ArrayLike | None = None
) -> tuple[Array, ...]:
    """Return positions, times and transverse coordinates, if given, as broadcast doubles.

    Integers must be exact doubles; other numbers are rounded to the nearest double.

    Raises ValueError for values that are not finite real numbers, and for shapes that do not
    broadcast.

    >>> check_points([1, 2], 1j)
    Traceback (most recent call last):
    ...
    ValueError: every time must be a real number, got complex128 (take its real part)
    """
    named = [("position", position), ("time", time)]
    named += [] if transverse is None else [("transverse coordinate", transverse)]
    arrays = [real_array(f"every {name}", values) for name, values in named]
    try:
        return tuple(np.broadcast_arrays(*arrays))
    except ValueError:
        third = "" if transverse is None else " and transverse coordinate"
        names = f"position, time{third}" if third else "position and time"
        raise ValueError(
            f"{names} must broadcast, got the shapes {' and '.join(str(a.shape) for a in arrays)} "
            "(give one of them a further axis)"
        ) from None
