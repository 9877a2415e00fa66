"""A scene on the spectral ring: what it asks for, seen through the ring's interpolation."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from lattice.refine import Announce, StoppedSearch, TooDearError
from lattice.spectral.exponential import ORDER
from lattice.state import BlowUp, empty_state, find_blow_up
from lattice.trial import Estimate
from solutions import Wave
from verify.comparison.engine_choice import RATES, most_spectral_work, stencil_seconds
from verify.comparison.error import Comparison
from verify.comparison.recording import (
    Observable,
    Progress,
    Recorder,
    build_dataset,
    build_recorders,
)
from verify.comparison.scene import Scene
from verify.comparison.spectral_search import (
    RingTooLargeError,
    SpectralRun,
    SpectralTask,
    StepTooShortError,
    spectral_run,
)
from verify.comparison.unfinished import unfinished

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
    assert scene.tolerance is not None
    scene_run = _with_looks(scene)
    recorders = build_recorders(scene_run)
    task = _task(scene_run, wave, recorders, scene.tolerance)
    try:
        solved = spectral_run(task, progress, announce)
    except StoppedSearch as stop:
        raise _stopped(scene, wave, task, stop, recorders) from None
    except RingTooLargeError as error:
        raise ValueError(
            f"tolerance must be larger than {scene.tolerance:g}: it needs {error} "
            "(raise it, end earlier or compare fewer sites)"
        ) from None
    except TooDearError as error:
        raise ValueError(
            f"engine must be 'stencil' for tolerance {scene.tolerance:g}, got 'spectral': the next "
            f"rings alone would take {RATES.spectral * error.work:.2g} s, site by site about "
            f"{stencil_seconds(scene, wave):.2g} s (or raise the tolerance)"
        ) from None
    except StepTooShortError as error:
        raise ValueError(
            f"engine must be 'stencil' for tolerance {scene.tolerance:g}, got 'spectral': it needs "
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
    scene: Scene, wave: Wave, observables: Sequence[Observable], tolerance: float
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
    scene: Scene, wave: Wave, solved: SpectralRun, observables: Sequence[Observable]
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
        view = Comparison(scene, wave, state)
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
