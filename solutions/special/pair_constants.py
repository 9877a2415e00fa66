"""The constants of the theta series in double-double."""

from __future__ import annotations

import math
from typing import NamedTuple

from solutions.special.doubledouble import Pair, Three, multiply, scale
from solutions.special.parameter import EllipticParameter

Series = tuple[Pair, Pair, Pair, Pair]
"""Coefficients of the terms in q^2, q^6, q^12 and q^20."""

ALTERNATING = (-1.0, 1.0, -1.0, 1.0)
EVEN = (1.0, 1.0, 1.0, 1.0)
RISING = (3.0, 5.0, 7.0, 9.0)


class PairConstants(NamedTuple):
    """What the loop needs of an `EllipticParameter`; a quarter period of 0 stands for inf."""

    quarter: Three
    rate: Pair
    q1: Pair
    q4: Pair
    q9: Pair
    q16: float
    q25: float
    alternating_terms: Series
    even_terms: Series
    rising_terms: Series
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
    m: float
    slope: float


def pair_constants(p: EllipticParameter) -> PairConstants:
    """Return the constants of the loop for the parameter `p`."""
    powers: list[Pair] = [(1.0, 0.0)]
    for _ in range(25):
        powers.append(multiply(powers[-1], p.nome))

    def series(weights: tuple[float, float, float, float]) -> Series:
        first, second, third, fourth = weights
        return (
            scale(powers[2], first), scale(powers[6], second),
            scale(powers[12], third), scale(powers[20], fourth),
        )  # fmt: skip

    return PairConstants(
        p.K if math.isfinite(p.K[0]) else (0.0, 0.0, 0.0), p.rate,
        powers[1], powers[4], powers[9], powers[16][0], powers[25][0],
        series(ALTERNATING), series(EVEN), series(RISING),
        p.sn_scale, p.cn_scale, p.dn_scale, p.cn_scale_odd, p.dn_scale_odd,
        p.E, p.epsilon_rate, p.zeta_rate, p.theta_scale, p.eta_scale, p.gauss,
        p.m[0], p.slope[0],
    )  # fmt: skip
