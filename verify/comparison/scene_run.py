"""Running a scene: as it is stated, or to its tolerance by the engine that it names.

Where none is named or required by what is asked for, the cheaper one by a model is taken. What the
spectral engine refuses, though it was not named, is run site by site.
"""

from collections.abc import Callable, Mapping

import xarray as xr

from lattice.refine import Announce
from lattice.trial import Estimate
from solutions import Wave
from verify.comparison.checks import shown
from verify.comparison.initial_data import build_wave
from verify.comparison.recording import Announcer, Progress, UnfinishedRun
from verify.comparison.scene import ENGINES, Scene
from verify.comparison.spectral_run import run_spectral, spectral_seconds
from verify.comparison.stated_run import run_from, stated_seconds
from verify.comparison.stencil_search import run_stencil, stencil_seconds
from verify.comparison.trust import check_trust

SITE_BY_SITE = ("energy", "momentum", "state")
"""Observables of all sites of a lattice, which the spectral ring does not have."""


def choose_engine(scene: Scene, wave: Wave) -> str:
    """The engine that the scene names, or the one that its observables need, or the cheaper one.

    Raises ValueError if the named one cannot compute an observable.
    """
    needing = [name for name in scene.observables if name in SITE_BY_SITE]
    named = scene.target
    if named.engine == "spectral" and needing:
        raise ValueError(
            f"engine must be 'stencil' for {needing[0]}, got 'spectral' (it has no ring of sites)"
        )
    if named.engine:
        return named.engine
    if needing or named.scheme:
        return "stencil"
    return min(ENGINES, key=lambda engine: SECONDS[engine](scene, wave))


SECONDS: Mapping[str, Callable[[Scene, Wave], float]] = {
    "stencil": stencil_seconds,
    "spectral": spectral_seconds,
}

Runner = Callable[[Scene, Wave, Progress, Announce], tuple[xr.Dataset, Estimate, float]]

RUNNERS: Mapping[str, Runner] = {"stencil": run_stencil, "spectral": run_spectral}
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
        run, estimate, planning_seconds = RUNNERS[name](scene, wave, *callbacks)
    except ValueError:
        if scene.target.engine or name == "stencil":
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


def run(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> xr.Dataset:
    """Run the scene and return what it asks for.

    Dimensions: ``time`` (the snapshots), ``curve_time``, ``look_time``, ``site`` (offset from the
    site nearest to c t) and what else the observables add. The table of observables
    (`observables.py`) says which variables each of them adds; none other is there.

    Attributes: the scene as JSON, versions, cost, and ``blow_up`` (empty if there was none). A run
    that blows up keeps the times before it. With a tolerance also ``error_estimate`` and its parts
    (`run_to_tolerance`); the scene is then the one with step and domain filled in, if sites were
    computed one by one. ``progress`` is called with the share of the work that is done, 0 .. 1;
    ``announce`` with the seconds that are expected to pass, if they are many.

    Raises ValueError for every input that the scene's wave, lattice or scheme do not admit, and
    UnfinishedRun on Ctrl-C.
    """
    if not isinstance(scene, Scene):
        raise ValueError(
            f"scene must be a Scene, got {shown(scene)} (load_scene and Scene.from_toml make one)"
        )
    if scene.tolerance is None:
        Announcer(announce or (lambda _: None))(stated_seconds(scene))
        return run_from(scene, None, progress)
    check_trust(scene)
    return run_to_tolerance(scene, progress, announce)
