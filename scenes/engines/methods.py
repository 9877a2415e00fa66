"""Table of how scenes of each kind are run; a kind's modules are imported when it is run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.state import State
    from longwave.lattice.trial import Progress
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.engines.run_record import RunRecord
    from longwave.support.request_limits import ExpectedCost

    Record: TypeAlias = Callable[[Scene, Progress | None, Announce | None, State | None], RunRecord]


class Method(NamedTuple):
    """What runs a scene, what a run is expected to cost, and the size of the wave compared.

    ``size`` takes the scene, a time, and whether the far field is meant; None without a wave.
    """

    record: Record
    cost: Callable[[Scene], ExpectedCost]
    size: Callable[[Scene, float, bool], float] | None = None


def _bench() -> Method:
    from longwave.scenes.engines import bench_run

    return Method(bench_run.record_scene, bench_run.scene_cost)


def _ring() -> Method:
    from longwave.scenes.engines import lattice_run

    return Method(lattice_run.record_scene, lattice_run.scene_cost, lattice_run.wave_size)


def _sidebands() -> Method:
    from longwave.scenes.engines import sideband_growth

    return Method(sideband_growth.record_scene, sideband_growth.scene_cost)


METHODS: Mapping[str, Callable[[], Method]] = {
    "bench": _bench,
    "moving_wave": _ring,
    "ring": _ring,
    "sidebands": _sidebands,
}
"""By `Scene.method`."""


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> RunRecord:
    """Run the scene, or go on from the state ``restart`` of a run of the same scene."""
    return METHODS[scene.method]().record(scene, progress, announce, restart)


def run_scene(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> xr.Dataset:
    """Run the scene and return its data set."""
    return record_scene(scene, progress, announce).dataset


def expected_cost(scene: Scene) -> ExpectedCost:
    """Return what a run is expected to cost, in a process that has just begun.

    Raises ValueError as a run does for what is wrong before anything is run.
    """
    return METHODS[scene.method]().cost(scene)


def wave_size(scene: Scene, t: float, far_field: bool = False) -> float:
    """Return the wave's largest deviation from its background, or its far field, at a time.

    Over the compared cells and all that is compared; NaN where there is no such field.
    """
    scene.check_compared()
    size = METHODS[scene.method]().size
    assert size is not None
    return size(scene, t, far_field)
