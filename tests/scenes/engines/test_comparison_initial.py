"""Catches: a missing chain-rule term or power of eps in s_n, data at the wrong sites or time."""

import pickle
from collections.abc import Callable

import numpy as np
import pytest

from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.window import FedWave
from longwave.scenes.starts.moving_wave import moving_wave


@pytest.mark.parametrize("kind", ["ring", "window"])
def test_the_initial_velocity_is_the_time_derivative_of_the_ansatz(
    ring_scene: Callable[..., Scene], window_scene: Callable[..., Scene], kind: str
) -> None:
    """eps^4 Y_T is 1e-4 of s here: dropping it must be seen, so the difference is 6th order."""
    scene = (ring_scene if kind == "ring" else window_scene)(eps=0.3, t0=-2.0, snapshots=(0.0,))
    wave = moving_wave(scene).wave
    sites = np.arange(-40, 41)
    [strain], [velocity] = moving_wave(scene).state(sites, scene.t0)
    h = 0.004
    weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
    difference = sum(
        weight
        * scene.eps
        * (wave.at(sites, -2.0 + i * h, scene.eps).Y - wave.at(sites, -2.0 - i * h, scene.eps).Y)
        for i, weight in weights.items()
    )
    np.testing.assert_allclose(velocity, difference / h, rtol=0, atol=2e-9)
    np.testing.assert_allclose(strain, scene.eps * wave.at(sites, -2.0, scene.eps).Y, atol=1e-15)


def test_rigid_data_start_as_the_initial_strain(
    window_scene: Callable[..., Scene], fed_wave: Callable[[Scene], FedWave]
) -> None:
    fed, moving = fed_wave(window_scene()), moving_wave(window_scene())
    sites = np.arange(-300, -100)
    strain, _ = fed.rigid_data(2.01, fed.rigid_offsets(2.01, sites, moving.t0))
    np.testing.assert_allclose(strain, moving.state(sites, moving.t0)[0], rtol=0, atol=1e-12)


def test_rigid_data_move_rigidly(
    window_scene: Callable[..., Scene], fed_wave: Callable[[Scene], FedWave]
) -> None:
    moving = fed_wave(window_scene())
    sites = np.arange(-300, -100)
    begun = moving.rigid_data(2.0, moving.rigid_offsets(2.0, sites, moving.t0))
    offsets = moving.rigid_offsets(2.0, sites + 50, moving.t0 + 25.0)
    later = moving.rigid_data(2.0, offsets)
    np.testing.assert_allclose(later[0], begun[0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(later[1], begun[1], rtol=0, atol=1e-12)
    slope = np.gradient(later[0][0], sites)[1:-1]
    assert np.corrcoef(slope, later[1][0][1:-1])[0, 1] == pytest.approx(-1.0, abs=1e-3)


def test_a_scene_that_has_been_looked_at_goes_to_another_process() -> None:
    scene = load_scene("rogue_cn_k_0.5")
    before = moving_wave(scene).wave.at(3.0, 0.0, 0.05)
    found = moving_wave(pickle.loads(pickle.dumps(scene))).wave
    assert found.at(3.0, 0.0, 0.05) == before
    assert repr(found) == repr(moving_wave(scene).wave)
