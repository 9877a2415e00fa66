"""A scene at constants sampled from their covariance, and its observables with intervals.

An observable's interval has three parts: the uncertainty of the measured constants (quantiles of
the samples), the deviation of theory from the lattice where a wave is compared, and the error of
the runs themselves.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from longwave.derive.intervals import LEVEL, rounded
from longwave.derive.measured import Measured
from longwave.derive.symbols import number_value
from longwave.runs.run_file import file_content
from longwave.runs.sweep_file import MAX_CELLS, SAMPLE, Sweep, SweptDimension
from longwave.scenes.description.bench import MEAN_SUFFIXES
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import whole
from longwave.support.atomic_file import write_atomically
from longwave.support.user_files import shown

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from longwave.runs.run_store import RunStore

QUANTILES = ((1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2)
"""Reported quantiles: lower end of the interval, median, upper end."""

MIN_SAMPLES = 39
"""Least number of samples: the smallest and largest of 39 are the ends of a 95 % interval."""

EXCLUDED = ("slow_time", "error", "sup_error", "error_far_field", "time_step_error", "domain_error")
"""Variables of a run that get no interval: slow time, and errors, which are parts of intervals."""


def sampled_sweep(source: str | Path | Scene, samples: int, seed: int = 0) -> Sweep:
    """Return a sweep over constants sampled from the covariance in the scene's lattice file.

    Errors are taken as normal. Constants that the scene overrides are exact. A larger number of
    samples starts with the same ones. Raises ValueError in one line for a scene without such
    constants, or with too few samples.
    """
    scene = source if isinstance(source, Scene) else load_scene(source)
    count = whole("samples", samples, 1)
    if not MIN_SAMPLES <= count <= MAX_CELLS:
        got = f"{count} ({MIN_SAMPLES} are the fewest that have a 95 % interval)"
        raise ValueError(f"samples must be {MIN_SAMPLES} to {MAX_CELLS}, got {got}")
    if isinstance(seed, bool) or not isinstance(seed, int):
        raise ValueError(f"seed must be a whole number, got {shown(seed)} (such as 1)")
    measured = scene.symbolic_lattice.measured or Measured.of({}, {})
    stated = dict(scene.constants)
    varied = {
        name: index
        for index, (name, value) in enumerate(measured.values)
        if measured.deviations[name] and number_value(name, stated[name]) == value
    }
    if not varied:
        raise ValueError(
            f"scene must take constants with a covariance from its lattice file, got {scene.name} "
            "(`longwave fit` writes such a file; a [covariance] may be added to any)"
        )
    samples_of_all = measured.samples(count, seed)
    rows = tuple(tuple(sample[i] for i in varied.values()) for sample in samples_of_all)
    dimension = SweptDimension(SAMPLE, tuple(f"constants.{name}" for name in varied), rows)
    title = f"{scene.title or scene.name}: {count} samples of {', '.join(varied)}"
    document = tomllib.loads(scene.toml())
    return Sweep(f"{scene.name}_samples", scene.name, document, (dimension,), title=title)


@dataclass(frozen=True)
class ObservedNumber:
    """An observable number of a scene at all samples; NaN for a sample without a run.

    ``reduction`` is the largest deviation of theory from the lattice, ``numerics`` the largest
    estimated error of a run. They are NaN where no wave is compared, or no error was measured.
    """

    name: str
    samples: NDArray[np.float64]
    reduction: float = math.nan
    numerics: float = math.nan

    @property
    def ends(self) -> tuple[float, float, float]:
        """Lower end of the interval, median, upper end."""
        low, median, high = _quantiles(self.samples).tolist()
        return low, median, high

    def text(self) -> str:
        """Return the median with the parts of its interval, as one line."""
        low, median, high = self.ends
        sizes = {"data": (high - low) / 2, "reduction": self.reduction, "numerics": self.numerics}
        largest = max(size for size in sizes.values() if not math.isnan(size))
        shown_sizes = (f"+- {size:.2g} ({name})" for name, size in sizes.items() if size == size)
        return " ".join([self.name, rounded(median, largest), *shown_sizes])


def _quantiles(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return lower end, median and upper end along the first axis, ignoring samples without a run.

    They are order statistics: a new sample lies between the ends in 95 % of all cases, whether
    there are few samples or many.
    """
    if not np.isfinite(samples).any():
        return np.full((len(QUANTILES), *samples.shape[1:]), math.nan)
    return np.asarray(np.nanquantile(samples, QUANTILES, axis=0, method="weibull"))


def observed_numbers(
    sweep: Sweep, store: RunStore, dataset: xr.Dataset
) -> Iterator[ObservedNumber]:
    """Yield the observable numbers of a sampled scene from its data set with the runs' fields.

    A wave gives its crest at the last time, a sensor its largest reading, and any other variable
    over time its last value.
    """
    from longwave.runs.sweep_dataset import cell_run

    done = np.flatnonzero(dataset["status"].values == "done")
    if not done.size:
        return
    scene, run = sweep.scene(0), cell_run(sweep, store, sample=int(done[0]))
    estimates = dataset["error_estimate"].values[done] * scene.eps ** run.attrs.get("power", 1)
    numerics = float(np.max(estimates))
    if {"strain", "analytic", "background"} <= set(dataset):
        last = dataset.isel(time=-1)
        lattice, theory = (
            np.asarray(np.abs(last[name] - last["background"])).reshape(dataset.sizes[SAMPLE], -1)
            for name in ("strain", "analytic")
        )
        lattice, theory = lattice.max(axis=1), theory.max(axis=1)
        yield ObservedNumber("crest", lattice, float(np.nanmax(np.abs(lattice - theory))), numerics)
    for label, samples in _readings(dataset):
        yield ObservedNumber(label, samples, numerics=numerics if scene.bench else math.nan)


def _readings(dataset: xr.Dataset) -> Iterator[tuple[str, NDArray[np.float64]]]:
    """Yield (label, samples) of each sensor's largest reading and other variables' last values."""
    for name in map(str, dataset.data_vars):
        values, label = dataset[name], name.replace("_", " ")
        inner_dims = values.dims[1:]
        if name.endswith(MEAN_SUFFIXES):
            continue
        if name.startswith("sensor_"):
            for index, site in enumerate(dataset["sensor"].values):
                readings = np.abs(values.isel(sensor=index).values).reshape(values.shape[0], -1)
                yield f"cell {site}: largest {name.removeprefix('sensor_')}", readings.max(axis=1)
        elif inner_dims == ("time",) and name.removeprefix("run_") not in EXCLUDED:
            yield label, values.values[:, -1]
        elif inner_dims == ("time", "mode"):
            for index, mode in enumerate(dataset["mode"].values):
                yield f"{label} {mode}", values.values[:, -1, index]


def write_samples(
    sweep: Sweep, store: RunStore, path: str | Path
) -> tuple[xr.Dataset, list[ObservedNumber]]:
    """Write the data set of a sampled scene as NetCDF-4; return it and the observable numbers.

    Each variable of the runs gets its interval at every index: ``strain_interval(quantile, ...)``.
    Raises OSError, naming the file.
    """
    from longwave.runs.sweep_dataset import sweep_dataset

    dataset = sweep_dataset(sweep, store)
    numbers = list(observed_numbers(sweep, store, dataset))
    intervals: dict[str, Any] = {}
    for name, values in dataset.data_vars.items():
        if values.dims[:1] == (SAMPLE,) and values.ndim > 1 and values.dtype.kind == "f":
            attrs = {**values.attrs, "comment": f"of {SAMPLE}s, at the quantiles"}
            dims = ("quantile", *values.dims[1:])
            intervals[f"{name}_interval"] = (dims, _quantiles(values.values), attrs)
    cell_numbers = [name for name, values in dataset.data_vars.items() if values.dims == (SAMPLE,)]
    result = dataset[cell_numbers].assign_coords(quantile=list(QUANTILES)).assign(intervals)
    content = file_content(result)
    write_atomically(Path(path), lambda draft: draft.write_bytes(content))
    return result, numbers
