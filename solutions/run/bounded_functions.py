"""Exponential, logarithm, tanh and sech of bounded numbers, block by block.

Each fills ``z`` from ``x``; ``scratch`` is an array of ``SCRATCH`` blocks.
"""

import math

import numpy as np
from numpy.typing import NDArray

from solutions.run.block_functions import BLOCK, decay, load
from solutions.run.block_functions import store as store_pair
from solutions.run.bounded import TINY, UNIT, relative_error, store
from solutions.run.doubledouble import Pair, add, multiply, reciprocal, scale, subtract
from solutions.run.jit import njit

__all__ = ["SCRATCH", "exponential", "logarithm", "sech", "tanh"]

Array = NDArray[np.float64]

SCRATCH = 7

_GONE = 680.0
"""``2 exp(-_GONE)`` is below ``TINY``."""


@njit(error_model="numpy")
def _is_gone(x: Array, i: int) -> bool:
    """Whether exp(-|x|) is below ``TINY`` for certain."""
    return abs(x[i]) - x[i + 2 * BLOCK] > _GONE


@njit(error_model="numpy")
def _store_exponential(z: Array, i: int, value: Pair, x: Array, is_falling: bool) -> None:
    """Store a multiple of exp(x) or of what has no larger logarithmic derivative."""
    e, size = x[i + 2 * BLOCK], abs(x[i])
    moved = 2.0 * e + UNIT * (1.0 + size) if e <= 0.5 else math.inf
    error = TINY if is_falling and _is_gone(x, i) else value[0] * moved + TINY
    store(z, i, (value[0], value[1], error))


@njit(error_model="numpy")
def _decay(x: Array, factor: float, scratch: Array) -> None:
    """Fill scratch[3] with exp(-factor |x|), scratch[4] with 1 minus that."""
    for i in range(BLOCK):
        store_pair(scratch[0], i, scale(load(x, i), factor if x[i] >= 0.0 else -factor))
    decay(scratch[0], scratch[1], scratch[2], scratch[3], scratch[4])


@njit(error_model="numpy")
def exponential(x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with exp(x)."""
    _decay(x, 1.0, scratch)
    fall = scratch[3]
    for i in range(BLOCK):
        falls, rises = load(fall, i), reciprocal(load(fall, i))
        down = x[i] <= 0.0
        value = (falls[0] if down else rises[0], falls[1] if down else rises[1])
        _store_exponential(z, i, value, x, down)


@njit(error_model="numpy")
def logarithm(x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with log(x): one Newton step from the double value."""
    start = scratch[5]
    for i in range(BLOCK):
        store(start, i, (-math.log(x[i]), 0.0, 0.0))
    exponential(start, scratch[6], scratch)
    for i in range(BLOCK):
        rest = subtract(multiply(load(x, i), load(scratch[6], i)), (1.0, 0.0))
        rest = subtract(rest, scale(multiply(rest, rest), 0.5))
        high, low = add((-start[i], 0.0), rest)
        moved = relative_error(x[i + 2 * BLOCK] / x[i])
        store(z, i, (high, low, moved + UNIT * (1.0 + abs(high))))


@njit(error_model="numpy")
def tanh(x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with tanh(x), of full relative precision."""
    _decay(x, 2.0, scratch)
    fall, rise = scratch[3], scratch[4]
    for i in range(BLOCK):
        value = multiply(load(rise, i), reciprocal(add((1.0, 0.0), load(fall, i))))
        high, low = scale(value, 1.0 if x[i] >= 0.0 else -1.0)
        e = x[i + 2 * BLOCK]
        slope = min(1.0, 12.0 * fall[i]) if e <= 0.5 else 1.0  # sech**2 <= 4 exp(1) fall nearby
        moved = 0.0 if _is_gone(x, i) else slope * e
        store(z, i, (high, low, moved + (UNIT * abs(high) + TINY)))


@njit(error_model="numpy")
def sech(x: Array, z: Array, scratch: Array) -> None:
    """Fill ``z`` with sech(x)."""
    _decay(x, 1.0, scratch)
    fall = scratch[3]
    for i in range(BLOCK):
        value = load(fall, i)
        inverse = reciprocal(add((1.0, 0.0), multiply(value, value)))
        _store_exponential(z, i, multiply(scale(value, 2.0), inverse), x, True)
