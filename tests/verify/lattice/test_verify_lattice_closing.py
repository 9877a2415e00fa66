"""Closing a ring by its circumference, and what it does to the domain's error."""

import math

import numpy as np
import pytest

import derive
from solutions import Wave, closed_form
from verify.lattice.closing import blend_seam, close_circumference
from verify.lattice.constants import Constants
from verify.lattice.ring_state import RingState
from verify.lattice.spectral import SpectralRing
from verify.lattice.spectral_data import RingData


def _data(name: str, t0: float, **parameters: object) -> RingData:
    K4 = closed_form(name).equation.s
    wave = Wave(closed_form(name), derive.mkdv_normal_form(1, K4), **parameters)
    return RingData(Constants(1.0, 0.0, float(K4)), wave, 0.05, t0, 201)


def test_closing_finds_the_phase_jump() -> None:
    jump = 0.3
    length = close_circumference(lambda x: np.cos(x - 0.5 * jump * np.tanh(x)), 2 * math.pi, 10)
    assert abs(length - (20 * math.pi + jump)) < 1e-9


@pytest.mark.parametrize("alpha", [0.3, 0.7])
def test_dark_breather_closes_by_its_phase_jump(alpha: float) -> None:
    """The sn waves on the two sides are 4 alpha apart in xi, exactly."""
    data = _data("breather_sn", 0.0, k=0.5, alpha=alpha, X_0=0)
    a = float(data.wave.normal_form.a)
    jump = (data.circumference(40) - 40 * data.unit) * a * data.eps
    period = data.unit * a * data.eps
    apart = min(
        abs((jump - sign * 4 * alpha + period / 2) % period - period / 2) for sign in (1, -1)
    )
    assert apart < 1e-9


def test_blend_leaves_no_kink() -> None:
    length, count = 60.0, 1200
    x = length * (np.arange(count) / count - 0.5)
    y = blend_seam(lambda x: np.arctan(x / 5), length, 1.5, x)
    spectrum = np.abs(np.fft.rfft(y)) / count
    assert spectrum[-100:].max() < 1e-14
    assert np.abs(y - np.arctan(x / 5))[np.abs(x) < 20].max() == 0.0


def _domain_errors(
    data: RingData, closed: bool, rest: bool, counts: tuple[int, ...]
) -> list[float]:
    sites = np.arange(-100, 101) + round(-data.t0)

    def strain(count: int, closed: bool, rest: bool) -> np.ndarray:
        length = data.circumference(count) if closed else count * data.unit
        state = data.state(length, 48 * count)
        if not rest:
            state = data.moving_state(length, 48 * count)
        return SpectralRing(data.constants, state, 8.0).at(-data.t0).strain(sites)

    reference = strain(256, True, True)
    return [
        float(np.abs(strain(count, closed, rest) - reference).max()) / data.eps for count in counts
    ]


@pytest.mark.slow
def test_what_closing_is_worth() -> None:
    """dn soliton to |t| = 10^4: plain, closed, and closed without mean velocity."""
    data = _data("soliton_dn", -1e4, k=0.7)
    plain = _domain_errors(data, False, False, (16, 32, 64))
    moving = _domain_errors(data, True, False, (16, 32, 64))
    rest = _domain_errors(data, True, True, (16, 32, 64))
    assert math.log2(moving[1] / moving[2]) > 3.5
    assert plain[2] > 5 * moving[2] > 25 * rest[2]


def test_state_is_a_ring_state() -> None:
    state = _data("rogue_cn", -100.0, k=0.5).state(1000.0, 64)
    assert isinstance(state, RingState)
    assert abs(float(np.mean(state.s))) < 1e-18
