"""Blocks of double-double numbers, and sine, cosine and exponential of a block.

A block is an array of ``BLOCK`` high parts, then as many low parts.  Loops over it have no branch
and call nothing but the primitives of `doubledouble`: LLVM then runs them on vectors.  Taylor
series have their first terms in double-double and the tail, which is below 1e-16 of the sum, in
double.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from solutions.run.doubledouble import (
    Array,
    Pair,
    add,
    add_loosely,
    fma,
    multiply,
    power_of_half,
    scale,
    split,
    subtract,
    two_sum,
)
from solutions.run.jit import njit

BLOCK = 128

_TERMS = 14
_PAIRS = 9
_HALVINGS = 4
_LOG2 = (0.6931471805599453, 2.3190468138462996e-17)
_FARTHEST = 708.0  # exp(-w) is taken as 0 beyond


def _inverse_factorials(first: int, stride: int) -> Array:
    return np.array([split(f"1/{factorial(first + stride * n)}") for n in range(_TERMS)])


_SINE = _inverse_factorials(1, 2)
_COSINE = _inverse_factorials(0, 2)
_EXPONENTIAL = _inverse_factorials(1, 1)


@njit(error_model="numpy")
def load(block: Array, i: int) -> Pair:
    """Return the i-th number of a block."""
    return block[i], block[i + BLOCK]


@njit(error_model="numpy")
def store(block: Array, i: int, value: Pair) -> None:
    """Set the i-th number of a block."""
    block[i], block[i + BLOCK] = value


@njit(error_model="numpy")
def get(w: Array, row: np.int64, i: int) -> Pair:
    """Return the i-th number of a row of `w`, blocks one after the other.

    Unsigned indices: with numba's test for negative ones the loops do not run on vectors.
    """
    return w[np.uint64(2 * BLOCK * row + i)], w[np.uint64(2 * BLOCK * row + BLOCK + i)]


@njit(error_model="numpy")
def put(w: Array, row: np.int64, i: int, value: Pair) -> None:
    """Set the i-th number of a row of `w`."""
    w[np.uint64(2 * BLOCK * row + i)], w[np.uint64(2 * BLOCK * row + BLOCK + i)] = value


@njit(error_model="numpy")
def block_of(w: Array, row: np.int64) -> Array:
    """Return a row of `w` as a block."""
    return w[2 * BLOCK * row : 2 * BLOCK * (row + 1)]


@njit(error_model="numpy")
def _polynomial(coefficients: Array, z: Array, total: Array) -> None:
    """Fill `total` with the sum of the coefficients times powers of z, |z| <= 0.63."""
    for i in range(BLOCK):
        total[i] = 0.0
        total[i + BLOCK] = 0.0
    for n in range(_TERMS - 1, _PAIRS - 1, -1):
        c = coefficients[n, 0]
        for i in range(BLOCK):
            total[i] = fma(z[i], total[i], c)
    for n in range(_PAIRS - 1, -1, -1):
        high, low = coefficients[n, 0], coefficients[n, 1]
        for i in range(BLOCK):
            product = multiply(load(z, i), load(total, i))
            store(total, i, add_loosely((high, low), product))


@njit(error_model="numpy")
def sine_cosine(v: Array, z: Array, sine: Array, cosine: Array) -> None:
    """Fill `sine` and `cosine` for |v| <= 0.79; `z` is scratch."""
    for i in range(BLOCK):
        square = multiply(load(v, i), load(v, i))
        store(z, i, (-square[0], -square[1]))
    _polynomial(_COSINE, z, cosine)
    _polynomial(_SINE, z, sine)
    for i in range(BLOCK):
        store(sine, i, multiply(load(v, i), load(sine, i)))


@njit(error_model="numpy")
def decay(w: Array, x: Array, power: Array, fall: Array, rise: Array) -> None:
    """Fill `fall` with exp(-w) and `rise` with 1 - exp(-w) for w >= 0; `x`, `power` are scratch.

    Both have full relative precision; exp(-w) is 0 for w > 708.
    """
    for i in range(BLOCK):
        far = w[i] > _FARTHEST
        near = 0.0 if far else w[i], 0.0 if far else w[i + BLOCK]
        n = np.floor(near[0] / _LOG2[0] + 0.5)
        power[i] = 0.0 if far else power_of_half(n)
        store(x, i, scale(subtract(scale(_LOG2, n), near), 0.5**_HALVINGS))
    _polynomial(_EXPONENTIAL, x, fall)
    for i in range(BLOCK):
        store(x, i, multiply(load(x, i), load(fall, i)))
    for _ in range(_HALVINGS):
        for i in range(BLOCK):
            p = load(x, i)
            store(x, i, add_loosely(scale(p, 2.0), multiply(p, p)))
    for i in range(BLOCK):
        p, part = scale(load(x, i), power[i]), power[i]
        store(fall, i, add((part, 0.0), p))
        store(rise, i, subtract(two_sum(1.0, -part), p))
