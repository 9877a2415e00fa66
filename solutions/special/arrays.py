"""Broadcasting of the two arguments of a compiled loop."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def flat_pair(a: ArrayLike, b: ArrayLike) -> tuple[Array, Array, tuple[int, ...]]:
    """Return a and b broadcast together as flat float arrays, and their common shape.

    >>> first, second, shape = flat_pair([1, 2, 3], [[0.5], [1.5]])
    >>> second.tolist(), shape
    ([0.5, 0.5, 0.5, 1.5, 1.5, 1.5], (2, 3))

    Raises:
        ValueError: if the shapes do not broadcast.
    """
    shape = np.broadcast_shapes(np.shape(a), np.shape(b))
    first, second = np.empty(shape), np.empty(shape)
    first[...], second[...] = a, b
    return first.ravel(), second.ravel(), shape
