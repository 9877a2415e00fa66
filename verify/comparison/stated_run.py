"""Running a scene whose step and domain are stated, site by site.

Discretisation errors are measured on request: the same scene with half the step, with twice the
sites.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from lattice.state import State
from verify.comparison.domain import Array
from verify.comparison.moving_wave import MovingWave
from verify.comparison.observables import observable_named
from verify.comparison.recording import (
    Moments,
    Observer,
    Progress,
    Recorder,
    Recording,
    UnfinishedRun,
    Variables,
    build_dataset,
    build_recorders,
    record,
)
from verify.comparison.scene import Scene
from verify.comparison.view import View

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

    def variables(self) -> Variables:
        """Nothing: the samples are only compared."""
        return {}


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
) -> xr.Dataset:
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
        why = f"Ctrl-C after t = {recording.march.state.t:g} of {scene.end:g}"
        raise UnfinishedRun(build_dataset(scene, reached, variables, cost | {"unfinished": why}))
    for measure in measures:
        part = meter.part(COST[measure])
        try:
            values = measured_error(scene, moving, measure, samples.samples, part)
        except KeyboardInterrupt:
            cost["unfinished"] = f"Ctrl-C before the {measure} was measured"
            raise UnfinishedRun(build_dataset(scene, reached, variables, cost)) from None
        attributes = observable_named(measure).variables[0].attributes
        variables[measure] = (("time",), values, attributes)
    return build_dataset(scene, reached, variables, cost)


def _reached(
    scene: Scene, recorders: Sequence[Recorder], recording: Recording
) -> tuple[float, ...]:
    """The snapshots that were recorded; without a recorder for them, those that were passed."""
    if recording.stopped:
        for recorder in recorders:
            if recorder.dimension == "time":
                return tuple(recorder.times)
    elif recording.march.blow_up is None:
        return scene.snapshots
    return tuple(t for t in scene.snapshots if t < recording.march.state.t)


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
    march, scheme = recording.march, scene.discretisation.table
    return {
        "engine": "stencil",
        "scheme": scheme.name,
        "order": scheme.order,
        "steps": march.steps,
        "force_evaluations": march.steps * scheme.stages,
        "sites": scene.discretisation.sites,
        "step_limit": recording.step_limit,
        "seconds": recording.seconds,
        "least_strain": march.strain[0],
        "most_strain": march.strain[1],
        "feed_mismatch": march.domain.mismatch,
        "blow_up": "" if march.blow_up is None else str(march.blow_up),
    }


def stated_seconds(scene: Scene) -> float:
    """What a scene takes that states its step and its sites, with the runs that measure errors."""
    stated = scene.discretisation
    steps = (scene.end - scene.t0) / stated.step
    runs = 1.0 + sum(COST.get(name, 0.0) for name in scene.observables)
    updates = steps * stated.table.stages * stated.sites
    return START_SECONDS + SECONDS_PER_UPDATE * updates * runs
