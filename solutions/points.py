"""Points of space and time as doubles: checked, broadcast, cut into chunks for the cache."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from functools import lru_cache
from itertools import chain
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.support.compiled.cores import usable_cores
from longwave.support.user_files import shown

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
    found = [_doubles(name, values) for name, values in given]
    try:
        return tuple(np.broadcast_arrays(*found))
    except ValueError:
        names = "position and time" if across is None else "position, time and place across"
        raise ValueError(
            f"{names} must broadcast, got the shapes {' and '.join(str(a.shape) for a in found)} "
            "(give one of them a further axis)"
        ) from None


def _doubles(name: str, values: ArrayLike) -> Array:
    if np.ma.is_masked(values):
        raise ValueError(f"no {name} may be masked, got a masked array (leave such points out)")
    try:
        array = np.asarray(values)
    except (ValueError, TypeError):
        raise ValueError(
            f"every {name} must be a number or an array of one shape, got {type(values).__name__} "
            "with rows of different lengths or no numbers (make it an array first)"
        ) from None
    if array.dtype.kind == "O":
        doubles = _from_objects(name, array)
    elif array.dtype.kind in "iuf":
        with np.errstate(over="ignore"):
            doubles = array.astype(float)
        if array.dtype.kind != "f":
            _check_integers(name, array, doubles)
    else:
        remedy = {"c": "take its real part", "b": "0 and 1 are numbers"}
        raise ValueError(
            f"every {name} must be a real number, got {array.dtype} "
            f"({remedy.get(array.dtype.kind, 'convert it to numbers')})"
        )
    if not np.all(np.isfinite(doubles)):
        raise ValueError(
            f"every {name} must be finite, got NaN or infinity (leave such points out)"
        )
    return doubles


def _check_integers(name: str, integers: NDArray[Any], doubles: Array) -> None:
    beyond = np.abs(doubles) >= 2.0**53
    for integer, double in zip(integers[beyond].tolist(), doubles[beyond].tolist(), strict=True):
        if integer != int(double):
            raise ValueError(
                f"every integer {name} must be a double exactly, got {shown(integer)} (use Wave.mp)"
            )


def _from_objects(name: str, objects: NDArray[Any]) -> Array:
    """Doubles from Python's own numbers (int of any size, Fraction, Decimal, ...)."""
    doubles = np.empty(objects.shape)
    for index, number in np.ndenumerate(objects):
        if isinstance(number, bool | np.bool_) or not isinstance(number, Real | Decimal):
            raise ValueError(
                f"every {name} must be a real number, got {shown(number)} "
                f"of type {type(number).__name__} (convert it to numbers)"
            )
        try:
            doubles[index] = float(number)
        except OverflowError:
            raise ValueError(
                f"every {name} must be finite as a double, got {shown(number)} (take less)"
            ) from None
        if isinstance(number, Integral):
            _check_integers(name, np.array([number], dtype=object), doubles[index][None])
    return doubles
