"""Types of arrays, and conversion of user input to doubles; what is not real is refused."""

from decimal import Decimal
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Indices = NDArray[np.int64]
Mask = NDArray[np.bool_]

REMEDIES = {"c": "take its real part", "b": "0 and 1 are numbers"}
"""Remedies shown for arrays that are not real numbers, keyed by `dtype.kind`."""


def real_array(item: str, values: ArrayLike, allows_nan: bool = False) -> Array:
    """Return an array of doubles; ``item`` names its entries in errors, such as "every time".

    Integers must be exactly representable as doubles; other numbers are rounded to the nearest
    double. Raises ValueError in one line for complex numbers, truth values, texts, masked entries,
    rows of different lengths and, unless ``allows_nan``, for values that are not finite.

    >>> real_array("every time", [1, 2.5])
    array([1. , 2.5])
    >>> real_array("every time", 1j)
    Traceback (most recent call last):
    ...
    ValueError: every time must be a real number, got complex128 (take its real part)
    """
    if np.ma.is_masked(values):
        raise ValueError(f"{item} must not be masked, got a masked array (leave such entries out)")
    try:
        array = np.asarray(values)
    except (ValueError, TypeError):
        raise ValueError(
            f"{item} must be a number or an array of one shape, got {type(values).__name__} "
            "with rows of different lengths or no numbers (make it an array first)"
        ) from None
    if array.dtype.kind == "O":
        doubles = _from_objects(item, array)
    elif array.dtype.kind in "iuf":
        with np.errstate(over="ignore"):
            doubles = array.astype(float, copy=False)
        if array.dtype.kind != "f":
            _check_integers(item, array, doubles)
    else:
        got = _shown(values) if array.dtype.kind in "SU" else array.dtype
        remedy = REMEDIES.get(array.dtype.kind, "convert it to numbers")
        raise ValueError(f"{item} must be a real number, got {got} ({remedy})")
    if not (allows_nan or np.all(np.isfinite(doubles))):
        raise ValueError(f"{item} must be finite, got NaN or infinity (leave such entries out)")
    return doubles


def _check_integers(item: str, integers: NDArray[Any], doubles: Array) -> None:
    """Raise ValueError for an integer that is not exactly a double."""
    beyond = np.abs(doubles) >= 2.0**53
    for integer, double in zip(integers[beyond].tolist(), doubles[beyond].tolist(), strict=True):
        if integer != int(double):
            raise ValueError(
                f"{item} must be exactly a double, got the integer {_shown(integer)} (use Wave.mp)"
            )


def _from_objects(item: str, objects: NDArray[Any]) -> Array:
    """Return doubles from Python's own numbers (int of any size, Fraction, Decimal, ...)."""
    doubles = np.empty(objects.shape)
    for index, number in np.ndenumerate(objects):
        if isinstance(number, bool | np.bool_) or not isinstance(number, Real | Decimal):
            raise ValueError(
                f"{item} must be a real number, got {_shown(number)} "
                f"of type {type(number).__name__} (convert it to numbers)"
            )
        try:
            doubles[index] = float(number)
        except OverflowError:
            raise ValueError(
                f"{item} must be finite as a double, got {_shown(number)} (take less)"
            ) from None
        if isinstance(number, Integral):
            _check_integers(item, np.array([number], dtype=object), doubles[index][None])
    return doubles


def _shown(value: object) -> str:
    """Return the value as text for errors."""
    from longwave.support.user_files import shown  # for errors alone

    return shown(value)
