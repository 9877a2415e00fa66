"""The spectral engine of scenes on any lattice: against the one site by site, which shares no step.

Catches: data or mean strain of the wrong ring, values of the wrong cells, a seam that is felt, and
estimates that do not bound.
"""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from longwave.scenes import run as run_scene
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.support.checkpoint import Memory, checkpoints_in
from longwave.support.request_limits import request_limits
from searches.soak_scenes import soak_scene
from tests.scenes.engines.test_lattices_run import FPUT, PEREGRINE, TODA

DIMER = TODA | {"lattice": "mass_dimer", "constants": FPUT | {"m1": 1, "m2": 3, "K3": "1/4"}}


def shares(scene: Scene, exacter: float = 0.03) -> tuple[float, xr.Dataset]:
    """Largest difference of both engines, in units of both estimates, and the spectral run."""
    exact = run_scene(scene.changed(tolerance=exacter * scene.target.tolerance))
    run = run_scene(scene.changed(engine="spectral"))
    assert run.error_estimate <= scene.target.tolerance
    name = "strains" if "strains" in run else "strain"
    difference = float(np.max(np.abs((exact[name] - run[name]).values))) / scene.eps**run.power
    return difference / (exact.error_estimate + run.error_estimate), run


@pytest.mark.parametrize(
    "given",
    [TODA, PEREGRINE, DIMER],
    ids=["toda", "envelope", "dimer"],
)
def test_both_engines_agree_within_their_estimates(given: dict[str, Any]) -> None:
    share, run = shares(Scene.of(**given))
    assert share <= 1.0
    assert run.engine == "spectral"


def test_a_long_wave_takes_fewer_points_than_cells_and_long_steps() -> None:
    share, run = shares(load_scene("kawahara_soliton"))
    assert share <= 1.0
    assert run.attrs["sites"] < 6000
    assert run.steps < 100


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"disorder": {"of": "mass", "spread": 0.1, "seed": 1}}, "must be 'stencil' with disorder"),
        ({"scheme": "kahan_li_8"}, "scheme must not be given for engine 'spectral'"),
        ({"observables": ["state"]}, "engine must be 'stencil' for state"),
    ],
)
def test_what_it_does_not_take_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Scene.of(**TODA | {"engine": "spectral"} | changes)


class Stops:
    """Keeps the memory of a loop, and stops it when that has been offered so many times."""

    least, share = 0.0, 1e9
    restored_seconds = 0.0

    def __init__(self, stop: int) -> None:
        self.kept: dict[str, tuple[str, Memory]] = {}
        self.stop = stop
        self.resumed = 0

    def read(self, name: str, task: str) -> Memory | None:
        found = self.kept.get(name)
        self.resumed += found is not None
        return found[1] if found is not None and found[0] == task else None

    def write(self, name: str, task: str, memory: Memory) -> None:
        copied = {key: value for key, value in memory.items() if key != "ring"}
        rings = {**memory["ring"]}
        rings["integrator"] = {
            key: np.copy(value) if isinstance(value, np.ndarray) else value
            for key, value in memory["ring"]["integrator"].items()
        }
        self.kept[name] = task, {**copied, "rows": list(memory["rows"]), "ring": rings}
        self.stop -= 1
        if self.stop == 0:
            raise InterruptedError

    def add_restored(self, seconds: float) -> None:
        return


def test_a_run_that_was_broken_off_goes_on_bit_by_bit() -> None:
    scene = Scene.of(**PEREGRINE).changed(engine="spectral")
    keeper = Stops(5)
    with pytest.raises(InterruptedError), checkpoints_in(keeper):
        run_scene(scene)
    with checkpoints_in(keeper):
        found = run_scene(scene)
    assert keeper.resumed
    whole = run_scene(scene)
    assert np.array_equal(found["strain"], whole["strain"])
    assert found.error_estimate == whole.error_estimate


@pytest.mark.slow
@pytest.mark.parametrize("name", ["dimer_rogue", "square_lump", "granular_peregrine"])
def test_shipped_scenes_agree(name: str) -> None:
    assert shares(load_scene(name))[0] <= 1.0


@pytest.mark.slow
def test_random_scenes_agree() -> None:
    found = []
    for index in range(24):
        scene = soak_scene(5, index)
        if scene.is_growth or scene.disorder:
            continue
        try:
            with request_limits(seconds=5):
                found.append(shares(scene)[0])
        except ValueError:  # no such equation, or too much for the seconds
            continue
    assert len(found) > 4
    assert max(found) <= 1.0


def test_observables_are_those_of_the_run_site_by_site() -> None:
    observables = ("strain", "error_curve", "energy", "momentum", "crest_track", "spectrum")
    scene = Scene.of(**TODA).changed(observables=observables, curve_points=9, look_points=5)
    sites, ring = run_scene(scene), run_scene(scene.changed(engine="spectral"))
    assert {*sites.variables} == {*ring.variables}
    for name in ("error_curve", "energy", "crest_position", "spectrum"):
        np.testing.assert_allclose(ring[name], sites[name], rtol=1e-3, atol=1e-5, err_msg=name)
