"""The dark breather on the sn wave, as printed in the paper's eqs. (21) and (29) (K4 < 0).

``H`` and ``Theta`` are the first and fourth theta functions of ``pi u/(2 K)``, ``Z`` is Jacobi's
zeta function. For floating point, ``H(u) = sqrt(k) sn(u) Theta(u)`` and the addition theorem
``Theta(xi+2a) Theta(xi-2a) = gamma**2 Theta(xi)**2 (1 - k**2 sn(xi)**2 sn(2a)**2)`` reduce it to
sn and the logarithm of one theta quotient, which shifts the phase eta.
"""

import sympy as sp

from longwave.solutions.equation import DEFOCUSING_MKDV
from longwave.solutions.forms.bare_waves import QUARTER_PERIOD, SN_PHASE, SN_WAVE, modulus
from longwave.solutions.functions import (
    jacobi_cn,
    jacobi_dn,
    jacobi_eta,
    jacobi_sn,
    jacobi_theta,
    jacobi_zeta,
)
from longwave.solutions.record import Bound, ClosedForm, FarFields, Reference, positive, real
from longwave.solutions.symbols import X_0, alpha, k, tau, xi

_m = k**2
_sn, _cn, _dn = (f(alpha, _m) for f in (jacobi_sn, jacobi_cn, jacobi_dn))
_zeta = jacobi_zeta(alpha, _m)
_pole = 1 + k * _sn**2

_gamma = jacobi_theta(2 * alpha, _m) / jacobi_theta(0, _m)
_beta_over_gamma = 1 - 2 * (1 + k) ** 2 * _sn**2 / _pole**2
_background_speed = sp.diff(SN_PHASE, tau)

inverse_width: sp.Expr = _zeta + k * _sn * _cn * _dn / _pole
"""Inverse width of the breather: kappa of the paper's eq. (29)."""

speed: sp.Expr = _background_speed + (2 * k * (1 + k) ** 2 * (1 - k * _sn**2) * _sn * _dn * _cn) / (
    (_zeta * _pole + k * _sn * _dn * _cn) * _pole**2
)
"""Speed of the breather towards negative xi: c of the paper's eq. (29)."""

_eta = inverse_width * (xi + speed * tau + X_0)


_ARGUMENTS = (SN_PHASE + 2 * alpha, SN_PHASE - 2 * alpha, SN_PHASE)
_H = _H_ahead, _H_behind, _H_here = sp.symbols("H_ahead H_behind H_here", real=True)
_T = _T_ahead, _T_behind, _T_here = sp.symbols("T_ahead T_behind T_here", positive=True)
"""``_T`` and ``_H`` are the symbols of Theta and H at the ``_ARGUMENTS``, in this order."""

_grow, _g = sp.symbols("grow gamma", positive=True)


def _fraction() -> tuple[sp.Expr, sp.Expr]:
    """Return the printed numerator and denominator; ``grow`` is exp(2 eta), gamma is a symbol."""
    beta = _beta_over_gamma * _g
    numerator = _H_ahead / _grow + _H_behind * _grow + 2 * beta * _H_here
    denominator = _T_ahead / _grow + _T_behind * _grow + 2 * _g * _T_here
    return sp.sqrt(k) * numerator, denominator


def _printed() -> sp.Expr:
    numerator, denominator = _fraction()
    values = {_grow: sp.exp(2 * _eta), _g: _gamma}
    values |= {H: jacobi_eta(u, _m) for H, u in zip(_H, _ARGUMENTS, strict=True)}
    values |= {T: jacobi_theta(u, _m) for T, u in zip(_T, _ARGUMENTS, strict=True)}
    return (numerator / denominator).xreplace(values)


def _divide(sides: sp.Expr, tanh: sp.Expr, sech: sp.Expr) -> sp.Expr:
    """Return ``sides``, linear in ``grow`` and ``1/grow``, divided by ``grow + 1/grow``."""
    terms = sp.collect(sp.expand(sides), _grow, evaluate=False)
    weights = {_grow: (1 + tanh) / 2, 1 / _grow: (1 - tanh) / 2, sp.S.One: sech / 2}
    return sum((terms[power] * weights[power] for power in terms), sp.S.Zero)


def _stable() -> sp.Expr:
    """Return the wave in sn, with the theta quotient in the phase and no growing exponentials."""
    numerator, denominator = _fraction()
    quotient, product = sp.symbols("quotient product", positive=True)
    sn = [jacobi_sn(u, _m) for u in _ARGUMENTS]
    thetas = {_T_ahead: quotient, _T_behind: 1 / quotient, _T_here: 1 / (_g * product)}
    etas = {H: sp.sqrt(k) * value * T for H, value, T in zip(_H, sn, _T, strict=True)}
    ahead, behind = (sp.log(jacobi_theta(u, _m)) for u in _ARGUMENTS[:2])
    shifted = 2 * _eta - (ahead - behind) / 2
    square = jacobi_dn(SN_PHASE, _m) ** 2 + (k * sn[2] * jacobi_cn(2 * alpha, _m)) ** 2
    tanh, sech = sp.symbols("tanh sech", real=True)
    parts = [
        _divide(part.xreplace(etas).xreplace(thetas).subs(_grow, _grow * quotient), tanh, sech)
        for part in (numerator, denominator)
    ]
    values = {tanh: sp.tanh(shifted), sech: sp.sech(shifted), product: sp.sqrt(square)}
    with sp.evaluate(False):  # SymPy would spend seconds on whether tanh and sech are finite
        return (parts[0] / parts[1]).xreplace(values)


def breather_sn() -> ClosedForm:
    """Return the dark breather on the snoidal wave (K4 < 0)."""
    return ClosedForm(
        name="breather_sn",
        title="dark breather on the snoidal wave",
        expression=_printed,
        equation=DEFOCUSING_MKDV,
        parameters=(
            modulus("the zero solution", "the kink"),
            positive(
                alpha,
                "the bare snoidal wave",
                Bound(QUARTER_PERIOD, "the bare snoidal wave reversed"),
            ),
            real(X_0),
        ),
        background=SN_WAVE,
        far_fields=FarFields(SN_WAVE.subs(xi, xi + 2 * alpha), SN_WAVE.subs(xi, xi - 2 * alpha)),
        reference=Reference("mucalica2024dark", "dark breather on snoidal-wave"),
        period=4 * QUARTER_PERIOD,
        stabilise=_stable,
    )
