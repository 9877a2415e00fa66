"""The rational solutions in double-double: two bivariate Horner schemes with their derivatives.

A and B of ``f = A + i B`` have degree d when x counts 1 and t counts 3. Their rows, polynomials in
t, are summed once for points that share t. The sums over rows run on blocks of points, with x
divided by a power of two S and a term of degree ``d - n`` by ``S**n``, so that no power overflows.
A row of the workspace holds ``BLOCK`` high parts, then as many low parts, as in
``solutions.pair_machine``.
"""

import math

import numpy as np
from numpy.typing import NDArray

from solutions.jit import njit
from solutions.special.doubledouble import Pair, add, divide, multiply, scale, subtract

__all__ = ["rational_loop"]

Array = NDArray[np.float64]
BLOCK = 128

_VALUE, _X, _XX, _T, _XT = 0, 1, 2, 3, 4
"""Rows of a polynomial's workspace: it and its derivatives (_XX is half the second)."""


@njit(error_model="numpy")
def _step(z: Array, x: Array, y: Array) -> None:
    """``z = z x + y``."""
    for i in range(BLOCK):
        product = multiply((z[i], z[i + BLOCK]), (x[i], x[i + BLOCK]))
        z[i], z[i + BLOCK] = add(product, (y[i], y[i + BLOCK]))


@njit(error_model="numpy")
def _step_weighted(z: Array, x: Array, y: Array, weight: Array) -> None:
    """``z = z x + y weight``, the weights being powers of two."""
    for i in range(BLOCK):
        product = multiply((z[i], z[i + BLOCK]), (x[i], x[i + BLOCK]))
        z[i], z[i + BLOCK] = add(product, (y[i] * weight[i], y[i + BLOCK] * weight[i]))


@njit(error_model="numpy")
def _prepare(x: Array, t: Array, weights: Array) -> None:
    """Divide x by S, with ``|x| <= S`` and ``|t| <= S**3``; fill ``weights[n] = S**-n``."""
    for i in range(BLOCK):
        down = 0.5 ** max(0, math.frexp(x[i])[1], math.ceil(math.frexp(t[i])[1] / 3))
        x[i], x[i + BLOCK] = x[i] * down, x[i + BLOCK] * down
        weight = 1.0
        for n in range(weights.shape[0]):
            weights[n, i] = weight
            weight *= down


@njit(error_model="numpy")
def _row(c: Array, first: int, step: int, t: Pair, square: Pair) -> tuple[Pair, Pair]:
    """The row ``sum c[j] t**j`` and its derivative, over j = first, first + step, ..."""
    variable = square if step == 2 else t
    value = slope = (0.0, 0.0)
    top = c.shape[0] - 1
    for j in range(top - (top - first) % step, first - 1, -step):
        slope = add(multiply(slope, variable), value)
        value = add(multiply(value, variable), (c[j, 0], c[j, 1]))
    if step == 1:
        return value, slope
    slope = scale(multiply(slope, t), 2.0)
    if first == 0:
        return value, slope
    return multiply(value, t), add(value, multiply(slope, t))


@njit(error_model="numpy")
def _rows(c: Array, parity: int, t: Array, values: Array, slopes: Array) -> None:
    """Fill the lanes of each row; ``c[i, j]`` belongs to x^i t^j.

    ``parity`` is the common parity of ``i + j``, or -1 if there is none.
    """
    degree = c.shape[0] - 1
    for i in range(degree + 1):
        columns = c[i, : (degree - i) // 3 + 1]
        first, step = (0, 1) if parity < 0 else ((i + parity) % 2, 2)
        value = slope = (0.0, 0.0)
        for lane in range(BLOCK):
            low = lane + BLOCK
            if lane == 0 or t[lane] != t[lane - 1] or t[low] != t[low - 1]:
                time = t[lane], t[low]
                value, slope = _row(columns, first, step, time, multiply(time, time))
            values[i, lane], values[i, low] = value
            slopes[i, lane], slopes[i, low] = slope


@njit(error_model="numpy")
def _polynomial(values: Array, slopes: Array, x: Array, weights: Array, out: Array) -> None:
    """Fill the rows of ``out`` with the polynomial and its derivatives."""
    degree = values.shape[0] - 1
    out[:] = 0.0
    for i in range(degree, -1, -1):
        _step(out[_XX], x, out[_X])
        _step(out[_X], x, out[_VALUE])
        _step_weighted(out[_VALUE], x, values[i], weights[degree - i])
        _step(out[_XT], x, out[_T])
        _step_weighted(out[_T], x, slopes[i], weights[degree - i])


@njit(error_model="numpy")
def _cross(A: Pair, b: Pair, a: Pair, B: Pair) -> Pair:
    """``A b - a B``."""
    return subtract(multiply(A, b), multiply(a, B))


@njit(error_model="numpy")
def _dot(A: Pair, a: Pair, B: Pair, b: Pair) -> Pair:
    """``A a + B b``."""
    return add(multiply(A, a), multiply(B, b))


@njit(error_model="numpy")
def _lane(rows: Array, row: int, i: int) -> Pair:
    """One lane of a flat workspace."""
    return rows[2 * BLOCK * row + i], rows[2 * BLOCK * row + BLOCK + i]


@njit(error_model="numpy")
def _wave(A: Array, B: Array, weights: Array, sign: float, out: Array) -> None:
    """U, U_xi, U_tau (flat, as the workspaces are) from the angle of A + i B and its rates."""
    for i in range(BLOCK):
        a, a_x, a_xx = _lane(A, _VALUE, i), _lane(A, _X, i), _lane(A, _XX, i)
        b, b_x, b_xx = _lane(B, _VALUE, i), _lane(B, _X, i), _lane(B, _XX, i)
        a_t, a_xt, b_t, b_xt = _lane(A, _T, i), _lane(A, _XT, i), _lane(B, _T, i), _lane(B, _XT, i)
        inverse = divide((1.0, 0.0), _dot(a, a, b, b))
        w_x = multiply(_cross(a, b_x, a_x, b), inverse)
        w_xx = subtract(_cross(a, b_xx, a_xx, b), multiply(w_x, _dot(a, a_x, b, b_x)))
        mixed = add(_cross(a, b_xt, a_xt, b), _cross(a_t, b_x, a_x, b_t))
        w_xt = subtract(mixed, scale(multiply(w_x, _dot(a, a_t, b, b_t)), 2.0))
        down, inverse = weights[i], scale(inverse, sign * weights[i])
        w_xx, w_xt = scale(multiply(w_xx, inverse), 2.0 * down), multiply(w_xt, inverse)
        value = subtract((sign, 0.0), scale(w_x, 2.0 * sign * down))
        rate = subtract(scale(w_xx, 12.0), scale(w_xt, 2.0))
        out[i], out[BLOCK + i] = value
        out[2 * BLOCK + i], out[3 * BLOCK + i] = -2.0 * w_xx[0], -2.0 * w_xx[1]
        out[4 * BLOCK + i], out[5 * BLOCK + i] = rate


@njit(cache=True, nogil=True, error_model="numpy")
def rational_loop(
    A: Array, B: Array, parities: tuple[int, int], sign: float, x: Array, t: Array, out: Array
) -> None:
    """Fill ``out`` (3, 2, points) with U, U_xi, U_tau from the pairs ``x`` and ``t`` (2, points).

    ``A`` and ``B`` hold the coefficients (degree + 1, degree // 3 + 1, 2); ``sign`` is the
    background; ``x`` is ``xi - 6 tau``.
    """
    degree, points = A.shape[0] - 1, x.shape[1]
    weights = np.empty((degree + 1, BLOCK))
    place, time = np.empty(2 * BLOCK), np.empty(2 * BLOCK)
    values, slopes = np.empty((degree + 1, 2 * BLOCK)), np.empty((degree + 1, 2 * BLOCK))
    rows_A, rows_B = np.empty((5, 2 * BLOCK)), np.empty((5, 2 * BLOCK))
    found = np.empty((3, 2, BLOCK))
    for start in range(0, points, BLOCK):
        for i in range(BLOCK):
            source = min(start + i, points - 1)
            place[i], place[i + BLOCK] = x[0, source], x[1, source]
            time[i], time[i + BLOCK] = t[0, source], t[1, source]
        _prepare(place, time, weights)
        _rows(A, parities[0], time, values, slopes)
        _polynomial(values, slopes, place, weights, rows_A)
        _rows(B, parities[1], time, values, slopes)
        _polynomial(values, slopes, place, weights, rows_B)
        _wave(rows_A.reshape(-1), rows_B.reshape(-1), weights[1], sign, found.reshape(-1))
        count = min(BLOCK, points - start)
        out[:, :, start : start + count] = found[:, :, :count]
