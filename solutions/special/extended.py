"""sn, cn, dn, epsilon, zeta and Theta in double-double, about 30 digits, on NumPy arrays.

The algorithm of `solutions.special.kernels`, with pairs throughout: errors below 1e-31 of
max(1, |value|), plus 5e-33 |u| from the period.  numba's disk cache sees changes of this file
only: after a change in `doubledouble`, `elementary` or `pair_series` remove `__pycache__`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from solutions.special.arrays import Array, flat_pair
from solutions.special.doubledouble import (
    Pair,
    add,
    divide,
    multiply,
    negate,
    scale,
    subtract,
    two_sum,
)
from solutions.special.elementary import decay, sine_cosine
from solutions.special.pair_series import (
    ALTERNATING,
    RISING,
    PairConstants,
    cosines,
    pair_constants,
    sines,
    slope_terms,
    thetas,
)
from solutions.special.parameter import EllipticParameter

_LARGEST = 1e50  # bounds cosh 2w where q' is so small that its terms are zero anyway


class JacobiPairs(NamedTuple):
    """sn, cn, dn, epsilon and zeta at the same points: arrays (2, ...) of high and low parts."""

    sn: Array
    cn: Array
    dn: Array
    epsilon: Array
    zeta: Array


@njit(error_model="numpy")
def _reduce(u: Pair, p: PairConstants) -> tuple[float, Pair]:
    """Return j and r with u = j K + r and |r| <= K/2; j = 0 where K is infinite."""
    if p.quarter[0] == 0.0:
        return 0.0, u
    j = math.floor(u[0] / p.quarter[0] + 0.5)
    return j, subtract(u, scale(p.quarter, j))


@njit(error_model="numpy")
def _circular(r: Pair, p: PairConstants) -> tuple[Pair, Pair, Pair, Pair, Pair]:
    """Return sin v, cos v, the scale 1, 2 cos 2v, sin 2v."""
    s, c = sine_cosine(multiply(r, p.rate))
    x = subtract((2.0, 0.0), scale(multiply(s, s), 4.0))
    return s, c, (1.0, 0.0), x, scale(multiply(s, c), 2.0)


@njit(error_model="numpy")
def _hyperbolic(r: Pair, p: PairConstants) -> tuple[Pair, Pair, Pair, Pair, Pair]:
    """Return g sinh w, g cosh w, g = exp(-|w|), 2 cosh 2w, sinh 2w (bounded)."""
    w = multiply(r, p.rate)
    sign = 1.0 if w[0] >= 0.0 else -1.0
    g, fall = decay(scale(w, sign))
    square = multiply(g, g)
    s = scale(multiply(fall, add((1.0, 0.0), g)), 0.5 * sign)
    c = scale(add((1.0, 0.0), square), 0.5)
    inverse = (_LARGEST, 0.0)
    if square[0] > 1.0 / _LARGEST:
        inverse = divide((1.0, 0.0), square)
    return s, c, g, add(square, inverse), scale(multiply(multiply(s, c), inverse), 2.0)


@njit(error_model="numpy")
def _quotient(
    r: Pair, odd: bool, circular: bool, p: PairConstants
) -> tuple[Pair, Pair, Pair, Pair, Pair]:
    """Return the unscaled numerators of sn, cn, dn and zeta's series, and their denominator."""
    s, c, g, x, y = _circular(r, p) if circular else _hyperbolic(r, p)
    theta3, theta4 = thetas(x, p)
    sine, cosine = multiply(s, sines(x, ALTERNATING, p)), multiply(c, cosines(x, p))
    first, second = slope_terms(x, p)
    slope = multiply(y, add(first, second if odd else negate(second)))
    if circular:
        if odd:
            return cosine, negate(sine), theta4, negate(slope), theta3
        return sine, cosine, theta3, slope, theta4
    upper = multiply(g, theta4)
    lower = multiply(g, theta3)
    if odd:
        return upper, negate(sine), cosine, multiply(g, slope), lower
    return sine, upper, lower, multiply(s, sines(x, RISING, p)), cosine


@njit(cache=True, nogil=True, error_model="numpy")
def _pair_loop(u: Array, u_lo: Array, circular: bool, p: PairConstants, out: Array) -> None:
    """Fill out[:, 0] and out[:, 1] with the high and low parts at the points u + u_lo."""
    for i in range(u.size):
        j, r = _reduce(two_sum(u[i], u_lo[i]), p)
        odd = j - 2.0 * math.floor(0.5 * j) != 0.0
        sn, cn, dn, z, denominator = _quotient(r, odd, circular, p)
        inverse = divide((1.0, 0.0), denominator)
        sign = 1.0 if j - 4.0 * math.floor(0.25 * j) < 2.0 else -1.0
        inverse_signed = scale(inverse, sign)
        cn_scale = p.cn_scale_odd if odd else p.cn_scale
        dn_scale = p.dn_scale_odd if odd else p.dn_scale
        z = multiply(p.rate, multiply(z, inverse))
        growth = add(scale(p.epsilon_quarter, j), multiply(p.epsilon_rate, r))
        out[0, 0, i], out[0, 1, i] = multiply(multiply(p.sn_scale, sn), inverse_signed)
        out[1, 0, i], out[1, 1, i] = multiply(multiply(cn_scale, cn), inverse_signed)
        out[2, 0, i], out[2, 1, i] = multiply(multiply(dn_scale, dn), inverse)
        out[3, 0, i], out[3, 1, i] = add(growth, z)
        out[4, 0, i], out[4, 1, i] = add(multiply(p.zeta_rate, r), z)


@njit(error_model="numpy")
def _theta(r: Pair, odd: bool, circular: bool, p: PairConstants) -> Pair:
    """Return Theta at an even or odd number of quarter periods from r, without its weight."""
    _, c, g, x, _ = _circular(r, p) if circular else _hyperbolic(r, p)
    theta3, theta4 = thetas(x, p)
    if circular:
        return theta3 if odd else theta4
    if odd:
        return multiply(p.theta_scale, theta3)
    return divide(multiply(p.eta_scale, multiply(c, cosines(x, p))), g)


@njit(cache=True, nogil=True, error_model="numpy")
def _theta_loop(u: Array, u_lo: Array, circular: bool, p: PairConstants, out: Array) -> None:
    """Fill the rows of `out` with the high and low part of Theta at the points u + u_lo."""
    for i in range(u.size):
        j, r = _reduce(two_sum(u[i], u_lo[i]), p)
        odd = j - 2.0 * math.floor(0.5 * j) != 0.0
        theta = _theta(r, odd, circular, p)
        if not circular:
            theta = multiply(theta, decay(multiply(p.gauss, multiply(r, r)))[0])
        out[0, i], out[1, i] = theta


def evaluate_theta_pairs(
    parameter: EllipticParameter, u: ArrayLike, u_lo: ArrayLike = 0.0
) -> Array:
    """Return Theta at u + u_lo in double-double, an array (2, *broadcast shape).

    Raises:
        ValueError: at m = 1, where the nome is 1.
    """
    if parameter.m1[0] == 0:
        raise ValueError("m1 must satisfy m1 > 0, got 0 (Theta has no limit as m -> 1)")
    high, low, shape = flat_pair(u, u_lo)
    out = np.empty((2, high.size))
    _theta_loop(high, low, parameter.circular, pair_constants(parameter), out)
    return out.reshape(2, *shape)


def evaluate_pairs(
    parameter: EllipticParameter, u: ArrayLike, u_lo: ArrayLike = 0.0
) -> JacobiPairs:
    """Return sn, cn, dn, epsilon and zeta at u + u_lo in double-double.

    Args:
        parameter: from `elliptic_parameter(m, m1)` or `parameter_of_modulus(k)`.
        u, u_lo: real arguments, broadcast together; u_lo is the low part of the sum.

    Returns:
        Arrays of shape (2, *broadcast shape): high parts and low parts.

    >>> from solutions.special.parameter import elliptic_parameter
    >>> sn, *_ = evaluate_pairs(elliptic_parameter(0.25, 0.75), 1.0)
    >>> sn.tolist()
    [0.8226355781298..., ...e-17]
    """
    high, low, shape = flat_pair(u, u_lo)
    out = np.empty((5, 2, high.size))
    constants = pair_constants(parameter)
    _pair_loop(high, low, parameter.circular, constants, out)
    return JacobiPairs(*out.reshape(5, 2, *shape))
