"""Benjamin-Feir growth on lattices against theory."""

from typing import Any

import numpy as np
import pytest
from sympy import Rational, pi

from derive import LATTICES, envelope
from verify.lattices.sideband_growth import sideband_growth

CUBIC = {"K2": 1, "K3": Rational(1, 4), "K4": 1}


@pytest.mark.parametrize(
    ("name", "k", "amplitude"),
    [
        ("fput", pi / 2, 0.3),
        pytest.param("fput_strain", pi / 2, 0.4, marks=pytest.mark.slow),
        pytest.param("fput_strain", pi, 0.4, marks=pytest.mark.slow),
    ],
)
def test_plane_waves_grow_as_the_envelope_says(name: str, k: Any, amplitude: float) -> None:
    """Differences fall as eps^2; without the mean in q the rate would be 40 % off."""
    found = envelope(LATTICES[name], k=k)
    rates = [sideband_growth(found, CUBIC, k, amplitude, eps) for eps in (0.1, 0.05, 0.025)]
    differences = np.abs([rate.difference for rate in rates])
    assert differences[-1] < 4e-4
    assert all(rate.discretisation < 1e-3 * rate.difference**2 + 1e-7 for rate in rates)
    slope = np.polyfit(np.log([0.1, 0.05, 0.025]), np.log(differences), 1)[0]
    assert 1.6 < slope < 2.3


@pytest.mark.slow
def test_a_tied_chain_grows_as_its_envelope_says() -> None:
    given = {"K2": 1, "g1": 2, "g2": 1, "g3": 1}
    k = 2 * pi / 3
    found = envelope(LATTICES["klein_gordon"], k=k)
    rates = [sideband_growth(found, given, k, 0.5, eps) for eps in (0.1, 0.05, 0.025)]
    differences = np.abs([rate.difference for rate in rates])
    assert differences[-1] < 3e-3
    slope = np.polyfit(np.log([0.1, 0.05, 0.025]), np.log(differences), 1)[0]
    assert 1.6 < slope < 2.3


def test_stable_plane_waves_are_refused() -> None:
    given = {"K2": 1, "K3": Rational(3, 2), "K4": 1}
    with pytest.raises(ValueError, match="k must be that of an unstable wave"):
        sideband_growth(envelope(LATTICES["fput"], k=pi / 2), given, pi / 2, 0.3, 0.1)
