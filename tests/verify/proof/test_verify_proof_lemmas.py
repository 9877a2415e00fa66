"""Equalities proved part by part: what is a part, and that a false one proves nothing."""

import sympy as sp

from solutions import closed_form
from verify.proof import prove_equal
from verify.proof.compilation import compile_expressions, regular_point
from verify.proof.domain import form_domains
from verify.proof.lemmas import equal_by_lemmas, find_lemmas
from verify.proof.signs import Signs
from verify.sampling import sample_points
from verify.verdict import Outcome

x, a = sp.symbols("x a", real=True)
SIGNS = Signs({})
POINT = {x: sp.Rational(1, 3), a: sp.Rational(2, 7)}
ONE_WAY, OTHER_WAY = sp.cosh(x) ** 2 + a, sp.sinh(x) ** 2 + a + 1


def test_the_largest_equal_sums_are_found() -> None:
    (lemma,) = find_lemmas(sp.exp(a) / ONE_WAY, sp.exp(a) / OTHER_WAY, [x], POINT, SIGNS)
    assert (lemma.left, lemma.right) == (ONE_WAY, OTHER_WAY)


def test_formulas_are_equal_if_their_parts_are() -> None:
    found = equal_by_lemmas(a / ONE_WAY + x, a / OTHER_WAY + x, [x], POINT, SIGNS)
    assert found is not None
    assert list(found[1].values()) == [ONE_WAY]


def test_different_formulas_of_equal_parts_are_not_equal() -> None:
    assert equal_by_lemmas(a / ONE_WAY, 2 * a / OTHER_WAY, [x], POINT, SIGNS) is None
    assert prove_equal(a / ONE_WAY, 2 * a / OTHER_WAY, [x]).outcome is Outcome.REFUTED


def test_a_false_lemma_proves_nothing() -> None:
    """The two sums agree at the point only."""
    left, right = x + a, x + 2 * a - sp.Rational(2, 7)
    assert find_lemmas(1 / left, 1 / right, [x], POINT, SIGNS)
    assert equal_by_lemmas(1 / left, 1 / right, [x], POINT, SIGNS) is None


def test_what_needs_the_parts_is_proved_without_lemmas() -> None:
    left = (sp.cosh(x) ** 2 + a) - sp.sinh(x) ** 2 * sp.sin(a) ** 2
    right = (sp.sinh(x) ** 2 + a + 1) - (sp.cosh(x) ** 2 - 1) * sp.sin(a) ** 2
    assert prove_equal(left, right, [x]).outcome is Outcome.PROVED


def test_a_denominator_that_vanishes_for_the_parts_is_not_overlooked() -> None:
    """A free symbol for the sum hides that the denominator vanishes identically."""
    symbol = sp.Symbol("part_1", real=True)
    compiled = compile_expressions(
        [1 / (symbol - 1 - a)], [], [x], {**POINT, symbol: sp.S.Half}, SIGNS
    )
    assert regular_point(compiled.field, [{**POINT, symbol: sp.S.Half}]) is not None
    assert regular_point(compiled.field, [POINT], {symbol: ONE_WAY - sp.sinh(x) ** 2}) is None


def test_the_integral_of_the_rogue_wave_is_a_lemma() -> None:
    form = closed_form("rogue_cn")
    (point,) = sample_points(form, 1, 0)
    variables = (form.equation.xi, form.equation.tau)
    (lemma,) = find_lemmas(
        form.expression, form.stable, variables, point, Signs(form_domains(form))
    )
    assert (
        prove_equal(lemma.left, lemma.right, variables, domains=form_domains(form)).outcome
        is Outcome.PROVED
    )
