"""The spectral ring against the stencil, its interpolation, and its check of the tail."""

import math
from dataclasses import replace

import numpy as np
import pytest

from longwave.lattice.model import Model
from longwave.lattice.schemes import scheme_named
from longwave.lattice.spectral.evolution import SamplingError, SpectralRing
from longwave.lattice.spectral.field_ring import FieldRing
from longwave.lattice.stepper import advance

CONSTANTS = Model(4.0, 0.0, 1.0)


def _bump(sites: int, width: float = 5.0) -> FieldRing:
    n = np.arange(sites) - sites / 2.0
    y = 0.05 * (1.0 + 2.0 / np.cosh(n / width))
    s = 2.0 * 0.05 * 2.0 / width * np.sinh(n / width) / np.cosh(n / width) ** 2
    return FieldRing(0.0, (-sites / 2.0,), (float(sites),), y[None], s[None])


@pytest.mark.parametrize(("K3", "K4"), [(0.0, 1.0), (0.2, -0.5), (0.1, 0.0)])
def test_engines_agree(K3: float, K4: float) -> None:
    constants = Model(4.0, K3, K4)
    state = _bump(512)
    ring = SpectralRing(constants, state.sampled((1024,)), 0.03)
    y, s = state.f[0].copy(), state.v[0].copy()
    advance(scheme_named("blanes_moan_6"), y[None], s[None], 0.1, 500, constants.lattice)
    reached = ring.at(50.0)
    assert np.abs(reached.at(state.points()) - y).max() < 1e-8 * 0.05
    assert np.abs(reached.velocities_at(state.points()) - s).max() < 1e-7 * 0.05


def test_one_point_per_site_aliases_short_waves() -> None:
    """The run above needs two points per site because products alias onto the lattice's waves."""
    state = _bump(512, width=2.0)
    y, s = state.f[0].copy(), state.v[0].copy()
    advance(scheme_named("blanes_moan_6"), y[None], s[None], 0.1, 200, CONSTANTS.lattice)
    errors = [
        np.abs(SpectralRing(CONSTANTS, ring, 0.02).at(20.0).at(state.points()) - y).max()
        for ring in (state, state.sampled((1024,)))
    ]
    assert errors[0] > 1e-7
    assert errors[1] < 2e-8


def test_mean_drifts() -> None:
    state = FieldRing(0.0, (0.0,), (64.5,), np.full((1, 64), 0.1), np.full((1, 64), 1e-3))
    reached = SpectralRing(Model(1.0, 0.0, 1.0), state, 1.0).at(10.0)
    np.testing.assert_allclose(reached.f, 0.11, atol=1e-12)
    np.testing.assert_allclose(reached.v, 1e-3, atol=1e-12)


def test_observing_changes_nothing() -> None:
    seen, unseen = (SpectralRing(CONSTANTS, _bump(128), 0.5) for _ in range(2))
    for t in (0.3, 1.7, 2.0):
        seen.at(t)
    np.testing.assert_array_equal(seen.at(6.1).f, unseen.at(6.1).f)


def test_tail_is_checked() -> None:
    """Narrow data split into waves that the sampling does not resolve; more points do."""
    state = _bump(128, width=3.0)
    bound = 10.0 * state.tail()
    with pytest.raises(SamplingError, match="tail"):
        SpectralRing(CONSTANTS, state, 0.5, tail=0.1 * state.tail())
    SpectralRing(CONSTANTS, state, 0.5, tail=bound).at(20.0)
    steep = replace(state, f=10.0 * state.f, v=10.0 * state.v)
    with pytest.raises(SamplingError, match="tail"):
        SpectralRing(CONSTANTS, steep, 0.05, tail=10.0 * bound).at(50.0)


def test_unstable_step_is_distinguished_from_coarse_sampling() -> None:
    with pytest.raises(FloatingPointError, match="grew without bound"):
        SpectralRing(CONSTANTS, _bump(512, width=2.0), 1000.0).at(1e6)


def test_waves_must_exist() -> None:
    state = _bump(64)
    large = replace(state, f=20.0 * state.f)
    with pytest.raises(FloatingPointError, match=r"waves grow at t = 0, site"):
        SpectralRing(Model(4.0, 0.0, -1.0), large, 1.0)


def test_interpolation() -> None:
    x = -3.0 + 20.5 / 64 * np.arange(64)
    wave = np.cos(2 * np.pi * 3 * (x - 0.7) / 20.5) + 0.5
    state = FieldRing(0.0, (-3.0,), (20.5,), wave[None], wave[None])
    at = np.array([-50.3, 0.0, 0.1, 1e4])
    exact = np.cos(2 * math.pi * 3 * (at - 0.7) / 20.5) + 0.5
    np.testing.assert_allclose(state.at(at)[0], exact, atol=1e-10)
    np.testing.assert_allclose(state.sampled((100,)).at(at)[0], exact, atol=1e-10)


def test_waves_of_wavenumber_2_pi_m_do_not_change() -> None:
    """On a circumference of whole sites the modes k = 2 pi m have no frequency, and no force."""
    length, count = 32.0, 256
    x = length / count * np.arange(count)
    y = 0.1 * np.cos(2 * np.pi * x / length) + 0.02 * np.cos(2 * np.pi * x)
    s = 0.001 * np.sin(4 * np.pi * x)
    ring = SpectralRing(
        Model(1.0, 0.0, 1e-12), FieldRing(0.0, (0.0,), (length,), y[None], s[None]), 0.5
    )
    for t in (0.0, 7.3, 20.0):
        state = ring.at(t)
        frequency = 2.0 * np.sin(np.pi / length)
        for offset in (0.0, 0.2):
            sites = offset + np.arange(32)
            long = 0.1 * np.cos(2 * np.pi * sites / length) * np.cos(frequency * t)
            still = 0.02 * np.cos(2 * np.pi * offset) + 0.001 * t * np.sin(4 * np.pi * offset)
            np.testing.assert_allclose(state.at(sites)[0], long + still, rtol=0, atol=1e-9)
