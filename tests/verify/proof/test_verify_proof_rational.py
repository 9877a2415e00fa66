"""Rational solutions of every order: bilinear identities and the residual itself."""

from collections.abc import Callable

import pytest
from flint import fmpq_mpoly

from longwave.solutions.forms.rational import rational
from longwave.solutions.forms.tau_polynomials import RationalTau, rational_tau
from longwave.verify.proof import CertificateError, check_certificate, prove, prove_rational
from longwave.verify.proof.rational_proofs import (
    SPACE,
    TIME,
    bilinear_certificate,
    rational_verdict,
    residual_at,
)
from longwave.verify.verdict import Outcome


@pytest.mark.parametrize("order", range(1, 10))
def test_every_order_is_proved_directly_and_by_bilinear_identities(order: int) -> None:
    family = rational_tau(order)
    assert "A = " in check_certificate(bilinear_certificate("own", family.A, family.B))
    assert prove_rational(order).outcome is Outcome.PROVED


def test_there_are_more_points_than_the_degree_in_time() -> None:
    """The D of order 3 has degree 4 in t, so D**4 times the residual has at most degree 16."""
    assert prove_rational(3).detail.startswith("0 at 17 values of tau")


def test_free_shifts_stay_symbolic() -> None:
    family = rational_tau(4, (5, 7))
    assert "tau_7" in check_certificate(bilinear_certificate("free", family.A, family.B))
    form = rational(3, (5,))
    assert prove(form.equation, form.expression).outcome is Outcome.PROVED


def test_the_residual_sees_a_changed_coefficient() -> None:
    family = rational_tau(3)
    assert any(residual_at(family.A + 1, family.B, 1, t) for t in range(-3, 4))
    assert not any(residual_at(family.A, family.B, x, t) for x in (0, 1, 5) for t in (-2, 0, 3))


def _backwards(family: RationalTau) -> list[fmpq_mpoly]:
    """Return A -> -A, t -> -t, which keeps the first bilinear equation and breaks the second."""
    terms = ({e: c * (-1) ** int(e[1]) for e, c in p.terms()} for p in (family.A, family.B))
    return [family.A.context().from_dict(changed) for changed in terms]


def _with_time(family: RationalTau) -> list[fmpq_mpoly]:
    """Return A + 3 t and B: a shift of the third kind that depends on time."""
    return [family.A + 3 * family.A.context().gens()[1], family.B]


@pytest.mark.parametrize(
    ("order", "changed", "broken"),
    [
        (3, lambda family: [family.A + 1, family.B], [SPACE, TIME]),
        (3, lambda family: [family.A, family.B + 1], [SPACE, TIME]),
        (2, _backwards, [TIME]),
        (2, _with_time, [TIME]),
    ],
)
def test_bilinear_identities_that_fail_are_rejected(
    order: int, changed: Callable[[RationalTau], list[fmpq_mpoly]], broken: list[str]
) -> None:
    certificate = bilinear_certificate("changed", *changed(rational_tau(order)))
    found = []
    for equation in certificate["statement"]["equations"]:
        one = certificate["statement"] | {"equations": [equation]}
        try:
            check_certificate(certificate.changed(statement=one))
        except CertificateError:
            found.append(equation)
    assert found == broken


def test_a_wrong_formula_is_refuted_at_a_point() -> None:
    family = rational_tau(3)
    verdict = rational_verdict(3, family.A + 1, family.B)
    assert verdict.outcome is Outcome.REFUTED
    assert verdict.witness is not None
    x, t = (int(verdict.witness[name]) for name in ("x", "t"))
    assert residual_at(family.A + 1, family.B, x, t) != 0
