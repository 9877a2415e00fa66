"""Sine, cosine and exponential in double-double, and linear phases formed in it.

Taylor series with the first terms in double-double and the tail, which is below 1e-16 of the
sum, in double.
"""

from __future__ import annotations

from math import factorial

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from solutions.special.arrays import Array, flat_pair
from solutions.special.doubledouble import (
    Pair,
    add,
    multiply,
    quick_two_sum,
    scale,
    split,
    subtract,
    two_prod,
    two_sum,
)

_INVERSE_FACTORIALS = tuple(split(f"1/{factorial(n)}") for n in range(28))
_LOG2 = (0.6931471805599453, 2.3190468138462996e-17)
_PAIRS = 9
_HALVINGS = 4


@njit(error_model="numpy")
def _alternating(first: int, z: Pair) -> Pair:
    """Return the sum over n of (-z)^n / (first + 2n)!, for 0 <= z <= 0.63."""
    tail = 0.0
    for n in range(13, _PAIRS - 1, -1):
        tail = _INVERSE_FACTORIALS[first + 2 * n][0] - z[0] * tail
    total = (tail, 0.0)
    for n in range(_PAIRS - 1, -1, -1):
        total = subtract(_INVERSE_FACTORIALS[first + 2 * n], multiply(z, total))
    return total


@njit(error_model="numpy")
def sine_cosine(v: Pair) -> tuple[Pair, Pair]:
    """Return (sin v, cos v) for |v| <= 0.79."""
    z = multiply(v, v)
    return multiply(v, _alternating(1, z)), _alternating(0, z)


@njit(error_model="numpy")
def exponential_minus_one(v: Pair) -> Pair:
    """Return exp(v) - 1 for |v| <= 0.35, with full relative precision."""
    x = scale(v, 0.5**_HALVINGS)
    tail = 0.0
    for n in range(14, _PAIRS, -1):
        tail = _INVERSE_FACTORIALS[n][0] + x[0] * tail
    total = (tail, 0.0)
    for n in range(_PAIRS, 0, -1):
        total = add(_INVERSE_FACTORIALS[n], multiply(x, total))
    total = multiply(x, total)
    for _ in range(_HALVINGS):
        total = add(scale(total, 2.0), multiply(total, total))
    return total


@njit(error_model="numpy")
def decay(w: Pair) -> tuple[Pair, Pair]:
    """Return (exp(-w), 1 - exp(-w)) for w >= 0, each with full relative precision."""
    n = np.floor(w[0] / _LOG2[0] + 0.5)
    p = exponential_minus_one(subtract(scale(_LOG2, n), w))
    power = 0.5**n
    return scale(add((1.0, 0.0), p), power), subtract(two_sum(1.0, -power), scale(p, power))


@njit(cache=True, error_model="numpy")
def _combine(n: Array, a: Pair, t: Array, b: Pair, out: Array) -> None:
    for i in range(n.size):
        an, bt = two_prod(a[0], n[i]), two_prod(b[0], t[i])
        an = quick_two_sum(an[0], an[1] + a[1] * n[i])
        bt = quick_two_sum(bt[0], bt[1] + b[1] * t[i])
        out[0, i], out[1, i] = add(an, bt)


def linear_phase(n: ArrayLike, a: Pair, t: ArrayLike, b: Pair) -> tuple[Array, Array]:
    """Return a n + b t as a double-double pair of arrays.

    Args:
        n, t: sites and times (any floats), broadcast together.
        a, b: wave number and minus the frequency, as pairs; `split` makes them.

    >>> hi, lo = linear_phase([10**6], split("1/3"), 10**6, split("-1/3"))
    >>> hi.tolist(), lo.tolist()
    ([0.0], [0.0])
    """
    sites, times, shape = flat_pair(n, t)
    out = np.empty((2, sites.size))
    _combine(sites, a, times, b, out)
    high, low = out.reshape(2, *shape)
    return high, low
