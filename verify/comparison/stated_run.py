"""Running a scene whose step and domain are stated, site by site.

Discretisation errors are measured on request: the same scene with half the step, with twice the
sites.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from lattice.refine import Progress
from lattice.schemes.scheme import check_step
from lattice.state import State
from lattice.stepper import Domain, Stepper
from verify.comparison.domain import Array, SiteRing, Window
from verify.comparison.moving_wave import MovingWave
from verify.comparison.observables import observable_named
from verify.comparison.recording import (
    Moments,
    Observer,
    Recorder,
    RunRecord,
    UnfinishedRun,
    Variables,
    build_recorders,
)
from verify.comparison.scene import Scene
from verify.comparison.view import View


@dataclass(frozen=True)
class Recording:
    """How far a run got, and what it cost (seconds without compilation).

    ``stopped`` if Ctrl-C ended it.
    """

    stepper: Stepper
    step_limit: float
    seconds: float
    stopped: bool = False


def build_domain(scene: Scene, moving: MovingWave) -> Domain:
    """The domain that the scene states. A closed ring fades where nothing asks for all sites."""
    stated = scene.discretisation
    if stated.domain == "window":
        return Window(moving, stated.sites)
    closed = stated.domain == "closed_ring"
    whole = any(observable_named(name).all_sites for name in scene.observables)
    return SiteRing(moving, stated.sites, closed, fades=closed and not whole)


def prepare(
    scene: Scene, moving: MovingWave, restart: State | None = None
) -> tuple[Stepper, float]:
    """What steps a scene, kernels compiled, and the largest stable step.

    It begins with the scene's initial data, or with the state ``restart`` of an earlier run of the
    same scene. Raises ValueError for a step past the stability limit and for a domain that is too
    small.
    """
    domain, step = build_domain(scene, moving), scene.discretisation.step
    scheme = scene.discretisation.table
    initial = domain.start()
    limit = check_step(step, scheme, scene.constants, initial.y)
    scheme.advance(initial.y, initial.s, step, 0, scene.constants)
    state = initial if restart is None else restart
    amplitude = float(np.max(np.abs(initial.y)))
    return Stepper(state, scheme, scene.constants, domain, step, amplitude), limit


def record(
    scene: Scene,
    moving: MovingWave,
    observers: Sequence[Observer],
    progress: Progress,
    restart: State | None = None,
) -> Recording:
    """Run the scene to its end, a blow-up or Ctrl-C, showing it to each observable at its moments.

    A run from ``restart`` shows nothing before or at the time of that state.
    """
    stepper, step_limit = prepare(scene, moving, restart)
    begin = stepper.state.t
    exact = {t for observer in observers for t in observer.moments.times}
    first = {begin} if restart is None else set()
    times = sorted({t for t in exact if t > begin} | first | {scene.end})
    begun, stopped = time.perf_counter(), False
    try:
        for state in stepper.through(times):
            view = View(moving, state)
            for observer in observers:
                if observer.moments.due(state.t):
                    observer.see(view)
            progress(_share(begin, scene.end, state.t))
    except KeyboardInterrupt:
        stopped = True
    return Recording(stepper, step_limit, time.perf_counter() - begun, stopped)


def _share(begin: float, end: float, t: float) -> float:
    return (t - begin) / (end - begin) if end > begin else 1.0


START_SECONDS = 0.03
"""Before the first step, measured with the planning."""

SECONDS_PER_UPDATE = 6e-10
"""Seconds per site and force evaluation, measured with the planning."""

COST = {"time_step_error": 2.0, "domain_error": 2.0}
"""Work of each re-run relative to the run itself."""


class StrainSamples:
    """Keeps the run's strains on the compared sites, and nothing else."""

    def __init__(self, times: Sequence[float]) -> None:
        self.moments = Moments(tuple(times))
        self.samples: list[Array] = []

    def see(self, view: View) -> None:
        """Keep the strains at one time."""
        self.samples.append(view.numeric)


def refined(scene: Scene, measure: str) -> Scene:
    """The scene with half the step (``time_step_error``) or twice the sites (``domain_error``)."""
    stated = scene.discretisation
    if measure == "time_step_error":
        finer = replace(stated, step=stated.step / 2.0)
    else:
        finer = replace(stated, sites=2 * stated.sites)
    return replace(scene, numerics=finer, observables=())


def measured_error(
    scene: Scene, moving: MovingWave, measure: str, samples: Sequence[Array], progress: Progress
) -> list[float]:
    """Largest difference of y/eps over the compared sites between a run and its refinement.

    One number for each of the snapshots in ``samples``, the strains of the run itself. Raises
    KeyboardInterrupt on Ctrl-C.
    """
    finer = StrainSamples(scene.snapshots[: len(samples)])
    if record(refined(scene, measure), moving, [finer], progress).stopped:
        raise KeyboardInterrupt
    return [
        float(np.max(np.abs(fine - coarse))) / scene.eps
        for coarse, fine in zip(samples, finer.samples, strict=False)
    ]


def run_from(
    scene: Scene,
    moving: MovingWave,
    restart: State | None,
    progress: Progress | None,
    witnesses: Sequence[Observer] = (),
) -> RunRecord:
    """Run from the wave's initial data or from a state of an earlier run of the same scene.

    ``witnesses`` see the run as well; what they see is no part of it. Raises UnfinishedRun with
    what was recorded on Ctrl-C.
    """
    meter = _Meter(scene, progress)
    recorders = build_recorders(scene)
    samples = StrainSamples(scene.snapshots)
    measures = [measure for measure in scene.observables if measure in COST]
    seen: list[Observer] = [*recorders, *witnesses]
    if measures:
        seen.append(samples)
    recording = record(scene, moving, seen, meter.part(1.0), restart)
    variables: Variables = {}
    for recorder in recorders:
        variables |= recorder.variables()
    reached, cost = _reached(scene, recorders, recording), _cost(scene, recording)
    if recording.stopped:
        why = f"Ctrl-C after t = {recording.stepper.state.t:g} of {scene.end:g}"
        raise UnfinishedRun(RunRecord(scene, reached, variables, cost | {"unfinished": why}))
    for measure in measures:
        part = meter.part(COST[measure])
        try:
            values = measured_error(scene, moving, measure, samples.samples, part)
        except KeyboardInterrupt:
            cost["unfinished"] = f"Ctrl-C before the {measure} was measured"
            raise UnfinishedRun(RunRecord(scene, reached, variables, cost)) from None
        attributes = observable_named(measure).variables[0].attributes
        variables[measure] = (("time",), values, attributes)
    return RunRecord(scene, reached, variables, cost)


def _reached(
    scene: Scene, recorders: Sequence[Recorder], recording: Recording
) -> tuple[float, ...]:
    """The snapshots that were recorded; without a recorder for them, those that were passed."""
    if recording.stopped:
        for recorder in recorders:
            if recorder.dimension == "time":
                return tuple(recorder.times)
    elif recording.stepper.blow_up is None:
        return scene.snapshots
    return tuple(t for t in scene.snapshots if t < recording.stepper.state.t)


class _Meter:
    """Turns the progress of each part of the work into progress of the whole."""

    def __init__(self, scene: Scene, progress: Progress | None) -> None:
        self._progress = progress
        self._total = 1.0 + sum(COST.get(name, 0.0) for name in scene.observables)
        self._before = 0.0

    def part(self, cost: float) -> Progress:
        start, self._before = self._before, self._before + cost

        def report(share: float) -> None:
            if self._progress is not None:
                self._progress(min(1.0, (start + share * cost) / self._total))

        return report


def _cost(scene: Scene, recording: Recording) -> dict[str, object]:
    stepper, scheme = recording.stepper, scene.discretisation.table
    return {
        "engine": "stencil",
        "scheme": scheme.name,
        "order": scheme.order,
        "steps": stepper.steps,
        "force_evaluations": stepper.steps * scheme.stages,
        "sites": scene.discretisation.sites,
        "step_limit": recording.step_limit,
        "seconds": recording.seconds,
        "least_strain": stepper.strain[0],
        "most_strain": stepper.strain[1],
        "feed_mismatch": stepper.domain.mismatch,
        "blow_up": "" if stepper.blow_up is None else str(stepper.blow_up),
    }


def stated_seconds(scene: Scene) -> float:
    """What a scene takes that states its step and its sites, with the runs that measure errors."""
    stated = scene.discretisation
    steps = (scene.end - scene.t0) / stated.step
    runs = 1.0 + sum(COST.get(name, 0.0) for name in scene.observables)
    updates = steps * stated.table.stages * stated.sites
    return START_SECONDS + SECONDS_PER_UPDATE * updates * runs
