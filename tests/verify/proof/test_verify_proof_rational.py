"""Rational solutions of every order: bilinear identities and the residual itself."""

import pytest

from longwave.solutions.forms.rational import rational, rational_tau
from longwave.verify.proof import prove, prove_bilinear, prove_rational
from longwave.verify.proof.rational_proofs import (
    SPACE,
    TIME,
    bilinear_residual,
    bilinear_verdict,
    nonzero_point,
    rational_verdict,
    residual_at,
)
from longwave.verify.verdict import Outcome


@pytest.mark.parametrize("order", range(1, 10))
def test_every_order_is_proved_directly_and_by_bilinear_identities(order: int) -> None:
    assert prove_bilinear(order).outcome is Outcome.PROVED
    assert prove_rational(order).outcome is Outcome.PROVED


def test_there_are_more_points_than_the_degree_in_time() -> None:
    """D of order 3 has t**4, so that D**4 times the residual has at most t**16."""
    assert prove_rational(3).detail.startswith("0 at 17 values of tau")


def test_free_shifts_stay_symbolic() -> None:
    assert prove_bilinear(4, (5, 7)).outcome is Outcome.PROVED
    form = rational(3, (5,))
    assert prove(form.equation, form.expression).outcome is Outcome.PROVED


def test_both_proofs_see_a_changed_coefficient() -> None:
    family = rational_tau(3)
    assert any(residual_at(family.A + 1, family.B, 1, t) for t in range(-3, 4))
    assert not any(residual_at(family.A, family.B, x, t) for x in (0, 1, 5) for t in (-2, 0, 3))
    assert not bilinear_residual(SPACE, family.A + 1, family.B).is_zero()
    assert not bilinear_residual(TIME, family.A + 1, family.B).is_zero()


def test_a_shift_of_the_third_kind_is_not_free_in_time() -> None:
    """tau_3 moves t: a coefficient of t changed in A alone breaks the identity."""
    family = rational_tau(2)
    t = family.A.context().gens()[1]
    assert not bilinear_residual(TIME, family.A + 3 * t, family.B).is_zero()


@pytest.mark.parametrize("changes", [(1, 0), (0, 1)])
def test_bilinear_identities_that_fail_are_refuted_with_a_point(changes: tuple[int, int]) -> None:
    family = rational_tau(3, (5,))
    A, B = family.A + changes[0], family.B + changes[1]
    verdict = bilinear_verdict("changed", A, B)
    assert verdict.outcome is Outcome.REFUTED
    assert verdict.witness is not None
    point = [int(verdict.witness[name]) for name in ("x", "t", "tau_5")]
    assert bilinear_residual(SPACE, A, B)(*point) != 0


def test_a_bilinear_identity_that_fails_in_time_alone_is_refuted() -> None:
    """A -> -A, t -> -t keeps the first equation and breaks the second."""
    family = rational_tau(2)
    later = (
        {e: c * (-1) ** int(e[1]) for e, c in family.A.terms()},
        {e: c * (-1) ** int(e[1]) for e, c in family.B.terms()},
    )
    A, B = (family.A.context().from_dict(terms) for terms in later)
    assert bilinear_residual(SPACE, A, B).is_zero()
    verdict = bilinear_verdict("backwards", A, B)
    assert verdict.outcome is Outcome.REFUTED
    assert "time equation" in verdict.detail


def test_a_point_is_found_where_small_integers_are_zeros() -> None:
    x, t = rational_tau(2).A.context().gens()
    polynomial = (x - 1) * (x - 2) * (t - 1)
    assert nonzero_point(polynomial) == (3, 2)


def test_a_wrong_formula_is_refuted_at_a_point() -> None:
    family = rational_tau(3)
    verdict = rational_verdict(3, family.A + 1, family.B)
    assert verdict.outcome is Outcome.REFUTED
    assert verdict.witness is not None
    x, t = (int(verdict.witness[name]) for name in ("x", "t"))
    assert residual_at(family.A + 1, family.B, x, t) != 0
