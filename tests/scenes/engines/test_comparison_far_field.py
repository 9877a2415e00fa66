"""Catches: a feed interpolated where the wave is not smooth enough, or outside its stretch."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.window import INTERPOLATION_ERROR, FedWave, Tail, Window, window_moves

SCENE = replace(load_scene("rational_2_eps_0.05"), t0=-3000.0, snapshots=(40_000.0,))
WAVES: dict[str, dict[str, float]] = {
    "rational_1": {},
    "rational_3": {},
    "soliton_sech": {"A": 2.0},
    "soliton_background": {"U_0": 1.0, "kappa": 2.0},
    "two_soliton": {"A_1": 2.0, "A_2": 1.0},
    "breather": {"p": 1.0, "q": 1.0},
}


SCENES = {
    "drift": SCENE,
    "steep": SCENE.changed(eps=0.2, snapshots=(0.0,), compared=40, sites=832),
    "far away": replace(SCENE, t0=-1e6, snapshots=(-1e6 + 5000.0,)),
}


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_every_move_feeds_the_transported_wave(
    scene: Scene, fed_wave: Callable[[Scene], FedWave]
) -> None:
    window = Window(fed_wave(scene))
    state = window.start()
    for t in window_moves(window.wave):
        state.t = t
        window.follow(state)
        fed = state.sites[-192:]
        offsets = window.wave.rigid_offsets(window.background_speed, fed, t)
        y, s = window.wave.rigid_data(window.background_speed, offsets)
        f, v = state.at(fed)
        assert np.abs(f - y).max() <= 1e-14 * scene.eps
        assert np.abs(v - s).max() <= 1e-14 * scene.eps


@pytest.mark.parametrize("name", WAVES)
@pytest.mark.parametrize("eps", [0.01, 0.2])
@pytest.mark.parametrize(("low", "high"), [(900.0, 1200.0), (-150.0, 150.0), (40.0, 4000.0)])
def test_what_no_degree_resolves_is_not_interpolated(
    name: str, eps: float, low: float, high: float, fed_wave: Callable[[Scene], FedWave]
) -> None:
    """Far in front of the wave, across its crest, and from there to where nothing is left."""
    scene = replace(SCENE, wave=name, parameters=tuple(WAVES[name].items()), t0=0.0, eps=eps)
    fed = fed_wave(scene.changed(compared=40))
    one = Tail(fed, 2.0, low, high)
    sites = np.arange(int(low), int(high))
    found = np.concatenate(one.at(sites, 0.0))
    exact = np.concatenate(fed.rigid_data(2.0, sites.astype(float)))
    bound = 2.0 * INTERPOLATION_ERROR * max(eps, float(np.abs(exact).max()))
    assert np.abs(found - exact).max() <= bound


def test_a_far_field_is_evaluated_on_a_few_points(
    monkeypatch: pytest.MonkeyPatch, fed_wave: Callable[[Scene], FedWave]
) -> None:
    evaluated, exact = [], FedWave.rigid_data

    def counting(*arguments: object) -> tuple[np.ndarray, np.ndarray]:
        evaluated.append(np.size(arguments[-1]))
        return exact(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(FedWave, "rigid_data", counting)
    one = Tail(fed_wave(SCENE), 2.0, 1500.0, 1800.0)
    for t in SCENE.t0 + np.arange(0.0, 3200.0, 32.0):
        one.at(np.arange(1550, 1750) + round(2.0 * t), t)
    assert sum(evaluated) < 100
