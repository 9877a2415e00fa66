"""Admissible parameters and a private mpmath context for the closed forms."""

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp

from longwave.derive import NormalForm, mkdv_normal_form
from longwave.solutions import ClosedForm
from longwave.solutions.functions.multiprecision import MpmathFormula
from longwave.solutions.symbols import tau, xi

RANGES = {
    "k": (0.05, 0.99),
    **dict.fromkeys(("A", "A_1", "kappa_1", "p", "q"), (0.3, 2.0)),
    **dict.fromkeys(("A_2", "kappa_2"), (0.1, 0.9)),
    "kappa": (0.1, 1.9),
    "nls_akhmediev a": (0.01, 0.49),
    "nls_kuznetsov_ma a": (0.51, 2.0),
    "gardner_table_soliton kappa": (0.05, 0.99),
}
"""``A_2`` in units of A_1, and kappa in units of A where the wave has these."""

Draw = Callable[[ClosedForm], dict[str, float]]


@pytest.fixture
def draw(rng: np.random.Generator) -> Draw:
    """Return a function that draws random admissible parameters of a closed form, as floats."""

    def parameters(form: ClosedForm) -> dict[str, float]:
        values: dict[str, float] = {}
        for parameter in form.parameters:
            own = RANGES.get(parameter.name, (-1.0, 1.0))
            low, high = RANGES.get(f"{form.name} {parameter.name}", own)
            unit = {"A_2": "A_1", "kappa_2": "kappa_1", "kappa": "A"}.get(parameter.name, "")
            high *= values.get(unit, 1.0)
            values[parameter.name] = round(float(rng.uniform(low, high)), 4)
            if parameter.name == "alpha":
                quarter = float(mpmath.ellipk(values["k"] ** 2))
                values["alpha"] = round(quarter * float(rng.uniform(0.1, 0.9)), 4)
        return values

    return parameters


@pytest.fixture
def ctx() -> Any:
    """Return a private mpmath context of 60 digits."""
    context = mpmath.MPContext()
    context.dps = 60
    return context


@pytest.fixture
def in_mp(ctx: Any) -> Callable[..., Any]:
    """``in_mp(form, expression, values)``: the expression as an mpmath function of (xi, tau)."""

    def function(form: ClosedForm, expression: sp.Expr, values: dict[str, float]) -> Any:
        exact = {s: ctx.mpf(v.p) / v.q for s, v in form.check(values).items()}
        formula = MpmathFormula.of([xi, tau, *exact], [expression])
        return lambda x, t: formula(ctx, ctx.mpf(x), ctx.mpf(t), *exact.values())[0]

    return function


@pytest.fixture
def normal_forms() -> dict[int, NormalForm]:
    """One normal form of mKdV for each sign s."""
    return {1: mkdv_normal_form(K2=4, K4=1), -1: mkdv_normal_form(K2=1, K4=-1)}
