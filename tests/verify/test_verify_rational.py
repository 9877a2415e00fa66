"""Exact proofs of the rational forms in the lab variables."""

from dataclasses import replace
from fractions import Fraction

import pytest
import sympy as sp

from derive import mkdv_normal_form, mkdv_reduction
from derive.symbols import K2, K4, c
from solutions.catalogue import closed_form
from solutions.equation import DEFOCUSING_MKDV
from solutions.rational import rational
from solutions.symbols import tau, xi
from verify.fraction import NotRationalError, Ring
from verify.lab import LabEquation, a, lab_frame
from verify.rational import check_rational, exact_residual, is_rational
from verify.verdict import Outcome

PRINTED = ["rational_1", "rational_2", "rational_3"]


@pytest.mark.parametrize("name", PRINTED)
def test_the_printed_forms_are_proved(name: str) -> None:
    verdict = check_rational(closed_form(name))
    assert verdict.outcome is Outcome.PROVED
    assert verdict.residual == 0
    assert verdict.seconds < 2


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_the_family_is_proved(order: int) -> None:
    assert check_rational(rational(order)).outcome is Outcome.PROVED


def test_the_family_is_proved_for_every_shift() -> None:
    assert check_rational(rational(3, free=[5])).outcome is Outcome.PROVED


@pytest.mark.parametrize("name", PRINTED)
def test_the_wrong_sign_of_k4_is_refuted(name: str) -> None:
    form = replace(closed_form(name), equation=DEFOCUSING_MKDV)
    assert check_rational(form).outcome is Outcome.REFUTED


def test_the_witness_of_a_refutation_leaves_the_residual_that_is_stated() -> None:
    wrong = replace(closed_form("rational_1"), expression=4 / (1 + 4 * (xi - 6 * tau) ** 2) - 2)
    verdict = check_rational(wrong)
    frame = lab_frame(1)
    lab = wrong.expression.xreplace({xi: frame.xi, tau: frame.tau})
    residual = LabEquation(frame).residual(lab)
    assert verdict.witness is not None
    point = {sp.Symbol(n, **_assumptions(n)): sp.Rational(v) for n, v in verdict.witness.items()}
    value = Fraction(str(sp.nsimplify(residual.subs(point))))
    assert abs(float(value)) == pytest.approx(verdict.residual)
    assert value != 0


def _assumptions(name: str) -> dict[str, bool]:
    return {"positive": True} if name in ("a", "c") else {"real": True}


@pytest.mark.parametrize("s", [1, -1])
def test_the_parametrisation_is_the_normal_form_record(s: int) -> None:
    frame = lab_frame(s)
    record = mkdv_normal_form(frame.K2, frame.K4)
    X, T = LabEquation(frame).xi, LabEquation(frame).tau
    assert sp.simplify(record.a * X - frame.xi) == 0
    assert sp.simplify(record.b * T - frame.tau) == 0
    assert sp.simplify(record.c - c) == 0
    assert record.s == s


def test_the_papers_letters_are_the_normal_form_variables() -> None:
    """b X = 2 xi and a T = -2 tau in Y2, c T = 24 tau in Y3, with the paper's b, a, c."""
    frame, pde = lab_frame(1), mkdv_reduction().pde
    at = frame.constants()
    beta, gamma_3 = pde.nonlinear_coefficient.subs(at), -pde.dispersive_coefficient.subs(at)
    b = sp.sqrt(-2 * beta / (3 * gamma_3))
    X, T = LabEquation(frame).xi, LabEquation(frame).tau
    assert sp.simplify(b * X - 2 * frame.xi) == 0
    assert sp.simplify(b**3 * gamma_3 / 4 * T + 2 * frame.tau) == 0
    assert sp.simplify(-3 * b**3 * gamma_3 * T - 24 * frame.tau) == 0


def test_the_generators_name_the_lattice_constants() -> None:
    assert lab_frame(-1).constants() == {K2: c**2, K4: -(a**2) * c**2 / 6}


def test_a_denominator_that_vanishes_identically_is_undecided() -> None:
    nothing = xi**2 - 1 - (xi - 1) * (xi + 1)
    form = replace(closed_form("rational_1"), expression=1 / nothing)
    verdict = check_rational(form)
    assert verdict.outcome is Outcome.UNDECIDED
    assert "denominator must not vanish" in verdict.detail


def test_a_form_with_functions_is_no_rational_form() -> None:
    assert not is_rational(closed_form("kink"))
    assert check_rational(closed_form("kink")).outcome is Outcome.UNDECIDED


def test_a_float_is_not_taken_for_a_rational() -> None:
    form = replace(closed_form("rational_1"), expression=sp.Float("0.5") + xi)
    assert not is_rational(form)
    with pytest.raises(NotRationalError):
        exact_residual(form)


def test_fractions_keep_a_common_denominator() -> None:
    x, y = sp.symbols("x y")
    numerator, denominator = Ring([x, y]).fraction(x / (1 + y) - 1 / (1 + y) ** 2 + y)
    expected = sp.Poly(x * (1 + y) - 1 + y * (1 + y) ** 2, x, y)
    assert len(numerator) == len(expected.terms())
    assert denominator.total_degree() == 2
