"""The reduced argument and the four theta series in double-double, on blocks of points.

The argument is reduced by quarter periods; of the rest there are circular or hyperbolic functions,
and of these the series.  The same series serve m <= 1/2 (x = 2 cos 2v, nome q) and m > 1/2
(x = 2 cosh 2w, nome q'); terms beyond q^12, below 1e-18 of their sums, are added in double.
Source: DLMF 20.2.

What is computed stands in the rows of one scratch array, each a block.  They are at distances that
LLVM knows, so that it runs the loops on vectors.  As NumPy's integers they have one type: for every
plain one numba would compile anew what takes it.
"""

from __future__ import annotations

import numpy as np

from solutions.run.block_functions import BLOCK, block_of, decay, get, put, sine_cosine
from solutions.run.doubledouble import (
    Array,
    Pair,
    Three,
    add_loosely,
    multiply,
    quick_two_sum,
    reciprocal,
    scale,
    subtract,
    two_prod,
    two_sum,
)
from solutions.run.elliptic_parameter import PairConstants, Series
from solutions.run.jit import njit

U, LOW, J, Q, R, V, WORK, POWER = map(np.int64, range(8))
"""The argument and its third float; its quarter periods; these modulo 4, and whether they are odd;
the rest; the rest times the rate."""

S, C, G, X, Y = map(np.int64, range(8, 13))
"""sin v, cos v, 1, 2 cos 2v, sin 2v, or g sinh v, g cosh v, g = exp(-|v|), 2 cosh 2v, sinh 2v."""

X2, X3, REST = map(np.int64, range(13, 16))
"""2 cos 4v, 2 cos 6v; 2 cos 8v and 2 cos 10v in double."""

THETA3, THETA4, SINE, COSINE, RISE, PLUS, MINUS = map(np.int64, range(16, 23))
"""The series, and the slopes of theta_3 and theta_4."""

SN, CN, DN, EPSILON, ZETA, THETA = map(np.int64, range(23, 29))

ROWS = 29


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


@njit(error_model="numpy")
def multiples(w: Array) -> None:
    """Fill X2, X3 and REST from X."""
    for i in range(BLOCK):
        x = get(w, X, i)
        x2 = add_loosely(multiply(x, x), (-2.0, 0.0))
        x3 = multiply(x, add_loosely(x2, (-1.0, 0.0)))
        x4 = x[0] * x3[0] - x2[0]
        put(w, X2, i, x2)
        put(w, X3, i, x3)
        put(w, REST, i, (x4, x[0] * x4 - x3[0]))


@njit(error_model="numpy")
def _one_and(a: Pair, b: Pair, c: Pair, d: float, series: Series) -> Pair:
    """Return 1 + the sum of a, b, c, d times the coefficients."""
    tail = add_loosely(multiply(series[2], c), (series[3][0] * d, 0.0))
    tail = add_loosely(multiply(series[1], b), tail)
    return add_loosely((1.0, 0.0), add_loosely(multiply(series[0], a), tail))


@njit(error_model="numpy")
def sines(w: Array, series: Series, row: np.int64) -> None:
    """Fill the row with 1 + the sum of coefficients times sin (2n+1)v / sin v."""
    for i in range(BLOCK):
        a = add_loosely((1.0, 0.0), get(w, X, i))
        b = add_loosely(a, get(w, X2, i))
        c = add_loosely(b, get(w, X3, i))
        put(w, row, i, _one_and(a, b, c, c[0] + get(w, REST, i)[0], series))


@njit(error_model="numpy")
def cosines(w: Array, p: PairConstants) -> None:
    """Fill COSINE with the sum of q^(n(n+1)) cos (2n+1)v / cos v."""
    for i in range(BLOCK):
        a = add_loosely(get(w, X, i), (-1.0, 0.0))
        b = subtract(get(w, X2, i), a)
        c = subtract(get(w, X3, i), b)
        put(w, COSINE, i, _one_and(a, b, c, get(w, REST, i)[0] - c[0], p.even_terms))


@njit(error_model="numpy")
def thetas(w: Array, p: PairConstants) -> None:
    """Fill THETA3 and THETA4."""
    for i in range(BLOCK):
        x4, x5 = get(w, REST, i)
        tail = add_loosely(multiply(p.q9, get(w, X3, i)), (p.q25 * x5, 0.0))
        odd = add_loosely(multiply(p.q1, get(w, X, i)), tail)
        tail = add_loosely(multiply(p.q4, get(w, X2, i)), (p.q16 * x4, 0.0))
        even = add_loosely((1.0, 0.0), tail)
        put(w, THETA3, i, add_loosely(even, odd))
        put(w, THETA4, i, add_loosely(even, (-odd[0], -odd[1])))


@njit(error_model="numpy")
def slopes(w: Array, p: PairConstants) -> None:
    """Fill PLUS with -theta_3'/sin 2v, MINUS with theta_4'/sin 2v."""
    for i in range(BLOCK):
        x, x2, x4 = get(w, X, i), get(w, X2, i), get(w, REST, i)[0]
        tail = (20.0 * p.q25 * (1.0 + x2[0] + x4), 0.0)
        tail = add_loosely(scale(multiply(p.q9, add_loosely(x2, (1.0, 0.0))), 12.0), tail)
        odd = add_loosely(scale(p.q1, 4.0), tail)
        tail = (16.0 * p.q16 * (x[0] + get(w, X3, i)[0]), 0.0)
        even = add_loosely(scale(multiply(p.q4, x), 8.0), tail)
        put(w, PLUS, i, add_loosely(odd, even))
        put(w, MINUS, i, add_loosely(odd, (-even[0], -even[1])))
