"""Exact facts about the rational solutions; the printed Y2 and Y3 are members of the family."""

import pytest
import sympy as sp

from longwave.solutions import closed_form, rational
from longwave.solutions.forms.tau_polynomials import rational_tau
from longwave.verify.proof import prove_equal, rational_facts
from longwave.verify.proof.rational_proofs import coefficient_in_x, leading_in_x, limit, reflected
from longwave.verify.verdict import Outcome


@pytest.mark.parametrize("order", range(1, 10))
def test_peak_background_degree_symmetry_and_sign_of_the_denominator(order: int) -> None:
    facts = rational_facts(order)
    assert facts.peak == 2 * order + 1
    assert facts.background == (-1) ** order
    assert facts.degree == order * (order + 1)
    assert facts.reduced
    assert facts.symmetric
    assert facts.positive


@pytest.mark.parametrize("order", range(3, 7))
def test_the_facts_hold_with_all_shifts_symbolic(order: int) -> None:
    facts = rational_facts(order, tuple(range(5, 2 * order, 2)))
    assert (facts.peak, facts.background) == (2 * order + 1, (-1) ** order)
    assert facts.reduced
    assert facts.symmetric
    assert facts.positive


@pytest.mark.parametrize("order", [2, 3])
def test_the_printed_forms_are_the_family_members(order: int) -> None:
    printed, member = closed_form(f"rational_{order}"), rational(order)
    variables = (printed.equation.xi, printed.equation.tau)
    assert prove_equal(printed.expression, member.expression, variables).outcome is Outcome.PROVED
    changed = printed.expression + sp.Rational(1, 10**30)
    assert prove_equal(changed, member.expression, variables).outcome is Outcome.REFUTED


def test_the_facts_are_those_of_the_expression() -> None:
    """The peak is the value of the formula that is evaluated, not only of A and B."""
    form = rational(4)
    origin = dict.fromkeys((form.equation.xi, form.equation.tau), 0)
    assert form.expression.subs(origin) == rational_facts(4).peak


def test_a_background_that_moves_is_no_background() -> None:
    A = rational_tau(2).A
    leading, top = leading_in_x(A)
    t = A.context().gens()[1]
    with pytest.raises(ValueError, match="depends on t"):
        limit(t * A, leading, top)
    with pytest.raises(ValueError, match="higher degree"):
        limit(A * A, leading, top)


def test_reflection_sees_an_even_term() -> None:
    A = rational_tau(2).A
    assert reflected(A) == -A
    assert reflected(A + 1) != -(A + 1)
    assert coefficient_in_x(A, 0) == 96 * A.context().gens()[1]
