"""Catches: a travelling wave that is none, growth rates that depend on the truncation."""

import numpy as np
import pytest

from longwave.derive import mkdv_normal_form
from longwave.lattice.schemes import KAHAN_LI_8
from longwave.lattice.stepper import advance
from longwave.reports.studies import travelling_waves
from longwave.reports.studies.travelling_waves import fastest_mode, lattice_mode, travelling_wave
from longwave.scenes.starts.background_growth import mkdv_rate
from longwave.solutions import Wave, closed_form
from tests.families import family


@pytest.mark.parametrize(
    ("form", "k", "period", "K4"),
    [("wave_cn", 0.8, 20, 1), ("wave_sn", 0.7, 27, -1), ("wave_dn", 0.7, 27, 1)],
)
def test_the_wave_travels_unchanged(form: str, k: float, period: int, K4: int) -> None:
    """Run for 500 time units with a small step, it is still where its speed says."""
    wave = travelling_wave(form, k, period, 1, K4)
    n = np.arange(float(4 * period))
    y, s = wave.strain(n), wave.velocity(n)
    advance(KAHAN_LI_8, y[None], s[None], 0.125, 4000, wave.constants.lattice)
    assert np.max(np.abs(y - wave.strain(n - 500.0 * wave.speed))) < 1e-10 * wave.eps
    assert abs(wave.speed - 1.0) < wave.eps**2


def test_the_travelling_wave_tends_to_the_reduced_equations_wave() -> None:
    """The distance to the cn wave falls like eps^2: by 4 from 20 to 40 sites."""
    misses = []
    for period in (20, 40):
        lattice = travelling_wave("wave_cn", 0.8, period, 1, 1)
        wave = Wave(closed_form("wave_cn"), mkdv_normal_form(1, 1), k=0.8)
        x = np.linspace(0.0, period, 100)
        miss = lattice.strain(x) / lattice.eps - wave.at(x, 0.0, lattice.eps).Y
        misses.append(float(np.max(np.abs(miss))))
    assert misses[0] / misses[1] == pytest.approx(4.0, rel=0.1)


def test_a_profile_too_sharp_for_its_modes_is_refused() -> None:
    with pytest.raises(ValueError, match=r"period must give a smooth profile, got 100 with resid"):
        travelling_wave("wave_cn", 1.0 - 1e-7, 100, 1, 1)


def test_the_mode_obeys_the_linearised_lattice() -> None:
    """A small multiple of the mode, run on the lattice, is the mode times e^{lambda t}."""
    wave = travelling_wave("wave_cn", 0.8, 20, 1, 1)
    mode = fastest_mode(wave, 4)
    n = np.arange(float(4 * wave.period))
    runs = []
    for sign in (1.0, -1.0):
        y, s = (1e-6 * sign * part for part in mode.at(n))
        y, s = wave.strain(n) + y, wave.velocity(n) + s
        advance(KAHAN_LI_8, y[None], s[None], 0.25, 1600, wave.constants.lattice)
        runs.append(y)
    x = n - 400.0 * wave.speed
    waves = np.exp(1j * np.multiply.outer(n, mode.q)) @ mode.strain
    scale = complex(waves[np.argmax(np.abs(waves))])
    moved = np.exp(1j * np.multiply.outer(x, mode.q)) @ mode.strain / scale
    expected = 1e-6 * (moved * np.exp(400.0 * mode.rate)).real
    np.testing.assert_allclose(0.5 * (runs[0] - runs[1]), expected, atol=1e-11)


def test_the_rate_does_not_depend_on_the_truncation(monkeypatch: pytest.MonkeyPatch) -> None:
    wave = travelling_wave("wave_cn", 0.8, 20, 1, 1)
    kappa = 2.0 * np.pi * 6 / (16 * 20)
    rate = lattice_mode(wave, kappa).rate.real
    monkeypatch.setattr(travelling_waves, "MODES", 18)
    assert wave.modes.size == 25
    assert lattice_mode(wave, kappa).rate.real == pytest.approx(rate, rel=1e-6)


def test_the_reduced_equations_rate_is_the_lattices_up_to_eps_squared() -> None:
    form = mkdv_normal_form(1, 1)
    bare = Wave(closed_form("wave_cn"), form, k=0.8)
    assert bare.wavelength is not None
    U = bare(bare.wavelength * np.arange(256) / 256, 0.0).Y
    a, b = float(form.a), float(form.b)
    misses = []
    for period in (20, 40):
        wave = travelling_wave("wave_cn", 0.8, period, 1, 1)
        kappa = 2.0 * np.pi * 6 / (16 * period)
        reduced_kappa = kappa / (a * wave.eps)
        reduced = mkdv_rate(U, a * bare.wavelength, 2 * 0.8**2 - 1, 1, reduced_kappa, modes=24)
        rate = lattice_mode(wave, kappa).rate.real / (b * wave.eps**3)
        misses.append(abs(rate / reduced - 1.0))
    assert misses[0] < 0.03
    assert misses[0] / misses[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize(
    ("form", "K4"), family([("wave_sn", -1), ("wave_dn", 1)], slow=("wave_dn",))
)
def test_sn_and_dn_waves_are_stable(form: str, K4: int) -> None:
    assert fastest_mode(travelling_wave(form, 0.7, 27, 1, K4), 8).rate.real < 1e-6
