"""Runs of a scene to a tolerance on spectral rings, measured by interpolation to the sites.

A model predicts the cost before any run: points times log2(points) times evaluations, on every ring
that the search for the domain tries. The number of steps follows from the slow time and the
tolerance.
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
from longwave.scenes.engines import spectral_data, spectral_search
from longwave.scenes.engines.domain_plan import ComparedCells
from longwave.scenes.engines.recorders import Recorder, build_recorders, recorded_variables
from longwave.scenes.engines.run_record import RunRecord, search_interrupt
from longwave.scenes.engines.stepped_cells import CellView
from longwave.scenes.starts.moving_wave import MovingWave, moving_wave
from longwave.support.request_limits import ExpectedCost, OverBudgetError

START_SECONDS = 0.08
"""Seconds before the first step, including the planning (measured)."""

SECONDS_PER_WORK = 2.2e-9
"""Seconds per unit of points times log2(points) times evaluations, with planning (measured)."""

EVALUATION_FACTOR = 11.0
"""Force evaluations at tolerance 1, per unit of 1 + b eps^3 t peak^3, with the peak in y/eps and
the factor b of the normal form's time tau = b T (measured)."""

POINT_FACTOR = 1.7
"""Points per site, in units of `first_density` times the peak in y/eps (measured)."""

TAIL_CHANGE = 20.0
"""Constant C of the change C peak / (eps L/2)^3 of the result when a ring with absorber, on a
constant background, is doubled to circumference L (measured)."""

PERIODIC_CHANGE = 0.1
"""Constant C of the change C b eps^3 t peak^3 / (eps L/2)^2 (see `EVALUATION_FACTOR`) of the result
when a ring on a periodic background is doubled to circumference L (measured)."""

LATTICE_SPREAD = 400.0
"""Variation of a wave's energy with its position between two sites, in units of exp(-pi^2/s) for
steepness s = a |y|, with the factor a of xi = a X; 250 to 520 for solitons of s from 0.35 to
0.6."""

FIRST_RING_RUNS = 2.0
"""Cost of all runs on the first ring, one for each step tried, in units of the last run."""

MOST_RELATIVE_COST = 300.0
"""Cost at which the spectral engine gives up, in units of the stencil's first run (`MIN_BUDGET`).

On a ring that short waves circle forever, a larger ring improves the result ever more slowly. Then
the stencil in a moving window is much cheaper.
"""

MIN_BUDGET = 10.0
"""Seconds that the spectral engine may use in any case."""

CHANGE_FRACTION = 0.6
"""Largest change from doubling the ring, as a fraction of the tolerance, that ends a search."""


POINT_BYTES = 530.0
"""Bytes per point of a run on a ring."""


@lru_cache(maxsize=4)
def spectral_cost(scene: Scene) -> ExpectedCost:
    """Return the expected cost of one run on each ring of a search, from the wave's peak."""
    moving, tolerance = moving_wave(scene), scene.target.tolerance
    data, numbers = spectral_data.spectral_start(moving, tolerance), moving.wave.numbers
    peak = float(np.max(np.abs(data.bounds.strain))) / moving.eps
    turns = numbers.b * moving.eps**3 * moving.duration * peak**3
    evaluations = EVALUATION_FACTOR * (1.0 + turns) * tolerance ** (-1.0 / ORDER)
    steepness = numbers.a * moving.eps * peak
    lattice_spread = LATTICE_SPREAD * math.exp(-(math.pi**2) / steepness) * (1.0 + turns) * peak
    if lattice_spread > ALIKE * tolerance:
        evaluations = max(evaluations, moving.duration / resolving_step(moving.speed))
    first, *wider = _circumferences(data, tolerance, peak, turns)
    density = POINT_FACTOR * peak * spectral_data.first_density(moving)
    points = density * np.array([*[first] * round(FIRST_RING_RUNS), 2.0 * first, *wider]) + 2.0
    work = evaluations * float(np.sum(points * np.log2(points)))
    most = min(float(spectral_search.MOST_POINTS), density * max(first, *wider, 0.0))
    return ExpectedCost(START_SECONDS + SECONDS_PER_WORK * work, POINT_BYTES * most)


def _circumferences(
    data: spectral_data.SpectralStart, tolerance: float, peak: float, turns: float
) -> list[float]:
    """Return the circumferences a search is expected to try for a wave of this ``peak`` in y/eps.

    Each is twice the one before; ``turns`` is b eps^3 t peak^3, as in `EVALUATION_FACTOR`.

    The search ends when the predicted change is within the tolerance or the ring is causal. On a
    constant background the change comes from the wave's tails, cut off at the seam; on a periodic
    one from the radiation of the wave. A kink's ring is causal from the start.
    """
    if data.kink:
        return [data.causal.circumference]
    level, power = (PERIODIC_CHANGE * turns, 2) if data.periodic else (TAIL_CHANGE * peak, 3)
    tried = [data.smallest]
    while tried[-1] < data.causal.circumference:
        change = level / (data.moving.eps * tried[-1]) ** power
        tried.append(2.0 * tried[-1])
        if change <= CHANGE_FRACTION * tolerance:
            break
    return [min(length, data.causal.circumference) for length in tried]


def run_spectral(
    scene: Scene, site_by_site: float, progress: Progress, announce: Announce
) -> tuple[RunRecord, Refined]:
    """Run a scene to its tolerance on spectral rings; return its record and the search's result.

    ``site_by_site`` is the expected time, in seconds, of a first run with the stencil. Looks are
    taken at equidistant times, and only the compared sites are evaluated. The record ends where
    their strains show a blow-up. Raises ValueError for a tolerance that cannot be met and for a
    lattice that blows up, UnfinishedRun on Ctrl-C.
    """
    tolerance = scene.target.tolerance
    looks = scene.look_points or scene.curve_points
    recorders = build_recorders(replace(scene, look_points=looks))
    times = {t for recorder in recorders for t in recorder.moments.times} | {scene.end}
    moving = replace(moving_wave(scene), times=(scene.t0, *sorted(times)))
    most_work = max(MIN_BUDGET, MOST_RELATIVE_COST * site_by_site) / SECONDS_PER_WORK
    try:
        found = spectral_search.solve_on_rings(moving, tolerance, progress, announce, most_work)
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
            "(take a smaller eps; engine 'stencil' stores the run up to there)"
        ) from None
    return _recorded(scene, moving, found.trial, recorders), found


def _stopped(
    scene: Scene, moving: MovingWave, stop: StoppedSearch, recorders: list[Recorder]
) -> KeyboardInterrupt:
    """Return the exception for a search ended by Ctrl-C, with the record of its best run."""
    trial = stop.trial
    if trial is None or trial.values is None:
        return search_interrupt(None, scene, None, stop.before)
    completed = replace(moving, times=moving.times[: 1 + len(trial.values)])
    run = _recorded(scene, completed, trial, recorders)
    if completed != moving:
        run.attrs["unfinished"] = f"Ctrl-C after t = {completed.end:g} of {scene.end:g}"
    return search_interrupt(run, scene, stop.error, stop.before)


def _recorded(
    scene: Scene, moving: MovingWave, trial: Trial, recorders: list[Recorder]
) -> RunRecord:
    """Return the record of a run: observables of the compared sites, up to a blow-up."""
    assert trial.values is not None
    cost: spectral_search.SpectralCost = trial.payload
    amplitude, fault = max(map(abs, cost.strain)), None
    reached = tuple(t for t in scene.snapshots if t <= moving.end)
    for t, row in zip(moving.times[1:], trial.values, strict=True):
        sites = moving.compared_sites(t)
        state = empty_chain(t, int(sites[0]), sites.size)
        state.store(sites, row * moving.eps, np.zeros(sites.size))
        fault = find_blow_up(scene.model.lattice, state, amplitude)
        if fault is not None:
            reached = tuple(snapshot for snapshot in scene.snapshots if snapshot < t)
            break
        view = view_of(moving, state)
        for recorder in recorders:
            if recorder.moments.is_due(t):
                recorder.observe(view)
    attributes = run_facts(
        trial, cost.steps, cost.evaluations, cost.points, "" if fault is None else str(fault)
    )
    attributes["circumference"] = cost.circumference
    variables = recorded_variables(recorders)
    return RunRecord(scene, (scene.compared,), reached, variables, attributes)


def view_of(moving: MovingWave, state: State) -> CellView:
    """Return the view of a moving wave and a lattice state on the compared sites."""
    compared = ComparedCells(moving.speed, (moving.compared,))
    ends = [(state.left, state.left + state.size - 1)]
    return CellView(moving, compared, moving.lattice, (0.0,), state, ends, state.at(state.sites))
