"""Envelopes solved by Fourier series, against closed forms and plane waves with the next order."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from sympy import Rational, pi

from longwave.derive import LATTICES, envelope
from longwave.derive.carrier_envelope import Envelope
from longwave.derive.carrier_numbers import CarrierFields, carrier_fields
from longwave.scenes.starts.envelope_flow import EnvelopeFlow
from tests.scenes.starts.envelope_waves import SymbolicWave

EPS = 0.1
GIVEN = {"K2": 1, "K3": Rational(1, 4), "K4": 1}
DEFOCUSING = {"K2": 1, "K3": Rational(3, 2), "K4": 1}


@cache
def derived() -> Envelope:
    return envelope(LATTICES["fput_strain"], k=pi / 2)


@cache
def fields(**given: int) -> CarrierFields:
    return carrier_fields(derived(), **given)


@pytest.mark.parametrize(
    ("name", "given", "turn"), [("bright", GIVEN, 0.0), ("dark", DEFOCUSING, np.pi)]
)
def test_without_the_next_order_it_is_the_closed_form(
    name: str, given: dict[str, int], turn: float
) -> None:
    wave = SymbolicWave(name, derived().normal_form(None, None, **given))
    form = fields(**given)
    leading = tuple(tuple(term for term in flow if term.power == 0) for flow in form.flow)
    flow = EnvelopeFlow(
        replace(form, flow=leading), EPS, lambda X: wave.jets(X, 0.0, 0)[0], first=-25.0,
        length=50.0, points=256, T0=0.0, turn=turn,
    )  # fmt: skip
    X = np.linspace(-10, 10, 41)
    for T in (0.7, 3.0, 2.0):
        assert np.max(np.abs(flow.jets(X, T, 2) - wave.jets(X, T, 2))) < 1e-7


def test_a_plane_wave_turns_as_the_next_order_says() -> None:
    """Return Omega = p x^2 - q a^2 + eps (a3 x^3 + (a1 + a2) a^2 x) at the wavenumber x."""
    found = derived().coefficients(**GIVEN)
    length, a = 3.0, 0.7
    x = (2 * np.pi + 0.4) / length
    flow = EnvelopeFlow(
        fields(**GIVEN), EPS, lambda X: a * np.exp(1j * x * X), first=-1.0, length=length,
        points=16, T0=0.5, turn=0.4,
    )  # fmt: skip
    shift = found.a3 * x**3 + (found.a1 + found.a2).real * a**2 * x
    turning = found.p * x**2 - found.q * a**2 + EPS * shift
    X = np.linspace(-1, 1, 7)
    expected = a * np.exp(1j * (x * X - turning * 1.5))
    found_jets = flow.jets(X, 2.0, 1)
    np.testing.assert_allclose(found_jets, [expected, 1j * x * expected], atol=1e-8)


def test_it_has_a_beginning() -> None:
    flow = EnvelopeFlow(
        fields(**GIVEN), EPS, np.ones_like, first=0.0, length=1.0, points=4, T0=1.0
    )  # fmt: skip
    with pytest.raises(ValueError, match=r"T must satisfy T >= 1, got 0\.9"):
        flow.jets(np.zeros(1), 0.9, 0)
