"""Running a scene."""

from importlib.metadata import version

import xarray as xr

from verify.lattice.discretisation import COST, StrainSamples, measured_error
from verify.lattice.initial import build_wave
from verify.lattice.observables import axis_values, entry_named
from verify.lattice.recorder import Observable, Variables, build_recorders
from verify.lattice.recording import Progress, Recording, record
from verify.lattice.scene import Scene
from verify.lattice.state import State

PACKAGES = ("longwave", "numpy", "numba", "sympy", "xarray")


def run(scene: Scene, progress: Progress | None = None) -> xr.Dataset:
    """Run the scene and return what it asks for.

    Dimensions: ``time`` (the snapshots), ``curve_time``, ``look_time``, ``site`` (offset from the
    site nearest to c t) and what else the observables add. The table of observables
    (`observables/table.py`) says which variables each of them adds; none other is there.

    Attributes: the scene as JSON, versions, cost, and ``blow_up`` (empty if there was none). A run
    that blows up keeps the times before it. ``progress`` is called with the share of the work
    that is done, 0 .. 1.

    Raises ValueError for every input that the scene's wave, lattice or scheme do not admit.
    """
    return run_from(scene, None, progress)


def run_from(scene: Scene, restart: State | None, progress: Progress | None) -> xr.Dataset:
    """``run`` from the scene's initial data or from a state of an earlier run of it."""
    meter = _Meter(scene, progress)
    wave = build_wave(scene)
    recorders = build_recorders(scene)
    samples = StrainSamples(scene.snapshots)
    measures = [measure for measure in scene.observables if measure in COST]
    seen: list[Observable] = [*recorders, samples] if measures else [*recorders]
    recording = record(scene, wave, seen, meter.part(1.0), restart)
    variables: Variables = {}
    for recorder in recorders:
        variables |= recorder.variables()
    for measure in measures:
        part = meter.part(COST[measure])
        values = measured_error(scene, wave, measure, samples.samples, part)
        attributes = entry_named(measure).variables[0].attributes
        variables[measure] = (("time",), values, attributes)
    return _dataset(scene, recording, variables)


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


def _dataset(scene: Scene, recording: Recording, variables: Variables) -> xr.Dataset:
    reached = scene.snapshots
    if recording.march.blow_up is not None:
        reached = tuple(t for t in reached if t < recording.march.state.t)
    coordinates: dict[str, object] = {"time": ("time", list(reached), {"units": "lattice time"})}
    for dimension in {name for dimensions, _, _ in variables.values() for name in dimensions}:
        axis = axis_values(dimension, scene.compared)
        if axis is not None:
            coordinates[dimension] = (dimension, *axis)
    names = {name for name, (dimensions, _, _) in variables.items() if dimensions == (name,)}
    coordinates |= {name: variables[name] for name in names}
    data = {name: value for name, value in variables.items() if name not in names}
    return xr.Dataset(data, coordinates, _attributes(scene, recording))


def _attributes(scene: Scene, recording: Recording) -> dict[str, object]:
    march, scheme = recording.march, scene.scheme_table
    return {
        "scene": scene.json(),
        "title": scene.title or scene.name,
        "engine": "stencil",
        "scheme": scheme.name,
        "order": scheme.order,
        "steps": march.steps,
        "force_evaluations": march.steps * scheme.stages,
        "sites": scene.sites,
        "step_limit": recording.step_limit,
        "seconds": recording.seconds,
        "feed_mismatch": march.domain.mismatch,
        "blow_up": "" if march.blow_up is None else str(march.blow_up),
        "versions": ", ".join(f"{package} {version(package)}" for package in PACKAGES),
    }
