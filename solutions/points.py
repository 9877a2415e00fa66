"""Points of evaluation: checked, broadcast, and cut into chunks that stay in the cache."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from functools import lru_cache
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["check_points", "evaluate_points"]

Array = NDArray[np.float64]

CHUNK = 4096


@lru_cache(maxsize=1)
def _executor() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="wave")


def evaluate_points(function: Callable[[Array, Array], Array], x: Array, t: Array) -> Array:
    """``function`` at points of one shape: ``(..., points)`` becomes ``(..., *shape)``.

    ``function`` takes flat contiguous arrays of one size. Chunks run in threads, as the compiled
    loops release the interpreter.

    >>> grid = check_points([1, 2], [[3], [4]])
    >>> evaluate_points(lambda x, t: np.stack([x, x * t]), *grid).tolist()
    [[[1.0, 2.0], [1.0, 2.0]], [[3.0, 6.0], [4.0, 8.0]]]
    """
    flat_x, flat_t = np.ravel(x), np.ravel(t)
    slices = [slice(start, start + CHUNK) for start in range(0, max(flat_x.size, 1), CHUNK)]
    if len(slices) == 1:
        out = function(flat_x.copy(), flat_t.copy())
    else:
        chunks = _executor().map(lambda s: function(flat_x[s].copy(), flat_t[s].copy()), slices)
        out = np.concatenate(list(chunks), axis=-1)
    return out.reshape(*out.shape[:-1], *x.shape)


def check_points(position: ArrayLike, time: ArrayLike) -> tuple[Array, Array]:
    """Positions and times as doubles, broadcast together.

    Integers must be doubles exactly; other numbers are rounded to the nearest double.

    Raises ValueError for what is no finite real number, and for shapes that do not broadcast.

    >>> check_points([1, 2], 1j)
    Traceback (most recent call last):
    ...
    ValueError: every time must be a real number, got complex128 (take its real part)
    """
    x, t = _doubles("position", position), _doubles("time", time)
    try:
        x, t = np.broadcast_arrays(x, t)
    except ValueError:
        raise ValueError(
            f"position and time must broadcast, got the shapes {x.shape} and {t.shape} "
            "(give one of them a further axis)"
        ) from None
    return x, t


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


def _shown(value: object) -> str:
    from derive.algebra.exact_numbers import shown  # with SymPy, for what is wrong alone

    return shown(value)


def _check_integers(name: str, integers: NDArray[Any], doubles: Array) -> None:
    beyond = np.abs(doubles) >= 2.0**53
    for integer, double in zip(integers[beyond].tolist(), doubles[beyond].tolist(), strict=True):
        if integer != int(double):
            raise ValueError(
                f"every integer {name} must be a double exactly, got {_shown(integer)} "
                "(use Wave.mp)"
            )


def _from_objects(name: str, objects: NDArray[Any]) -> Array:
    """Doubles from Python's own numbers (int of any size, Fraction, Decimal, ...)."""
    doubles = np.empty(objects.shape)
    for index, number in np.ndenumerate(objects):
        if isinstance(number, bool | np.bool_) or not isinstance(number, Real | Decimal):
            raise ValueError(
                f"every {name} must be a real number, got {_shown(number)} "
                f"of type {type(number).__name__} (convert it to numbers)"
            )
        try:
            doubles[index] = float(number)
        except OverflowError:
            raise ValueError(
                f"every {name} must be finite as a double, got {_shown(number)} (take less)"
            ) from None
        if isinstance(number, Integral):
            _check_integers(name, np.array([number], dtype=object), doubles[index][None])
    return doubles
