"""The argument in double-double, reduced, and its circular or hyperbolic functions, by blocks."""

from __future__ import annotations

import numpy as np

from solutions.jit import njit
from solutions.special.arrays import Array
from solutions.special.blocks import BLOCK, block_of, decay, get, put, sine_cosine
from solutions.special.doubledouble import (
    Pair,
    Three,
    add_loosely,
    multiply,
    quick_two_sum,
    reciprocal,
    scale,
    two_prod,
    two_sum,
)
from solutions.special.pair_constants import PairConstants
from solutions.special.pair_rows import LOW, POWER, WORK, C, G, J, Q, R, S, U, V, X, Y

_LARGEST = 1e50  # bounds cosh 2v where q' is so small that its terms are zero anyway


@njit(error_model="numpy")
def choose(condition: bool, a: Pair, b: Pair) -> Pair:
    """Return a if the condition holds, else b, without a branch."""
    return (a[0] if condition else b[0]), (a[1] if condition else b[1])


@njit(error_model="numpy")
def _without(u: Three, j: float, quarter: Three) -> Three:
    """Return u - j K as three floats, with an error of 2^-155 |u|."""
    high, e = two_prod(quarter[0], j)
    middle, f = two_prod(quarter[1], j)
    high, g = two_sum(u[0], -high)
    middle, a = two_sum(u[1], -middle)
    middle, b = two_sum(middle, -e)
    middle, c = two_sum(middle, g)
    low = (u[2] - quarter[2] * j) + ((a - f) + (b + c))
    high, middle = two_sum(high, middle)
    middle, low = two_sum(middle, low)
    high, middle = two_sum(high, middle)
    middle, low = two_sum(middle, low)
    return high, middle, low


@njit(error_model="numpy")
def reduce_argument(w: Array, p: PairConstants) -> None:
    """Fill J and R from U + LOW = J K + R with |R| <= K/2, and V = R times the rate.

    Q is J modulo 4, and modulo 2. A quotient of more than 53 bits takes the second step.
    """
    quarter = p.quarter[0] if p.quarter[0] != 0.0 else np.inf
    for i in range(BLOCK):
        u = get(w, U, i)
        first = np.floor(u[0] / quarter + 0.5)
        rest = _without((u[0], u[1], get(w, LOW, i)[0]), first, p.quarter)
        second = np.floor(rest[0] / quarter + 0.5)
        high, middle, low = _without(rest, second, p.quarter)
        r = quick_two_sum(high, middle + low)
        j = first - 4.0 * np.floor(0.25 * first) + (second - 4.0 * np.floor(0.25 * second))
        put(w, J, i, two_sum(first, second))
        put(w, Q, i, (j - 4.0 * np.floor(0.25 * j), j - 2.0 * np.floor(0.5 * j)))
        put(w, R, i, r)
        put(w, V, i, multiply(r, p.rate))


@njit(error_model="numpy")
def circular_functions(w: Array) -> None:
    """Fill S = sin v, C = cos v, G = 1, X = 2 cos 2v, Y = sin 2v."""
    sine_cosine(block_of(w, V), block_of(w, WORK), block_of(w, S), block_of(w, C))
    for i in range(BLOCK):
        s, c = get(w, S, i), get(w, C, i)
        put(w, X, i, add_loosely((2.0, 0.0), scale(multiply(s, s), -4.0)))
        put(w, Y, i, scale(multiply(s, c), 2.0))
        put(w, G, i, (1.0, 0.0))


@njit(error_model="numpy")
def hyperbolic_functions(w: Array) -> None:
    """Fill S = g sinh v, C = g cosh v, G = g = exp(-|v|), X = 2 cosh 2v, Y = sinh 2v (bounded)."""
    for i in range(BLOCK):
        v = get(w, V, i)
        put(w, Y, i, scale(v, 1.0 if v[0] >= 0.0 else -1.0))
    work, power = block_of(w, WORK), block_of(w, POWER)
    decay(block_of(w, Y), work, power, block_of(w, G), block_of(w, S))
    for i in range(BLOCK):
        g, fall = get(w, G, i), get(w, S, i)
        sign = 1.0 if get(w, V, i)[0] >= 0.0 else -1.0
        square = multiply(g, g)
        s = scale(multiply(fall, add_loosely((1.0, 0.0), g)), 0.5 * sign)
        c = scale(add_loosely((1.0, 0.0), square), 0.5)
        inverse = reciprocal(square)
        inverse = choose(square[0] > 1.0 / _LARGEST, inverse, (_LARGEST, 0.0))
        put(w, S, i, s)
        put(w, C, i, c)
        put(w, X, i, add_loosely(square, inverse))
        put(w, Y, i, scale(multiply(multiply(s, c), inverse), 2.0))
