"""Running a scene on the paper's chain: as it is stated, or to its tolerance by an engine.

Where none is named or required by what is asked for, the cheaper one by a model is taken. What the
spectral engine refuses, though it was not named, is run site by site.

What a scene is expected to cost is known first from the scene alone, which takes no time whatever
it says; then, for one with a tolerance, from its wave, by the models of the two engines. The
numbers were measured in processor time on one core of a 3 GHz server; `benchmarks/costs.py`
compares the estimates with what scenes take.
"""

from __future__ import annotations

import math
import time
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from longwave.lattice.refine import Announce
from longwave.lattice.state import State
from longwave.lattice.trial import Progress
from longwave.scenes.chain.spectral_run import run_spectral, spectral_cost
from longwave.scenes.chain.stencil_search import (
    SECONDS_PER_UPDATE,
    SITE_BYTES,
    START_SECONDS,
    ChainSites,
    part_of,
    run_stencil,
    stencil_cost,
)
from longwave.scenes.chain.trust import check_trust, trust_attributes
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.stated_run import refinements, run_from, stated_runs
from longwave.scenes.observed.observables import MAP_CELLS, Observable, observable_named
from longwave.scenes.observed.recorders import MOMENT_BYTES
from longwave.scenes.observed.run_record import RunRecord, UnfinishedRun, judged
from longwave.scenes.observed.view import SiteView
from longwave.support.request_limits import Announcer, ExpectedCost, check_request, is_too_much


def choose_engine(scene: Scene) -> str:
    """The engine that the scene names, or the one that its observables need, or the cheaper one.

    Raises ValueError if the named one cannot compute an observable.
    """
    needing = [name for name in scene.observables if observable_named(name).all_sites]
    named = scene.target
    if named.engine == "spectral" and needing:
        raise ValueError(
            f"engine must be 'stencil' for {needing[0]}, got 'spectral' (it has no ring of sites)"
        )
    if named.engine:
        return named.engine
    if needing or named.scheme:
        return "stencil"
    cheap = stencil_cost(scene).seconds <= spectral_cost(scene).seconds
    return "stencil" if cheap else "spectral"


def record_scene(
    scene: Scene,
    progress: Progress | None = None,
    announce: Announce | None = None,
    restart: State | None = None,
) -> RunRecord:
    """The record of a run, with what can be trusted of it, from the start or a state.

    ``progress`` and ``announce`` are as in `scene_run.run`, as is what is raised.
    """
    told = {"frame_speed": scene.model.sound_speed(), "power": 1} | trust_attributes(scene)
    announcer = Announcer(announce or (lambda _: None))
    try:
        record = _record(scene, progress or (lambda _: None), announcer, restart)
    except UnfinishedRun as stop:
        stop.record.attrs |= told
        raise
    record.attrs |= told
    return record


def _record(
    scene: Scene, progress: Progress, announce: Announcer, restart: State | None
) -> RunRecord:
    expected = scene_cost(scene)
    remedy = CHEAPER_STATED if scene.tolerance is None else CHEAPER
    check_request(scene.name, expected, remedy)
    if scene.tolerance is None:
        announce(expected.seconds)
        return run_from(ChainSites(scene, scene.moving_wave), restart, progress)
    check_trust(scene)
    seconds, begun = stencil_cost(scene).seconds, time.perf_counter()
    if choose_engine(scene) == "spectral":
        announce(expected.seconds)
        try:
            return judged(*run_spectral(scene, seconds, progress, announce), scene, begun)
        except ValueError:
            if scene.target.engine:
                raise
    announce(RUNS["stencil"] * seconds)
    return judged(*run_stencil(scene, progress, announce), scene, begun)


def wave_size(scene: Scene, t: float, far_field: bool) -> float:
    """The wave's largest deviation from its background, or its far field (`Scene.wave_size`)."""
    none = np.zeros((1, 0))
    view = SiteView(scene.moving_wave, State(t, none, none))
    found = view.far_field if far_field else view.background
    return math.nan if found is None else float(np.max(np.abs(view.analytic - found)))


PROCESS_SECONDS = 1.5
"""For imports, what is loaded and what is written, once in a process."""

PROCESS_BYTES = 2.8e8
"""Of a process that has run something small and made its data set."""

VALUE_BYTES = 20.0
"""For each number that is kept: in rows, in an array, and as a file's content."""

MOVE_BYTES = 250.0
"""For each move of a window."""

TRIALS = 8.0
"""Runs of a search of which what is compared is kept."""

RUNS = {"stencil": 2.7, "spectral": 4.0}
"""Runs of a search, in units of the engine's first: seconds."""

STATED_SHARE = 0.5
"""Of what an update takes in a search, where nothing is compared."""

VIEW_SECONDS = 4e-4
"""To see the wave beside the lattice once."""

SEEN_SECONDS = {False: 5e-7, True: 1.6e-6}
"""For each compared site that is seen, by whether the wave is periodic."""

STOP_SECONDS = 4e-5
"""To stop once."""

CHEAPER = "end earlier, compare fewer sites or see fewer times"
CHEAPER_STATED = "take a larger step or fewer sites, or see fewer times"


def scene_cost(scene: Scene) -> ExpectedCost:
    """What a run is expected to cost, in a process that has just begun.

    What is known to be beyond the limits from the scene alone is not looked at any further. Raises
    ValueError as making its wave does.
    """
    least = _least_cost(scene)
    if scene.tolerance is None or is_too_much(least):
        return least
    engines = {"stencil": stencil_cost, "spectral": spectral_cost}
    named = scene.target.engine
    costs = {name: cost(scene) for name, cost in engines.items() if named in ("", name)}
    name, cheapest = min(costs.items(), key=lambda entry: entry[1].seconds)
    kept = TRIALS * _seen(scene).exact * _width(scene)
    if name == "stencil" and part_of(scene, scene.moving_wave) is not None:
        kept = 0.0
    return replace(
        least,
        seconds=least.seconds + RUNS[name] * cheapest.seconds,
        memory_bytes=least.memory_bytes + VALUE_BYTES * kept + cheapest.memory_bytes,
    )


def _least_cost(scene: Scene) -> ExpectedCost:
    """What is known from the scene alone: all of it, if its step and its sites are stated."""
    seen = _seen(scene)
    if scene.tolerance is not None:
        return ExpectedCost(
            seen.seconds,
            PROCESS_BYTES + VALUE_BYTES * seen.values + MOMENT_BYTES * seen.times,
            once=PROCESS_SECONDS,
        )
    stated, measures = scene.discretisation, refinements(scene)
    sites = stated.sites * (2 if "domain_error" in measures else 1)
    duration = (scene.end - scene.t0) / stated.step
    steps = duration + seen.exact
    updates = (duration * stated_runs(scene) + seen.exact) * stated.table.stages * stated.sites
    moves = 0.0
    if stated.domain == "window":
        moves = (scene.end - scene.t0) * scene.model.sound_speed() / 64.0
    kept = seen.values + _width(scene) * len(scene.snapshots) * len(measures)
    return ExpectedCost(
        START_SECONDS
        + STATED_SHARE * SECONDS_PER_UPDATE * updates
        + seen.seconds
        + SITE_SECONDS * sites
        + STOP_SECONDS * (steps / 64.0 + moves) * (1 + 2 * len(measures)),
        PROCESS_BYTES
        + SITE_BYTES * sites
        + VALUE_BYTES * kept
        + MOMENT_BYTES * seen.times
        + MOVE_BYTES * moves,
        steps * (1 + 2 * len(measures)),
        PROCESS_SECONDS,
    )


SITE_SECONDS = 3e-6
"""For the data of a site at the beginning."""


class _Seen(NamedTuple):
    """How often a scene is looked at, how often exactly, and the numbers that are kept of it."""

    times: float
    exact: float
    values: float
    seconds: float


def _seen(scene: Scene) -> _Seen:
    entries = [observable_named(name) for name in scene.observables]
    looks = scene.look_points or scene.curve_points
    counts = {"snapshots": len(scene.snapshots), "curve": scene.curve_points, "looks": looks}
    counts["refinement"] = 0
    kinds = {entry.seen for entry in entries}
    exact = counts["snapshots"] + ("curve" in kinds) * scene.curve_points
    exact += ("looks" in kinds) * (scene.look_points or 0)
    a_look = VIEW_SECONDS + SEEN_SECONDS["k" in dict(scene.parameters)] * _width(scene)
    return _Seen(
        sum(counts[kind] for kind in kinds) + exact,
        exact,
        sum(counts[entry.seen] * _values(entry, scene) for entry in entries),
        PROCESS_SECONDS + sum(counts[kind] * a_look for kind in kinds),
    )


def _width(scene: Scene) -> int:
    return 2 * scene.compared + 1


def _values(entry: Observable, scene: Scene) -> float:
    """Numbers that an observable keeps of one time."""
    width = _width(scene)
    sites = 0 if scene.tolerance is not None else scene.discretisation.sites
    sizes = {"site": width, "wavenumber": width / 2, "map_site": MAP_CELLS, "cell": sites}
    return sum(
        math.prod(sizes.get(name, 1) for name in variable.dimensions)
        for variable in entry.variables
    )
