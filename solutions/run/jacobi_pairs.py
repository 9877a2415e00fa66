"""sn, cn, dn, epsilon, zeta and Theta in double-double, about 30 digits, on NumPy arrays.

The parameter comes as an `EllipticParameter`, because 1 - m loses digits near m = 1.  The argument
is reduced to u = j K + r, |r| <= K/2, so that no function is evaluated near a cancellation; u and K
are sums of three floats there, for u may be 1e28 and must keep its place in the period.  For
m <= 1/2 the theta series run in sines and cosines of v = pi r / (2K) with the nome q; for m > 1/2
Jacobi's imaginary transformation turns the same four series into hyperbolic functions of
w = pi r / (2K') with the nome q', scaled by exp(-|w|), which stay finite down to m1 = 0 (q' = 0:
tanh and sech).  Both nomes are below 0.0433.  Errors are below 1e-31 of max(1, |value|), plus
1e-45 |u| from the period.  Sources: DLMF 20.2, 20.7(viii), 22.2, 22.16(iii).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from solutions.run.block_functions import BLOCK, block_of, decay, get, put
from solutions.run.doubledouble import Array, add, multiply, negate, reciprocal, scale, two_sum
from solutions.run.elliptic_parameter import EllipticParameter, PairConstants, pair_constants
from solutions.run.jit import njit
from solutions.run.theta_series import (
    CN,
    COSINE,
    DN,
    EPSILON,
    LOW,
    MINUS,
    PLUS,
    POWER,
    RISE,
    ROWS,
    SINE,
    SN,
    THETA,
    THETA3,
    THETA4,
    WORK,
    ZETA,
    C,
    G,
    J,
    Q,
    R,
    S,
    U,
    V,
    Y,
    choose,
    circular_functions,
    cosines,
    hyperbolic_functions,
    multiples,
    reduce_argument,
    sines,
    slopes,
    thetas,
)


def flat_pair(a: ArrayLike, b: ArrayLike) -> tuple[Array, Array, tuple[int, ...]]:
    """Return a and b broadcast together as flat float arrays, and their common shape.

    >>> first, second, shape = flat_pair([1, 2, 3], [[0.5], [1.5]])
    >>> second.tolist(), shape
    ([0.5, 0.5, 0.5, 1.5, 1.5, 1.5], (2, 3))

    Raises:
        ValueError: if the shapes do not broadcast.
    """
    shape = np.broadcast_shapes(np.shape(a), np.shape(b))
    first, second = np.empty(shape), np.empty(shape)
    first[...], second[...] = a, b
    return first.ravel(), second.ravel(), shape


_PERIOD, _REST = 2.0**-150, 2.0**-104
"""Bounds of the error of the reduced argument, relative to the argument and to itself."""

_FARTHEST = 2.0**100
"""From as many quarter periods on, the quotient has more bits than two doubles."""

_ROUNDING = 2.0**-99
"""Bound of what rounding adds, relative to the value."""


class JacobiPairs(NamedTuple):
    """sn, cn, dn, epsilon, zeta and, if asked for, Theta at the same points.

    Arrays (3, ...) of high parts, low parts and bounds of the errors.
    """

    sn: Array
    cn: Array
    dn: Array
    epsilon: Array
    zeta: Array
    theta: Array | None = None


@njit(error_model="numpy")
def _series(w: Array, circular: bool, p: PairConstants) -> None:
    """Fill all that the quotients are made of."""
    reduce_argument(w, p)
    if circular:
        circular_functions(w)
    else:
        hyperbolic_functions(w)
    multiples(w)
    thetas(w, p)
    sines(w, p.alternating_terms, SINE)
    cosines(w, p)
    for i in range(BLOCK):
        put(w, SINE, i, multiply(get(w, S, i), get(w, SINE, i)))
        put(w, COSINE, i, multiply(get(w, C, i), get(w, COSINE, i)))


@njit(error_model="numpy")
def _circular_quotients(w: Array) -> None:
    """Fill SN, CN, DN, ZETA with unscaled numerators, EPSILON with their denominator."""
    for i in range(BLOCK):
        odd = get(w, Q, i)[1] != 0.0
        sine, cosine = get(w, SINE, i), get(w, COSINE, i)
        theta3, theta4, y = get(w, THETA3, i), get(w, THETA4, i), get(w, Y, i)
        put(w, SN, i, choose(odd, cosine, sine))
        put(w, CN, i, choose(odd, negate(sine), cosine))
        put(w, DN, i, choose(odd, theta4, theta3))
        put(w, EPSILON, i, choose(odd, theta3, theta4))
        slope = choose(odd, negate(get(w, PLUS, i)), get(w, MINUS, i))
        put(w, ZETA, i, multiply(y, slope))


@njit(error_model="numpy")
def _hyperbolic_quotients(w: Array) -> None:
    """Fill SN, CN, DN, ZETA with unscaled numerators, EPSILON with their denominator."""
    for i in range(BLOCK):
        odd = get(w, Q, i)[1] != 0.0
        sine, cosine, g = get(w, SINE, i), get(w, COSINE, i), get(w, G, i)
        upper, lower = multiply(g, get(w, THETA4, i)), multiply(g, get(w, THETA3, i))
        put(w, SN, i, choose(odd, upper, sine))
        put(w, CN, i, choose(odd, negate(sine), upper))
        put(w, DN, i, choose(odd, cosine, lower))
        put(w, EPSILON, i, choose(odd, lower, cosine))
        slope = multiply(g, multiply(get(w, Y, i), get(w, PLUS, i)))
        put(w, ZETA, i, choose(odd, slope, multiply(get(w, S, i), get(w, RISE, i))))


@njit(error_model="numpy")
def _finish(w: Array, p: PairConstants) -> None:
    """Make sn, cn, dn, epsilon and zeta of the quotients."""
    for i in range(BLOCK):
        quadrant, odd = get(w, Q, i)
        r = get(w, R, i)
        inverse = reciprocal(get(w, EPSILON, i))
        signed = scale(inverse, 1.0 if quadrant < 2.0 else -1.0)
        cn_scale = choose(odd != 0.0, p.cn_scale_odd, p.cn_scale)
        dn_scale = choose(odd != 0.0, p.dn_scale_odd, p.dn_scale)
        z = multiply(p.rate, multiply(get(w, ZETA, i), inverse))
        growth = add(multiply(p.epsilon_quarter, get(w, J, i)), multiply(p.epsilon_rate, r))
        put(w, SN, i, multiply(multiply(p.sn_scale, get(w, SN, i)), signed))
        put(w, CN, i, multiply(multiply(cn_scale, get(w, CN, i)), signed))
        put(w, DN, i, multiply(multiply(dn_scale, get(w, DN, i)), inverse))
        put(w, EPSILON, i, add(growth, z))
        put(w, ZETA, i, add(multiply(p.zeta_rate, r), z))


@njit(error_model="numpy")
def _jacobi(w: Array, circular: bool, p: PairConstants) -> None:
    """Fill SN .. ZETA from what `_series` made."""
    slopes(w, p)
    if circular:
        _circular_quotients(w)
    else:
        sines(w, p.rising_terms, RISE)
        _hyperbolic_quotients(w)
    _finish(w, p)


@njit(error_model="numpy")
def _theta(w: Array, circular: bool, p: PairConstants) -> None:
    """Fill THETA from what `_series` made; V and Y are lost."""
    if circular:
        for i in range(BLOCK):
            odd = get(w, Q, i)[1] != 0.0
            put(w, THETA, i, choose(odd, get(w, THETA3, i), get(w, THETA4, i)))
        return
    for i in range(BLOCK):
        r = get(w, R, i)
        put(w, V, i, multiply(p.gauss, multiply(r, r)))
    work, power = block_of(w, WORK), block_of(w, POWER)
    decay(block_of(w, V), work, power, block_of(w, THETA), block_of(w, Y))
    for i in range(BLOCK):
        odd = get(w, Q, i)[1] != 0.0
        whole = multiply(p.theta_scale, get(w, THETA3, i))
        half = multiply(p.eta_scale, multiply(get(w, COSINE, i), reciprocal(get(w, G, i))))
        put(w, THETA, i, multiply(get(w, THETA, i), choose(odd, whole, half)))


@njit(error_model="numpy")
def _bounds(w: Array, i: int, e: float, p: PairConstants, bounds: Array) -> None:
    """Fill `bounds` with those of the rows SN .. THETA at an argument whose error is e.

    Slopes come from the values; no second derivative exceeds 4 (m times 4 for zeta).
    """
    u, r = get(w, U, i)[0], get(w, R, i)[0]
    sn, cn, dn = get(w, SN, i)[0], get(w, CN, i)[0], get(w, DN, i)[0]
    zeta, theta = get(w, ZETA, i)[0], get(w, THETA, i)[0]
    e = (e + _PERIOD * abs(u) + _REST * abs(r)) * (1.0 + 2.0**-50)
    if abs(get(w, J, i)[0]) > _FARTHEST:
        e = math.inf
    rest = 2.0 * e * e
    bounds[0] = abs(cn * dn) * e + rest + _ROUNDING * abs(sn)
    bounds[1] = abs(sn * dn) * e + rest + _ROUNDING * abs(cn)
    bounds[2] = p.m * abs(sn * cn) * e + rest + _ROUNDING * dn
    bounds[3] = dn * dn * e + rest + _ROUNDING * (1.0 + abs(u))
    bounds[4] = min(p.m, abs(dn * dn - p.slope) + 2.0**-50) * e + rest  # dn**2, E/K >= 1 - m
    bounds[4] += _ROUNDING * (abs(zeta) + abs(p.zeta_rate[0] * r))
    bounds[5] = abs(theta) * (abs(zeta) * e + rest + 4.0 * _ROUNDING)


@njit(cache=True, nogil=True, error_model="numpy")
def _loop(
    u: Array, u_lo: Array, rest: Array, e: Array, circular: bool, p: PairConstants, out: Array
) -> None:
    """Fill out[:, 0], out[:, 1], out[:, 2] with high parts, low parts, bounds at u + u_lo + rest.

    The rows are SN .. ZETA, and THETA if there is a sixth.
    """
    w = np.zeros(2 * BLOCK * ROWS)
    bounds = np.zeros(6)
    for start in range(0, u.size, BLOCK):
        count = min(BLOCK, u.size - start)
        for i in range(count):
            put(w, U, i, two_sum(u[start + i], u_lo[start + i]))
            put(w, LOW, i, (rest[start + i], 0.0))
        _series(w, circular, p)
        _jacobi(w, circular, p)
        if out.shape[0] > 5:
            _theta(w, circular, p)
        for row in range(out.shape[0]):
            for i in range(count):
                out[row, 0, start + i], out[row, 1, start + i] = get(w, SN + row, i)
        for i in range(count):
            _bounds(w, i, e[start + i], p, bounds)
            for row in range(out.shape[0]):
                out[row, 2, start + i] = bounds[row]


def evaluate_pairs(
    parameter: EllipticParameter,
    u: ArrayLike,
    u_lo: ArrayLike = 0.0,
    rest: ArrayLike = 0.0,
    *,
    bound: ArrayLike = 0.0,
    theta: bool = False,
) -> JacobiPairs:
    """Return sn, cn, dn, epsilon, zeta and, if asked for, Theta in double-double.

    Args:
        parameter: from `elliptic_parameter(m, m1)` or `parameter_of_modulus(k)`.
        u, u_lo: real arguments, broadcast together; u_lo is the low part of the sum.
        rest: what is to be added to u + u_lo besides, of the same shape or a number.
        bound: bound of the error of the sum, of the same shape or a number.
        theta: whether Theta is wanted, too.

    Returns:
        Arrays of shape (3, *broadcast shape): high parts, low parts, bounds of the errors.

    Raises:
        ValueError: for Theta at m = 1, where the nome is 1.

    >>> from solutions.run.elliptic_parameter import elliptic_parameter
    >>> sn, *_ = evaluate_pairs(elliptic_parameter(0.25, 0.75), 1.0)
    >>> sn[:2].tolist()
    [0.8226355781298..., ...e-17]
    """
    if theta and parameter.m1[0] == 0:
        raise ValueError("m1 must satisfy m1 > 0, got 0 (Theta has no limit as m -> 1)")
    high, low, shape = flat_pair(u, u_lo)
    lowest, bounds = (
        np.broadcast_to(np.asarray(part, dtype=float), shape).ravel() for part in (rest, bound)
    )
    out = np.empty((6 if theta else 5, 3, high.size))
    _loop(high, low, lowest, bounds, parameter.circular, pair_constants(parameter), out)
    return JacobiPairs(*out.reshape(len(out), 3, *shape))
