"""The soliton on a constant background (K4 > 0); algebraic as its width grows without bound."""

import sympy as sp

from solutions.forms.half_phase import by_tanh
from solutions.parameter import Bound, Parameter
from solutions.record import FOCUSING_MKDV, ClosedForm, FarFields, Reference
from solutions.symbols import kappa, tau, xi

__all__ = ["SOLITON_BACKGROUND"]

_level = sp.Symbol("U_0", real=True)

_phase = kappa * (xi - (6 * _level**2 + kappa**2) * tau)
_height = sp.sqrt(4 * _level**2 + kappa**2)
_denominator = 2 * _level + _height * sp.cosh(_phase)


def _stable() -> sp.Expr:
    return _level + kappa**2 * sp.sech(_phase / 2) ** 2 / by_tanh(_denominator, _phase)


SOLITON_BACKGROUND = ClosedForm(
    name="soliton_background",
    title="soliton on a constant background",
    expression=_level + kappa**2 / _denominator,
    equation=FOCUSING_MKDV,
    parameters=(
        Parameter(_level, default=sp.S.One),
        Parameter(
            kappa,
            lower=Bound(sp.S.Zero, "the constant U_0, or the Lorentzian rational_1 if U_0 < 0"),
        ),
    ),
    background=_level,
    far_fields=FarFields(_level, _level),
    reference=Reference("el2017dispersive", "standard mKdV"),
    stabilise=_stable,
)
