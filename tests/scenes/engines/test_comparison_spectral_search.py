"""Runs to a tolerance by the spectral engine: the true error, measured by the stencil."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from longwave import derive
from longwave.lattice.model import Model
from longwave.lattice.refine import StoppedSearch
from longwave.lattice.schemes import scheme_named
from longwave.lattice.spectral.evolution import SpectralRing
from longwave.lattice.stepper import advance
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.engines import spectral_run
from longwave.scenes.engines.spectral_data import spectral_start
from longwave.scenes.engines.spectral_search import solve_on_rings
from longwave.scenes.starts.moving_wave import MovingWave
from longwave.solutions import Wave, closed_form

SCENES = {
    "rogue_cn": (0.05, 1.0, {"k": 0.4}),
    "soliton_dn": (0.05, 1.0, {"k": 0.6}),
    "breather_sn": (0.05, 1.0, {"k": 0.65, "alpha": 0.8, "X_0": 0.3}),
    "wave_cn": (0.08, 2.0, {"k": 0.8}),
    "rational_2": (0.07, 4.0, {}),
    "soliton_sech": (0.1, 1.0, {"A": 1}),
}
"""eps, K2 and parameters: none of them is a shipped scene."""


def _moving(name: str, end: float = 80.0) -> MovingWave:
    eps, K2, parameters = SCENES[name]
    form = closed_form(name)
    K4 = float(form.equation.s)
    wave = Wave(form, derive.mkdv_normal_form(K2, K4), **parameters)
    constants = Model(K2, 0.0, K4)
    return MovingWave(wave, constants, eps, (-60.0, -10.0, end), 120)


@cache
def _stencil(name: str, index: int, end: float = 80.0) -> np.ndarray:
    """y/eps on the compared sites, on a ring whose seam is out of reach."""
    moving = _moving(name, end)
    t = moving.times[1 + index]
    duration = t - moving.t0
    c = moving.speed
    reach = 120 + int(3.2 * c * duration) + 100
    sites = round(c * moving.t0) + np.arange(-reach, reach + int(c * duration))
    y, s = np.concatenate(moving.state(sites, moving.t0))
    steps = round(20 * duration)
    advance(
        scheme_named("kahan_li_8"),
        y[None],
        s[None],
        duration / steps,
        steps,
        moving.constants.lattice,
    )
    return np.asarray(y[moving.compared_sites(t) - sites[0]] / moving.eps)


def _check(name: str, tolerance: float, end: float = 80.0) -> None:
    moving = _moving(name, end)
    found = solve_on_rings(moving, tolerance)
    values = found.trial.values
    assert values is not None
    error = max(float(np.abs(values[i] - _stencil(name, i, end)).max()) for i in (0, 1))
    assert error <= tolerance
    assert error <= found.error <= tolerance


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [("wave_cn", 1e-2), *((name, 1e-4) for name in SCENES)],
)
def test_tolerance_is_met(name: str, tolerance: float) -> None:
    _check(name, tolerance)


@pytest.mark.parametrize("name", ["rogue_cn", pytest.param("wave_cn", marks=pytest.mark.slow)])
def test_engines_agree_to_1e_8(name: str) -> None:
    _check(name, 1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [3e-4, 1e-5])
@pytest.mark.parametrize(
    ("name", "eps", "parameters"), [("soliton_dn", 0.07, {"k": 0.6}), ("soliton_sech", 0.17, {})]
)
def test_what_all_long_steps_do_alike_is_told(
    name: str,
    eps: float,
    parameters: dict[str, float],
    tolerance: float,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The first one's error was 5.2e-6 for steps from 0.9 to 2.1 alike, 15 times the estimate."""
    monkeypatch.setitem(SCENES, name, (eps, 1.0, parameters or {"A": 1.4}))
    _stencil.cache_clear()
    _check(name, tolerance, 700.0)
    _stencil.cache_clear()


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
@pytest.mark.parametrize("name", SCENES)
def test_tolerance_is_met_on_longer_runs(name: str, tolerance: float) -> None:
    _check(name, tolerance, 700.0)


def test_cost_does_not_depend_on_eps() -> None:
    """Y2 over the same slow time, to the same tolerance; a window would cost 64 times as much."""
    wave = Wave(closed_form("rational_2"), derive.mkdv_normal_form(4, 1))
    work = []
    for eps in (0.08, 0.02):
        times = (-0.3 / eps**3, 0.0)
        times = (times[0], *times)
        moving = MovingWave(wave, Model(4.0, 0.0, 1.0), eps, times, round(10 / eps))
        cost = solve_on_rings(moving, 1e-3).trial.payload
        work.append(cost.evaluations * cost.points)
    assert work[1] < 2.5 * work[0]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "k"), [("rogue_cn", 0.5), ("soliton_dn", 0.7)])
def test_long_runs_on_periodic_backgrounds(name: str, k: float) -> None:
    wave = Wave(closed_form(name), derive.mkdv_normal_form(1, 1), k=k)
    times = tuple(np.linspace(-1e4, 1e4, 11))
    moving = MovingWave(wave, Model(1.0, 0.0, 1.0), 0.05, (-1e4, *times), 400)
    found = solve_on_rings(moving, 1e-4)
    assert found.error <= 1e-4
    data, trial = spectral_start(moving, 1e-4), found.trial
    cost, values = trial.payload, trial.values
    assert values is not None
    points = 2 * round(cost.points * data.causal.circumference / cost.circumference / 2)
    ring = SpectralRing(moving.constants, data.state(data.causal, points), trial.choices.step)
    for t, row in zip(times, values, strict=True):
        exact = ring.at(t).at(moving.compared_sites(t))[0]
        assert np.abs(row * moving.eps - exact).max() <= 1e-4 * 0.05


def test_progress_ends_at_one() -> None:
    shares: list[float] = []
    solve_on_rings(_moving("wave_cn"), 1e-2, shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_bad_input() -> None:
    good = _moving("wave_cn")
    with pytest.raises(ValueError, match="times must increase"):
        replace(good, times=(-60.0, -90.0))
    with pytest.raises(ValueError, match="tolerance must satisfy"):
        solve_on_rings(good, 0.0)


def test_ctrl_c_before_any_ring_is_done_keeps_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def stopped(*_: object) -> None:
        raise StoppedSearch(None, None, 0.0)

    monkeypatch.setattr(spectral_run.spectral_search, "solve_on_rings", stopped)
    scene = load_scene("rogue_cn_k_0.5").with_tolerance(1e-3)
    with pytest.raises(KeyboardInterrupt, match="before anything was recorded"):
        spectral_run.run_spectral(scene, 1.0, lambda _: None, lambda _: None)
