"""The second-order rational solution Y2, as printed in the paper's eqs. (12) and (13) (K4 > 0).

The paper's letters, of the paper's eq. (14): ``b X`` is ``2 xi`` and ``a T`` is ``-2 tau``, because
``b = sqrt(24 K4/K2) = 2 sqrt(6 K4/K2)`` and ``a = b**3 gamma_3/4`` with ``gamma_3`` minus the
dispersive coefficient.
"""

import sympy as sp

from solutions.equation import FOCUSING_MKDV
from solutions.rational_family import horner_form, rational_evaluator
from solutions.record import ClosedForm, FarFields, Reference
from solutions.symbols import tau, xi

__all__ = ["RATIONAL_2"]


def _printed(aT: sp.Expr, bX: sp.Expr) -> sp.Expr:
    G_2 = 3 - (6 * aT + bX) * ((6 * aT + bX) ** 3 + 6 * (22 * aT + bX))
    D_2 = (
        12
        * aT
        * (
            243 * (2 * aT) ** 4 * (aT + bX)
            + bX * (3 * bX**4 - 2 * bX**2 + 51)
            + 72 * aT**2 * bX * (5 * bX**2 - 9)
            + 108 * aT**3 * (15 * bX**2 - 13)
            + 3 * aT * (15 * bX**4 - 30 * bX**2 + 139)
        )
        + bX**6
        + 3 * bX**4
        + 27 * bX**2
        + 9
    )
    return 12 * G_2 / D_2 + 1


RATIONAL_2 = ClosedForm(
    name="rational_2",
    title="second-order rational solution",
    expression=_printed(aT=-2 * tau, bX=2 * xi),
    equation=FOCUSING_MKDV,
    parameters=(),
    background=sp.S.One,
    far_fields=FarFields(sp.S.One, sp.S.One),
    reference=Reference("ankiewicz2018rogue", "mKdV 2-order soln"),
    stabilise=lambda: horner_form(2),
    evaluator=rational_evaluator(2),
)
