"""Running a scene: as it is stated, or to its tolerance by the engine that it names.

Where none is named or required by what is asked for, the cheaper one by a model is taken. What the
spectral engine refuses, though it was not named, is run site by site.
"""

from typing import TYPE_CHECKING

from lattice.refine import Announce, Progress
from verify.comparison.checks import shown
from verify.comparison.recording import Announcer, RunRecord, UnfinishedRun
from verify.comparison.scene import Scene
from verify.comparison.spectral_run import run_spectral, spectral_seconds
from verify.comparison.stated_run import run_from, stated_seconds
from verify.comparison.stencil_search import run_stencil, stencil_seconds
from verify.comparison.trust import check_trust

if TYPE_CHECKING:
    import xarray as xr

SITE_BY_SITE = ("energy", "momentum", "state")
"""Observables of all sites of a lattice, which the spectral ring does not have."""


def choose_engine(scene: Scene) -> str:
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
    cheap = stencil_seconds(scene) <= spectral_seconds(scene)
    return "stencil" if cheap else "spectral"


def run_to_tolerance(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> RunRecord:
    """Run a scene that has a tolerance.

    The run carries, beside what any run does, ``tolerance``, ``error_estimate`` (of y/eps, sup over
    the compared sites and all exact times, against the infinite lattice), ``rounding_estimate``
    (its part for rounding), ``next_decade`` (the factor by which ten times more accuracy costs
    more) and ``planning_seconds``. Raises ValueError and UnfinishedRun as `run` does.
    """
    by_ring = choose_engine(scene) == "spectral"
    told, progress = Announcer(announce or (lambda _: None)), progress or (lambda _: None)
    seconds, found = stencil_seconds(scene), None
    try:
        if by_ring:
            told(spectral_seconds(scene))
            try:
                found = run_spectral(scene, seconds, progress, told)
            except ValueError:
                if scene.target.engine:
                    raise
        if found is None:
            told(seconds)
            found = run_stencil(scene, progress, told)
    except UnfinishedRun as stop:
        stop.record.attrs["tolerance"] = scene.tolerance
        raise
    run, estimate, planning_seconds = found
    run.attrs |= {
        "tolerance": scene.tolerance,
        "error_estimate": estimate.total,
        "rounding_estimate": estimate.rounding,
        "next_decade": estimate.next_decade,
        "planning_seconds": planning_seconds,
    }
    return run


def run(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> "xr.Dataset":
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
    return record_scene(scene, progress, announce).dataset


def record_scene(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> RunRecord:
    """`run` without a data set: what it records, of which one can be made."""
    if not isinstance(scene, Scene):
        raise ValueError(
            f"scene must be a Scene, got {shown(scene)} (load_scene and Scene.from_toml make one)"
        )
    if scene.tolerance is None:
        Announcer(announce or (lambda _: None))(stated_seconds(scene))
        return run_from(scene, scene.moving_wave, None, progress)
    check_trust(scene)
    return run_to_tolerance(scene, progress, announce)
