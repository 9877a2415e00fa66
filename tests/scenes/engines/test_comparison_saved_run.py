"""Catches: a restart that differs in a bit, a file that loses some, a resume from nothing."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from longwave.runs import load_run, save_run
from longwave.scenes import resume, run
from longwave.scenes.description.named_scenes import scene_of
from longwave.scenes.description.scene import Scene

NAMES = ("strain", "state", "error_curve")


@pytest.fixture(params=["ring", "window"])
def scene(
    request: pytest.FixtureRequest,
    ring_scene: Callable[..., Scene],
    window_scene: Callable[..., Scene],
) -> Scene:
    """Snapshot times that no step hits by itself."""
    if request.param == "ring":
        return ring_scene(observables=NAMES, snapshots=(-20.0, -3.7, 11.3, 20.0))
    return window_scene(observables=NAMES, snapshots=(-150.0, -77.7, 0.0))


def test_a_resumed_run_has_the_same_bits(scene: Scene, tmp_path: Path) -> None:
    whole = run(scene)
    path = tmp_path / "run.nc"
    save_run(whole, path)
    loaded = load_run(path)
    assert scene_of(loaded) == scene
    at = scene.snapshots[-2]
    for source in (whole, loaded):
        resumed = resume(source, at=at)
        assert resumed.time.values.tolist() == [scene.snapshots[-1]]
        for name in ("state_y", "state_s", "state_left", "strain", "error"):
            assert np.array_equal(resumed[name][-1], whole[name][-1]), name
        later = whole.curve_time > at
        assert np.array_equal(resumed.error_curve, whole.error_curve[later])


def test_the_bits_depend_on_the_velocities_too(scene: Scene) -> None:
    whole = run(scene)
    whole["state_s"][-2] *= 1.0 + 2.0**-50
    resumed = resume(whole, at=scene.snapshots[-2])
    assert not np.array_equal(resumed.state_y[-1], whole.state_y[-1])


def test_a_run_goes_on_from_its_last_snapshot_to_later_times(
    ring_scene: Callable[..., Scene],
) -> None:
    scene = ring_scene(observables=("state", "strain"))
    further = replace(scene, snapshots=(*scene.snapshots, 30.0))
    resumed = resume(run(scene), snapshots=(30.0,))
    assert np.array_equal(resumed.strain[-1], run(further).strain[-1])


@pytest.mark.parametrize(
    ("observables", "options", "message"),
    [
        (("strain",), {}, "run must hold its states.*observable 'state'"),
        (
            ("state",),
            {"at": 1.0},
            r"at must be a snapshot of .*, got 1 \(it has -20, 0, 20\)",
        ),
        (("state",), {}, "snapshots must lie after t = 20, got none"),
        (("state",), {"snapshots": (5.0,)}, "snapshots must lie after t = 20, got none"),
    ],
)
def test_what_cannot_be_resumed_is_refused(
    ring_scene: Callable[..., Scene],
    observables: tuple[str, ...],
    options: dict[str, object],
    message: str,
) -> None:
    with pytest.raises(ValueError, match=message):
        resume(run(ring_scene(observables=observables)), **options)  # type: ignore[arg-type]
