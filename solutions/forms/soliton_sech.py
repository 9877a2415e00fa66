"""The sech soliton on zero (K4 > 0)."""

import sympy as sp

from solutions.parameter import Bound, Parameter
from solutions.record import FOCUSING_MKDV, ClosedForm, FarFields, Reference
from solutions.symbols import A, tau, xi

__all__ = ["SOLITON_SECH"]

SOLITON_SECH = ClosedForm(
    name="soliton_sech",
    title="sech soliton",
    expression=A * sp.sech(A * xi - A**3 * tau),
    equation=FOCUSING_MKDV,
    parameters=(Parameter(A, lower=Bound(sp.S.Zero, "the zero solution")),),
    background=sp.S.Zero,
    far_fields=FarFields(sp.S.Zero, sp.S.Zero),
    reference=Reference("ablowitz1981solitons", "standard mKdV"),
)
