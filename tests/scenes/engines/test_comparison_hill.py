"""Catches: growth rates that are not the equation's, or those of too few modes."""

import numpy as np
import pytest

from longwave import derive
from longwave.scenes.starts.background_growth import (
    LEAST_MODES,
    fastest_rate,
    mkdv_rate,
    resolving_modes,
)
from longwave.solutions import Wave, closed_form


def test_a_uniform_state_neither_grows_nor_decays() -> None:
    assert mkdv_rate(np.full(512, 0.7), 3.0, 0.0, 1, 0.4, modes=12) < 1e-9


def _cn(k: float) -> tuple[np.ndarray, float]:
    wave = Wave(closed_form("wave_cn"), derive.mkdv_normal_form(1, 1), k=k)
    assert wave.wavelength is not None
    samples = wave.wavelength * np.arange(1024) / 1024
    return wave(samples, 0.0).Y, wave.wavelength * float(wave.normal_form.a)


def test_a_nearly_linear_cn_wave_grows_like_the_square_of_its_amplitude() -> None:
    """As k -> 0 it is k cos(xi): the side bands of a Stokes wave grow like U^2."""
    rates = [fastest_rate(*_cn(k), 2 * k * k - 1, 1) for k in (0.05, 0.1)]
    assert rates[1] / rates[0] == pytest.approx(4.0, rel=0.02)


@pytest.mark.parametrize(
    "k", [0.5, *(pytest.param(k, marks=pytest.mark.slow) for k in (0.99, 0.9999)), 0.999999]
)
def test_the_modes_taken_resolve_the_wave(k: float) -> None:
    """A fixed number of 24 modes is 15 times off at k = 0.999999."""
    U, wavelength = _cn(k)
    modes, kappa = resolving_modes(U), 0.6 * np.pi / wavelength
    finer = mkdv_rate(U, wavelength, 2 * k * k - 1, 1, kappa, 2 * modes)
    assert mkdv_rate(U, wavelength, 2 * k * k - 1, 1, kappa, modes) == pytest.approx(
        finer, rel=0.01
    )


def test_few_modes_for_a_smooth_wave() -> None:
    assert resolving_modes(np.cos(2 * np.pi * np.arange(64) / 64)) == LEAST_MODES
