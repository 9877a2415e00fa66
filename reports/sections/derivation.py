"""The derivation: the reduction order by order, the dispersion relation, the velocity."""

from typing import Any

import sympy as sp

from derive import dispersion_relation, initial_velocity_latex, mkdv_reduction, reduce
from derive.dispersion import agrees_with_reduction

DERIVATION_ORDERS = 7
"""Highest power of eps shown: two beyond the mKdV equation."""


def derivation() -> dict[str, Any]:
    """The reduction order by order, its coefficients, the dispersion relation, the velocity."""
    shown = reduce(mkdv_reduction().lattice, mkdv_reduction().scaling, orders=DERIVATION_ORDERS)
    relation = dispersion_relation(shown.lattice)
    coefficients, form = shown.coefficients(), shown.normal_form()
    return {
        "force": sp.latex(shown.lattice.bonds[0].force),
        "orders": [(order, equation.latex()) for order, equation in shown.orders.items()],
        "sound": sp.latex(shown.sound_condition),
        "conditions": [
            (condition.latex(), condition.order, condition.equation.latex())
            for condition in shown.conditions
        ],
        "pde": shown.pde.latex(),
        "remainders": [shown.latex_remainder(order) for order in shown.remainders],
        "corrections": [shown.latex_correction(power) for power in shown.corrections],
        "coefficients": [
            (name, sp.latex(getattr(coefficients, name)))
            for name in ("c", "nonlinear", "dispersive")
        ],
        "normal_form": [(name, sp.latex(getattr(form, name))) for name in ("a", "b", "s")],
        "dispersion": relation.latex(),
        "dispersion_agrees": agrees_with_reduction(shown.lattice, shown),
        "velocity": initial_velocity_latex(),
    }
