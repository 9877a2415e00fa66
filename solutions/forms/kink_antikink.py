"""A kink and an antikink (K4 < 0): dark solitons on a constant, as wide as wanted."""

import sympy as sp

from solutions.forms.half_phase import by_sech
from solutions.parameter import Bound, Parameter
from solutions.record import DEFOCUSING_MKDV, ClosedForm, FarFields, Reference
from solutions.symbols import A, kappa, tau, xi

__all__ = ["KINK_ANTIKINK"]

_phase = kappa * (xi + (6 * A**2 - kappa**2) * tau)
_height = sp.sqrt(4 * A**2 - kappa**2)
_denominator = 2 * A + _height * sp.cosh(_phase)


def _stable() -> sp.Expr:
    return A - kappa**2 * sp.sech(_phase / 2) ** 2 / by_sech(_denominator, _phase)


KINK_ANTIKINK = ClosedForm(
    name="kink_antikink",
    title="kink and antikink",
    expression=A - kappa**2 / _denominator,
    equation=DEFOCUSING_MKDV,
    parameters=(
        Parameter(A, lower=Bound(sp.S.Zero, "the zero solution")),
        Parameter(
            kappa,
            lower=Bound(sp.S.Zero, "the constant A"),
            upper=Bound(2 * A, "a kink and an antikink infinitely far apart"),
        ),
    ),
    background=A,
    far_fields=FarFields(A, A),
    reference=Reference("el2017dispersive", "standard mKdV"),
    stabilise=_stable,
)
