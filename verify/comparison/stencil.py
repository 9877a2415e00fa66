"""What the lattice site by site can be given: scheme, steps, windows and rings.

Measured discretisation errors: the same scene with half the step, with twice the sites.

Running a scene whose step and domain are stated, site by site.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from lattice.schemes.scheme import Scheme, stability_limit
from lattice.state import State
from solutions import Wave
from verify.comparison.domain import (
    Array,
    creeping,
    least_ring,
    least_window,
    seam_room,
    window_moves,
)
from verify.comparison.initial_data import build_wave
from verify.comparison.observables import entry_named
from verify.comparison.observables.entry import View
from verify.comparison.recording import (
    Moments,
    Observable,
    Progress,
    Recorder,
    Recording,
    Variables,
    build_dataset,
    build_recorders,
    moments_of,
    record,
)
from verify.comparison.scene import Scene
from verify.comparison.trust import TOLERANCE
from verify.comparison.unfinished import UnfinishedRun
from verify.comparison.wave_bounds import Extent, find_extent

PREFERRED = "reduced_phase_6"
"""Fewest force evaluations for sup errors from 1e-2 to 1e-9 of those in the table."""

LIMIT_SHARE = 0.9
"""Longest step tried, in units of the stability limit at the largest strain of the wave."""

SIZE_MULTIPLE = 64
"""Sizes are multiples of this, which suits the kernels."""

SEEN = 16
"""Moves of a window at which runs are compared, beside the times that are asked for."""


def extent_of(scene: Scene, wave: Wave) -> Extent:
    """The sites that hold the scene's wave and its compared sites at all times."""
    times = (scene.t0, *scene.snapshots)
    tolerance = scene.tolerance or TOLERANCE
    return find_extent(scene.constants, wave, scene.eps, times, scene.compared, tolerance)


def domain_kind(scene: Scene, wave: Wave) -> str:
    """A window on a constant background, unless something asked for needs a ring."""
    needs_ring = any(entry_named(name).needs_ring for name in scene.observables)
    return "ring" if needs_ring or wave.constant_background is None else "window"


def longest_step(scene: Scene, scheme: Scheme, extent: Extent) -> float:
    """A step that is stable about the wave's largest strain."""
    limit = stability_limit(scheme) / scene.constants.highest_frequency(extent.strain)
    return LIMIT_SHARE * limit


def least_sites(scene: Scene, wave: Wave, domain: str, extent: Extent) -> int:
    """Fewest sites that hold the wave and the compared sites, in a multiple that suits kernels.

    A window's also keep off the rear's signals, which are faster than it on some backgrounds.
    """
    if domain == "ring":
        return round_up(least_ring(scene, extent.strain) + seam_room(wave, scene.eps))
    return round_up(least_window(extent.reach + creeping(scene, wave)))


def round_up(sites: float) -> int:
    """The next multiple of ``SIZE_MULTIPLE``."""
    return SIZE_MULTIPLE * math.ceil(sites / SIZE_MULTIPLE)


def exact_times(scene: Scene) -> tuple[float, ...]:
    """The times that the scene's observables want exactly."""
    entries = map(entry_named, scene.observables)
    times = {t for entry in entries for t in moments_of(scene, entry.seen).times}
    return tuple(sorted(times.union(scene.snapshots)))


def judged_times(scene: Scene, exact: Sequence[float], domain: str) -> tuple[float, ...]:
    """The exact times and, in a window, some of the stops that its moves make anyway."""
    if domain == "ring":
        return tuple(exact)
    moves = [t for t in window_moves(scene) if t < scene.end]
    return tuple(sorted({*moves[:: max(1, len(moves) // SEEN)], *exact}))


def mean_step(stops: Array, step: float, order: int) -> float:
    """The step that would make the same error if the stops did not shorten it.

    Between two stops the steps are equal and at most ``step``.

    >>> mean_step(np.array([0.0, 1.0, 2.0]), 0.9, 6)
    0.5
    """
    gaps = np.diff(stops)
    gaps = gaps[gaps > 0]
    if gaps.size == 0:
        return step
    taken = gaps / np.ceil(gaps / step * (1.0 - 1e-12))
    return float(np.average((taken / step) ** order, weights=gaps) ** (1.0 / order) * step)


def shorter_step(stops: Array, step: float, order: int, ratio: float) -> float:
    """A step whose error falls as that of ``ratio`` times the step, whatever the stops."""
    wanted = ratio * mean_step(stops, step, order)
    found = ratio * step
    while mean_step(stops, found, order) > wanted:
        found *= 0.97
    return found


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
    if measure == "time_step_error":
        return replace(scene, step=scene.step / 2.0, observables=())
    return replace(scene, sites=2 * scene.sites, observables=())


def measured_error(
    scene: Scene, wave: Wave, measure: str, samples: Sequence[Array], progress: Progress
) -> list[float]:
    """Largest difference of y/eps over the compared sites between a run and its refinement.

    One number for each of the snapshots in ``samples``, the strains of the run itself. Raises
    KeyboardInterrupt on Ctrl-C.
    """
    finer = StrainSamples(scene.snapshots[: len(samples)])
    if record(refined(scene, measure), wave, [finer], progress).stopped:
        raise KeyboardInterrupt
    return [
        float(np.max(np.abs(fine - coarse))) / scene.eps
        for coarse, fine in zip(samples, finer.samples, strict=False)
    ]


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
