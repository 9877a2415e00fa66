"""Rational solutions of every order: bilinear identities and the residual itself."""

import pytest

from solutions.rational import rational, rational_tau
from verify.proof import prove, prove_bilinear, prove_rational
from verify.proof.bilinear import space_residual, time_residual
from verify.proof.rational_orders import residual_at, wave_polynomials
from verify.verdict import Outcome


@pytest.mark.parametrize("order", range(1, 10))
def test_every_order_is_proved_directly_and_by_bilinear_identities(order: int) -> None:
    assert prove_bilinear(order).outcome is Outcome.PROVED
    assert prove_rational(order).outcome is Outcome.PROVED


def test_there_are_more_points_than_the_degree_in_time() -> None:
    """D of order 3 has t**4, so that D**4 times the residual has at most t**16."""
    assert prove_rational(3).detail == "0 at 17 values of tau"


def test_free_shifts_stay_symbolic() -> None:
    assert prove_bilinear(4, (5, 7)).outcome is Outcome.PROVED
    form = rational(3, (5,))
    assert prove(form.equation, form.expression).outcome is Outcome.PROVED


def test_both_proofs_see_a_changed_coefficient() -> None:
    N, D = wave_polynomials(3)
    N[0] = N[0] + 1
    assert any(residual_at(N, D, t) for t in range(-3, 4))
    family = rational_tau(3)
    assert not space_residual(family.A + 1, family.B).is_zero()
    assert not time_residual(family.A + 1, family.B).is_zero()


def test_a_shift_of_the_third_kind_is_not_free_in_time() -> None:
    """tau_3 moves t: a coefficient of t changed in A alone breaks the identity."""
    family = rational_tau(2)
    t = family.A.context().gens()[1]
    assert not time_residual(family.A + 3 * t, family.B).is_zero()
