"""The lattices of one ring: the spread of their energies, against sums over sites."""

import numpy as np
import pytest

from longwave import derive
from longwave.lattice.model import Model
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.lattice.spectral.crest_energy import DENSITY, crest_energy_spread
from longwave.lattice.spectral.field_ring import FieldRing
from longwave.scenes.engines.spectral_data import spectral_start
from longwave.scenes.starts.moving_wave import MovingWave
from longwave.solutions import Wave, closed_form

LATTICES = 16


def _spread(steepness: float, points_per_site: float = DENSITY) -> tuple[float, float]:
    """Return the spread of a soliton's energies, and the same from sums over sites."""
    wave = Wave(closed_form("soliton_sech"), derive.mkdv_normal_form(1, 1), A=1)
    eps = steepness / float(wave.normal_form.a)
    data = spectral_start(MovingWave(wave, Model(1.0, 0.0, 1.0), eps, (0.0, 100.0), 60), 1e-4)
    ring = data.ring(data.smallest)
    state = data.state(ring, 2 * round(points_per_site * ring.circumference / 2))
    sites = round(ring.circumference / 2 - data.seam(ring.circumference))
    middle = state.left[0] + ring.circumference / 2
    energies = []
    for x in np.arange(LATTICES) / LATTICES:
        places = middle + x + np.arange(-sites, sites)
        y, s = state.at(places)[0], state.velocities_at(places)[0]
        velocity = np.cumsum(s) - s
        energies.append(np.sum(y**2 / 2 + y**4 / 4 + velocity**2 / 2))
    parted = 0.5 * (max(energies) - min(energies)) / np.mean(energies)
    chain = data.moving.constants.lattice
    return crest_energy_spread(chain, state, 0), float(parted)


@pytest.mark.parametrize("steepness", [0.4, 0.5, 0.6])
def test_the_spread_agrees_with_sums_over_sites(steepness: float) -> None:
    found, parted = _spread(steepness)
    assert 0.4 * parted < found < 2.5 * parted


def test_the_spread_does_not_depend_on_the_sampling() -> None:
    assert _spread(0.5, 9.0)[0] == pytest.approx(_spread(0.5)[0], rel=1e-3)


def test_long_waves_have_one_energy() -> None:
    assert _spread(0.2)[0] < 1e-12


def test_a_mean_strain_changes_the_springs() -> None:
    """Catches: energies of stretches without the mean strain."""
    x = 120.0 * (np.arange(600) / 600 - 0.5)
    u = np.exp(-((x / 2.0) ** 2))[None]
    ring = FieldRing(0.0, (-60.0,), (120.0,), u, 0.5 * x * u)
    fput, strain = derive.LATTICES["fput"], 0.5
    strained = numeric_lattice(fput, {"K2": 1, "K3": 1, "K4": 1}, (strain,))
    stiffer = {"K2": 1 + 2 * strain + 3 * strain**2, "K3": 1 + 3 * strain, "K4": 1}
    spread = crest_energy_spread(numeric_lattice(fput, stiffer), ring, 0)
    assert crest_energy_spread(strained, ring, 0) == pytest.approx(spread, rel=1e-6)
