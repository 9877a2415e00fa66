"""Data of carrier waves: time derivatives, equations of motion, mean strain."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from sympy import Rational, pi

from longwave.derive import LATTICES, envelope
from longwave.derive.carrier_envelope import Envelope
from longwave.scenes.starts.envelope_data import EnvelopeData
from tests.families import family
from tests.scenes.starts.envelope_waves import SymbolicWave

CUBIC = {"K2": 1, "K3": Rational(1, 4), "K4": 1}
CASES: dict[str, tuple[str, Any, dict[str, Any], str, str | int]] = {
    "strain": ("fput_strain", pi / 2, CUBIC, "bright", 0),
    "displacement": ("fput", pi / 2, CUBIC, "bright", 0),
    "boundary": ("fput_strain", pi, CUBIC, "peregrine", 0),
    "dark": ("fput", pi / 2, {"K2": 1, "K3": Rational(3, 2), "K4": 1}, "dark", 0),
    "tied": ("klein_gordon", pi / 3, {"K2": 1, "g1": 2, "g2": 1, "g3": 1}, "dark", 0),
    "grains": ("granular", pi / 2, {"A": 1, "d": 1}, "dark", 0),
    "optical": ("mass_dimer", pi / 2, {"m1": 1, "m2": 3, **CUBIC}, "peregrine", "optical"),
}


@cache
def derived(case: str) -> Envelope:
    name, k, given, _, branch = CASES[case]
    inner = {key: v for key, v in given.items() if key in map(str, LATTICES[name].constants)}
    return envelope(LATTICES[name], k, branch, **inner)


def data(case: str, eps: float, order: str, **further: Any) -> EnvelopeData:
    _, _, given, wave, _ = CASES[case]
    form = derived(case).normal_form(None, None, **given)
    return EnvelopeData(derived(case), given, SymbolicWave(wave, form), eps, order, **further)


def around(wave: EnvelopeData, t: float) -> np.ndarray:
    half = int(1.5 / wave.eps)
    return np.arange(-half, half + 1.0) + round(wave.speed * t)


def without_drift(wave: EnvelopeData, f: np.ndarray) -> np.ndarray:
    return np.diff(f, axis=1) if wave.carrier.is_displacement else f


def rates(wave: EnvelopeData, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Return time derivatives of positions and velocities by differences, without common drift."""
    n, h = around(wave, t), 1e-3
    states = [[without_drift(wave, f) for f in wave.state(n, t + j * h)] for j in range(-2, 3)]
    first, second, _, third, fourth = (np.array(state) for state in states)
    found = (first - 8 * second + 8 * third - fourth) / (12 * h)
    return found[0], found[1]


@pytest.mark.parametrize("case", family(sorted(CASES), slow=("optical",)))
def test_velocities_are_time_derivatives(case: str) -> None:
    """Slaved data have every kind of term: harmonics, means and their integral."""
    t = 0.3 / 0.05**2
    wave = data(case, 0.05, "slaved")
    moving, _ = rates(wave, t)
    given = without_drift(wave, wave.state(around(wave, t), t)[1])
    assert np.max(np.abs(moving - given)) < 2e-9 < 1e-4 * np.max(np.abs(given))


def left(wave: EnvelopeData, t: float) -> float:
    """Return the residual of the equations of motion near the wave's middle."""
    f = wave.state(around(wave, t), t)[0]
    forced = without_drift(wave, wave.lattice.acceleration(f))
    return float(np.max(np.abs(rates(wave, t)[1] - forced)[:, 4:-4]))


PROMISED = {"leading": 2, "slaved": 3}


@pytest.mark.parametrize(
    ("case", "order"), [*((case, "slaved") for case in CASES), ("displacement", "leading")]
)
def test_what_data_leave_of_the_equations_of_motion_falls(case: str, order: str) -> None:
    rests = []
    for eps in (0.04, 0.02):
        wave = data(case, eps, order)
        rests.append(max(left(wave, 0.3 / eps**2 + 0.7 * j) for j in range(5)))
    assert np.log2(rests[0] / rests[1]) > PROMISED[order] - 0.4


@pytest.mark.parametrize("case", ["displacement", "dark", "grains"])
def test_a_ring_of_displacements_holds_the_mean_strain(case: str) -> None:
    wave = data(case, 0.05, "slaved")
    cells = np.arange(-402.0, 400.0)
    ring = wave.ring(cells, 0.0)
    inner = slice(2, -2)
    found = wave.quantity_values(ring.f, ring.mean_strain)[:, inner]
    np.testing.assert_allclose(found, wave.strain(cells, 0.0)[:, inner], atol=1e-13)
    strain = wave.eps**2 * derived(case).coefficients(**CASES[case][2]).mean
    values = np.abs(wave.wave.jets(wave.eps * cells, 0.0, 0)[0]) ** 2
    assert ring.mean_strain[0] == pytest.approx(strain * np.mean(values), rel=1e-3)
    assert np.max(np.abs(wave.quantity_values(ring.f, ring.mean_strain))) < 2 * np.max(
        np.abs(found)
    )


def test_leading_data_have_the_strain_of_their_background_alone() -> None:
    strain, displaced = (data(case, 0.1, "leading", mean_square=2.0) for case in ("strain", "dark"))
    far = np.array([-400.0, -399.0])
    mean = derived("strain").coefficients(**CASES["strain"][2]).mean
    np.testing.assert_allclose(strain.state(far, 0.0)[0], 0.01 * mean * 2.0, rtol=1e-12)
    mean = derived("dark").coefficients(**CASES["dark"][2]).mean
    assert displaced.mean_strain(far, 0.0) == (pytest.approx(0.01 * mean * 2.0),)
    assert data("dark", 0.1, "leading").mean_strain(far, 0.0) == (0.0,)


def test_corrected_data_begin_with_the_wave_and_leave_it() -> None:
    wave = data("strain", 0.1, "corrected")
    with pytest.raises(ValueError, match="start must be called"):
        wave.state(np.arange(4.0), 0.0)
    wave.start(50.0)
    X = np.linspace(-3, 3, 13)
    before, after = (wave.wave.jets(X, T, 2) - wave.amplitude.jets(X, T, 2) for T in (0.5, 1.5))
    assert np.max(np.abs(before)) < 1e-8
    assert 1e-3 < np.max(np.abs(after[0])) < 0.2


def test_support_is_where_the_wave_is() -> None:
    first, last = data("strain", 0.1, "slaved").support(100.0)
    assert (first + last) / 2 == pytest.approx(100 * np.sqrt(0.5))
    assert 400 < last - first < 450  # sech(X) < 1e-9 beyond 21.4
    assert data("dark", 0.1, "slaved").support(0.0) == (-np.inf, np.inf)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: data("dark", 0.1, "corrected").start(0.0), "interval must be given"),
        (
            lambda: data("displacement", 0.1, "slaved").state(np.array([0.0, 2.0]), 0.0),
            "cells must be consecutive",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(make: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message) as refused:
        make()
    assert "\n" not in str(refused.value)
