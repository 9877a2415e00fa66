"""The kink between -A and A (K4 < 0)."""

import sympy as sp

from solutions.parameter import Bound, Parameter
from solutions.record import DEFOCUSING_MKDV, ClosedForm, FarFields, Reference
from solutions.symbols import A, tau, xi

__all__ = ["KINK"]

KINK = ClosedForm(
    name="kink",
    title="kink",
    expression=A * sp.tanh(A * xi + 2 * A**3 * tau),
    equation=DEFOCUSING_MKDV,
    parameters=(Parameter(A, lower=Bound(sp.S.Zero, "the zero solution")),),
    background=sp.S.Zero,
    far_fields=FarFields(-A, A),
    reference=Reference("el2017dispersive", "standard mKdV"),
)
