"""The parameter of an elliptic function, with everything that depends on it alone.

Sums of m and m1 = 1 - m lose the smaller of the two, so the record is made from the pair, or from
the modulus k.  Its numbers are computed once, in a private mpmath context, and kept as
double-double pairs (hi, lo).  Those of the theta series follow as a tuple that compiled loops take.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from mpmath import MPContext

from solutions.run.doubledouble import Pair, Three, multiply, scale, split, split_three

_CONTEXT = MPContext()
_CONTEXT.prec = 240
_PAIR_TOLERANCE = 4e-16


@dataclass(frozen=True)
class EllipticParameter:
    """m = k^2 and m1 = 1 - m, the complete integrals, and the constants of the theta series.

    `circular` says which nome the series use: q = exp(-pi K'/K) for m <= 1/2 (sines and cosines
    of pi u / (2K)), its complement q' = exp(-pi K/K') for m > 1/2 (hyperbolic functions of
    pi u / (2K')).  Either nome is below 0.0433.

    Attributes:
        m, m1: the parameter and its complement.
        K: complete integral of the first kind (inf at m = 1), three floats for large arguments.
        E: complete integral of the second kind.
        slope: E / K, the mean of dn^2 and the linear growth of epsilon.
        rate: pi / (2K), or pi / (2K') when not circular.
        nome: q, or q' when not circular.
        epsilon_rate: coefficient of the reduced argument in epsilon beside its series.
        zeta_rate: the same for zeta.
        sn_scale, cn_scale, dn_scale: factors of the theta quotients on even quarter periods.
        cn_scale_odd, dn_scale_odd: the same on odd quarter periods (sn's is `sn_scale`).
        theta_scale: factor of Theta, H and their shifts by K (see `extended`).
        gauss: coefficient of u^2 in the Gaussian factor of Theta when not circular.
    """

    circular: bool
    m: Pair
    m1: Pair
    K: Three
    E: Pair
    slope: Pair
    rate: Pair
    nome: Pair
    epsilon_rate: Pair
    zeta_rate: Pair
    sn_scale: Pair
    cn_scale: Pair
    dn_scale: Pair
    cn_scale_odd: Pair
    dn_scale_odd: Pair
    theta_scale: Pair
    eta_scale: Pair
    gauss: Pair


def _complete(m: Any, m1: Any) -> tuple[Any, Any]:
    """Return (K, E) for the parameter m with complement m1, both exact."""
    ctx = _CONTEXT
    K = ctx.inf if m1 == 0 else ctx.pi / (2 * ctx.agm(1, ctx.sqrt(m1)))
    return K, ctx.ellipe(m)


def _circular_constants(m: Any, m1: Any) -> dict[str, Any]:
    ctx = _CONTEXT
    K, E = _complete(m, m1)
    q = ctx.exp(-ctx.pi * _complete(m1, m)[0] / K) if m else ctx.zero
    sn_scale = 2 * ctx.root(q / m, 4) if m else ctx.one
    root = ctx.root(m1, 4)
    return {
        "circular": True, "K": K, "E": E, "slope": E / K, "rate": ctx.pi / (2 * K), "nome": q,
        "epsilon_rate": E / K, "zeta_rate": ctx.zero,
        "sn_scale": sn_scale, "cn_scale": sn_scale * root, "dn_scale": root,
        "cn_scale_odd": sn_scale * root, "dn_scale_odd": root,
        "theta_scale": ctx.one, "eta_scale": 2 * ctx.root(q, 4), "gauss": ctx.zero,
    }  # fmt: skip


def _hyperbolic_constants(m: Any, m1: Any) -> dict[str, Any]:
    ctx = _CONTEXT
    K, E = _complete(m, m1)
    K1, E1 = _complete(m1, m)
    q = ctx.exp(-ctx.pi * K / K1)
    sn_scale = 1 / ctx.root(m, 4)
    dn_scale = ctx.root(m1 / q, 4) / 2 if m1 else ctx.one
    dn_scale_odd = 2 * ctx.root(q * m1, 4)
    amplitude = ctx.sqrt(K / K1) if m1 else ctx.nan
    return {
        "circular": False, "K": K, "E": E, "slope": E / K, "rate": ctx.pi / (2 * K1), "nome": q,
        "epsilon_rate": 1 - E1 / K1, "zeta_rate": -ctx.pi / (2 * K * K1),
        "sn_scale": sn_scale, "cn_scale": sn_scale * dn_scale, "dn_scale": dn_scale,
        "cn_scale_odd": sn_scale * dn_scale_odd, "dn_scale_odd": dn_scale_odd,
        "theta_scale": amplitude, "eta_scale": amplitude * 2 * ctx.root(q, 4) if m1 else ctx.nan,
        "gauss": ctx.pi / (4 * K * K1),
    }  # fmt: skip


def _from_exact(m: Any, m1: Any) -> EllipticParameter:
    """Make the record from m and m1 = 1 - m, held exactly enough in the private context."""
    constants = (_circular_constants if m <= 0.5 else _hyperbolic_constants)(m, m1)
    circular = constants.pop("circular")
    K = split_three(constants.pop("K"))
    pairs = {name: split(value) for name, value in constants.items()}
    return EllipticParameter(circular=circular, m=split(m), m1=split(m1), K=K, **pairs)


@lru_cache(maxsize=256)
def exact_parameter(m: Any, m1: Any) -> EllipticParameter:
    """Return the record for long numbers m and m1 = 1 - m, mpf of any context, 0 < m < 1.

    >>> from mpmath import mpf
    >>> exact_parameter(mpf(0.25), mpf(0.75)) == elliptic_parameter(0.25, 0.75)
    True
    """
    return _from_exact(_CONTEXT.convert(m), _CONTEXT.convert(m1))


@lru_cache(maxsize=256)
def elliptic_parameter(
    m: float, m1: float, m_lo: float = 0.0, m1_lo: float = 0.0
) -> EllipticParameter:
    """Return the record for m + m_lo and m1 + m1_lo; the smaller of the two defines both.

    >>> elliptic_parameter(0.0, 1.0).K[0]
    1.5707963267948966

    Raises:
        ValueError: unless 0 <= m <= 1, 0 <= m1 <= 1 and m + m1 = 1 to rounding.
    """
    if not (0 <= m <= 1 and 0 <= m1 <= 1):
        raise ValueError(
            f"m and m1 must lie in [0, 1], got m = {m}, m1 = {m1} (m = k*k for a modulus k < 1)"
        )
    if abs(m + m1 - 1) > _PAIR_TOLERANCE:
        raise ValueError(
            f"m + m1 must equal 1, got m = {m}, m1 = {m1} (pass m = k*k, m1 = (1 - k)*(1 + k))"
        )
    ctx = _CONTEXT
    if m1 <= m:
        complement = ctx.mpf(m1) + m1_lo
        return _from_exact(1 - complement, complement)
    exact = ctx.mpf(m) + m_lo
    return _from_exact(exact, 1 - exact)


@lru_cache(maxsize=256)
def parameter_of_modulus(k: float, k_lo: float = 0.0) -> EllipticParameter:
    """Return the record for the modulus k + k_lo, with m1 = (1 - k)(1 + k) exact.

    >>> parameter_of_modulus(1 - 2.0**-40).m1[0]
    1.8189894035450...e-12

    Raises:
        ValueError: unless 0 <= k <= 1.
    """
    if not 0 <= k <= 1:
        raise ValueError(f"k must satisfy 0 <= k <= 1, got {k} (the project's waves have k <= 1)")
    modulus = _CONTEXT.mpf(k) + k_lo
    return _from_exact(modulus**2, (1 - modulus) * (1 + modulus))


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
