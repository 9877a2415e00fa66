"""Lab variables: K2 and K4 without square roots, and proofs in these variables."""

from dataclasses import replace

import pytest
import sympy as sp

from longwave.derive import mkdv_normal_form, mkdv_reduction
from longwave.derive.symbols import K2, K4, T, X, c
from longwave.solutions import closed_form, rational
from longwave.solutions.equation import DEFOCUSING_MKDV
from longwave.solutions.symbols import tau, xi
from longwave.verify.proof import prove_form
from longwave.verify.proof.catalogue_proofs import a, lab_frame
from longwave.verify.verdict import Outcome

PRINTED = ["rational_1", "rational_2", "rational_3"]


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_rational_family_is_proved_in_lab_variables(order: int) -> None:
    assert prove_form(rational(order)).outcome is Outcome.PROVED


def test_the_rational_family_is_proved_for_every_shift() -> None:
    assert prove_form(rational(3, free=[5])).outcome is Outcome.PROVED


@pytest.mark.parametrize("name", PRINTED)
def test_the_wrong_sign_of_k4_is_refuted(name: str) -> None:
    form = replace(closed_form(name), equation=DEFOCUSING_MKDV)
    assert prove_form(form).outcome is Outcome.REFUTED


def test_the_witness_of_a_refutation_leaves_a_residual() -> None:
    wrong = replace(closed_form("rational_1"), expression=4 / (1 + 4 * (xi - 6 * tau) ** 2) - 2)
    verdict = prove_form(wrong)
    frame = lab_frame(1)
    lab = wrong.expression.xreplace({xi: frame.xi, tau: frame.tau})
    residual = frame.residual(lab)
    assert verdict.witness is not None
    point = {symbol: sp.Rational(verdict.witness[str(symbol)]) for symbol in residual.free_symbols}
    value = residual.xreplace(point)
    assert value.is_Rational
    assert value != 0


@pytest.mark.parametrize("s", [1, -1])
def test_the_parametrisation_is_the_normal_form_record(s: int) -> None:
    frame = lab_frame(s)
    record = mkdv_normal_form(frame.K2, frame.K4)
    assert sp.simplify(record.a * X - frame.xi) == 0
    assert sp.simplify(record.b * T - frame.tau) == 0
    assert sp.simplify(record.c - c) == 0
    assert record.s == s


def test_the_papers_letters_are_the_normal_form_variables() -> None:
    """In Y2 b X = 2 xi and a T = -2 tau, in Y3 c T = 24 tau, with the paper's b, a, c."""
    frame, pde = lab_frame(1), mkdv_reduction().pde
    at = frame.constants()
    beta, gamma_3 = pde.nonlinear_coefficient.subs(at), -pde.dispersive_coefficient.subs(at)
    b = sp.sqrt(-2 * beta / (3 * gamma_3))
    assert sp.simplify(b * X - 2 * frame.xi) == 0
    assert sp.simplify(b**3 * gamma_3 / 4 * T + 2 * frame.tau) == 0
    assert sp.simplify(-3 * b**3 * gamma_3 * T - 24 * frame.tau) == 0


def test_the_generators_name_the_lattice_constants() -> None:
    assert lab_frame(-1).constants() == {K2: c**2, K4: -(a**2) * c**2 / 6}


def test_a_denominator_that_vanishes_identically_is_undecided() -> None:
    nothing = xi**2 - 1 - (xi - 1) * (xi + 1)
    verdict = prove_form(replace(closed_form("rational_1"), expression=1 / nothing))
    assert verdict.outcome is Outcome.UNDECIDED
    assert "every denominator is shown not to vanish" in verdict.detail


def test_a_float_is_not_taken_for_a_rational() -> None:
    form = replace(closed_form("rational_1"), expression=sp.Float("0.5") + xi)
    verdict = prove_form(form)
    assert verdict.outcome is Outcome.UNDECIDED
    assert "Float" in verdict.detail
