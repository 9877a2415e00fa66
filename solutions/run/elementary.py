"""Sine, cosine, exponential, logarithm, tanh and sech of blocks of bounded numbers.

Each fills the block ``z`` from the block ``x``; ``scratch`` is an array of ``SCRATCH`` blocks. All
but sine and cosine use exp(-|x|), which `decay_of` leaves in ``scratch``. The machine calls
`decay_of` in one place only, because LLVM compiles it anew for each call. Loops over a block have
no branch and call only the primitives of `doubledouble`, so that LLVM vectorises them. Taylor
series have their first terms in double-double and the others, below 1e-16 of the sum, in double.
"""

from __future__ import annotations

import math
from math import factorial

import numpy as np

from longwave.solutions.run import doubledouble as dd
from longwave.solutions.run.bounded import (
    BLOCK,
    TINY,
    UNIT,
    load_pair,
    relative_error,
    store,
    store_pair,
)
from longwave.support.compiled.jit import njit

SCRATCH = 7
"""Number of blocks in the scratch memory."""

_TERMS, _PAIRS = 14, 9
"""Number of terms of a Taylor series; number of its first terms that are in double-double."""

_HALVINGS = 4
"""Number of halvings of the argument before exp's series is summed."""

_LOG2 = (0.6931471805599453, 2.3190468138462996e-17)
_ZERO_ABOVE, _NEGLIGIBLE_ABOVE = 708.0, 680.0
"""exp(-w) is replaced by 0 for w > ``_ZERO_ABOVE``; 2 exp(-w) is below ``TINY`` for w >
``_NEGLIGIBLE_ABOVE``."""


def _inverse_factorials(first: int, stride: int) -> dd.Array:
    return np.array([dd.split(f"1/{factorial(first + stride * n)}") for n in range(_TERMS)])


_SINE = _inverse_factorials(1, 2)
_COSINE = _inverse_factorials(0, 2)
_EXPONENTIAL = _inverse_factorials(1, 1)


@njit()
def _polynomial(coefficients: dd.Array, z: dd.Array, total: dd.Array) -> None:
    """Fill `total` with the sum of the coefficients times powers of z, |z| <= 0.63."""
    for i in range(BLOCK):
        total[i] = 0.0
        total[i + BLOCK] = 0.0
    for n in range(_TERMS - 1, _PAIRS - 1, -1):
        c = coefficients[n, 0]
        for i in range(BLOCK):
            total[i] = dd.fma(z[i], total[i], c)
    for n in range(_PAIRS - 1, -1, -1):
        high, low = coefficients[n, 0], coefficients[n, 1]
        for i in range(BLOCK):
            product = dd.multiply(load_pair(z, i), load_pair(total, i))
            store_pair(total, i, dd.add_loosely((high, low), product))


@njit()
def sine_or_cosine(x: dd.Array, is_sine: bool, z: dd.Array, scratch: dd.Array) -> None:
    """Fill ``z`` with cos(x) or, if ``is_sine``, sin(x) to full relative precision; |x| <= 0.79."""
    square, series = scratch[0], scratch[1]
    for i in range(BLOCK):
        high, low = dd.multiply(load_pair(x, i), load_pair(x, i))
        store_pair(square, i, (-high, -low))
    _polynomial(_SINE if is_sine else _COSINE, square, series)
    for i in range(BLOCK):
        e, (high, low) = x[i + 2 * BLOCK], load_pair(series, i)
        if is_sine:
            high, low = dd.multiply(load_pair(x, i), (high, low))
            store(z, i, (high, low, e + (UNIT * abs(high) + TINY)))
        else:
            store(z, i, (high, low, (abs(x[i]) + e) * e + UNIT))


@njit()
def decay(w: dd.Array, x: dd.Array, power: dd.Array, fall: dd.Array, rise: dd.Array) -> None:
    """Fill `fall` with exp(-w) and `rise` with 1 - exp(-w) for w >= 0; `x`, `power` are scratch.

    Both have full relative precision; exp(-w) is 0 for w > 708.
    """
    for i in range(BLOCK):
        far = w[i] > _ZERO_ABOVE
        near = 0.0 if far else w[i], 0.0 if far else w[i + BLOCK]
        n = np.floor(near[0] / _LOG2[0] + 0.5)
        power[i] = 0.0 if far else dd.power_of_half(n)
        store_pair(x, i, dd.scale(dd.subtract(dd.scale(_LOG2, n), near), 0.5**_HALVINGS))
    _polynomial(_EXPONENTIAL, x, fall)
    for i in range(BLOCK):
        store_pair(x, i, dd.multiply(load_pair(x, i), load_pair(fall, i)))
    for _ in range(_HALVINGS):
        for i in range(BLOCK):
            p = load_pair(x, i)
            store_pair(x, i, dd.add_loosely(dd.scale(p, 2.0), dd.multiply(p, p)))
    for i in range(BLOCK):
        p, part = dd.scale(load_pair(x, i), power[i]), power[i]
        store_pair(fall, i, dd.add((part, 0.0), p))
        store_pair(rise, i, dd.subtract(dd.two_sum(1.0, -part), p))


@njit()
def _is_negligible(x: dd.Array, i: int) -> bool:
    """Return whether exp(-|x|) is certainly below ``TINY``."""
    return abs(x[i]) - x[i + 2 * BLOCK] > _NEGLIGIBLE_ABOVE


@njit()
def _store_exponential(z: dd.Array, i: int, value: dd.Pair, x: dd.Array, is_falling: bool) -> None:
    """Store ``value`` with its bound; it is a function of x that varies no faster than exp(x).

    ``is_falling`` says that it is at most 2 exp(-|x|), hence negligible for large |x|.
    """
    e, size = x[i + 2 * BLOCK], abs(x[i])
    input_error = 2.0 * e + UNIT * (1.0 + size) if e <= 0.5 else math.inf
    error = TINY if is_falling and _is_negligible(x, i) else value[0] * input_error + TINY
    store(z, i, (value[0], value[1], error))


@njit()
def decay_of(x: dd.Array, factor: float, scratch: dd.Array) -> None:
    """Fill scratch[3] with exp(-factor |x|) and scratch[4] with 1 - exp(-factor |x|)."""
    for i in range(BLOCK):
        store_pair(scratch[0], i, dd.scale(load_pair(x, i), factor if x[i] >= 0.0 else -factor))
    decay(scratch[0], scratch[1], scratch[2], scratch[3], scratch[4])


@njit()
def exponential(x: dd.Array, z: dd.Array, scratch: dd.Array) -> None:
    """Fill ``z`` with exp(x) from the ``scratch`` that `decay_of` x has filled."""
    fall = scratch[3]
    for i in range(BLOCK):
        falls, rises = load_pair(fall, i), dd.reciprocal(load_pair(fall, i))
        down = x[i] <= 0.0
        value = (falls[0] if down else rises[0], falls[1] if down else rises[1])
        _store_exponential(z, i, value, x, down)


@njit()
def start_logarithm(x: dd.Array, start: dd.Array) -> None:
    """Fill ``start`` with -log(x) in double precision, where `logarithm` starts."""
    for i in range(BLOCK):
        store(start, i, (-math.log(x[i]), 0.0, 0.0))


@njit()
def logarithm(x: dd.Array, start: dd.Array, power: dd.Array, z: dd.Array) -> None:
    """Fill ``z`` with log(x) by one step from ``start``, which is about -log(x).

    ``power`` is exp(start).
    """
    for i in range(BLOCK):
        residual = dd.subtract(dd.multiply(load_pair(x, i), load_pair(power, i)), (1.0, 0.0))
        residual = dd.subtract(residual, dd.scale(dd.multiply(residual, residual), 0.5))
        high, low = dd.add((-start[i], 0.0), residual)
        input_error = relative_error(x[i + 2 * BLOCK] / x[i])
        store(z, i, (high, low, input_error + UNIT * (1.0 + abs(high))))


@njit()
def tanh(x: dd.Array, z: dd.Array, scratch: dd.Array) -> None:
    """Fill ``z`` with tanh(x) to full relative precision, after `decay_of` x with factor 2."""
    fall, rise = scratch[3], scratch[4]
    for i in range(BLOCK):
        inverse = dd.reciprocal(dd.add((1.0, 0.0), load_pair(fall, i)))
        value = dd.multiply(load_pair(rise, i), inverse)
        high, low = dd.scale(value, 1.0 if x[i] >= 0.0 else -1.0)
        e = x[i + 2 * BLOCK]
        slope = min(1.0, 12.0 * fall[i]) if e <= 0.5 else 1.0  # sech**2 <= 4 exp(1) fall nearby
        input_error = 0.0 if _is_negligible(x, i) else slope * e
        store(z, i, (high, low, input_error + (UNIT * abs(high) + TINY)))


@njit()
def sech(x: dd.Array, z: dd.Array, scratch: dd.Array) -> None:
    """Fill ``z`` with sech(x) from the ``scratch`` that `decay_of` x has filled."""
    fall = scratch[3]
    for i in range(BLOCK):
        value = load_pair(fall, i)
        inverse = dd.reciprocal(dd.add((1.0, 0.0), dd.multiply(value, value)))
        _store_exponential(z, i, dd.multiply(dd.scale(value, 2.0), inverse), x, True)
