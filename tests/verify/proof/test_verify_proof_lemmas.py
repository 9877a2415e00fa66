"""Equalities proved part by part: the choice of parts; a false part proves nothing."""

import sympy as sp

from longwave.solutions import closed_form
from longwave.verify.evidence.residual import sample_points
from longwave.verify.kernel import check_certificate
from longwave.verify.proof import form_domains, prove_equal
from longwave.verify.proof.certificate import find_lemmas, make_certificate
from longwave.verify.proof.problem import equality_problem
from longwave.verify.verdict import Outcome

x, a = sp.symbols("x a", real=True)
POINT = {x: sp.Rational(1, 3), a: sp.Rational(2, 7)}
ONE_WAY, OTHER_WAY = sp.cosh(x) ** 2 + a, sp.sinh(x) ** 2 + a + 1


def accepted(left: sp.Expr, right: sp.Expr, parts: list[tuple[sp.Expr, sp.Expr]]) -> bool:
    problem = equality_problem(left, right, [x])
    try:
        check_certificate(make_certificate(problem, parts))
    except ValueError:
        return False
    return True


def test_the_largest_equal_sums_are_found() -> None:
    assert find_lemmas(sp.exp(a) / ONE_WAY, sp.exp(a) / OTHER_WAY, [x], POINT) == [
        (ONE_WAY, OTHER_WAY)
    ]


def test_formulas_are_equal_if_their_parts_are() -> None:
    assert accepted(a / ONE_WAY + x, a / OTHER_WAY + x, [(ONE_WAY, OTHER_WAY)])


def test_different_formulas_of_equal_parts_are_not_equal() -> None:
    assert not accepted(a / ONE_WAY, 2 * a / OTHER_WAY, [(ONE_WAY, OTHER_WAY)])
    assert prove_equal(a / ONE_WAY, 2 * a / OTHER_WAY, [x]).outcome is Outcome.REFUTED


def test_a_false_part_proves_nothing() -> None:
    """The two sums agree at the point only."""
    left, right = x + a, x + 2 * a - sp.Rational(2, 7)
    assert find_lemmas(1 / left, 1 / right, [x], POINT)
    assert not accepted(1 / left, 1 / right, [(left, right)])


def test_what_needs_the_parts_is_proved_without_them() -> None:
    left = (sp.cosh(x) ** 2 + a) - sp.sinh(x) ** 2 * sp.sin(a) ** 2
    right = (sp.sinh(x) ** 2 + a + 1) - (sp.cosh(x) ** 2 - 1) * sp.sin(a) ** 2
    assert prove_equal(left, right, [x]).outcome is Outcome.PROVED


def test_a_denominator_that_vanishes_for_the_parts_is_not_overlooked() -> None:
    """A free generator for the sum hides that the denominator vanishes identically."""
    nothing, same = 1 / (ONE_WAY - OTHER_WAY), 1 / (OTHER_WAY - ONE_WAY)
    assert not accepted(nothing, same, [(ONE_WAY, OTHER_WAY)])
    assert prove_equal(nothing, same, [x]).outcome is Outcome.UNDECIDED


def test_the_parts_of_the_rogue_wave_are_lemmas() -> None:
    form = closed_form("rogue_cn")
    (point,) = sample_points(form, 1, 0)
    variables = (form.equation.xi, form.equation.tau)
    lemmas = find_lemmas(form.expression, form.stable, variables, point)
    assert len(lemmas) == 2
    for left, right in lemmas:
        verdict = prove_equal(left, right, variables, domains=form_domains(form))
        assert verdict.outcome is Outcome.PROVED
