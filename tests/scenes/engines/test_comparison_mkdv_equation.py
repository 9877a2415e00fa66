"""The integrated mKdV equation against closed forms in time; bad input."""

import math

import numpy as np
import pytest

from longwave import derive
from longwave.solutions import Wave, closed_form
from tests.scenes.engines.mkdv_equation import PeriodicMkdv, evolve

TIMES = (0.3, 1.0)


def _form(name: str, s: int, xi: np.ndarray, tau: float, **parameters: float) -> np.ndarray:
    """U itself: the wave with X and T scaled back."""
    wave = Wave(closed_form(name), derive.mkdv_normal_form(1, s), **parameters)
    a, b = float(wave.normal_form.a), float(wave.normal_form.b)
    return np.asarray(wave(xi / a, np.full_like(xi, tau / b)).Y)


def _period(name: str, s: int, **parameters: float) -> float:
    wave = Wave(closed_form(name), derive.mkdv_normal_form(1, s), **parameters)
    assert wave.wavelength is not None
    return wave.wavelength * float(wave.normal_form.a)


@pytest.mark.parametrize(("name", "s"), [("wave_dn", 1), ("wave_cn", 1), ("wave_sn", -1)])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_periodic_waves_travel(name: str, s: int, tolerance: float) -> None:
    period = 2 * _period(name, s, k=0.7)
    xi = period / 96 * np.arange(96)
    rows = evolve(_form(name, s, xi, 0.0, k=0.7), period, s, TIMES, tolerance)
    for row, tau in zip(rows, TIMES, strict=True):
        assert np.abs(row - _form(name, s, xi, tau, k=0.7)).max() < tolerance


def test_sech_travels_on_a_long_period() -> None:
    """Its tail exp(-period/2) is all that the period costs."""
    period, count = 60.0, 768
    xi = period * (np.arange(count) / count - 0.5)
    rows = evolve(_form("soliton_sech", 1, xi, 0.0, A=1), period, 1, TIMES, 1e-8)
    for row, tau in zip(rows, TIMES, strict=True):
        assert np.abs(row - _form("soliton_sech", 1, xi, tau, A=1)).max() < 2e-8


def test_the_method_is_of_order_4() -> None:
    period = _period("wave_dn", 1, k=0.7)
    xi = period / 64 * np.arange(64)
    start = _form("wave_dn", 1, xi, 0.0, k=0.7)
    exact = _form("wave_dn", 1, xi, 1.0, k=0.7)
    errors = [
        float(np.abs(PeriodicMkdv(start, period, 1, h).at(1.0) - exact).max())
        for h in (0.02, 0.01, 0.005)
    ]
    assert 3.7 < math.log2(errors[1] / errors[2]) < 4.3
    assert errors[0] > errors[1]


def test_invariants_of_arbitrary_data() -> None:
    xi = 2 * math.pi / 128 * np.arange(128)
    solution = PeriodicMkdv(0.5 * np.sin(xi) + 0.2 * np.cos(2 * xi), 2 * math.pi, -1, 1e-3)
    before = solution.invariants
    solution.at(1.0)
    np.testing.assert_allclose(solution.invariants, before, atol=1e-9)


def test_a_time_between_two_steps_is_reached_on_the_side() -> None:
    xi = 2 * math.pi / 64 * np.arange(64)
    interrupted, plain = (PeriodicMkdv(np.sin(xi), 2 * math.pi, 1, 2e-3) for _ in range(2))
    between = interrupted.at(0.1234)
    np.testing.assert_array_equal(interrupted.at(0.2), plain.at(0.2))
    reference = PeriodicMkdv(np.sin(xi), 2 * math.pi, 1, 0.1234 / 400).at(0.1234)
    np.testing.assert_allclose(between, reference, rtol=0, atol=1e-6)


def test_zero_stays_zero() -> None:
    assert np.all(evolve(np.zeros(16), 1.0, 1, (1.0,), 1e-6) == 0.0)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"s": 0}, "s must be 1 or -1"),
        ({"period": -1.0}, "period must"),
        ({"U": [np.nan]}, "U must"),
        ({"step": 0.0}, "h must"),
    ],
)
def test_bad_input(change: dict[str, object], message: str) -> None:
    good: dict[str, object] = {"U": np.ones(8), "period": 1.0, "s": 1, "step": 0.1}
    with pytest.raises(ValueError, match=message):
        PeriodicMkdv(**(good | change))  # type: ignore[arg-type]
