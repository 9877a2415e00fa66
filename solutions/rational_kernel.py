"""The rational solutions in double-double: two bivariate Horner schemes with their derivatives.

A and B of ``f = A + i B`` have degree d when x counts 1 and t counts 3. At each point both are
scaled by a power of two S with ``|x| <= S`` and ``|t| <= S**3``, so that no power overflows: a
term of degree ``d - n`` gets the factor ``S**-n``. A row of the workspace holds ``BLOCK`` high
parts, then as many low parts, as in ``solutions.pair_machine``. numba's disk cache sees changes of
this file only: after a change in ``solutions.special.doubledouble`` remove ``__pycache__``.
"""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from solutions.special.doubledouble import Pair, add, divide, multiply, scale, subtract

__all__ = ["rational_loop"]

Array = NDArray[np.float64]
BLOCK = 64

_VALUE, _X, _XX, _T, _XT, _ROW, _ROW_T, _ROWS = 0, 1, 2, 3, 4, 5, 6, 7
"""Rows of a polynomial's workspace: it, its derivatives (_XX is half the second), one row's."""


@njit(error_model="numpy")
def _step(z: Array, x: Array, y: Array) -> None:
    """``z = z x + y``."""
    for i in range(BLOCK):
        product = multiply((z[i], z[i + BLOCK]), (x[i], x[i + BLOCK]))
        z[i], z[i + BLOCK] = add(product, (y[i], y[i + BLOCK]))


@njit(error_model="numpy")
def _step_scaled(z: Array, x: Array, c: Pair, weight: Array) -> None:
    """``z = z x + c weight``, the weights being powers of two."""
    for i in range(BLOCK):
        product = multiply((z[i], z[i + BLOCK]), (x[i], x[i + BLOCK]))
        z[i], z[i + BLOCK] = add(product, (c[0] * weight[i], c[1] * weight[i]))


@njit(error_model="numpy")
def _prepare(x: Array, t: Array, weights: Array, square: Array) -> None:
    """Scale x and t, fill ``weights[n] = S**-n`` and ``square = t**2``."""
    for i in range(BLOCK):
        size = max(0, math.frexp(x[i])[1], math.ceil(math.frexp(t[i])[1] / 3))
        down = 0.5**size
        x[i], x[i + BLOCK] = x[i] * down, x[i + BLOCK] * down
        t[i], t[i + BLOCK] = t[i] * down**3, t[i + BLOCK] * down**3
        weight = 1.0
        for n in range(weights.shape[0]):
            weights[n, i] = weight
            weight *= down
        pair = t[i], t[i + BLOCK]
        square[i], square[i + BLOCK] = multiply(pair, pair)


@njit(error_model="numpy")
def _row(c: Array, first: int, step: int, x: Array, weights: Array, rows: Array) -> None:
    """One row's value and derivative in ``x`` (t, or its square if ``step`` is 2).

    ``c[j]`` are the coefficients of ``t**j``; ``weights[n0 - 3 j]`` belongs to it.
    """
    value, slope = rows[_ROW], rows[_ROW_T]
    value[:] = 0.0
    slope[:] = 0.0
    top = c.shape[0] - 1
    for j in range(top - (top - first) % step, first - 1, -step):
        _step(slope, x, value)
        _step_scaled(value, x, (c[j, 0], c[j, 1]), weights[weights.shape[0] - 1 - 3 * j])


@njit(error_model="numpy")
def _in_t(first: int, t: Array, square: Array, rows: Array) -> None:
    """From a row in ``t**2`` to ``t**first`` times it, and the derivative in t."""
    value, slope = rows[_ROW], rows[_ROW_T]
    for i in range(BLOCK):
        v, s = (value[i], value[i + BLOCK]), (slope[i], slope[i + BLOCK])
        time = t[i], t[i + BLOCK]
        if first == 1:
            s = add(v, scale(multiply((square[i], square[i + BLOCK]), s), 2.0))
            v = multiply(v, time)
        else:
            s = scale(multiply(s, time), 2.0)
        value[i], value[i + BLOCK] = v
        slope[i], slope[i + BLOCK] = s


@njit(error_model="numpy")
def _polynomial(
    c: Array, parity: int, x: Array, t: Array, square: Array, weights: Array, rows: Array
) -> None:
    """Fill the rows with the polynomial and its derivatives; ``c[i, j]`` belongs to x^i t^j.

    ``parity`` is the common parity of ``i + j``, or -1 if there is none.
    """
    degree = c.shape[0] - 1
    rows[:] = 0.0
    for i in range(degree, -1, -1):
        columns, powers = c[i, : (degree - i) // 3 + 1], weights[: degree - i + 1]
        if parity < 0:
            _row(columns, 0, 1, t, powers, rows)
        else:
            first = (i + parity) % 2
            _row(columns, first, 2, square, powers, rows)
            _in_t(first, t, square, rows)
        _step(rows[_XX], x, rows[_X])
        _step(rows[_X], x, rows[_VALUE])
        _step(rows[_VALUE], x, rows[_ROW])
        _step(rows[_XT], x, rows[_T])
        _step(rows[_T], x, rows[_ROW_T])


@njit(error_model="numpy")
def _cross(A: Pair, b: Pair, a: Pair, B: Pair) -> Pair:
    """``A b - a B``."""
    return subtract(multiply(A, b), multiply(a, B))


@njit(error_model="numpy")
def _dot(A: Pair, a: Pair, B: Pair, b: Pair) -> Pair:
    """``A a + B b``."""
    return add(multiply(A, a), multiply(B, b))


@njit(error_model="numpy")
def _lane(rows: Array, i: int) -> tuple[Pair, Pair, Pair, Pair, Pair]:
    """The polynomial and its derivatives at lane i."""
    j = i + BLOCK
    return (
        (rows[_VALUE, i], rows[_VALUE, j]),
        (rows[_X, i], rows[_X, j]),
        (rows[_XX, i], rows[_XX, j]),
        (rows[_T, i], rows[_T, j]),
        (rows[_XT, i], rows[_XT, j]),
    )


@njit(error_model="numpy")
def _angle_rates(A: Array, B: Array, i: int) -> tuple[Pair, Pair, Pair]:
    """The x, xx and xt derivatives of the angle of A + i B at lane i."""
    a, a_x, a_xx, a_t, a_xt = _lane(A, i)
    b, b_x, b_xx, b_t, b_xt = _lane(B, i)
    inverse = divide((1.0, 0.0), _dot(a, a, b, b))
    w_x = multiply(_cross(a, b_x, a_x, b), inverse)
    growth_x, growth_t = _dot(a, a_x, b, b_x), _dot(a, a_t, b, b_t)
    w_xx = subtract(_cross(a, b_xx, a_xx, b), multiply(w_x, growth_x))
    mixed = add(_cross(a, b_xt, a_xt, b), _cross(a_t, b_x, a_x, b_t))
    w_xt = subtract(mixed, scale(multiply(w_x, growth_t), 2.0))
    return w_x, scale(multiply(w_xx, inverse), 2.0), multiply(w_xt, inverse)


@njit(cache=True, nogil=True, error_model="numpy")
def rational_loop(
    A: Array, B: Array, parities: tuple[int, int], sign: float, x: Array, t: Array, out: Array
) -> None:
    """Fill ``out`` (3, 2, points) with U, U_xi and U_tau from the pairs ``x`` and ``t`` (2, points).

    ``A`` and ``B`` hold the coefficients (degree + 1, degree // 3 + 1, 2); ``sign`` is the
    background; ``x`` is ``xi - 6 tau``.
    """
    degree, points = A.shape[0] - 1, x.shape[1]
    weights = np.empty((degree + 1, BLOCK))
    place, time, square = np.empty((3, 2 * BLOCK))
    rows_A, rows_B = np.empty((2, _ROWS, 2 * BLOCK))
    for start in range(0, points, BLOCK):
        for i in range(BLOCK):
            source = min(start + i, points - 1)
            place[i], place[i + BLOCK] = x[0, source], x[1, source]
            time[i], time[i + BLOCK] = t[0, source], t[1, source]
        _prepare(place, time, weights, square)
        _polynomial(A, parities[0], place, time, square, weights, rows_A)
        _polynomial(B, parities[1], place, time, square, weights, rows_B)
        for i in range(min(BLOCK, points - start)):
            w_x, w_xx, w_xt = _angle_rates(rows_A, rows_B, i)
            down = weights[1, i]
            value = subtract((1.0, 0.0), scale(w_x, 2.0 * down))
            w_xx, w_xt = scale(w_xx, down**2), scale(w_xt, down**4)
            rate = subtract(scale(w_xx, 12.0), scale(w_xt, 2.0))
            out[0, 0, start + i], out[0, 1, start + i] = scale(value, sign)
            out[1, 0, start + i], out[1, 1, start + i] = scale(w_xx, -2.0 * sign)
            out[2, 0, start + i], out[2, 1, start + i] = scale(rate, sign)
