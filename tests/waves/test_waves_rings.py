"""Stability on rings: verdicts, counts of exponents, and certificates that must be refused."""

import copy
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from longwave.derive import LATTICES
from longwave.waves.exact_wave import ExactWave, exact_wave
from longwave.waves.kernel.check import check_certificate
from longwave.waves.kernel.limits import CertificateError
from longwave.waves.rings import RingStability, Stability


def wave_of_period(form: str, k: str, period: int) -> ExactWave:
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    return exact_wave(lattice, near=form, k=k, period=period)


@pytest.fixture(scope="module")
def wave() -> ExactWave:
    return wave_of_period("dn", "3/5", 10)


@pytest.fixture(scope="module")
def ring(wave: ExactWave) -> RingStability:
    return wave.ring(3)


def test_a_dn_wave_is_stable_on_a_ring(ring: RingStability) -> None:
    assert ring.verdict is Stability.STABLE
    assert [len(spectrum) for spectrum in ring.certificate["spectra"]] == [16, 20]
    assert "On a ring of 3 wavelengths it is spectrally STABLE" in ring.statement
    assert ring.to_json()["growth"] == {"lower": "0", "upper": "0"}


@pytest.mark.slow
def test_a_dn_wave_is_stable_on_a_ring_of_eight(wave: ExactWave) -> None:
    ring = wave.ring(8)
    assert ring.verdict is Stability.STABLE
    assert [len(spectrum) for spectrum in ring.certificate["spectra"]] == [16, 20, 20, 20, 20]


def test_a_cn_wave_is_unstable_at_its_known_rate() -> None:
    wave = wave_of_period("cn", "1/2", 20)
    growth = wave.exponent("1/4").growth
    assert abs(growth.value - 4.36472683431128779e-4) < 1e-15 > growth.error
    ring = wave.ring(4)
    assert ring.verdict is Stability.UNSTABLE
    assert ring.proved_growth is not None
    assert float(ring.proved_growth.lower) >= float(growth.lower)


def test_exponents_are_those_of_a_float_monodromy(wave: ExactWave, ring: RingStability) -> None:
    """Catches a count that is wrong: an integrated ring has these multipliers and no others."""
    cells, length, speed = 10, 30, wave.speed.value

    def rate(time: float, state: np.ndarray) -> np.ndarray:
        y = state.reshape(2, length, -1)
        stiffness = 1 + 3 * wave.at(np.arange(length) - speed * time) ** 2
        force = stiffness[:, None] * y[0]
        change = np.roll(force, -1, 0) - 2 * force + np.roll(force, 1, 0)
        return np.concatenate([y[1], change]).ravel()

    end = solve_ivp(
        rate, (0, 1 / speed), np.eye(2 * length).ravel(), method="DOP853", rtol=1e-12, atol=1e-13
    ).y[:, -1]
    shifted = np.roll(end.reshape(2, length, -1), -1, 1).reshape(2 * length, 2 * length)
    integrated = np.linalg.eigvals(shifted)
    proved = [1.0 + 0j] * 4
    for m, spectrum in enumerate(ring.certificate["spectra"]):
        turns = np.exp(1j * np.array([float(e["frequency"]) for e in spectrum]) / speed)
        proved += [*turns, *turns.conj()] if m else [*turns]
    assert len(proved) == 2 * length == 6 * cells
    for value in proved:
        assert np.abs(integrated - value).min() < 1e-4
    for value in integrated:
        assert np.abs(np.array(proved) - value).min() < 1e-4


def _with_spectrum(ring: RingStability, m: int, change: Any) -> dict[str, Any]:
    certificate = copy.deepcopy(dict(ring.certificate))
    certificate["spectra"][m] = change(certificate["spectra"][m])
    return certificate


CHANGES: list[tuple[int, Any]] = [
    (1, lambda s: s[:-1]),
    (1, lambda s: [*s, s[0]]),
    (1, lambda s: [*s[:-1], s[0]]),
    (0, lambda s: [*s[:-1], s[0]]),
    (1, lambda s: [{**s[0], "radius": "1e-3"}, *s[1:]]),
    (1, lambda s: [{**s[0], "radius": "0"}, *s[1:]]),
    (1, lambda s: [{**s[0], "frequency": "0.123"}, *s[1:]]),
    (1, lambda s: [{**s[0], "fixed": s[0]["fixed"] + 1}, *s[1:]]),
    (1, lambda s: [{**s[0], "growth": "0"}, *s[1:]]),
    (1, lambda s: s[0]),
]


@pytest.mark.parametrize("number", range(len(CHANGES)))
def test_a_changed_spectrum_is_refused(ring: RingStability, number: int) -> None:
    """Catches a missing, doubled or false enclosure."""
    with pytest.raises(CertificateError):
        check_certificate(_with_spectrum(ring, *CHANGES[number]))


def test_a_changed_statement_is_refused(ring: RingStability) -> None:
    certificate = dict(ring.certificate)
    near = {"form": "dn", "k": "3/5", "eps": "1/10"}
    other = {name: text for name, text in certificate["wave"].items() if name not in PINS}
    changes: list[dict[str, Any]] = [
        {"wavelengths": 5},
        {"wavelengths": 2},
        {"wavelengths": 0},
        {"wave": {**certificate["wave"], "period": "21/2"}},
        {"wave": {**other, "near": near}},
        {"claims": {"growth": ["-1", "-1/2"]}},
        {"claims": {"growths": ["0", "0"]}},
    ]
    for change in changes:
        with pytest.raises(CertificateError):
            check_certificate({**copy.deepcopy(certificate), **change})


PINS = ("period", "mean", "first_mode")


def test_an_equivalent_exponent_is_not_counted_twice(ring: RingStability) -> None:
    """Catches a comparison that is not modulo 2 pi i v: lambda + 2 pi i v is the same exponent."""

    def shifted(spectrum: list[dict[str, Any]]) -> list[dict[str, Any]]:
        first = copy.deepcopy(spectrum[0])
        return [*spectrum[:-1], {**first, "fixed": first["fixed"]}]

    with pytest.raises(CertificateError, match="too close"):
        check_certificate(_with_spectrum(ring, 1, shifted))


@pytest.mark.parametrize("wavelengths", [0, -1, 257])
def test_the_number_of_wavelengths_is_limited(wave: ExactWave, wavelengths: int) -> None:
    with pytest.raises(ValueError, match="wavelengths must be 1 to 256"):
        wave.ring(wavelengths)


def test_a_ring_needs_a_whole_period() -> None:
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    with pytest.raises(ValueError, match="integer number of cells"):
        exact_wave(lattice, near="dn", k="3/5", eps="1/10").ring(4)
    solitary = exact_wave(lattice, speed="11/10")
    with pytest.raises(ValueError, match="periodic wave that exists"):
        solitary.ring(4)


def test_eps_comes_from_the_period() -> None:
    lattice = LATTICES["fput_strain"].with_values({"K2": 1, "K3": 0, "K4": 1})
    with pytest.raises(ValueError, match="near and period"):
        exact_wave(lattice, near="dn", k="3/5", period=10, eps="1/10")
