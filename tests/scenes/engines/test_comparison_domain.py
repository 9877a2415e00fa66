"""Catches: a window that feeds the wrong values, drops the wrong cells or lets its seam in."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from longwave.lattice.state import State
from longwave.scenes import run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.domain_plan import FRONT_CELLS
from longwave.scenes.engines.lattice_run import domain_plan
from longwave.scenes.engines.window import INTERPOLATION_ERROR, LARGEST_MISFIT, FedWave, Window
from longwave.scenes.starts.lattice_wave import nearest_cell
from longwave.scenes.starts.moving_wave import moving_wave


def window_of(scene: Scene) -> Window:
    sites = scene.discretisation.sites
    return Window(FedWave(domain_plan(scene)[1], sites))


def strain(scene: Scene) -> np.ndarray:
    return np.asarray(run(replace(scene, observables=("strain",))).strain)


def test_window_equals_a_wide_ring(window_scene: Callable[..., Scene]) -> None:
    """The window moves by 400 sites here; the ring holds them all."""
    scene = window_scene()
    wide = scene.changed(domain="ring", sites=4096)
    assert np.max(np.abs(strain(scene) - strain(wide))) < 1e-6 * scene.eps


def test_the_windows_error_cancels_between_two_steps() -> None:
    """Catches: a window that moves at times which depend on the step."""
    scene = load_scene("rational_2_eps_0.05").changed(
        t0=-2000.0,
        snapshots=(0.0,),
        compared=200,
        scheme="blanes_moan_6",
    )
    small, wide = (
        [strain(scene.changed(sites=sites, step=step)) for step in (0.69, 0.25)]
        for sites in (960, 2304)
    )
    steps, window = wide[0] - wide[1], small[0] - wide[0]
    assert np.abs(window).max() > 5.0 * np.abs(steps).max()
    assert np.abs((small[0] - small[1]) - steps).max() < 1e-3 * np.abs(steps).max()


@pytest.mark.parametrize(("factor", "shift"), [(1.01, 0.0), (1.0, 1e-3), (-1.0, 0.0)])
def test_a_wrong_far_field_stops_the_run(
    window_scene: Callable[..., Scene],
    monkeypatch: pytest.MonkeyPatch,
    factor: float,
    shift: float,
) -> None:
    right = FedWave.rigid_data

    def wrong(*arguments: object) -> tuple[np.ndarray, np.ndarray]:
        y, s = right(*arguments)  # type: ignore[arg-type]
        return factor * y + 0.1 * shift, s

    monkeypatch.setattr(FedWave, "rigid_data", wrong)
    measured = run(window_scene())
    text = measured.attrs["blow_up"]
    assert "the window's feed differs from the lattice by" in text
    front = nearest_cell(moving_wave(window_scene()).speed, -200.0 + 32.0) + 512 - 192
    assert text.endswith(f"at t = -168, site {front - 8}")
    assert measured.attrs["feed_mismatch"] > 5e-4


@pytest.mark.parametrize("shipped", [False, True])
def test_a_sound_feed_is_far_below_the_limit(
    window_scene: Callable[..., Scene], shipped: bool
) -> None:
    scene = load_scene("rational_3_eps_0.075") if shipped else window_scene()
    measured = run(replace(scene, observables=()))
    assert measured.attrs["blow_up"] == ""
    assert 0.0 < measured.attrs["feed_mismatch"] < 0.01 * LARGEST_MISFIT


def test_a_moved_window_keeps_its_cells_and_feeds_the_front(
    window_scene: Callable[..., Scene],
) -> None:
    scene = window_scene()
    window = window_of(scene)
    state = window.start()
    [values_before], _ = state.at(state.sites)
    state.t += 10.0
    window.follow(state)
    middle = nearest_cell(moving_wave(scene).speed, state.t)
    assert state.left == middle - scene.discretisation.sites // 2
    fed = 2 * 20 + FRONT_CELLS
    np.testing.assert_array_equal(state.at(state.sites)[0][0, :-fed], values_before[20 : 20 - fed])
    speed = window.background_speed
    offsets = window.wave.rigid_offsets(speed, state.sites[-fed:], state.t)
    expected = window.wave.rigid_data(speed, offsets)
    bound = 1.1 * INTERPOLATION_ERROR * np.abs(expected[0]).max()
    for values, reference in zip(state.at(state.sites[-fed:]), expected, strict=True):
        np.testing.assert_allclose(values, reference, rtol=0, atol=bound)


def test_the_feed_moves_at_the_sound_speed_of_the_background(
    window_scene: Callable[..., Scene],
) -> None:
    scene = window_scene()
    window = window_of(scene)
    assert window.background_speed == pytest.approx(np.sqrt(4.0 + 3.0 * 0.1**2), abs=1e-14)


def test_the_middle_is_the_site_nearest_to_c_t(window_scene: Callable[..., Scene]) -> None:
    speed = moving_wave(window_scene()).speed
    assert [nearest_cell(speed, t) for t in (-0.3, -0.2, 0.0, 0.2, 0.3)] == [-1, 0, 0, 0, 1]
    assert nearest_cell(speed, 100.0) == 200


def test_storage_survives_negative_sites() -> None:
    state = State(0.0, np.zeros((1, 4)), np.zeros((1, 4)), left=-5)
    state.store(np.arange(-5, -1), np.arange(4.0), np.arange(4.0))
    assert state.at(np.array([-4, -2]))[0].tolist() == [[1.0, 3.0]]
    assert state.sites.tolist() == [-5, -4, -3, -2]
