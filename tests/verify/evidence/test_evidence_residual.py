"""High-precision residual: right forms pass, wrong ones are refuted, others have a reason."""

from dataclasses import replace

import pytest
import sympy as sp

from longwave.solutions.catalogue import CATALOGUE, closed_form
from longwave.solutions.equation import FOCUSING_MKDV
from longwave.solutions.functions import jacobi_sn
from longwave.solutions.record import ClosedForm
from longwave.solutions.symbols import k, s, tau, xi
from longwave.verify.evidence.residual import Sampling, check_residual
from longwave.verify.verdict import Outcome
from tests.families import WAVES, family

QUICK = Sampling(digits=(30, 50), points=3, seed=5)
DEAR = ("rogue_cn", "breather_sn", "gardner_soliton")
"""Forms of which a residual takes seconds: in the default suite they are looked at once."""

TRANSCENDENTAL = [form for form in CATALOGUE if not form.name.startswith("rational_")]
SIGNED = [form for form in TRANSCENDENTAL if form.equation.normal not in ("KdV", "KP")]


@pytest.mark.parametrize("form", family(CATALOGUE, quick=WAVES))
def test_every_form_passes_at_three_precisions(form: ClosedForm) -> None:
    verdict = check_residual(form, Sampling(points=2, seed=11))
    assert verdict.outcome is Outcome.CHECKED, verdict.detail
    assert verdict.residual < 1e-95


@pytest.mark.parametrize("form", family(SIGNED, quick=WAVES, slow=DEAR))
def test_the_other_sign_of_the_equation_is_refuted(form: ClosedForm) -> None:
    if form.equation.free_sign:
        form = replace(form, expression=form.expression.subs(s, 1))
    other = replace(form.equation, s=1 if form.equation.s == -1 else -1)
    verdict = check_residual(replace(form, equation=other), QUICK)
    assert verdict.outcome is Outcome.REFUTED
    assert verdict.witness is not None
    assert {"xi", "tau"} <= verdict.witness.keys()


def test_a_constant_of_double_precision_is_refuted() -> None:
    """1/3 as a float satisfies the equation to 1e-17 and no further."""
    slow = sp.Rational(1, 3)
    exact = slow * sp.sech(slow * xi - slow**3 * tau)
    rounded = exact.subs(slow, sp.Float(1 / 3, 40))
    assert rounded != exact
    wrong = sp.Float(1 / 3, 40) * sp.sech(slow * xi - slow**3 * tau)
    form = closed_form("soliton_sech")
    assert _outcome(form, exact) is Outcome.CHECKED
    assert _outcome(form, wrong) is Outcome.REFUTED


def test_a_perturbation_far_below_the_lowest_precision_is_refuted() -> None:
    form = closed_form("wave_dn")
    off = form.expression * (1 + sp.Rational(1, 10**40))
    assert check_residual(replace(form, expression=off), Sampling((30, 50, 100), 2)).outcome is (
        Outcome.REFUTED
    )


def _outcome(form: ClosedForm, expression: sp.Expr) -> Outcome:
    return check_residual(replace(form, expression=expression, parameters=()), QUICK).outcome


def test_a_function_without_implementation_is_undecided_with_its_name() -> None:
    unknown = sp.Function("unheard_of")(xi)
    verdict = check_residual(replace(closed_form("wave_sn"), expression=unknown), QUICK)
    assert verdict.outcome is Outcome.UNDECIDED
    assert "unheard_of" in verdict.detail


def test_a_derivative_in_the_parameter_is_undecided() -> None:
    form = replace(closed_form("wave_sn"), expression=jacobi_sn(xi, tau))
    verdict = check_residual(form, QUICK)
    assert verdict.outcome is Outcome.UNDECIDED
    assert "jacobi_sn has no known derivative" in verdict.detail


def test_a_nameless_value_is_undecided_with_the_point() -> None:
    form = replace(closed_form("wave_sn"), expression=sp.LambertW(xi + sp.besseli(0, tau)))
    verdict = check_residual(form, QUICK)
    assert verdict.outcome is Outcome.UNDECIDED
    assert "no value at" in verdict.detail


def test_a_pole_everywhere_is_undecided() -> None:
    pole = 1 / sp.Add(xi, -xi, evaluate=False)
    verdict = check_residual(replace(closed_form("wave_sn"), expression=pole), QUICK)
    assert verdict.outcome is Outcome.UNDECIDED


def test_a_residual_that_neither_falls_nor_settles_is_undecided() -> None:
    """Cancellation of 80 digits hides whether the remainder is a solution."""
    huge = sp.Integer(10) ** 80
    noisy = huge * (sp.sin(2 * k) - 2 * sp.sin(k) * sp.cos(k)) + sp.sech(xi - tau)
    form = replace(closed_form("wave_sn"), expression=noisy, equation=FOCUSING_MKDV)
    assert check_residual(form, QUICK).outcome is not Outcome.CHECKED


def test_the_same_seed_gives_the_same_residual() -> None:
    form = closed_form("wave_cn")
    assert check_residual(form, QUICK).residual == check_residual(form, QUICK).residual


@pytest.mark.parametrize(("points", "digits"), [(0, (30, 50)), (3, (30,))])
def test_samplings_that_say_nothing_are_refused(points: int, digits: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"must (be|satisfy)"):
        Sampling(digits, points)
