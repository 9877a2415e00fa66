"""The four theta series in double-double, on blocks of points.

The same series serve m <= 1/2 (x = 2 cos 2v, nome q) and m > 1/2 (x = 2 cosh 2w, nome q'); terms
beyond q^12, below 1e-18 of their sums, are added in double.  Source: DLMF 20.2.
"""

from __future__ import annotations

import numpy as np

from solutions.jit import njit
from solutions.special.arrays import Array
from solutions.special.blocks import BLOCK, get, put
from solutions.special.doubledouble import Pair, add_loosely, multiply, scale, subtract
from solutions.special.pair_constants import PairConstants, Series
from solutions.special.pair_rows import COSINE, MINUS, PLUS, REST, THETA3, THETA4, X2, X3, X


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
