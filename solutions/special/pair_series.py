"""The four theta series in double-double, and the constants they need.

The same series serve m <= 1/2 (x = 2 cos 2v, nome q) and m > 1/2 (x = 2 cosh 2w, nome q'); terms
beyond q^12, below 1e-18 of their sums, are added in double.  Source: DLMF 20.2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from numba import njit

from solutions.special.doubledouble import Pair, add, multiply, scale, subtract
from solutions.special.parameter import EllipticParameter

Weights = tuple[float, float, float, float]
ALTERNATING: Weights = (-1.0, 1.0, -1.0, 1.0)
EVEN: Weights = (1.0, 1.0, 1.0, 1.0)
RISING: Weights = (3.0, 5.0, 7.0, 9.0)


class PairConstants(NamedTuple):
    """What the loop needs of an `EllipticParameter`, as pairs (K = 0 stands for inf)."""

    quarter: Pair
    rate: Pair
    q1: Pair
    q2: Pair
    q4: Pair
    q6: Pair
    q9: Pair
    q12: Pair
    q16: float
    q20: float
    q25: float
    sn_scale: Pair
    cn_scale: Pair
    dn_scale: Pair
    cn_scale_odd: Pair
    dn_scale_odd: Pair
    epsilon_quarter: Pair
    epsilon_rate: Pair
    zeta_rate: Pair
    theta_scale: Pair
    eta_scale: Pair
    gauss: Pair


def pair_constants(p: EllipticParameter) -> PairConstants:
    """Return the constants of the loop for the parameter `p`."""
    powers: list[Pair] = [(1.0, 0.0)]
    for _ in range(12):
        powers.append(multiply(powers[-1], p.nome))
    q = p.nome[0]
    return PairConstants(
        p.K if math.isfinite(p.K[0]) else (0.0, 0.0), p.rate,
        powers[1], powers[2], powers[4], powers[6], powers[9], powers[12], q**16, q**20, q**25,
        p.sn_scale, p.cn_scale, p.dn_scale, p.cn_scale_odd, p.dn_scale_odd,
        p.E, p.epsilon_rate, p.zeta_rate, p.theta_scale, p.eta_scale, p.gauss,
    )  # fmt: skip


@njit(error_model="numpy")
def _multiples(x: Pair) -> tuple[Pair, Pair, float, float]:
    """Return 2 cos 4v, 2 cos 6v, 2 cos 8v, 2 cos 10v for x = 2 cos 2v."""
    x2 = subtract(multiply(x, x), (2.0, 0.0))
    x3 = multiply(x, subtract(x2, (1.0, 0.0)))
    x4 = x[0] * x3[0] - x2[0]
    return x2, x3, x4, x[0] * x4 - x3[0]


@njit(error_model="numpy")
def _weighted(a: Pair, b: Pair, c: Pair, d: float, weights: Weights, p: PairConstants) -> Pair:
    """Return 1 + the sum of weight times q^(n(n+1)) times the n-th of a, b, c, d."""
    small = (weights[3] * p.q20 * d, 0.0)
    total = add(scale(multiply(p.q12, c), weights[2]), small)
    total = add(scale(multiply(p.q6, b), weights[1]), total)
    return add((1.0, 0.0), add(scale(multiply(p.q2, a), weights[0]), total))


@njit(error_model="numpy")
def sines(x: Pair, weights: Weights, p: PairConstants) -> Pair:
    """Return the sum of weights times q^(n(n+1)) sin (2n+1)v / sin v, 1 included."""
    x2, x3, x4, _ = _multiples(x)
    a = add((1.0, 0.0), x)
    b = add(a, x2)
    c = add(b, x3)
    return _weighted(a, b, c, c[0] + x4, weights, p)


@njit(error_model="numpy")
def cosines(x: Pair, p: PairConstants) -> Pair:
    """Return the sum of q^(n(n+1)) cos (2n+1)v / cos v."""
    x2, x3, x4, _ = _multiples(x)
    a = subtract(x, (1.0, 0.0))
    b = subtract(x2, a)
    c = subtract(x3, b)
    return _weighted(a, b, c, x4 - c[0], EVEN, p)


@njit(error_model="numpy")
def thetas(x: Pair, p: PairConstants) -> tuple[Pair, Pair]:
    """Return theta_3 and theta_4."""
    x2, x3, x4, x5 = _multiples(x)
    odd = add(multiply(p.q1, x), add(multiply(p.q9, x3), (p.q25 * x5, 0.0)))
    even = add((1.0, 0.0), add(multiply(p.q4, x2), (p.q16 * x4, 0.0)))
    return add(even, odd), subtract(even, odd)


@njit(error_model="numpy")
def slope_terms(x: Pair, p: PairConstants) -> tuple[Pair, Pair]:
    """Return the odd and even parts of -theta_3'/sin 2v."""
    x2, x3, x4, _ = _multiples(x)
    odd = add(scale(p.q1, 4.0), scale(multiply(p.q9, add(x2, (1.0, 0.0))), 12.0))
    odd = add(odd, (20.0 * p.q25 * (1.0 + x2[0] + x4), 0.0))
    even = scale(multiply(p.q4, x), 8.0)
    return odd, add(even, (16.0 * p.q16 * (x[0] + x3[0]), 0.0))
