"""The breather on zero (K4 > 0): a soliton bound to its negative, its carrier sin(p ...)."""

import sympy as sp

from solutions.forms.arctangent import arctangent_slope, bounded_slope
from solutions.parameter import Bound, Parameter
from solutions.record import FOCUSING_MKDV, ClosedForm, FarFields, Reference
from solutions.symbols import X_0, tau, xi

__all__ = ["BREATHER"]

_p = sp.Symbol("p", positive=True)
_q = sp.Symbol("q", positive=True)

_carrier = _p * (xi + (_p**2 - 3 * _q**2) * tau)
_envelope = _q * (xi + (3 * _p**2 - _q**2) * tau + X_0)
_tangent = _q * sp.sin(_carrier) / (_p * sp.cosh(_envelope))

BREATHER = ClosedForm(
    name="breather",
    title="breather",
    expression=arctangent_slope(_tangent),
    equation=FOCUSING_MKDV,
    parameters=(
        Parameter(_p, lower=Bound(sp.S.Zero, "the double-pole soliton")),
        Parameter(_q, lower=Bound(sp.S.Zero, "the zero solution")),
        Parameter(X_0, default=sp.S.Zero),
    ),
    background=sp.S.Zero,
    far_fields=FarFields(sp.S.Zero, sp.S.Zero),
    reference=Reference("clarke2000generation", "standard mKdV"),
    stabilise=lambda: bounded_slope(_tangent),
)
