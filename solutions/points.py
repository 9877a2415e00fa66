"""Evaluation at many points: broadcasting, and chunks that stay in the cache, on every core."""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["evaluate_points"]

Array = NDArray[np.float64]

CHUNK = 4096


@lru_cache(maxsize=1)
def _executor() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix="wave")


def evaluate_points(function: Callable[[Array, Array], Array], x: ArrayLike, t: ArrayLike) -> Array:
    """``function`` at the broadcast points: ``(..., points)`` becomes ``(..., *shape)``.

    ``function`` takes flat contiguous arrays of one size. Chunks run in threads, as the compiled
    loops release the interpreter.

    >>> evaluate_points(lambda x, t: np.stack([x, x * t]), [1, 2], [[3], [4]]).tolist()
    [[[1.0, 2.0], [1.0, 2.0]], [[3.0, 6.0], [4.0, 8.0]]]
    """
    x, t = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(t, dtype=float))
    flat_x, flat_t = np.ravel(x), np.ravel(t)
    slices = [slice(start, start + CHUNK) for start in range(0, max(flat_x.size, 1), CHUNK)]
    if len(slices) == 1:
        out = function(np.ascontiguousarray(flat_x), np.ascontiguousarray(flat_t))
    else:
        chunks = _executor().map(lambda s: function(flat_x[s].copy(), flat_t[s].copy()), slices)
        out = np.concatenate(list(chunks), axis=-1)
    return out.reshape(*out.shape[:-1], *x.shape)
