"""Running a scene to a tolerance: by the engine it names, or by the cheaper one."""

import time
from collections.abc import Callable, Mapping

import xarray as xr

from solutions import Wave
from verify.lattice.engine import choose_engine
from verify.lattice.estimate import Estimate
from verify.lattice.initial import build_wave
from verify.lattice.recording import Progress
from verify.lattice.scene import Scene
from verify.lattice.spectral_scene import run_spectral
from verify.lattice.stencil_plan import plan_stencil
from verify.lattice.stencil_run import run_from

PLANNING_SHARE = 0.6
"""Share of the progress that a stencil's pilots are taken to be."""


def run_to_tolerance(scene: Scene, progress: Progress | None = None) -> xr.Dataset:
    """Run a scene that has a tolerance.

    The run carries, beside what any run does, ``tolerance``, ``error_estimate`` (sup error of y/eps
    over the compared sites, to be expected against the infinite lattice), its parts
    ``time_error_estimate`` and ``space_error_estimate``, ``next_decade`` (the factor by which ten
    times more accuracy costs more) and ``planning_seconds``. Raises ValueError as `run` does.
    """
    wave = build_wave(scene)
    engine = choose_engine(scene, wave)
    return RUNS[engine](scene, wave, progress or (lambda _: None))


def estimate_attributes(
    tolerance: float | None, estimate: Estimate, planning_seconds: float
) -> dict[str, object]:
    """The attributes that tell what was estimated."""
    return {
        "tolerance": tolerance,
        "error_estimate": estimate.total,
        "time_error_estimate": estimate.time,
        "space_error_estimate": estimate.space,
        "next_decade": estimate.next_decade,
        "planning_seconds": planning_seconds,
    }


def _run_stencil(scene: Scene, wave: Wave, progress: Progress) -> xr.Dataset:
    begun = time.perf_counter()
    plan = plan_stencil(scene, wave, lambda share: progress(PLANNING_SHARE * share))
    planned = time.perf_counter() - begun
    rest = 1.0 - PLANNING_SHARE
    run = run_from(plan.scene, None, lambda share: progress(PLANNING_SHARE + rest * share))
    return run.assign_attrs(estimate_attributes(scene.tolerance, plan.estimate, planned))


def _run_spectral(scene: Scene, wave: Wave, progress: Progress) -> xr.Dataset:
    run, estimate, planned = run_spectral(scene, wave, progress)
    return run.assign_attrs(estimate_attributes(scene.tolerance, estimate, planned))


RUNS: Mapping[str, Callable[[Scene, Wave, Progress], xr.Dataset]] = {
    "stencil": _run_stencil,
    "spectral": _run_spectral,
}
