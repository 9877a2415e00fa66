"""The bare periodic waves: sn for K4 < 0, cn and dn for K4 > 0.

Each solves ``U'' = v U - 2 s U**3`` with phase ``xi - v tau``; speed and amplitude follow from
the second derivative of the Jacobi function. They are the backgrounds of the localised waves,
which import phase and wave from this module.
"""

import sympy as sp

from longwave.solutions.equation import DEFOCUSING_MKDV, FOCUSING_MKDV, Equation
from longwave.solutions.functions import jacobi_cn, jacobi_dn, jacobi_sn, jacobi_zeta
from longwave.solutions.record import Bound, ClosedForm, FarFields, Parameter, Reference, positive
from longwave.solutions.symbols import k, tau, xi

QUARTER_PERIOD: sp.Expr = sp.elliptic_k(k**2)

SN_PHASE: sp.Expr = xi + (1 + k**2) * tau
CN_PHASE: sp.Expr = xi - (2 * k**2 - 1) * tau
DN_PHASE: sp.Expr = xi - (2 - k**2) * tau

SN_WAVE: sp.Expr = k * jacobi_sn(SN_PHASE, k**2)
CN_WAVE: sp.Expr = k * jacobi_cn(CN_PHASE, k**2)
DN_WAVE: sp.Expr = jacobi_dn(DN_PHASE, k**2)


def shifted_area(u: sp.Expr) -> sp.Expr:
    """Return ``epsilon(u + K) - E``, the integral of ``k'**2/dn**2`` from 0 to u; small as k -> 1.

    By the addition theorem ``epsilon(u) = shifted_area(u) + k**2 sn(u) cn(u)/dn(u)``.
    """
    mean = sp.elliptic_e(k**2) / QUARTER_PERIOD
    return jacobi_zeta(u + QUARTER_PERIOD, k**2) + mean * u


def modulus(at_zero: str, at_one: str) -> Parameter:
    """Return the parameter ``0 < k < 1``; the arguments name the wave's limits at k = 0 and 1."""
    return positive(k, at_zero, Bound(sp.S.One, at_one))


def _bare(
    letter: str,
    wave: sp.Expr,
    equation: Equation,
    limits: tuple[str, str],
    reference: Reference,
    quarters: int = 4,
) -> ClosedForm:
    return ClosedForm(
        name=f"wave_{letter}n",
        title=f"{letter}noidal wave",
        expression=wave,
        equation=equation,
        parameters=(modulus(*limits),),
        far_fields=FarFields(wave, wave),
        reference=reference,
        period=quarters * QUARTER_PERIOD,
    )


def wave_sn() -> ClosedForm:
    """Return the snoidal wave (K4 < 0)."""
    source = Reference("mucalica2024dark", "subsec: Dark breathers on snoidal waves")
    return _bare("s", SN_WAVE, DEFOCUSING_MKDV, ("the zero solution", "the kink"), source)


def wave_cn() -> ClosedForm:
    """Return the cnoidal wave (K4 > 0)."""
    limits = "the zero solution", "the sech soliton"
    return _bare("c", CN_WAVE, FOCUSING_MKDV, limits, Reference("chen2018rogue", "(27)"))


def wave_dn() -> ClosedForm:
    """Return the dnoidal wave (K4 > 0)."""
    limits = "the constant 1", "the sech soliton"
    return _bare("d", DN_WAVE, FOCUSING_MKDV, limits, Reference("chen2018rogue", "(24)"), 2)
