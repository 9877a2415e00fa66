"""The spectral ring against the stencil, its interpolation, and the closing of rings."""

import numpy as np
import pytest

from verify.lattice.closing import close_circumference
from verify.lattice.constants import Constants
from verify.lattice.spectral import RingState, SpectralRing
from verify.lattice.schemes import BLANES_MOAN_6


def _bump(sites: int, t: float = 0.0) -> RingState:
    n = np.arange(sites) - sites / 2.0
    y = 0.05 * (1.0 + 2.0 / np.cosh(0.2 * n))
    s = 2.0 * 0.05 * 2.0 * 0.2 * np.sinh(0.2 * n) / np.cosh(0.2 * n) ** 2
    return RingState(t, -sites / 2.0, float(sites), y, s)


@pytest.mark.parametrize(("K3", "K4"), [(0.0, 1.0), (0.2, -0.5), (0.1, 0.0)])
def test_engines_agree(K3: float, K4: float) -> None:
    constants = Constants(4.0, K3, K4)
    state = _bump(512)
    ring = SpectralRing(constants, state.resampled(1024), 0.25)
    ring.advance(50.0, 1e-9 * 0.05 / 50.0)
    y, s = state.y.copy(), state.s.copy()
    BLANES_MOAN_6.advance(y, s, 0.1, 500, constants)
    assert np.abs(ring.state().strain(state.points) - y).max() < 1e-8 * 0.05


def test_mean_drifts() -> None:
    y = np.full(64, 0.1)
    state = RingState(0.0, 0.0, 64.5, y, np.full(64, 1e-3))
    ring = SpectralRing(Constants(1.0, 0.0, 1.0), state, 1.0)
    ring.advance(10.0, 1e-9)
    np.testing.assert_allclose(ring.state().y, 0.11, atol=1e-12)
    np.testing.assert_allclose(ring.state().s, 1e-3, atol=1e-12)


def test_interpolation() -> None:
    x = -3.0 + 20.5 / 64 * np.arange(64)
    wave = np.cos(2 * np.pi * 3 * (x - 0.7) / 20.5) + 0.5
    state = RingState(0.0, -3.0, 20.5, wave, wave)
    at = np.array([-50.3, 0.0, 0.1, 1e4])
    np.testing.assert_allclose(
        state.strain(at), np.cos(2 * np.pi * 3 * (at - 0.7) / 20.5) + 0.5, atol=1e-10
    )


def test_closing_finds_the_phase_jump() -> None:
    jump = 0.3

    def profile(x: np.ndarray) -> np.ndarray:
        return np.cos(x - 0.5 * jump * np.tanh(x))

    length = close_circumference(profile, 2 * np.pi, 10)
    assert abs(length - (20 * np.pi + jump)) < 1e-9
