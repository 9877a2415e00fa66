"""Run a scene cell by cell with given step and domain, and measure its observables.

Discretisation errors are measured by a second run with half the step or twice the sites.
"""

from __future__ import annotations

import time
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from longwave.scenes.engines.recorders import (
    Observer,
    Recorder,
    Samples,
    build_recorders,
    exact_times,
    recorded_variables,
)
from longwave.scenes.engines.run_record import RunRecord, UnfinishedRun, stencil_cost
from longwave.scenes.observed.observables import observable_named
from longwave.support.checkpoint import Memory, begin_loop
from longwave.support.real_arrays import Array

if TYPE_CHECKING:
    from longwave.lattice.state import State
    from longwave.lattice.stepper import Stepper
    from longwave.lattice.trial import Progress
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.engines.stepped_cells import SteppedCells


@dataclass(frozen=True)
class Recording:
    """Outcome of a run: its stepper, which holds the last state, and its seconds.

    ``step_limit`` is the largest stable step; ``stopped`` is true if Ctrl-C ended the run.
    """

    stepper: Stepper
    step_limit: float
    seconds: float
    stopped: bool = False


def record(
    stepped: SteppedCells,
    observers: Sequence[Observer],
    progress: Progress,
    restart: State | None = None,
    stops: Collection[float] = (),
) -> Recording:
    """Run the scene to its end, a blow-up or Ctrl-C; each observer measures at its own times.

    A run from the state ``restart`` is measured only after the time of that state. ``stops`` are
    further times that the steps hit exactly.
    """
    scene = stepped.scene
    stepper, step_limit = stepped.stepper(restart)
    begin = stepper.state.t
    exact = {t for observer in observers for t in observer.moments.times}.union(stops)
    first = {begin} if restart is None else set()
    times = sorted({t for t in exact if t > begin} | first | {scene.end})
    loop, stopped = begin_loop(f"{stepped.task} from {begin!r}"), False
    if loop.memory is not None:
        stepper.recall(loop.memory)
        for observer, memory in zip(observers, loop.memory["observers"], strict=True):
            observer.recall(memory)
        times = [t for t in times if t > stepper.state.t]

    def checkpoint(arrays: bool = True) -> Memory:
        return stepper.memory(arrays) | {"observers": [one.memory() for one in observers]}

    try:
        for state in stepper.stops(times) if times else ():
            view = stepped.view(state)
            for observer in observers:
                if observer.moments.is_due(state.t):
                    observer.observe(view)
            progress((state.t - begin) / (scene.end - begin) if scene.end > begin else 1.0)
            if state.t < scene.end:
                loop.offer(checkpoint)
    except KeyboardInterrupt:
        stopped = True
    if times and not stopped and stepper.blow_up is None:
        loop.end(lambda: checkpoint(arrays=False))
    return Recording(stepper, step_limit, time.perf_counter() - loop.begun, stopped)


REFINED_COST = 2.0
"""Work of a run with half the step or twice the sites, relative to the run itself."""


def refinements(scene: Scene) -> list[str]:
    """Return the observables of a scene that need a second, refined run."""
    return [
        name for name in scene.observables if observable_named(name).measured_at == "refinement"
    ]


def refined_scene(scene: Scene, measure: str) -> Scene:
    """Return the scene with half the step for ``measure`` time_step_error, else twice the sites."""
    stated = scene.discretisation
    if measure == "time_step_error":
        finer = replace(stated, step=stated.step / 2.0)
    else:
        finer = replace(stated, sites=2 * stated.sites)
    return replace(scene, numerics=finer, observables=())


def measured_error(
    stepped: SteppedCells, measure: str, samples: Sequence[Array], progress: Progress
) -> list[float]:
    """Run the refined scene and return its largest difference from the run at each snapshot.

    ``samples`` are the compared values of the run at its snapshots. Differences are in units of the
    wave's scale. Both runs fit their steps to the same times. Raises KeyboardInterrupt on Ctrl-C.
    """
    scene = stepped.scene
    finer = Samples(scene.snapshots[: len(samples)])
    again = stepped.refined(refined_scene(scene, measure))
    if record(again, [finer], progress, stops=exact_times(scene)).stopped:
        raise KeyboardInterrupt
    return [
        float(np.max(np.abs(fine - coarse))) / stepped.scale
        for coarse, fine in zip(samples, finer.samples, strict=False)
    ]


def run_from(
    stepped: SteppedCells,
    restart: State | None,
    progress: Progress | None,
    witnesses: Sequence[Observer] = (),
) -> RunRecord:
    """Run from the wave's initial data, or from a state of an earlier run of the same scene.

    ``witnesses`` are further observers whose values are not part of the record. Raises
    UnfinishedRun with the values recorded so far on Ctrl-C.
    """
    scene = stepped.scene
    measures = refinements(scene)
    whole, *parts = _split_progress(
        progress or (lambda _: None), [1.0, *[REFINED_COST] * len(measures)]
    )
    recorders = build_recorders(scene)
    samples = Samples(scene.snapshots)
    observers: list[Observer] = [*recorders, *witnesses]
    if measures:
        observers.append(samples)
    recording = record(stepped, observers, whole, restart)
    variables, stepper = recorded_variables(recorders), recording.stepper
    sites, limit = scene.discretisation.sites, recording.step_limit
    facts = stepper.scheme, stepper.steps, sites, recording.seconds, stepper.blow_up
    cost = stencil_cost(*facts, step_limit=limit) | stepped.attributes(stepper)
    run = RunRecord(scene, stepped.reach, _reached(scene, recorders, recording), variables, cost)
    if recording.stopped:
        cost["unfinished"] = f"Ctrl-C after t = {recording.stepper.state.t:g} of {scene.end:g}"
        raise UnfinishedRun(run)
    for measure, part in zip(measures, parts, strict=True):
        try:
            values = measured_error(stepped, measure, samples.samples, part)
        except KeyboardInterrupt:
            cost["unfinished"] = f"Ctrl-C before the {measure} was measured"
            raise UnfinishedRun(run) from None
        attributes = observable_named(measure).variables[0].attributes
        variables[measure] = (("time",), values, attributes)
    return run


def _reached(
    scene: Scene, recorders: Sequence[Recorder], recording: Recording
) -> tuple[float, ...]:
    """Return the recorded snapshots, or the snapshots reached if no observable needs any."""
    if recording.stopped:
        for recorder in recorders:
            if recorder.dimension == "time":
                return tuple(recorder.times)
    elif recording.stepper.blow_up is None:
        return scene.snapshots
    return tuple(t for t in scene.snapshots if t < recording.stepper.state.t)


def _split_progress(progress: Progress, costs: Sequence[float]) -> list[Progress]:
    """Return a progress callback for each part of a run, which reports the whole run's progress."""

    def part(start: float, cost: float) -> Progress:
        return lambda share: progress(min(1.0, (start + share * cost) / sum(costs)))

    return [part(sum(costs[:index]), cost) for index, cost in enumerate(costs)]
