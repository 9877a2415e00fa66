"""Dispatch from the kind of a scene to its engine, whose modules are imported on first use."""

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
    """Functions for one kind of scene: run it, predict its cost, return the size of its wave.

    ``size`` takes the scene, a time and whether to use the far field instead of the background. It
    is None for scenes without a wave.
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
"""Function that imports and returns the `Method` for each value of `Scene.method`."""


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> RunRecord:
    """Run a scene and return its record; ``restart`` is a state of an earlier run to resume."""
    return METHODS[scene.method]().record(scene, progress, announce, restart)


def run_scene(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> xr.Dataset:
    """Run the scene and return its data set."""
    return record_scene(scene, progress, announce).dataset


def expected_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of a scene in a new process.

    Raises ValueError, as a run does, for a scene that is refused before it is run.
    """
    return METHODS[scene.method]().cost(scene)


def wave_size(scene: Scene, t: float, far_field: bool = False) -> float:
    """Return the wave's largest deviation from its background, or from its far field, at time t.

    The maximum is over the compared cells and quantities. NaN if the wave has no such far field.
    """
    scene.check_compared()
    size = METHODS[scene.method]().size
    assert size is not None
    return size(scene, t, far_field)
