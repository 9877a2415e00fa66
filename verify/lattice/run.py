"""Running a scene."""

from importlib.metadata import version

import numpy as np
import xarray as xr

from verify.lattice.discretisation import COST, StrainSamples, measured_error
from verify.lattice.initial import build_wave
from verify.lattice.observables import Observable, Variables, build_observables
from verify.lattice.recording import Progress, Recording, record
from verify.lattice.scene import Scene

PACKAGES = ("longwave", "numpy", "numba", "sympy", "xarray")
MEASURED = {"units": "strain / eps", "long_name": "sup difference to the refined run"}


def run(scene: Scene, progress: Progress | None = None) -> xr.Dataset:
    """Run the scene and return what it asks for.

    Dimensions: ``time`` (the snapshots), ``site`` (offset from the site nearest to c t) and
    ``curve_time``. Variables, each only if its observable is asked for:

    * strain: ``strain``, ``analytic``, ``background`` (time, site), ``n`` (the site's number on
      the lattice), ``error`` and, on periodic backgrounds, ``error_far_field`` (time);
    * error_curve: ``error_curve``, ``error_curve_far_field`` (curve_time);
    * energy: ``energy`` (energy_time);
    * time_step_error, domain_error (time): sup difference of y/eps to the run with half the step,
      with twice the sites.

    Attributes: the scene as JSON, versions, cost, and ``blow_up`` (empty if there was none). A run
    that blows up keeps the times before it. ``progress`` is called with the share of the work
    that is done, 0 .. 1.

    Raises ValueError for every input that the scene's wave, lattice or scheme do not admit.
    """
    meter = _Meter(scene, progress)
    wave = build_wave(scene)
    observables = build_observables(scene)
    samples = StrainSamples(scene.snapshots)
    measures = [measure for measure in scene.observables if measure in COST]
    seen: list[Observable] = [*observables, samples] if measures else observables
    recording = record(scene, wave, seen, meter.part(1.0))
    variables: Variables = {}
    for observable in observables:
        variables |= observable.variables()
    for measure in measures:
        part = meter.part(COST[measure])
        values = measured_error(scene, wave, measure, samples.samples, part)
        variables[measure] = (("time",), values, MEASURED)
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
    if "strain" in variables:
        offsets = np.arange(-scene.compared, scene.compared + 1)
        coordinates["site"] = ("site", offsets, {"long_name": "offset from the site nearest c t"})
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
        "blow_up": "" if march.blow_up is None else str(march.blow_up),
        "versions": ", ".join(f"{package} {version(package)}" for package in PACKAGES),
    }
