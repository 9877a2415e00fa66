"""Exponential, logarithm, tanh and sech in double-double, block by block.

Each fills ``z`` from ``x``; ``scratch`` is an array of ``SCRATCH`` blocks.
"""

import math

import numpy as np
from numpy.typing import NDArray

from solutions.jit import njit
from solutions.special.blocks import BLOCK, decay, load, store
from solutions.special.doubledouble import (
    add,
    multiply,
    reciprocal,
    scale,
    subtract,
)

__all__ = ["SCRATCH", "exponential", "logarithm", "sech", "tanh"]

Array = NDArray[np.float64]

SCRATCH = 7


@njit(error_model="numpy")
def _decay(x: Array, factor: float, scratch: Array) -> None:
    """Fill scratch[3] with exp(-factor |x|), scratch[4] with 1 minus that."""
    for i in range(BLOCK):
        store(scratch[0], i, scale(load(x, i), factor if x[i] >= 0.0 else -factor))
    decay(scratch[0], scratch[1], scratch[2], scratch[3], scratch[4])


@njit(error_model="numpy")
def exponential(x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with exp(x)."""
    _decay(x, 1.0, scratch)
    fall = scratch[3]
    for i in range(BLOCK):
        falls, rises = load(fall, i), reciprocal(load(fall, i))
        down = x[i] <= 0.0
        store(z, i, (falls[0] if down else rises[0], falls[1] if down else rises[1]))


@njit(error_model="numpy")
def logarithm(x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with log(x): one Newton step from the double value."""
    start = scratch[5]
    for i in range(BLOCK):
        start[i] = -math.log(x[i])
        start[i + BLOCK] = 0.0
    exponential(start, scratch[6], scratch)
    for i in range(BLOCK):
        rest = subtract(multiply(load(x, i), load(scratch[6], i)), (1.0, 0.0))
        rest = subtract(rest, scale(multiply(rest, rest), 0.5))
        store(z, i, add((-start[i], 0.0), rest))


@njit(error_model="numpy")
def tanh(x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with tanh(x), of full relative precision."""
    _decay(x, 2.0, scratch)
    fall, rise = scratch[3], scratch[4]
    for i in range(BLOCK):
        value = multiply(load(rise, i), reciprocal(add((1.0, 0.0), load(fall, i))))
        store(z, i, scale(value, 1.0 if x[i] >= 0.0 else -1.0))


@njit(error_model="numpy")
def sech(x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with sech(x)."""
    _decay(x, 1.0, scratch)
    fall = scratch[3]
    for i in range(BLOCK):
        value = load(fall, i)
        store(
            z, i, multiply(scale(value, 2.0), reciprocal(add((1.0, 0.0), multiply(value, value))))
        )
