"""Mutants are refuted with a witness or proved to be solutions; none is undecided."""

import pytest
import sympy as sp

from longwave.solutions import CATALOGUE, ClosedForm, closed_form
from longwave.verify.evidence.mutations import count_mutants
from longwave.verify.proof import form_domains, prove
from longwave.verify.verdict import Outcome


@pytest.mark.parametrize(
    "name",
    ["kink", "soliton_sech", "wave_cn", "rational_1", "gardner_kink", "nls_dn"],
)
def test_no_mutant_is_undecided(name: str) -> None:
    found = count_mutants(closed_form(name))
    assert found.undecided == 0
    assert found.refuted > 5 * found.proved > 0


@pytest.mark.slow
@pytest.mark.parametrize("form", CATALOGUE, ids=lambda form: form.name)
def test_no_mutant_of_any_form_is_undecided(form: ClosedForm) -> None:
    found = count_mutants(form)
    assert found.undecided == 0
    assert found.refuted > 0


def test_the_witness_is_a_point_with_a_residual() -> None:
    form = closed_form("kink")
    verdict = prove(form.equation, 2 * form.expression)
    assert verdict.outcome is Outcome.REFUTED
    assert verdict.witness is not None
    point = {
        symbol: sp.Rational(verdict.witness[str(symbol)]) for symbol in form.expression.free_symbols
    }
    residual = form.equation.residual(2 * form.expression).xreplace(point)
    assert abs(sp.N(residual, 30)) > 1e-10


def test_a_change_below_double_precision_is_refuted() -> None:
    form = closed_form("wave_dn")
    changed = form.expression * (1 + sp.Rational(1, 10**30))
    verdict = prove(form.equation, changed, domains=form_domains(form))
    assert verdict.outcome is Outcome.REFUTED


def test_a_change_below_the_first_precision_is_refuted_by_a_higher_one() -> None:
    form = closed_form("wave_dn")
    changed = form.expression * (1 + sp.Rational(1, 10**80))
    verdict = prove(form.equation, changed, domains=form_domains(form))
    assert verdict.outcome is Outcome.REFUTED


def test_what_cannot_be_decided_says_why() -> None:
    x = sp.Symbol("x")
    u = sp.Function("u")(x)
    verdict = prove(x * u.diff(x, 2) + u.diff(x) + x * u, sp.gamma(x))
    assert verdict.outcome is Outcome.UNDECIDED
    assert "gamma" in verdict.detail


def test_an_equation_needs_one_unknown() -> None:
    x = sp.Symbol("x")
    with pytest.raises(ValueError, match="one unknown function, got 2"):
        prove(sp.Function("u")(x) + sp.Function("v")(x), x)
