"""Dispatch a scene to the module that runs it, which is imported on first use."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.state import State
    from longwave.lattice.trial import Progress
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.engines.run_record import RunRecord
    from longwave.support.request_limits import ExpectedCost


class Method(Protocol):
    """Interface of a module that runs scenes with one ``start.method`` and predicts their cost."""

    def record_scene(
        self,
        scene: Scene,
        /,
        progress: Progress | None,
        announce: Announce | None,
        restart: State | None,
    ) -> RunRecord:
        """Run a scene, or resume it from the state ``restart``, and return its record."""

    def scene_cost(self, scene: Scene, /) -> ExpectedCost:
        """Return the expected cost of a scene in a new process."""


def method_of(scene: Scene) -> Method:
    """Return the module that runs the scene, chosen by ``scene.start.method``."""
    if scene.start.method == "bench":
        from longwave.scenes.engines import bench_run

        return bench_run
    if scene.start.method == "sidebands":
        from longwave.scenes.engines import sideband_growth

        return sideband_growth
    from longwave.scenes.engines import lattice_run

    return lattice_run


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> RunRecord:
    """Run a scene and return its record; ``restart`` is a state of an earlier run to resume."""
    return method_of(scene).record_scene(scene, progress, announce, restart)


def run_scene(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> xr.Dataset:
    """Run the scene and return its data set."""
    return record_scene(scene, progress, announce).dataset


def expected_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of running a scene in a new process.

    Raises ValueError for scenes that are refused before any run.
    """
    return method_of(scene).scene_cost(scene)


def wave_size(scene: Scene, t: float, far_field: bool = False) -> float:
    """Return the wave's largest deviation from background, or if ``far_field`` from far field.

    The maximum is over the compared cells and quantities at time t. NaN if the far field is None.
    """
    from longwave.scenes.engines import lattice_run

    scene.check_compared()
    return lattice_run.wave_size(scene, t, far_field)
