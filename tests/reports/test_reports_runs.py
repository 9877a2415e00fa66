"""Running scenes in processes: order kept, progress rises to 1, failures reach the caller."""

from dataclasses import replace

import pytest

from reports.runs import run_scenes
from verify.lattice import Scene, load_scene, run

SHORT = replace(
    load_scene("rational_2_eps_0.05"),
    snapshots=(-10000.0, -9999.0),
    observables=("strain",),
)


def test_runs_come_back_under_their_names_with_rising_progress() -> None:
    scenes = {"short": SHORT, "long": replace(SHORT, snapshots=(-10000.0, -9995.0))}
    shares: list[float] = []
    runs = run_scenes(scenes, 2, shares.append)
    assert list(runs) == ["short", "long"]
    assert [float(runs[name].time[-1]) for name in scenes] == [-9999.0, -9995.0]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    here = run(SHORT)
    assert (runs["short"]["strain"].values == here["strain"].values).all()


def test_a_failing_run_raises_here() -> None:
    wrong: Scene = replace(SHORT, wave="no_such_wave")
    with pytest.raises(ValueError, match="no_such_wave"):
        run_scenes({"wrong": wrong}, 1, lambda share: None)


def test_at_least_one_worker() -> None:
    with pytest.raises(ValueError, match="workers must be at least 1, got 0"):
        run_scenes({"short": SHORT}, 0, lambda share: None)
