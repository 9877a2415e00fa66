"""Waves of KdV: the soliton, two solitons, the cnoidal wave."""

import sympy as sp

from longwave.solutions.equation import KDV
from longwave.solutions.forms.arctangents import without_cancellation
from longwave.solutions.forms.bare_waves import QUARTER_PERIOD, modulus
from longwave.solutions.functions import jacobi_cn
from longwave.solutions.record import Bound, ClosedForm, FarFields, Reference, positive, real
from longwave.solutions.symbols import X_0, k, kappa, tau, xi

_level = sp.Symbol("U_0", real=True)
_rates = sp.symbols("kappa_1 kappa_2", positive=True)


def kdv_soliton() -> ClosedForm:
    """Return the soliton on zero, of height 2 kappa**2."""
    return ClosedForm(
        name="kdv_soliton",
        title="KdV soliton",
        expression=2 * kappa**2 * sp.sech(kappa * (xi - 4 * kappa**2 * tau)) ** 2,
        equation=KDV,
        parameters=(positive(kappa, "the zero solution"),),
        reference=Reference("D. J. Korteweg and G. de Vries, Phil. Mag. 39 (1895) 422"),
    )


def kdv_two_soliton() -> ClosedForm:
    """Return two solitons, the faster overtaking the other."""
    first, second = _rates
    phases = (first * (xi - 4 * first**2 * tau), second * (xi - 4 * second**2 * tau + X_0))
    (c_1, c_2), (s_1, s_2) = ([f(phase) for phase in phases] for f in (sp.cosh, sp.sinh))
    height = 2 * (first**2 - second**2) * ((first * c_2) ** 2 + (second * s_1) ** 2)
    return ClosedForm(
        name="kdv_two_soliton",
        title="two KdV solitons",
        expression=height / (first * c_1 * c_2 - second * s_1 * s_2) ** 2,
        equation=KDV,
        parameters=(
            positive(first, "the zero solution"),
            positive(
                second, "one soliton", Bound(first, "one soliton, the other infinitely far away")
            ),
            real(X_0),
        ),
        reference=Reference("P. D. Lax, Comm. Pure Appl. Math. 21 (1968) 467"),
        stabilise=lambda: _stable_solitons(*phases),
    )


def _stable_solitons(one: sp.Expr, other: sp.Expr) -> sp.Expr:
    """Return the wave with a positive denominator, divided by ``cosh(one)**2 cosh(other)**2``."""
    first, second = _rates
    t, s = list(sp.symbols("t_1 t_2", real=True)), list(sp.symbols("s_1 s_2", positive=True))
    height = 2 * (first**2 - second**2) * ((first * s[0]) ** 2 + (second * t[0] * s[1]) ** 2)
    divisor = first - second + second * without_cancellation(t, s)
    values = [f(phase) for f in (sp.tanh, sp.sech) for phase in (one, other)]
    return (height / divisor**2).xreplace(dict(zip(t + s, values, strict=True)))


def kdv_cnoidal() -> ClosedForm:
    """Return the cnoidal wave with troughs at U_0."""
    speed = 6 * _level + 4 * kappa**2 * (2 * k**2 - 1)
    wave = _level + 2 * (kappa * k * jacobi_cn(kappa * (xi - speed * tau), k**2)) ** 2
    return ClosedForm(
        name="kdv_cnoidal",
        title="KdV cnoidal wave",
        expression=wave,
        equation=KDV,
        parameters=(
            modulus("the constant U_0", "the soliton"),
            positive(kappa, "the constant U_0", default=sp.S.One),
            real(_level),
        ),
        far_fields=FarFields(wave, wave),
        reference=Reference("D. J. Korteweg and G. de Vries, Phil. Mag. 39 (1895) 422"),
        period=2 * QUARTER_PERIOD / kappa,
    )
