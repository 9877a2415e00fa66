"""Running a scene: as it is stated, or to its tolerance by the engine that it names.

Where none is named or required by what is asked for, the cheaper one by a model is taken. What the
spectral engine refuses, though it was not named, is run site by site.

A run can be gone on with from a snapshot.
"""

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from longwave.lattice.model import State
from longwave.lattice.refine import Announce
from longwave.lattice.trial import Progress
from longwave.scenes.chain.spectral_run import run_spectral, spectral_seconds
from longwave.scenes.chain.stated_run import (
    PROCESS_SECONDS as PROCESS_SECONDS,  # asked for by `Scene.process_seconds`
)
from longwave.scenes.chain.stated_run import (
    RunRecord,
    UnfinishedRun,
    run_from,
)
from longwave.scenes.chain.stencil_search import run_stencil, stencil_seconds
from longwave.scenes.chain.trust import check_trust, trust_attributes
from longwave.scenes.named_scenes import scene_of
from longwave.scenes.scene import Scene
from longwave.support.checkpoint import spared_seconds
from longwave.support.request_limits import Announcer, ExpectedCost, is_too_much
from longwave.support.user_files import shown

if TYPE_CHECKING:
    import xarray as xr

    from longwave.solutions import ClosedForm


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
    seconds, found, begun = stencil_seconds(scene), None, time.perf_counter()
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
        stop.record.asked = scene
        stop.record.attrs["tolerance"] = scene.tolerance
        raise
    run, refined = found
    run.asked = scene
    run.attrs |= {
        "tolerance": scene.tolerance,
        "error_estimate": refined.error,
        "rounding_estimate": refined.rounding,
        "next_decade": refined.next_decade,
        "planning_seconds": time.perf_counter() - begun + spared_seconds() - refined.trial.seconds,
    }
    return run


def run(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> "xr.Dataset":
    """Run the scene and return what it asks for.

    Dimensions: ``time`` (the snapshots), ``curve_time``, ``look_time``, ``site`` (offset from the
    site nearest to c t) and what else the observables add. The table of observables
    (`observables.py`) says which variables each of them adds; none other is there.

    Attributes: the scene as TOML, what made the run (`provenance`), cost, and ``blow_up`` (empty if
    there was none). A run that blows up keeps the times before it. With a tolerance also
    ``error_estimate`` and its parts (`run_to_tolerance`), and ``plan``, the scene with step and
    domain filled in, if sites were computed one by one. ``progress`` is called with the share of
    the work that is done, 0 .. 1; ``announce`` with the seconds that are expected to pass, if they
    are many.

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
    from longwave.scenes.chain.expected_cost import check_cost

    expected = check_cost(scene)
    if scene.tolerance is None:
        Announcer(announce or (lambda _: None))(expected.seconds)
        return run_from(scene, scene.moving_wave, None, progress)
    check_trust(scene)
    return run_to_tolerance(scene, progress, announce)


def run_scene(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> "xr.Dataset":
    """`run`, with what can be trusted of the run."""
    return record_with_trust(scene, progress, announce).dataset


def scene_cost(scene: Scene) -> ExpectedCost:
    """What a run is expected to cost, in a process that has just begun.

    What is known to be beyond the limits from the scene alone is not looked at any further. Raises
    ValueError for what no scene can be run with.
    """
    from longwave.scenes.chain.expected_cost import expected_cost, least_cost

    least = least_cost(scene)
    return least if is_too_much(least) else expected_cost(scene)


def record_with_trust(
    scene: Scene, progress: Progress | None = None, announce: Announce | None = None
) -> RunRecord:
    """`record_scene`, with what can be trusted of the run."""
    trust = trust_attributes(scene)
    try:
        record = record_scene(scene, progress, announce)
    except UnfinishedRun as stop:
        stop.record.attrs |= trust
        raise
    record.attrs |= trust
    return record


def state_at(run: "xr.Dataset", t: float) -> State:
    """A copy of the state at a snapshot of a run whose scene asks for the observable ``state``.

    Raises ValueError if the run carries no states or has no snapshot at ``t``.
    """
    if "state_y" not in run:
        raise ValueError(
            "run must carry its states to be resumed, got none (ask for the observable 'state')"
        )
    found = np.flatnonzero(run["time"].values == t)
    if found.size == 0:
        kept = ", ".join(f"{kept:g}" for kept in run["time"].values)
        raise ValueError(f"at must be a snapshot of the run, got {t:g} (it kept {kept or 'none'})")
    row = run.isel(time=int(found[0]))
    y, s = (np.array(row[name].values, dtype=np.float64) for name in ("state_y", "state_s"))
    return State(t, int(row["state_left"]), y, s)


def resume(
    run: "xr.Dataset",
    at: float | None = None,
    snapshots: Sequence[float] | None = None,
    progress: Progress | None = None,
    wave: "ClosedForm | None" = None,
) -> "xr.Dataset":
    """Go on from a snapshot of a run, to the bit as if the run had not been interrupted.

    ``at`` is the snapshot, by default the last one; ``snapshots`` are the times wanted after it, by
    default those of the scene; a ``wave`` of your own, which no file holds, is to be given again.
    The result holds what the scene asks for after ``at``. Same bits need the same stops:
    ``curve_points`` and ``look_points`` times move with the end of the run.

    Raises ValueError if the run carries no state at ``at`` or nothing is wanted after it.
    """
    start = state_at(run, float(run["time"].values[-1]) if at is None else at)
    scene = scene_of(run) if wave is None else replace(scene_of(run), wave=wave)
    later = tuple(t for t in (scene.snapshots if snapshots is None else snapshots) if t > start.t)
    if not later:
        raise ValueError(f"snapshots must lie after t = {start.t:g}, got none (name later ones)")
    scene = scene.changed(t0=scene.t0, snapshots=later)
    return run_from(scene, scene.moving_wave, start, progress).dataset
