"""A scene with a tolerance on the spectral ring, seen through the ring's interpolation.

What it will take is told before any run by a model: points times log2(points) times evaluations,
with steps set by the slow time and the tolerance, on every ring that the search for the domain goes
through.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from lattice.refine import Announce, StoppedSearch, TooDearError
from lattice.spectral.exponential import ORDER
from lattice.spectral.ring import ALIKE, telling_step
from lattice.state import BlowUp, empty_state, find_blow_up
from lattice.trial import Estimate
from solutions import Wave
from verify.comparison.recording import (
    LONG,
    Observer,
    Progress,
    Recorder,
    build_dataset,
    build_recorders,
    unfinished,
)
from verify.comparison.scene import Scene
from verify.comparison.spectral_data import first_density, ring_data
from verify.comparison.spectral_search import RingTooLargeError, StepTooShortError, spectral_run
from verify.comparison.spectral_task import SpectralRun, SpectralTask
from verify.comparison.stencil_search import scene_bounds, stencil_seconds
from verify.comparison.view import View

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

FAR_DEARER = 100.0
"""The spectral engine gives up at so many times what the stencil takes, and not before ``LONG``."""

SHARE = 0.6
"""Share of the tolerance that doubling the last ring may change."""


def spectral_seconds(scene: Scene, wave: Wave) -> float:
    """What rings would take; the wave's peak sets their points and steps, as in the mKdV limit."""
    tolerance = scene.target.tolerance
    peak = float(np.max(np.abs(scene_bounds(scene, wave).strain))) / scene.eps
    turns = float(wave.normal_form.b) * scene.eps**3 * (scene.end - scene.t0) * peak**3
    evaluations = EVALUATIONS * (1.0 + turns) * tolerance ** (-1.0 / ORDER)
    steepness = float(wave.normal_form.a) * scene.eps * peak
    apart = APART * math.exp(-(math.pi**2) / steepness) * (1.0 + turns) * peak
    if apart > ALIKE * tolerance:
        step = telling_step(scene.constants.sound_speed())
        evaluations = max(evaluations, (scene.end - scene.t0) / step)
    first, *wider = _circumferences(scene, wave, peak, turns)
    density = POINTS * peak * first_density(wave, scene.eps)
    points = density * np.array([*[first] * round(STEPPING), 2.0 * first, *wider]) + 2.0
    work = evaluations * float(np.sum(points * np.log2(points)))
    return START_SECONDS + SECONDS_PER_WORK * work


def _circumferences(scene: Scene, wave: Wave, peak: float, turns: float) -> list[float]:
    """Those that are tried: doubled until the law says that it is enough, or until the causal one.

    On a constant background a doubling changes by the tails, which are cut off at the seam; on a
    periodic one by what the wave radiates. A kink's ring is causal.
    """
    tolerance = scene.target.tolerance
    data = ring_data(
        scene.constants,
        wave,
        scene.eps,
        (scene.t0, *scene.snapshots),
        scene.compared,
        tolerance,
    )
    assert data.causal is not None
    if data.kink:
        return [data.causal.circumference]
    level, power = (PHASE * turns, 2) if data.periodic else (TAIL * peak, 3)
    tried = [data.smallest]
    while tried[-1] < data.causal.circumference:
        change = level / (scene.eps * tried[-1]) ** power
        tried.append(2.0 * tried[-1])
        if change <= SHARE * tolerance:
            break
    return [min(length, data.causal.circumference) for length in tried]


def most_spectral_work(scene: Scene, wave: Wave) -> float:
    """Points times their log2 times evaluations that rings may take at once.

    A ring on which short waves come round for ever improves ever more slowly. Where that takes long
    and a window needs next to nothing, the ring is no help to anyone.
    """
    return max(LONG, FAR_DEARER * stencil_seconds(scene, wave)) / SECONDS_PER_WORK


SCHEME = "exponential_adams"
"""The one scheme of the spectral engine."""


def run_spectral(
    scene: Scene, wave: Wave, progress: Progress, announce: Announce
) -> tuple[xr.Dataset, Estimate, float]:
    """The run of a scene to its tolerance, the estimated error, and the seconds of planning.

    What the stencil would look at where its march stops is looked at equidistant times here. Only
    the compared sites are formed, at the times asked for. The run ends where their
    strains are no longer sound. Raises ValueError for a tolerance that cannot be met and for a
    lattice that blows up, UnfinishedRun on Ctrl-C.
    """
    tolerance = scene.target.tolerance
    scene_run = _with_looks(scene)
    recorders = build_recorders(scene_run)
    task = _task(scene_run, wave, recorders, tolerance)
    try:
        solved = spectral_run(task, progress, announce)
    except StoppedSearch as stop:
        raise _stopped(scene, wave, task, stop, recorders) from None
    except RingTooLargeError as error:
        raise ValueError(
            f"tolerance must be larger than {tolerance:g}: it needs {error} "
            "(raise it, end earlier or compare fewer sites)"
        ) from None
    except TooDearError as error:
        raise ValueError(
            f"engine must be 'stencil' for tolerance {tolerance:g}, got 'spectral': the next "
            f"rings alone would take {SECONDS_PER_WORK * error.work:.2g} s, site by site about "
            f"{stencil_seconds(scene, wave):.2g} s (or raise the tolerance)"
        ) from None
    except StepTooShortError as error:
        raise ValueError(
            f"engine must be 'stencil' for tolerance {tolerance:g}, got 'spectral': it needs "
            f"{error} (the wave is hardly longer than the distance of sites)"
        ) from None
    except FloatingPointError as error:
        raise ValueError(
            f"the scene must stay bounded for engine 'spectral': {error} "
            "(take a smaller eps; engine 'stencil' keeps what came before)"
        ) from None
    run = _recorded(scene, wave, solved, recorders)
    return run, solved.estimate, solved.cost.planning_seconds


def _stopped(
    scene: Scene, wave: Wave, task: SpectralTask, stop: StoppedSearch, recorders: list[Recorder]
) -> KeyboardInterrupt:
    """What the best run that is left shows, as far as it got."""
    trial = stop.trial
    if trial is None or trial.values is None:
        return unfinished(None, None, stop.before)
    seen = replace(task, times=task.times[: len(trial.values)])
    unknown = Estimate(math.nan, trial.rounding, math.nan)
    solved = SpectralRun(seen, trial.values, trial.choices, unknown, trial.payload)
    run = _recorded(scene, wave, solved, recorders)
    if seen != task:
        run.attrs["unfinished"] = f"Ctrl-C after t = {seen.times[-1]:g} of {scene.end:g}"
    return unfinished(run, stop.error, stop.before)


def _recorded(
    scene: Scene, wave: Wave, solved: SpectralRun, recorders: list[Recorder]
) -> xr.Dataset:
    reached, fault = _show(scene, wave, solved, recorders)
    variables = {name: value for item in recorders for name, value in item.variables().items()}
    cost = _cost(solved) | {"blow_up": "" if fault is None else str(fault)}
    return build_dataset(scene, reached, variables, cost)


def _with_looks(scene: Scene) -> Scene:
    return replace(scene, look_points=scene.look_points or scene.curve_points)


def _task(
    scene: Scene, wave: Wave, observables: Sequence[Observer], tolerance: float
) -> SpectralTask:
    times = {t for item in observables for t in item.moments.times} | {scene.end}
    return SpectralTask(
        scene.constants,
        wave,
        scene.eps,
        scene.t0,
        tuple(sorted(times)),
        scene.compared,
        tolerance,
        most_spectral_work(scene, wave),
    )


def _show(
    scene: Scene, wave: Wave, solved: SpectralRun, observables: Sequence[Observer]
) -> tuple[tuple[float, ...], BlowUp | None]:
    """Show each observable the compared sites at its moments, as far as they are sound.

    Return the snapshots that were shown and what was wrong afterwards, if anything was.
    """
    amplitude = max(map(abs, solved.cost.strain))
    for index, t in enumerate(solved.task.times):
        sites = solved.task.sites(t)
        state = empty_state(t, int(sites[0]), sites.size)
        state.store(sites, solved.strain(index), np.zeros(sites.size))
        fault = find_blow_up(scene.constants, state, amplitude)
        if fault is not None:
            return tuple(seen for seen in scene.snapshots if seen < t), fault
        view = View(scene, wave, state)
        for item in observables:
            if item.moments.due(t):
                item.see(view)
    return tuple(t for t in scene.snapshots if t <= solved.task.times[-1]), None


def _cost(solved: SpectralRun) -> dict[str, object]:
    cost = solved.cost
    return {
        "engine": "spectral",
        "scheme": SCHEME,
        "order": ORDER,
        "steps": cost.steps,
        "force_evaluations": cost.evaluations,
        "sites": cost.points,
        "circumference": cost.circumference,
        "step": solved.choices.step,
        "seconds": cost.seconds,
    }
