"""What a scene is expected to cost, before it is run: steps, seconds, and the most bytes at once.

First from the scene alone, which takes no time whatever it says; then, for one with a tolerance,
from its wave, by the models of the two engines. The numbers were measured in processor time on one
core of a 3 GHz server; `benchmarks/costs.py` compares the estimates with what scenes take.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from operator import attrgetter

from longwave.scenes.chain.sites import PROCESS_SECONDS, SECONDS_PER_UPDATE, START_SECONDS
from longwave.scenes.chain.spectral_run import spectral_cost
from longwave.scenes.chain.stencil_search import SITE_BYTES, stencil_cost
from longwave.scenes.observables import MAP_CELLS, Observable, observable_named
from longwave.scenes.recorders import MOMENT_BYTES
from longwave.scenes.scene import Scene
from longwave.scenes.stated_run import refinements, stated_runs
from longwave.support.request_limits import ExpectedCost, check_request, is_too_much

PROCESS_BYTES = 2.8e8
"""Of a process that has run something small and made its data set."""

VALUE_BYTES = 20.0
"""For each number that is kept: in rows, in an array, and as a file's content."""

MOVE_BYTES = 250.0
"""For each move of a window."""

TRIALS = 8.0
"""Runs of a search of which what is compared is kept."""

RUNS = 4.0
"""Runs of a search, in units of the engine's first: seconds."""

VIEW_SECONDS = 4e-4
"""To see the wave beside the lattice once."""

SEEN_SECONDS = {False: 5e-7, True: 1.6e-6}
"""For each compared site that is seen, by whether the wave is periodic."""

STOP_SECONDS = 4e-5
"""To stop once."""

CHEAPER = "end earlier, compare fewer sites or see fewer times"
CHEAPER_STATED = "take a larger step or fewer sites, or see fewer times"


def check_cost(scene: Scene) -> ExpectedCost:
    """`scene_cost`; OverBudgetError if that is more than the limits allow."""
    found = scene_cost(scene)
    stated = scene.tolerance is None
    check_request(scene.name, found, CHEAPER_STATED if stated else CHEAPER)
    return found


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
    costs = [cost(scene) for name, cost in engines.items() if named in ("", name)]
    cheapest = min(costs, key=attrgetter("seconds"))
    return replace(
        least,
        seconds=least.seconds + RUNS * cheapest.seconds,
        memory_bytes=least.memory_bytes + cheapest.memory_bytes,
    )


def _least_cost(scene: Scene) -> ExpectedCost:
    """What is known from the scene alone: all of it, if its step and its sites are stated."""
    seen = _Seen.of(scene)
    if scene.tolerance is not None:
        kept = seen.values + TRIALS * seen.exact * (2 * scene.compared + 1)
        return ExpectedCost(
            seen.seconds,
            PROCESS_BYTES + VALUE_BYTES * kept + MOMENT_BYTES * seen.times,
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
    kept = seen.values + (2 * scene.compared + 1) * len(scene.snapshots) * len(measures)
    return ExpectedCost(
        START_SECONDS
        + SECONDS_PER_UPDATE * updates
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


@dataclass(frozen=True)
class _Seen:
    """How often a scene is looked at, how often exactly, and the numbers that are kept of it."""

    times: float
    exact: float
    values: float
    seconds: float

    @classmethod
    def of(cls, scene: Scene) -> _Seen:
        entries = [observable_named(name) for name in scene.observables]
        looks = scene.look_points or scene.curve_points
        counts = {"snapshots": len(scene.snapshots), "curve": scene.curve_points, "looks": looks}
        counts["refinement"] = 0
        kinds = {entry.seen for entry in entries}
        exact = len(scene.snapshots)
        exact += scene.curve_points if "curve" in kinds else 0
        exact += looks if "looks" in kinds and scene.look_points is not None else 0
        width = 2 * scene.compared + 1
        a_point = SEEN_SECONDS["k" in dict(scene.parameters)]
        return cls(
            sum(counts[kind] for kind in kinds) + exact,
            exact,
            sum(counts[entry.seen] * _values(entry, scene) for entry in entries),
            PROCESS_SECONDS
            + sum(counts[kind] * (VIEW_SECONDS + a_point * width) for kind in kinds),
        )


def _values(entry: Observable, scene: Scene) -> float:
    """Numbers that an observable keeps of one time."""
    width = 2 * scene.compared + 1
    sites = 0 if scene.tolerance is not None else scene.discretisation.sites
    sizes = {"site": width, "wavenumber": width / 2, "map_site": MAP_CELLS, "cell": sites}
    return sum(
        math.prod(sizes.get(name, 1) for name in variable.dimensions)
        for variable in entry.variables
    )
