"""The double-pole soliton (K4 > 0): a soliton and its negative that part like log|T|.

M. Wadati and K. Ohkuma, Multiple-pole solutions of the modified Korteweg-de Vries equation,
J. Phys. Soc. Jpn. 51 (1982) 2029.
"""

import sympy as sp

from solutions.forms.arctangent import arctangent_slope, bounded_slope
from solutions.parameter import Bound, Parameter
from solutions.record import FOCUSING_MKDV, ClosedForm, FarFields, Reference
from solutions.symbols import X_0, A, tau, xi

__all__ = ["DOUBLE_POLE"]

_slow = A * (xi - 3 * A**2 * tau + X_0)
_fast = A * (xi - A**2 * tau)
_tangent = _slow / sp.cosh(_fast)

DOUBLE_POLE = ClosedForm(
    name="double_pole",
    title="double-pole soliton",
    expression=arctangent_slope(_tangent),
    equation=FOCUSING_MKDV,
    parameters=(
        Parameter(A, lower=Bound(sp.S.Zero, "the zero solution")),
        Parameter(X_0, default=sp.S.Zero),
    ),
    background=sp.S.Zero,
    far_fields=FarFields(sp.S.Zero, sp.S.Zero),
    reference=Reference("wadati1982multiple", "standard mKdV"),
    stabilise=lambda: bounded_slope(_tangent),
)
