"""The fields of a carrier with numbers, against closed forms."""

from math import cos, sin

import pytest
from sympy import Rational, pi

from longwave.derive import LATTICES, EnvelopeError, envelope
from longwave.derive.carrier_numbers import CarrierTerms, carrier_fields

K2, K3, K4 = 2.25, 0.4, 1.1
GIVEN = {"K2": Rational(9, 4), "K3": Rational(2, 5), "K4": Rational(11, 10)}
S, C = sin(0.5), cos(0.5)
A, B, A_X, B_X = (0, 0), (0, 1), (1, 0), (1, 1)


def value(terms: CarrierTerms, power: int, *jets: tuple[int, int]) -> complex:
    found = [t.value for t in terms if (t.power, t.jets) == (power, tuple(sorted(jets)))]
    assert len(found) == 1
    return found[0]


def test_the_strain_chain_has_its_known_second_harmonic_and_mean() -> None:
    """F_{2,3} = -(K3/K2)(C/s^3) A A_1 and
    F_{0,3} = (K3/K2)(C/s^3)(A_1 conj A + c.c.), with A_1 = -i A_X."""
    found = carrier_fields(envelope(LATTICES["fput_strain"]), 1, **GIVEN)
    field = found.parts[0]
    assert value(field, 2, A, A) == pytest.approx(K3 / K2 * (C / S) ** 2)
    assert value(field, 3, A, A_X) == pytest.approx(1j * K3 / K2 * C / S**3)
    assert value(found.mean, 2, A, B) == pytest.approx(-2 * K3 / (K2 * S**2))
    assert value(found.mean, 3, B, A_X) == pytest.approx(-1j * K3 / K2 * C / S**3)
    assert value(found.mean, 3, A, B_X) == pytest.approx(1j * K3 / K2 * C / S**3)
    assert found.shares == (1.0,)
    assert {term.power for term in field} == {1, 2, 3}
    assert all(term.harmonic >= 0 for term in field)


def test_the_mean_of_displacements_is_an_integral_that_flows() -> None:
    """d_T int b0 |A|^2 = i p b0 (A_X conj A - c.c.)."""
    found = envelope(LATTICES["fput"], **GIVEN)
    numbers, fields = found.coefficients(1, **GIVEN), carrier_fields(found, 1, **GIVEN)
    assert fields.is_displacement
    flow = 1j * numbers.p * numbers.mean
    assert value(fields.mean_flow, 2, B, A_X) == pytest.approx(flow)
    assert value(fields.mean_flow, 2, A, B_X) == pytest.approx(-flow)
    assert value(fields.mean_slope, 2, B, A_X) == pytest.approx(numbers.mean)


def test_a_tied_lattice_has_its_mean_among_the_fields() -> None:
    given = {"K2": 1, "g1": 2, "g2": 1, "g3": 1}
    fields = carrier_fields(envelope(LATTICES["klein_gordon"], **given), 1, **given)
    assert fields.mean == () == fields.mean_flow
    assert value(fields.parts[0], 2, A, B) == pytest.approx(-1.0)


def test_jets_reach_as_far_as_rates_need() -> None:
    fields = carrier_fields(envelope(LATTICES["fput_strain"], k=pi), **GIVEN)
    assert len(fields.flow) - 1 > max(m for t in fields.parts[0] for m, _ in t.jets)
    assert value(fields.flow[0], 0, (2, 0)) == pytest.approx(-1j * 1.5 / 4)


def test_a_resonance_is_refused() -> None:
    given = {"K2": 1, "K3": 1, "K4": 0, "L2": -Rational(1, 4), "L3": 0, "L4": 0}
    with pytest.raises(EnvelopeError, match="k must not be a resonance"):
        carrier_fields(envelope(LATTICES["next_nearest"], **given), pi / 2, **given)


@pytest.mark.slow
def test_a_group_velocity_that_vanishes_is_0_and_no_complex_rounding() -> None:
    """Catches: 1e-81 + 1e-82 i as the speed of a frame, which an opponent's scene stumbled on."""
    constants = {"K2": 4, "K3": 2, "K4": Rational(1, 2), "L2": 2, "L3": 2, "L4": 0}
    found = carrier_fields(envelope(LATTICES["next_nearest"], 2 * pi / 3), **constants)
    assert isinstance(found.v, float)
    assert found.v == 0.0
