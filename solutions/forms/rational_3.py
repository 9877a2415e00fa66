"""The third-order rational solution Y3, as printed in the paper's eqs. (17) and (18) (K4 > 0).

The paper's letters: ``b X`` is ``2 xi`` and ``c T`` is ``24 tau``, because ``c = -3 b**3 gamma_3``
is 24 times the rate of tau; hence ``z = (2 b X - c T)/4 = xi - 6 tau``.
"""

import sympy as sp

from solutions.equation import FOCUSING_MKDV
from solutions.rational_family import horner_form, rational_evaluator
from solutions.record import ClosedForm, FarFields, Reference
from solutions.symbols import tau, xi

__all__ = ["RATIONAL_3"]


def _printed(bX: sp.Expr, cT: sp.Expr) -> sp.Expr:
    z = (2 * bX - cT) / 4
    G_3 = (
        4
        * (
            800 * cT**3 * z
            + 150 * cT**2 * (16 * z**4 - 8 * z**2 + 5)
            + 120 * cT * z * (-16 * z**4 + 40 * z**2 + 15)
            + z**2 * (8 * z**2 * (32 * z**6 + 120 * z**4 + 420 * z**2 - 225) - 675)
        )
        + 675
    )
    D_3 = 2025 + 8 * (
        800 * cT**4
        - 800 * cT**3 * z * (-3 + 4 * z**2)
        + 30 * cT**2 * (165 - 180 * z**2 + 240 * z**4 + 64 * z**6)
        + 10 * cT * z * (-675 + 32 * z**2 * (45 - 27 * z**2 + 8 * z**6))
        + z**2 * (6075 + 2 * z**2 * (3375 + 16 * z**2 * (585 + 135 * z**2 + 24 * z**4 + 16 * z**6)))
    )
    return 24 * G_3 / D_3 - 1


RATIONAL_3 = ClosedForm(
    name="rational_3",
    title="third-order rational solution",
    expression=_printed(bX=2 * xi, cT=24 * tau),
    equation=FOCUSING_MKDV,
    parameters=(),
    background=sp.S.NegativeOne,
    far_fields=FarFields(sp.S.NegativeOne, sp.S.NegativeOne),
    reference=Reference("ankiewicz2018rogue", "third-order soln of mKdV"),
    stabilise=lambda: horner_form(3),
    evaluator=rational_evaluator(3),
)
