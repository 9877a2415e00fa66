"""The rational solutions with numbers in, from their polynomials A and B, in double-double.

Two bivariate Horner schemes with their derivatives: A and B of ``f = A + i B`` have degree d when x
counts 1 and t counts 3. Their rows, polynomials in t, are summed once for points that share t. The
sums over rows run on blocks of points, with x divided by a power of two S and a term of degree
``d - n`` by ``S**n``, so that no power overflows. A row of the workspace holds ``BLOCK`` high
parts, then as many low parts. Beside each row runs the sum of the terms' sizes in double: times the
number of roundings in a term it bounds the error.
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

Space = tuple[Array, Array, Array, Array, Array, Array, Array, Array, Array]

_VALUE, _X, _XX, _T, _XT = 0, 1, 2, 3, 4
"""Rows of a polynomial's workspace: it and its derivatives (_XX is half the second)."""

_STEPS = np.array([[_XX, _X], [_X, _VALUE], [_VALUE, -1], [_XT, _T], [_T, -1]])
"""What each row takes in a step: another row, or the polynomial in t (-1)."""


@njit()
def _step(z: Array, x: Array, y: Array, weight: Array) -> None:
    """``z = z x + y weight``, the weights being powers of two; the same of the sizes."""
    for i in range(BLOCK):
        low, size = i + BLOCK, i + 2 * BLOCK
        product = multiply((z[i], z[low]), (x[i], x[low]))
        z[i], z[low] = add_loosely(product, (y[i] * weight[i], y[low] * weight[i]))
        z[size] = z[size] * x[size] + y[size] * weight[i]


@njit()
def _prepare(x: Array, t: Array, scales: Array, weights: Array) -> None:
    """Divide x by S, with ``|x| <= S`` and ``|t| <= S**3``; fill ``weights[n] = S**-n``.

    ``scales`` holds 1/S. The errors of x and t become sizes, of which they are at most a fraction
    UNIT/4.
    """
    degree = weights.shape[0] - 1
    for i in range(BLOCK):
        size, down = i + 2 * BLOCK, scales[i]
        x[size] = max(abs(x[i]), 4.0 / UNIT * x[size]) * down
        t[size] = max(abs(t[i]), 4.0 / UNIT * t[size])
        x[i], x[i + BLOCK] = x[i] * down, x[i + BLOCK] * down
        weight = 1.0
        for n in range(degree + 1):
            weights[n, i] = weight
            weight *= down


@njit()
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


@njit()
def _row_sizes(c: Array, t: float) -> tuple[float, float]:
    """The sums of the sizes of a row's terms, and of those of its derivative."""
    value = slope = 0.0
    for j in range(c.shape[0] - 1, -1, -1):
        slope = slope * t + value
        value = value * t + abs(c[j, 0])
    return value, slope


@njit()
def _rows(c: Array, parity: int, t: Array, values: Array, slopes: Array) -> None:
    """Fill the lanes of each row; ``c[i, j]`` belongs to x^i t^j.

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
    """Fill the rows of ``out`` with the polynomial and its derivatives."""
    degree = values.shape[0] - 1
    out[:] = 0.0
    for i in range(degree, -1, -1):
        for target, source in _STEPS:
            if source >= 0:
                _step(out[target], x, out[source], weights[0])
            else:
                given = values[i] if target == _VALUE else slopes[i]
                _step(out[target], x, given, weights[degree - i])


@njit()
def _cross(A: Bounded, b: Bounded, a: Bounded, B: Bounded) -> Bounded:
    """``A b - a B``."""
    return bounded.subtract(bounded.multiply(A, b), bounded.multiply(a, B))


@njit()
def _dot(A: Bounded, a: Bounded, B: Bounded, b: Bounded) -> Bounded:
    """``A a + B b``."""
    return bounded.add(bounded.multiply(A, a), bounded.multiply(B, b))


@njit()
def _lane(rows: Array, row: int, i: int, rounding: float) -> Bounded:
    """One lane of a flat workspace."""
    high, low, size = bounded.load(rows[3 * BLOCK * row : 3 * BLOCK * (row + 1)], i)
    return high, low, rounding * size


@njit()
def _wave(A: Array, B: Array, weights: Array, e: float, sign: float, out: Array) -> None:
    """U, U_xi, U_tau (flat, as the workspaces are) from the angle of A + i B and its rates.

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
        turned = bounded.multiply(w_x, _dot(a, a_x, b, b_x))
        w_xx = bounded.subtract(_cross(a, b_xx, a_xx, b), turned)
        mixed = bounded.add(_cross(a, b_xt, a_xt, b), _cross(a_t, b_x, a_x, b_t))
        turned = bounded.multiply(w_x, _dot(a, a_t, b, b_t))
        w_xt = bounded.subtract(mixed, bounded.scale(turned, 2.0))
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
_PLACES_EXAMPLE = doubles(2), doubles(2), doubles(1)


@njit(
    cache=True,
    examples=[(doubles(4), integers(1), 0.0, *_PLACES_EXAMPLE, _SPACE_EXAMPLE, doubles(3))],
)
def rational_loop(
    tables: Array,
    parities: NDArray[np.int64],
    sign: float,
    x: Array,
    t: Array,
    scales: Array,
    space: Space,
    out: Array,
) -> None:
    """Fill ``out`` (3, 3, points) with U, U_xi, U_tau from ``x`` and ``t`` (3, points).

    The axis of three is high part, low part and bound of the error. ``tables`` holds the
    coefficients of A and B (2, degree + 1, degree // 3 + 1, 2); ``sign`` is the background; ``x``
    is ``xi - 6 tau``; ``scales`` are those of `scales_of`, ``space`` is that of `workspace`.
    """
    degree, points = tables.shape[1] - 1, x.shape[1]
    rounding = 4.0 * (degree + 1.0) * UNIT
    place, time, down, weights, values, slopes, rows, flat, found = space
    for start in range(0, points, BLOCK):
        count = min(BLOCK, points - start)
        for part in range(3):
            for i in range(BLOCK):
                source = start + min(i, count - 1)
                place[part * BLOCK + i] = x[part, source]
                time[part * BLOCK + i] = t[part, source]
        for i in range(BLOCK):
            down[i] = scales[start + min(i, count - 1)]
        _prepare(place, time, down, weights)
        for which in range(2):
            _rows(tables[which], parities[which], time, values, slopes)
            _polynomial(values, slopes, place, weights, rows[which])
        _wave(flat[0], flat[1], weights[1], rounding, sign, found)
        for row in range(3):
            for part in range(3):
                for i in range(count):
                    out[row, part, start + i] = found[(3 * row + part) * BLOCK + i]


def scales_of(x: Array, t: Array) -> Array:
    """1/S at each point: S is the least power of two, not below 1, of `_prepare`."""
    exponents = np.maximum(np.frexp(x)[1], np.ceil(np.frexp(t)[1] / 3.0)).astype(np.int64)
    return np.ldexp(1.0, -np.maximum(exponents, 0))


def workspace(degree: int) -> Space:
    """What `rational_loop` writes to, a block at a time; the same memory once more flat."""
    rows = np.empty((2, 5, 3 * BLOCK))
    place, time, found = np.empty(3 * BLOCK), np.empty(3 * BLOCK), np.empty(9 * BLOCK)
    weights = np.empty((degree + 1, BLOCK))
    values, slopes = np.empty((degree + 1, 3 * BLOCK)), np.empty((degree + 1, 3 * BLOCK))
    flat = rows.reshape(2, -1)
    return place, time, np.empty(BLOCK), weights, values, slopes, rows, flat, found


class RationalEvaluator:
    """U and its xi and tau derivatives at given shifts.

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
        """``x = xi - 6 tau`` and ``t = tau`` in the caller's variables."""
        return [variables.phase(1, -6, 0), variables.phase(0, 1, 0)]

    def __call__(self, phases: list[LinearPhase], *points: Array) -> Array:
        """Value, xi derivative and tau derivative at the points (x, t): an array (3, 3, points)."""
        place, time = (as_pairs(phase(*points)) for phase in phases)
        out = np.empty((3, PARTS, points[0].size))
        space = workspace(self._tables.shape[1] - 1)
        scales = scales_of(place[0], time[0])
        rational_loop(self._tables, self._parities, self._sign, place, time, scales, space, out)
        return out


def _coefficients(part: fmpq_mpoly, shifts: list[sp.Expr]) -> dict[tuple[int, int], Any]:
    """The exact coefficients of ``x**i t**j``, the shifts put in."""
    import sympy as sp

    table: dict[tuple[int, int], Any] = {}
    for exponents, number in part.terms():
        i, j, *powers = (int(exponent) for exponent in exponents)
        factors = [shift**power for shift, power in zip(shifts, powers, strict=True)]
        term = sp.Rational(int(number.p), int(number.q)) * sp.Mul(*factors)
        table[i, j] = table.get((i, j), sp.S.Zero) + term
    return {powers: number for powers, number in table.items() if number != 0}


def _parity(table: Mapping[tuple[int, int], Any]) -> int:
    """The common parity of ``i + j``, or -1."""
    found = {(i + j) % 2 for i, j in table}
    return found.pop() if len(found) == 1 else -1


def _pairs(table: Mapping[tuple[int, int], Any], degree: int) -> Array:
    pairs = np.zeros((degree + 1, degree // 3 + 1, 2))
    for (i, j), number in table.items():
        pairs[i, j] = split(check_range(long_number(number)))
    return pairs
