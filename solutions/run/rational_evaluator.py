"""The rational solutions at given shifts, from their polynomials A and B, in double-double.

Two bivariate Horner schemes with their derivatives: A and B of ``f = A + i B`` have degree d if x
counts 1 and t counts 3. Their rows, polynomials in t, are summed once for points that share t. The
sums over rows run on blocks of points, with x divided by a power of two S and a term of degree
``d - n`` by ``S**n``, so that no power overflows. A row of the workspace holds ``BLOCK`` high
parts, then low parts, then the sums of the terms' absolute values in double. That sum times the
number of roundings in a term bounds the error.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from longwave.solutions.run import bounded
from longwave.solutions.run.bounded import BLOCK, PARTS, UNIT, Bounded
from longwave.solutions.run.doubledouble import (
    Array,
    Pair,
    add,
    add_loosely,
    check_range,
    multiply,
    scale,
    split,
)
from longwave.solutions.run.linear_phase import LinearPhase, Variables, as_pairs, long_number
from longwave.support.compiled.jit import doubles, integers, njit

if TYPE_CHECKING:
    import sympy as sp
    from flint import fmpq_mpoly

    from longwave.solutions.forms.tau_polynomials import RationalTau

Workspace = tuple[Array, Array, Array, Array, Array, Array, Array, Array, Array]

_VALUE, _X, _XX, _T, _XT = 0, 1, 2, 3, 4
"""Row numbers in a polynomial's workspace: value, derivatives; _XX is half the xx derivative."""

_STEPS = np.array([[_XX, _X], [_X, _VALUE], [_VALUE, -1], [_XT, _T], [_T, -1]])
"""Pairs (row, row added to it) of a Horner step, in order; -1 is the coefficient, a series in t."""


@njit()
def _step(z: Array, x: Array, y: Array, weight: Array) -> None:
    """Compute ``z = z x + y weight`` for numbers and for their sums of the terms' magnitudes.

    The weights are powers of two.
    """
    for i in range(BLOCK):
        low, size = i + BLOCK, i + 2 * BLOCK
        product = multiply((z[i], z[low]), (x[i], x[low]))
        z[i], z[low] = add_loosely(product, (y[i] * weight[i], y[low] * weight[i]))
        z[size] = z[size] * x[size] + y[size] * weight[i]


@njit()
def _prepare(x: Array, t: Array, scales: Array, weights: Array) -> None:
    """Divide x by S, with ``|x| <= S`` and ``|t| <= S**3``; fill ``weights[n] = S**-n``.

    ``scales`` holds 1/S. The magnitudes stored with x and t are raised if needed, so that the
    errors of x and t are at most UNIT/4 of these magnitudes.
    """
    degree = weights.shape[0] - 1
    for i in range(BLOCK):
        size, scale_inverse = i + 2 * BLOCK, scales[i]
        x[size] = max(abs(x[i]), 4.0 / UNIT * x[size]) * scale_inverse
        t[size] = max(abs(t[i]), 4.0 / UNIT * t[size])
        x[i], x[i + BLOCK] = x[i] * scale_inverse, x[i + BLOCK] * scale_inverse
        weight = 1.0
        for n in range(degree + 1):
            weights[n, i] = weight
            weight *= scale_inverse


@njit()
def _row(c: Array, first: int, step: int, t: Pair, square: Pair) -> tuple[Pair, Pair]:
    """Return ``sum c[j] t**j`` over j = first, first + step, ..., and its derivative in t."""
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


@njit()
def _row_sizes(c: Array, t: float) -> tuple[float, float]:
    """Return the sum of the magnitudes of a row's terms, and that of its derivative's terms."""
    value = slope = 0.0
    for j in range(c.shape[0] - 1, -1, -1):
        slope = slope * t + value
        value = value * t + abs(c[j, 0])
    return value, slope


@njit()
def _rows(c: Array, parity: int, t: Array, values: Array, slopes: Array) -> None:
    """Fill ``values`` and ``slopes`` with a block's polynomials in t, one row for each power of x.

    ``c[i, j]`` is the coefficient of x^i t^j; ``slopes`` are the derivatives in t.

    ``parity`` is the common parity of ``i + j``, or -1 if there is none.
    """
    degree = c.shape[0] - 1
    for i in range(degree + 1):
        columns = c[i, : (degree - i) // 3 + 1]
        first, step = (0, 1) if parity < 0 else ((i + parity) % 2, 2)
        value = slope = (0.0, 0.0)
        sizes = (0.0, 0.0)
        for lane in range(BLOCK):
            low, size = lane + BLOCK, lane + 2 * BLOCK
            if lane == 0 or t[lane] != t[lane - 1] or t[low] != t[low - 1]:
                time = t[lane], t[low]
                value, slope = _row(columns, first, step, time, multiply(time, time))
                sizes = _row_sizes(columns, t[size])
            values[i, lane], values[i, low], values[i, size] = value[0], value[1], sizes[0]
            slopes[i, lane], slopes[i, low], slopes[i, size] = slope[0], slope[1], sizes[1]


@njit()
def _polynomial(values: Array, slopes: Array, x: Array, weights: Array, out: Array) -> None:
    """Fill the rows of ``out`` with the polynomial and its derivatives, by Horner's rule in x."""
    degree = values.shape[0] - 1
    out[:] = 0.0
    for i in range(degree, -1, -1):
        for target, source in _STEPS:
            if source >= 0:
                _step(out[target], x, out[source], weights[0])
            else:
                coefficients = values[i] if target == _VALUE else slopes[i]
                _step(out[target], x, coefficients, weights[degree - i])


@njit()
def _cross(A: Bounded, b: Bounded, a: Bounded, B: Bounded) -> Bounded:
    """Return ``A b - a B``."""
    return bounded.subtract(bounded.multiply(A, b), bounded.multiply(a, B))


@njit()
def _dot(A: Bounded, a: Bounded, B: Bounded, b: Bounded) -> Bounded:
    """Return ``A a + B b``."""
    return bounded.add(bounded.multiply(A, a), bounded.multiply(B, b))


@njit()
def _lane(rows: Array, row: int, i: int, rounding: float) -> Bounded:
    """Return the bounded number of point ``i`` in a row of a flat workspace.

    Its bound is ``rounding`` times the sum of magnitudes that the row stores.
    """
    high, low, size = bounded.load(rows[3 * BLOCK * row : 3 * BLOCK * (row + 1)], i)
    return high, low, rounding * size


@njit()
def _wave(A: Array, B: Array, weights: Array, e: float, sign: float, out: Array) -> None:
    """Compute U, U_xi, U_tau from A + i B and its derivatives, in flat workspaces.

    ``e`` is the error of a term relative to its size.
    """
    for i in range(BLOCK):
        a, a_x, a_xx = _lane(A, _VALUE, i, e), _lane(A, _X, i, e), _lane(A, _XX, i, e)
        b, b_x, b_xx = _lane(B, _VALUE, i, e), _lane(B, _X, i, e), _lane(B, _XX, i, e)
        a_t, a_xt, b_t, b_xt = (
            _lane(A, _T, i, e), _lane(A, _XT, i, e), _lane(B, _T, i, e), _lane(B, _XT, i, e)
        )  # fmt: skip
        inverse = bounded.reciprocal(_dot(a, a, b, b))
        w_x = bounded.multiply(_cross(a, b_x, a_x, b), inverse)
        product_term = bounded.multiply(w_x, _dot(a, a_x, b, b_x))
        w_xx = bounded.subtract(_cross(a, b_xx, a_xx, b), product_term)
        mixed = bounded.add(_cross(a, b_xt, a_xt, b), _cross(a_t, b_x, a_x, b_t))
        product_term = bounded.multiply(w_x, _dot(a, a_t, b, b_t))
        w_xt = bounded.subtract(mixed, bounded.scale(product_term, 2.0))
        down, inverse = weights[i], bounded.scale(inverse, sign * weights[i])
        w_xx = bounded.scale(bounded.multiply(w_xx, inverse), 4.0 * down)
        w_xt = bounded.scale(bounded.multiply(w_xt, inverse), 2.0)
        value = bounded.subtract((sign, 0.0, 0.0), bounded.scale(w_x, 2.0 * sign * down))
        rate = bounded.subtract(bounded.multiply(w_xx, (6.0, 0.0, 0.0)), w_xt)
        bounded.store(out[: 3 * BLOCK], i, value)
        bounded.store(out[3 * BLOCK : 6 * BLOCK], i, bounded.negate(w_xx))
        bounded.store(out[6 * BLOCK :], i, rate)


_SPACE_EXAMPLE = (
    *(doubles(1), doubles(1), doubles(1), doubles(2), doubles(2)),
    *(doubles(2), doubles(3), doubles(2), doubles(1)),
)
_POINTS_EXAMPLE = doubles(2), doubles(2), doubles(1)


@njit(
    cache=True,
    examples=[(doubles(4), integers(1), 0.0, *_POINTS_EXAMPLE, _SPACE_EXAMPLE, doubles(3))],
)
def rational_loop(
    tables: Array,
    parities: NDArray[np.int64],
    sign: float,
    x: Array,
    t: Array,
    scales: Array,
    work: Workspace,
    out: Array,
) -> None:
    """Fill ``out`` (3, 3, points) with U, U_xi, U_tau from ``x`` and ``t`` (3, points).

    The axis of three is high part, low part and bound of the error. ``tables`` holds the
    coefficients of A and B (2, degree + 1, degree // 3 + 1, 2); ``sign`` is the background; ``x``
    is ``xi - 6 tau``; ``scales`` are those of `scales_of`, ``work`` is a `workspace`.
    """
    degree, points = tables.shape[1] - 1, x.shape[1]
    rounding = 4.0 * (degree + 1.0) * UNIT
    x_block, t_block, inverse_scales, weights, values, slopes, rows, flat, result = work
    for start in range(0, points, BLOCK):
        count = min(BLOCK, points - start)
        for part in range(3):
            for i in range(BLOCK):
                source = start + min(i, count - 1)
                x_block[part * BLOCK + i] = x[part, source]
                t_block[part * BLOCK + i] = t[part, source]
        for i in range(BLOCK):
            inverse_scales[i] = scales[start + min(i, count - 1)]
        _prepare(x_block, t_block, inverse_scales, weights)
        for polynomial_index in range(2):
            _rows(tables[polynomial_index], parities[polynomial_index], t_block, values, slopes)
            _polynomial(values, slopes, x_block, weights, rows[polynomial_index])
        _wave(flat[0], flat[1], weights[1], rounding, sign, result)
        for row in range(3):
            for part in range(3):
                for i in range(count):
                    out[row, part, start + i] = result[(3 * row + part) * BLOCK + i]


def scales_of(x: Array, t: Array) -> Array:
    """Return 1/S at each point; S is the least power of two >= 1 that `_prepare` allows."""
    exponents = np.maximum(np.frexp(x)[1], np.ceil(np.frexp(t)[1] / 3.0)).astype(np.int64)
    return np.ldexp(1.0, -np.maximum(exponents, 0))


def workspace(degree: int) -> Workspace:
    """Return the buffers of `rational_loop` for one block, with a flat view of the rows."""
    rows = np.empty((2, 5, 3 * BLOCK))
    x_block, t_block, result = np.empty(3 * BLOCK), np.empty(3 * BLOCK), np.empty(9 * BLOCK)
    weights = np.empty((degree + 1, BLOCK))
    values, slopes = np.empty((degree + 1, 3 * BLOCK)), np.empty((degree + 1, 3 * BLOCK))
    flat = rows.reshape(2, -1)
    return x_block, t_block, np.empty(BLOCK), weights, values, slopes, rows, flat, result


class RationalEvaluator:
    """Evaluator of a rational solution U and its xi and tau derivatives, at given shifts.

    Raises OverflowError for a coefficient beyond 1e-250 .. 1e250.
    """

    def __init__(self, family: RationalTau, shifts: Mapping[sp.Symbol, sp.Expr]) -> None:
        degree = family.order * (family.order + 1) // 2
        numbers = [shifts[symbol] for symbol in family.symbols[2:]]
        tables = [_coefficients(part, numbers) for part in (family.A, family.B)]
        self._tables = np.stack([_pairs(table, degree) for table in tables])
        self._parities = np.array([_parity(table) for table in tables])
        self._sign = float((-1) ** family.order)

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """Return ``x = xi - 6 tau`` and ``t = tau`` in the caller's variables."""
        return [variables.phase(1, -6, 0), variables.phase(0, 1, 0)]

    def __call__(self, phases: list[LinearPhase], *points: Array) -> Array:
        """Return value, xi and tau derivative at the points (x, t): an array (3, 3, points)."""
        x_pairs, t_pairs = (as_pairs(phase(*points)) for phase in phases)
        out = np.empty((3, PARTS, points[0].size))
        work = workspace(self._tables.shape[1] - 1)
        scales = scales_of(x_pairs[0], t_pairs[0])
        rational_loop(self._tables, self._parities, self._sign, x_pairs, t_pairs, scales, work, out)
        return out


def _coefficients(part: fmpq_mpoly, shifts: list[sp.Expr]) -> dict[tuple[int, int], Any]:
    """Return the exact coefficients of ``x**i t**j`` with the shifts substituted."""
    import sympy as sp

    table: dict[tuple[int, int], Any] = {}
    for exponents, number in part.terms():
        i, j, *powers = (int(exponent) for exponent in exponents)
        factors = [shift**power for shift, power in zip(shifts, powers, strict=True)]
        term = sp.Rational(int(number.p), int(number.q)) * sp.Mul(*factors)
        table[i, j] = table.get((i, j), sp.S.Zero) + term
    return {powers: number for powers, number in table.items() if number != 0}


def _parity(table: Mapping[tuple[int, int], Any]) -> int:
    """Return the parity that ``i + j`` has for all (i, j) in ``table``, or -1 if it varies."""
    parities = {(i + j) % 2 for i, j in table}
    return parities.pop() if len(parities) == 1 else -1


def _pairs(table: Mapping[tuple[int, int], Any], degree: int) -> Array:
    pairs = np.zeros((degree + 1, degree // 3 + 1, 2))
    for (i, j), number in table.items():
        pairs[i, j] = split(check_range(long_number(number)))
    return pairs
