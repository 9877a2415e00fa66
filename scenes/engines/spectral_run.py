"""A scene with a tolerance on the spectral ring, seen through the ring's interpolation.

What it will take is told before any run by a model: points times log2(points) times evaluations,
with steps set by the slow time and the tolerance, on every ring that the search for the domain goes
through.
"""

import math
from dataclasses import replace
from functools import lru_cache

import numpy as np

from longwave.lattice.blow_up import find_blow_up
from longwave.lattice.refine import Announce, Refined, StoppedSearch
from longwave.lattice.spectral.exponential import ORDER
from longwave.lattice.spectral.ring_search import ALIKE, resolving_step, run_facts
from longwave.lattice.state import State, empty_chain
from longwave.lattice.trial import Progress, Trial
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.domain_plan import ComparedCells
from longwave.scenes.engines.recorders import Recorder, build_recorders
from longwave.scenes.engines.run_record import RunRecord, unfinished
from longwave.scenes.engines.spectral_data import (
    SpectralStart,
    first_density,
    spectral_start,
)
from longwave.scenes.engines.spectral_search import (
    MOST_POINTS,
    SpectralCost,
    solve_on_rings,
)
from longwave.scenes.engines.stepped_cells import CellView
from longwave.scenes.starts.moving_wave import MovingWave, moving_wave
from longwave.support.request_limits import ExpectedCost, OverBudgetError

START_SECONDS = 0.08
"""Before the first step, measured with the planning."""

SECONDS_PER_WORK = 2.2e-9
"""Seconds per point, log2(points) and evaluation, measured with the planning."""

EVALUATIONS = 11.0
"""Evaluations per unit of b eps^3 t times peak^3, at tolerance 1 (measured)."""

POINTS = 1.7
"""Points per site in units of the first density times the peak (measured)."""

TAIL = 20.0
"""What doubling a ring to the circumference L changes, on a constant background, times
(eps L/2)^3 and per unit of the peak: the absorbed ring's law (measured)."""

PHASE = 0.1
"""On a periodic one, times (eps L/2)^2 and per unit of b eps^3 t times peak^3 (measured)."""

APART = 400.0
"""Spread of the energies of a ring's lattices, in units of exp(-pi^2/(a |y|)); 250 to 520 for
solitons of a |y| from 0.35 to 0.6."""

STEPPING = 2.0
"""Runs on the first ring with all longer steps, in units of the last of them."""

FAR_DEARER = 300.0
"""The spectral engine gives up at so many times what the stencil takes, and not before ``WORTH``.

A ring on which short waves come round for ever improves ever more slowly. Where that takes long and
a window needs next to nothing, the ring is no help to anyone.
"""

WORTH = 10.0
"""Seconds that a ring may always take."""

SHARE = 0.6
"""Share of the tolerance that doubling the last ring may change."""


POINT_BYTES = 530.0
"""Of a ring's run, for each point."""


@lru_cache(maxsize=4)
def spectral_cost(scene: Scene) -> ExpectedCost:
    """What rings take; the wave's peak sets their points and steps, as in the mKdV limit."""
    moving, tolerance = moving_wave(scene), scene.target.tolerance
    data, numbers = spectral_start(moving, tolerance), moving.wave.numbers
    peak = float(np.max(np.abs(data.bounds.strain))) / moving.eps
    turns = numbers.b * moving.eps**3 * moving.duration * peak**3
    evaluations = EVALUATIONS * (1.0 + turns) * tolerance ** (-1.0 / ORDER)
    steepness = numbers.a * moving.eps * peak
    apart = APART * math.exp(-(math.pi**2) / steepness) * (1.0 + turns) * peak
    if apart > ALIKE * tolerance:
        evaluations = max(evaluations, moving.duration / resolving_step(moving.speed))
    first, *wider = _circumferences(data, tolerance, peak, turns)
    density = POINTS * peak * first_density(moving)
    points = density * np.array([*[first] * round(STEPPING), 2.0 * first, *wider]) + 2.0
    work = evaluations * float(np.sum(points * np.log2(points)))
    most = min(float(MOST_POINTS), density * max(first, *wider, 0.0))
    return ExpectedCost(START_SECONDS + SECONDS_PER_WORK * work, POINT_BYTES * most)


def _circumferences(
    data: SpectralStart, tolerance: float, peak: float, turns: float
) -> list[float]:
    """Those that are tried: doubled until the law says that it is enough, or until the causal one.

    On a constant background a doubling changes by the tails, which are cut off at the seam; on a
    periodic one by what the wave radiates. A kink's ring is causal.
    """
    if data.kink:
        return [data.causal.circumference]
    level, power = (PHASE * turns, 2) if data.periodic else (TAIL * peak, 3)
    tried = [data.smallest]
    while tried[-1] < data.causal.circumference:
        change = level / (data.moving.eps * tried[-1]) ** power
        tried.append(2.0 * tried[-1])
        if change <= SHARE * tolerance:
            break
    return [min(length, data.causal.circumference) for length in tried]


def run_spectral(
    scene: Scene, site_by_site: float, progress: Progress, announce: Announce
) -> tuple[RunRecord, Refined]:
    """The run of a scene to its tolerance, and how its error was estimated.

    ``site_by_site`` are the seconds that the stencil would take. What it would look at where it
    stops is looked at equidistant times here. Only the compared sites are formed, at the times
    asked for. The run ends where their strains are no longer sound. Raises ValueError for a
    tolerance that cannot be met and for a lattice that blows up, UnfinishedRun on Ctrl-C.
    """
    tolerance = scene.target.tolerance
    looks = scene.look_points or scene.curve_points
    recorders = build_recorders(replace(scene, look_points=looks))
    times = {t for recorder in recorders for t in recorder.moments.times} | {scene.end}
    moving = replace(moving_wave(scene), times=(scene.t0, *sorted(times)))
    most_work = max(WORTH, FAR_DEARER * site_by_site) / SECONDS_PER_WORK
    try:
        found = solve_on_rings(moving, tolerance, progress, announce, most_work)
    except StoppedSearch as stop:
        raise _stopped(scene, moving, stop, recorders) from None
    except OverBudgetError as error:
        raise ValueError(
            f"engine must be 'stencil' for tolerance {tolerance:g}, got 'spectral': the next "
            f"rings alone would take {SECONDS_PER_WORK * error.work:.2g} s, site by site about "
            f"{site_by_site:.2g} s (or raise the tolerance)"
        ) from None
    except FloatingPointError as error:
        raise ValueError(
            f"the scene must stay bounded for engine 'spectral': {error} "
            "(take a smaller eps; engine 'stencil' keeps what came before)"
        ) from None
    return _recorded(scene, moving, found.trial, recorders), found


def _stopped(
    scene: Scene, moving: MovingWave, stop: StoppedSearch, recorders: list[Recorder]
) -> KeyboardInterrupt:
    """What the best run that is left shows, as far as it got."""
    trial = stop.trial
    if trial is None or trial.values is None:
        return unfinished(None, scene, None, stop.before)
    seen = replace(moving, times=moving.times[: 1 + len(trial.values)])
    run = _recorded(scene, seen, trial, recorders)
    if seen != moving:
        run.attrs["unfinished"] = f"Ctrl-C after t = {seen.end:g} of {scene.end:g}"
    return unfinished(run, scene, stop.error, stop.before)


def _recorded(
    scene: Scene, moving: MovingWave, trial: Trial, recorders: list[Recorder]
) -> RunRecord:
    """What the recorders see of the compared sites at their moments, as far as they are sound."""
    assert trial.values is not None
    cost: SpectralCost = trial.payload
    amplitude, fault = max(map(abs, cost.strain)), None
    reached = tuple(t for t in scene.snapshots if t <= moving.end)
    for t, row in zip(moving.times[1:], trial.values, strict=True):
        sites = moving.compared_sites(t)
        state = empty_chain(t, int(sites[0]), sites.size)
        state.store(sites, row * moving.eps, np.zeros(sites.size))
        fault = find_blow_up(scene.model.lattice, state, amplitude)
        if fault is not None:
            reached = tuple(seen for seen in scene.snapshots if seen < t)
            break
        view = view_of(moving, state)
        for item in recorders:
            if item.moments.due(t):
                item.see(view)
    told = run_facts(
        trial, cost.steps, cost.evaluations, cost.points, "" if fault is None else str(fault)
    )
    told["circumference"] = cost.circumference
    variables = {name: value for item in recorders for name, value in item.variables().items()}
    return RunRecord(scene, (scene.compared,), reached, variables, told)


def view_of(moving: MovingWave, state: State) -> CellView:
    """The compared sites of a state that holds them."""
    compared = ComparedCells(moving.speed, (moving.compared,))
    ends = [(state.left, state.left + state.size - 1)]
    return CellView(moving, compared, moving.lattice, (0.0,), state, ends, state.at(state.sites))
