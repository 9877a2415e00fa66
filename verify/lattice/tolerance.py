"""Running a scene to a tolerance: by the engine it names, or by the cheaper one.

What the spectral engine refuses, though it was not named, is run site by site.
"""

from collections.abc import Callable, Mapping

import xarray as xr

from solutions import Wave
from verify.lattice.engine import SECONDS, choose_engine
from verify.lattice.estimate import Estimate
from verify.lattice.initial import build_wave
from verify.lattice.recording import Progress
from verify.lattice.refine import Announce
from verify.lattice.scene import Scene
from verify.lattice.spectral_scene import run_spectral
from verify.lattice.stencil_scene import run_stencil
from verify.lattice.unfinished import Announcer, UnfinishedRun

Engine = Callable[[Scene, Wave, Progress, Announce], tuple[xr.Dataset, Estimate, float]]

ENGINES: Mapping[str, Engine] = {"stencil": run_stencil, "spectral": run_spectral}
"""Run, estimated error and seconds of planning of a scene with a tolerance."""


def run_to_tolerance(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> xr.Dataset:
    """Run a scene that has a tolerance.

    The run carries, beside what any run does, ``tolerance``, ``error_estimate`` (of y/eps, sup over
    the compared sites and all exact times, against the infinite lattice), ``rounding_estimate``
    (its part for rounding), ``next_decade`` (the factor by which ten times more accuracy costs
    more) and ``planning_seconds``. Raises ValueError and UnfinishedRun as `run` does.
    """
    wave = build_wave(scene)
    name = choose_engine(scene, wave)
    told = Announcer(announce or (lambda _: None))
    callbacks = progress or (lambda _: None), told
    told(SECONDS[name](scene, wave))
    try:
        run, estimate, planning_seconds = ENGINES[name](scene, wave, *callbacks)
    except ValueError:
        if scene.engine or name == "stencil":
            raise
        told(SECONDS["stencil"](scene, wave))
        run, estimate, planning_seconds = run_stencil(scene, wave, *callbacks)
    except UnfinishedRun as stop:
        stop.run.attrs["tolerance"] = scene.tolerance
        raise
    return run.assign_attrs(
        tolerance=scene.tolerance,
        error_estimate=estimate.total,
        rounding_estimate=estimate.rounding,
        next_decade=estimate.next_decade,
        planning_seconds=planning_seconds,
    )
