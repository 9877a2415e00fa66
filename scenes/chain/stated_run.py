"""Running a scene whose step and domain are stated, site by site, for observers at their moments.

Recorders measure what the scene asks for; the record of a run holds what was recorded, with the
scene, the versions and the cost, and so does what Ctrl-C leaves of a run. A data set is made of it
where one is asked for. Discretisation errors are measured on request: the same scene with half the
step, with twice the sites.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.model import Domain, State
from longwave.lattice.schemes import check_step
from longwave.lattice.stepper import Stepper, advance
from longwave.lattice.trial import Progress
from longwave.scenes.chain.domain import Array, SiteRing, Window
from longwave.scenes.chain.moving_wave import MovingWave
from longwave.scenes.chain.observables import (
    TIME,
    axis_values,
    observable_named,
)
from longwave.scenes.chain.recorders import (
    Observer,
    Recorder,
    StrainSamples,
    Variables,
    build_recorders,
)
from longwave.scenes.chain.view import View
from longwave.scenes.scene import Scene
from longwave.support.checkpoint import Memory, begin_loop
from longwave.support.provenance import provenance

if TYPE_CHECKING:
    import xarray as xr


@dataclass
class RunRecord:
    """A run of ``scene`` as it was recorded: a `Dataset` before anyone needs one.

    ``reached`` are the snapshots that were got to; ``attrs`` is what was told of the run, its cost
    first, and may be added to until the data set is made. ``asked`` is the scene that was asked
    for, if step and domain of ``scene`` were chosen.
    """

    scene: Scene
    reached: Sequence[float]
    variables: Variables
    attrs: dict[str, Any]
    asked: Scene | None = None

    def values(self, name: str) -> NDArray[Any]:
        """The values of a variable, in the order of its times."""
        return np.asarray(self.variables[name][1])

    @cached_property
    def dataset(self) -> "xr.Dataset":
        """The run with its coordinates, the scene and what made it."""
        import xarray as xr  # 0.4 s, for those who want a data set

        used = {name for dimensions, _, _ in self.variables.values() for name in dimensions}
        axes = {name: axis_values(name, self.scene.compared) for name in used}
        coordinates: dict[str, object] = {"time": ("time", list(self.reached), TIME)}
        coordinates |= {name: (name, *axis) for name, axis in axes.items() if axis is not None}
        names = {name for name, (found, _, _) in self.variables.items() if found == (name,)}
        coordinates |= {name: self.variables[name] for name in names}
        data = {name: value for name, value in self.variables.items() if name not in names}
        asked = self.asked or self.scene
        attributes = {
            "title": asked.title or asked.name,
            "scene": asked.toml(),
            **({} if asked is self.scene else {"plan": self.scene.toml()}),
            **self.attrs,
            **provenance(),
        }
        return xr.Dataset(data, coordinates, attributes)


class UnfinishedRun(KeyboardInterrupt):
    """Ctrl-C during a run, which had recorded something: ``run``, and ``record`` before it.

    The run's attribute ``unfinished`` says why it is not what the scene asks for.
    """

    def __init__(self, record: RunRecord) -> None:
        super().__init__("interrupted")
        self.record = record

    @property
    def run(self) -> "xr.Dataset":
        """What was recorded."""
        return self.record.dataset


def unfinished(
    run: RunRecord | None, error: float | None, planning_seconds: float
) -> KeyboardInterrupt:
    """The best run of a search that Ctrl-C ended; ``error`` is its estimated one, if measured."""
    if run is None:
        return KeyboardInterrupt("before anything was recorded")
    run.attrs["planning_seconds"] = planning_seconds
    why = run.attrs.get("unfinished", "Ctrl-C before the tolerance was met")
    if error is None:
        run.attrs["unfinished"] = f"{why}, its error not estimated"
    else:
        run.attrs |= {"unfinished": why, "error_estimate": error}
    return UnfinishedRun(run)


@dataclass(frozen=True)
class Recording:
    """How far a run got, and what it cost (seconds without compilation).

    ``stopped`` if Ctrl-C ended it.
    """

    stepper: Stepper[State]
    step_limit: float
    seconds: float
    stopped: bool = False


def build_domain(scene: Scene, moving: MovingWave) -> Domain[State]:
    """The domain that the scene states. A closed ring fades where nothing asks for all sites."""
    stated = scene.discretisation
    if stated.domain == "window":
        return Window(moving, stated.sites)
    closed = stated.domain == "closed_ring"
    whole = any(observable_named(name).all_sites for name in scene.observables)
    return SiteRing(moving, stated.sites, closed, fades=closed and not whole)


def prepare(
    scene: Scene, moving: MovingWave, restart: State | None = None
) -> tuple[Stepper[State], float]:
    """What steps a scene, kernels compiled, and the largest stable step.

    It begins with the scene's initial data, or with the state ``restart`` of an earlier run of the
    same scene. Raises ValueError for a step past the stability limit and for a domain that is too
    small.
    """
    domain, step = build_domain(scene, moving), scene.discretisation.step
    scheme = scene.discretisation.table
    initial = domain.start()
    limit = check_step(step, scheme, scene.model.highest_frequency(initial.y))
    advance(scheme, initial.y, initial.s, step, 0, scene.model)
    state = initial if restart is None else restart
    amplitude = float(np.max(np.abs(initial.y)))
    return Stepper(state, scheme, scene.model, domain, step, amplitude), limit


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
    loop, stopped = begin_loop(f"{scene.json()} from {begin!r}"), False
    if loop.memory is not None:
        stepper.recall(loop.memory)
        for observer, memory in zip(observers, loop.memory["observers"], strict=True):
            observer.recall(memory)
        times = [t for t in times if t > stepper.state.t]

    def remember(arrays: bool = True) -> Memory:
        return stepper.memory(arrays) | {"observers": [one.memory() for one in observers]}

    try:
        for state in stepper.through(times) if times else ():
            view = View(moving, state)
            for observer in observers:
                if observer.moments.due(state.t):
                    observer.see(view)
            progress(_share(begin, scene.end, state.t))
            if state.t < scene.end:
                loop.offer(remember)
    except KeyboardInterrupt:
        stopped = True
    if times and not stopped and stepper.blow_up is None:
        loop.end(lambda: remember(arrays=False))
    return Recording(stepper, step_limit, time.perf_counter() - loop.begun, stopped)


def _share(begin: float, end: float, t: float) -> float:
    return (t - begin) / (end - begin) if end > begin else 1.0


START_SECONDS = 0.03
"""Before the first step, measured with the planning."""

PROCESS_SECONDS = 1.0
"""For imports, what is loaded and what is written, once in a process."""

SECONDS_PER_UPDATE = 6e-10
"""Seconds per site and force evaluation, measured with the planning."""

REFINED_COST = 2.0
"""Work of a run with half the step or twice the sites, relative to the run itself."""


def refinements(scene: Scene) -> list[str]:
    """The observables that are measured by running the scene again."""
    return [name for name in scene.observables if observable_named(name).seen == "refinement"]


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
    measures = refinements(scene)
    whole, *parts = _parts(progress or (lambda _: None), [1.0, *[REFINED_COST] * len(measures)])
    recorders = build_recorders(scene)
    samples = StrainSamples(scene.snapshots)
    seen: list[Observer] = [*recorders, *witnesses]
    if measures:
        seen.append(samples)
    recording = record(scene, moving, seen, whole, restart)
    variables: Variables = {}
    for recorder in recorders:
        variables |= recorder.variables()
    reached, cost = _reached(scene, recorders, recording), _cost(scene, recording)
    if recording.stopped:
        why = f"Ctrl-C after t = {recording.stepper.state.t:g} of {scene.end:g}"
        raise UnfinishedRun(RunRecord(scene, reached, variables, cost | {"unfinished": why}))
    for measure, part in zip(measures, parts, strict=True):
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


def _parts(progress: Progress, costs: Sequence[float]) -> list[Progress]:
    """The progress of each part of the work, as progress of the whole."""

    def part(start: float, cost: float) -> Progress:
        return lambda share: progress(min(1.0, (start + share * cost) / sum(costs)))

    return [part(sum(costs[:place]), cost) for place, cost in enumerate(costs)]


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
        "least_strain": float(stepper.ranges[0, 0]),
        "most_strain": float(stepper.ranges[0, 1]),
        "feed_mismatch": stepper.domain.mismatch,
        "blow_up": "" if stepper.blow_up is None else str(stepper.blow_up),
    }


def stated_seconds(scene: Scene) -> float:
    """What a scene takes that states its step and its sites, with the runs that measure errors."""
    stated = scene.discretisation
    steps = (scene.end - scene.t0) / stated.step
    runs = 1.0 + REFINED_COST * len(refinements(scene))
    updates = steps * stated.table.stages * stated.sites
    return START_SECONDS + SECONDS_PER_UPDATE * updates * runs
