"""The first-order rational solution: a Lorentzian travelling wave on -1 (K4 > 0)."""

import sympy as sp

from solutions.equation import FOCUSING_MKDV
from solutions.rational_family import CO_MOVING, horner_form, rational_evaluator
from solutions.record import ClosedForm, FarFields, Reference

__all__ = ["RATIONAL_1"]

RATIONAL_1 = ClosedForm(
    name="rational_1",
    title="first-order rational solution (Lorentzian)",
    expression=4 / (1 + 4 * CO_MOVING**2) - 1,
    equation=FOCUSING_MKDV,
    parameters=(),
    background=sp.S.NegativeOne,
    far_fields=FarFields(sp.S.NegativeOne, sp.S.NegativeOne),
    reference=Reference("ankiewicz2018rogue", "Sec: Local waves on constant back"),
    stabilise=lambda: horner_form(1),
    evaluator=rational_evaluator(1),
)
