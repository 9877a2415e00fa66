"""Compiled loops for the Jacobi functions in double precision: theta series of the smaller nome.

The argument is reduced to u = j K + r, |r| <= K/2, with K in double-double, so that no function
is evaluated near a cancellation.  For m <= 1/2 the series run in sines and cosines of
v = pi r / (2K) with the nome q; for m > 1/2 Jacobi's imaginary transformation turns the same four
series into hyperbolic functions of w = pi r / (2K') with the nome q', scaled by exp(-|w|), which
stay finite down to m1 = 0 (q' = 0: tanh and sech).  Both nomes are below 0.0433: the terms written
out reach 1e-18.  Sources: DLMF 20.2, 20.7(viii), 22.2, 22.16(iii).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from solutions.jit import njit
from solutions.special.arrays import Array
from solutions.special.doubledouble import fma, two_sum
from solutions.special.parameter import EllipticParameter

_LARGEST = 1e75  # bounds cosh 2w where q' is so small that its terms are zero anyway


class SeriesConstants(NamedTuple):
    """What the loops need of an `EllipticParameter`, as single floats (K = 0 stands for inf)."""

    quarter: float
    quarter_lo: float
    inverse_quarter: float
    rate: float
    rate_lo: float
    q1: float
    q2: float
    q4: float
    q6: float
    q9: float
    q12: float
    sn_scale: float
    cn_scale: float
    dn_scale: float
    cn_scale_odd: float
    dn_scale_odd: float
    epsilon_quarter: float
    epsilon_quarter_lo: float
    epsilon_rate: float
    zeta_rate: float
    theta_scale: float
    eta_scale: float
    gauss: float


def series_constants(p: EllipticParameter) -> SeriesConstants:
    """Return the constants of the loops for the parameter `p`."""
    finite = math.isfinite(p.K[0])
    quarter = p.K if finite else (0.0, 0.0)
    q = p.nome[0]
    return SeriesConstants(
        *quarter, 1 / p.K[0], *p.rate,
        q, q**2, q**4, q**6, q**9, q**12,
        p.sn_scale[0], p.cn_scale[0], p.dn_scale[0], p.cn_scale_odd[0], p.dn_scale_odd[0],
        *p.E, p.epsilon_rate[0], p.zeta_rate[0], p.theta_scale[0], p.eta_scale[0], p.gauss[0],
    )  # fmt: skip


@njit(error_model="numpy")
def _reduce(u: float, u_lo: float, p: SeriesConstants) -> tuple[float, float, float]:
    """Return j and r (hi, lo) with u + u_lo = j K + r and |r| <= K/2."""
    u, u_lo = two_sum(u, u_lo)
    j = math.floor(u * p.inverse_quarter + 0.5)
    product = j * p.quarter
    excess = fma(j, p.quarter, -product)
    r, r_lo = two_sum(u - product, (u_lo - excess) - j * p.quarter_lo)
    return j, r, r_lo


@njit(error_model="numpy")
def _scaled(r: float, r_lo: float, p: SeriesConstants) -> tuple[float, float]:
    """Return r times the rate, as a pair."""
    v = r * p.rate
    return v, fma(r, p.rate, -v) + (r * p.rate_lo + r_lo * p.rate)


@njit(error_model="numpy")
def _circular(
    r: float, r_lo: float, p: SeriesConstants
) -> tuple[float, float, float, float, float]:
    """Return sin v, cos v, the scale 1, 2 cos 2v, sin 2v."""
    v, v_lo = _scaled(r, r_lo, p)
    sine, cosine = math.sin(v), math.cos(v)
    s, c = sine + cosine * v_lo, cosine - sine * v_lo
    return s, c, 1.0, 2.0 - 4.0 * s * s, 2.0 * s * c


@njit(error_model="numpy")
def _hyperbolic(
    r: float, r_lo: float, p: SeriesConstants
) -> tuple[float, float, float, float, float]:
    """Return g sinh w, g cosh w, g = exp(-|w|), 2 cosh 2w, sinh 2w (bounded)."""
    w, w_lo = _scaled(r, r_lo, p)
    sign = math.copysign(1.0, w)
    w_lo *= sign
    g = math.exp(-abs(w))
    g -= g * w_lo
    fall = -math.expm1(-abs(w)) + g * w_lo
    s, c = 0.5 * sign * fall * (1.0 + g), 0.5 + 0.5 * g * g
    inverse = min(1.0 / (g * g), _LARGEST)
    return s, c, g, g * g + inverse, 2.0 * s * c * inverse


@njit(error_model="numpy")
def _series(x: float, p: SeriesConstants) -> tuple[float, float, float, float]:
    """Return theta_1/(2 q^(1/4) sin v), theta_2/(2 q^(1/4) cos v), theta_3, theta_4.

    x = 2 cos 2v.
    """
    x2 = x * x - 2.0
    x3 = x * (x * x - 3.0)
    odd = p.q1 * x + p.q9 * x3
    even = p.q4 * x2
    sines = 1.0 - (p.q2 * (1.0 + x) - (p.q6 * (1.0 + x + x2) - p.q12 * (1.0 + x + x2 + x3)))
    cosines = 1.0 + (p.q2 * (x - 1.0) + (p.q6 * (x2 - x + 1.0) + p.q12 * (x3 - x2 + x - 1.0)))
    return sines, cosines, 1.0 + (odd + even), 1.0 - (odd - even)


@njit(error_model="numpy")
def _rise(x: float, p: SeriesConstants) -> float:
    """Return the derivative of theta_2's hyperbolic series, over 2 q^(1/4) sinh w."""
    x2, x3 = x * x - 2.0, x * (x * x - 3.0)
    rest = 5.0 * p.q6 * (1.0 + x + x2) + 7.0 * p.q12 * (1.0 + x + x2 + x3)
    return 1.0 + (3.0 * p.q2 * (1.0 + x) + rest)


@njit(error_model="numpy")
def _quotient(
    r: float, r_lo: float, odd: bool, circular: bool, p: SeriesConstants
) -> tuple[float, float, float, float, float]:
    """Return the unscaled numerators of sn, cn, dn and zeta's series, and their denominator."""
    s, c, g, x, y = _circular(r, r_lo, p) if circular else _hyperbolic(r, r_lo, p)
    sines, cosines, theta3, theta4 = _series(x, p)
    sine, cosine = s * sines, c * cosines
    first = 4.0 * p.q1 + 12.0 * p.q9 * (x * x - 1.0)
    second = 8.0 * p.q4 * x
    if circular:
        if odd:
            return cosine, -sine, theta4, -y * (first + second), theta3
        return sine, cosine, theta3, y * (first - second), theta4
    upper, lower = g * theta4, g * theta3
    if odd:
        return upper, -sine, cosine, g * (y * (first + second)), lower
    return sine, upper, lower, s * _rise(x, p), cosine


@njit(error_model="numpy")
def _quadrant(j: float) -> tuple[bool, float]:
    """Return whether j is odd, and the sign of sn and cn: -1 where j mod 4 is 2 or 3."""
    odd = j - 2.0 * math.floor(0.5 * j) != 0.0
    return odd, (1.0 if j - 4.0 * math.floor(0.25 * j) < 2.0 else -1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def elliptic_loop(u: Array, u_lo: Array, circular: bool, p: SeriesConstants, out: Array) -> None:
    """Fill the rows of `out` with sn, cn, dn, epsilon and zeta at the points u + u_lo."""
    for i in range(u.size):
        j, r, r_lo = _reduce(u[i], u_lo[i], p)
        odd, sign = _quadrant(j)
        sn, cn, dn, z, denominator = _quotient(r, r_lo, odd, circular, p)
        cn_scale = p.cn_scale_odd if odd else p.cn_scale
        dn_scale = p.dn_scale_odd if odd else p.dn_scale
        z = p.rate * z / denominator
        whole = j * p.epsilon_quarter
        whole_lo = fma(j, p.epsilon_quarter, -whole) + j * p.epsilon_quarter_lo
        out[0, i] = sign * p.sn_scale * sn / denominator
        out[1, i] = sign * cn_scale * cn / denominator
        out[2, i] = dn_scale * dn / denominator
        out[3, i] = whole + (p.epsilon_rate * r + z + whole_lo)
        out[4, i] = p.zeta_rate * r + z


@njit(cache=True, nogil=True, error_model="numpy")
def theta_loop(u: Array, u_lo: Array, circular: bool, p: SeriesConstants, out: Array) -> None:
    """Fill the rows of `out` with H and Theta at the points u + u_lo."""
    for i in range(u.size):
        j, r, r_lo = _reduce(u[i], u_lo[i], p)
        odd, sign = _quadrant(j)
        s, c, g, x, _ = _circular(r, r_lo, p) if circular else _hyperbolic(r, r_lo, p)
        sines, cosines, theta3, theta4 = _series(x, p)
        weight = math.exp(-p.gauss * r * r)
        first, second = p.eta_scale * s * sines / g, p.eta_scale * c * cosines / g
        if circular:
            eta, theta = (second, theta3) if odd else (first, theta4)
        elif odd:
            eta, theta = p.theta_scale * theta4, p.theta_scale * theta3
        else:
            eta, theta = first, second
        out[0, i] = sign * weight * eta
        out[1, i] = weight * theta
