"""Running a scene whose step and domain are stated, site by site."""

from collections.abc import Sequence

import xarray as xr

from verify.lattice.dataset import build_dataset
from verify.lattice.discretisation import COST, StrainSamples, measured_error
from verify.lattice.initial import build_wave
from verify.lattice.observables import entry_named
from verify.lattice.recorder import Observable, Recorder, Variables, build_recorders
from verify.lattice.recording import Progress, Recording, record
from verify.lattice.scene import Scene
from verify.lattice.state import State
from verify.lattice.unfinished import UnfinishedRun


def run_from(
    scene: Scene,
    restart: State | None,
    progress: Progress | None,
    witnesses: Sequence[Observable] = (),
) -> xr.Dataset:
    """Run from the scene's initial data or from a state of an earlier run of the same scene.

    ``witnesses`` see the run as well; what they see is no part of it. Raises UnfinishedRun with
    what was recorded on Ctrl-C.
    """
    meter = _Meter(scene, progress)
    wave = build_wave(scene)
    recorders = build_recorders(scene)
    samples = StrainSamples(scene.snapshots)
    measures = [measure for measure in scene.observables if measure in COST]
    seen: list[Observable] = [*recorders, *witnesses]
    if measures:
        seen.append(samples)
    recording = record(scene, wave, seen, meter.part(1.0), restart)
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
            values = measured_error(scene, wave, measure, samples.samples, part)
        except KeyboardInterrupt:
            cost["unfinished"] = f"Ctrl-C before the {measure} was measured"
            raise UnfinishedRun(build_dataset(scene, reached, variables, cost)) from None
        attributes = entry_named(measure).variables[0].attributes
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
    march, scheme = recording.march, scene.scheme_table
    return {
        "engine": "stencil",
        "scheme": scheme.name,
        "order": scheme.order,
        "steps": march.steps,
        "force_evaluations": march.steps * scheme.stages,
        "sites": scene.sites,
        "step_limit": recording.step_limit,
        "seconds": recording.seconds,
        "least_strain": march.strain[0],
        "most_strain": march.strain[1],
        "feed_mismatch": march.domain.mismatch,
        "blow_up": "" if march.blow_up is None else str(march.blow_up),
    }
