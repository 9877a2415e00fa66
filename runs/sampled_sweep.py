"""A scene at constants drawn from their covariance, and its observables with their intervals.

An observable's interval has three parts: what the errors of the measured constants leave open (the
quantiles of the samples), by how much theory misses the lattice where a wave is compared, and how
far the runs themselves may be off.
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
from longwave.runs.sweep_file import MOST_CELLS, SAMPLE, Sweep, SweptDimension
from longwave.scenes.description.bench import OF_MEANS
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import whole
from longwave.support.atomic_file import write_atomically
from longwave.support.user_files import shown

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

    from longwave.runs.run_store import RunStore

ENDS = ((1 - LEVEL) / 2, 0.5, (1 + LEVEL) / 2)
"""The quantiles that are told: the ends of the interval, and the median between them."""

FEWEST = 39
"""Samples: the least and the largest of so many are the ends of a 95 % interval."""

APART = ("slow_time", "error", "sup_error", "error_far_field", "time_step_error", "domain_error")
"""Numbers of a run in time that are parts of an interval, and have none themselves."""


def sampled_sweep(source: str | Path | Scene, samples: int, seed: int = 0) -> Sweep:
    """The scene at constants drawn from the covariance in its lattice file, as if errors were
    normal; those that the scene states otherwise are exact.

    With more samples the first ones stay what they are. Raises ValueError in one line for a scene
    without such constants, and for too few samples.
    """
    scene = source if isinstance(source, Scene) else load_scene(source)
    count = whole("samples", samples, 1)
    if not FEWEST <= count <= MOST_CELLS:
        raise ValueError(
            f"samples must be {FEWEST} to {MOST_CELLS}, got {count} ({FEWEST} are the fewest that "
            "have a 95 % interval)"
        )
    if isinstance(seed, bool) or not isinstance(seed, int):
        raise ValueError(f"seed must be a whole number, got {shown(seed)} (such as 1)")
    measured = scene.symbolic_lattice.measured or Measured.of({}, {})
    stated = dict(scene.constants)
    moving = {
        name: place
        for place, (name, value) in enumerate(measured.values)
        if measured.deviations[name] and number_value(name, stated[name]) == value
    }
    if not moving:
        raise ValueError(
            f"scene must take constants with a covariance from its lattice file, got {scene.name} "
            "(`longwave fit` writes such a file; a [covariance] may be added to any)"
        )
    rows = tuple(tuple(s[at] for at in moving.values()) for s in measured.samples(count, seed))
    drawn = SweptDimension(SAMPLE, tuple(f"constants.{name}" for name in moving), rows)
    title = f"{scene.title or scene.name}: {count} samples of {', '.join(moving)}"
    return Sweep(
        f"{scene.name}_samples", scene.name, tomllib.loads(scene.toml()), (drawn,), title=title
    )


@dataclass(frozen=True)
class Observed:
    """A number that is seen of a scene, at all samples (NaN where there is no run).

    ``reduction`` is the largest amount by which theory misses it on the lattice, ``numerics`` the
    largest estimated error of a run; NaN where no wave is compared, or nothing was measured.
    """

    name: str
    samples: NDArray[np.float64]
    reduction: float = math.nan
    numerics: float = math.nan

    @property
    def ends(self) -> tuple[float, float, float]:
        """The lower end of the interval, the median, and the upper end."""
        low, middle, high = _quantiles(self.samples)
        return float(low), float(middle), float(high)

    def text(self) -> str:
        """The median with the parts of its interval."""
        low, middle, high = self.ends
        half = (high - low) / 2
        size = max(part for part in (half, self.reduction, self.numerics) if part == part)
        parts = [f"{self.name} {rounded(middle, size)} +- {half:.2g} (data)"]
        for name in ("reduction", "numerics"):
            part = getattr(self, name)
            parts += [f"+- {part:.2g} ({name})"] if part == part else []
        return " ".join(parts)


def _quantiles(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """The ends and the median along the first axis, of the samples that have a run.

    By order statistics: a new draw lies between the ends in 95 % of all cases, few samples or many.
    """
    if not np.isfinite(samples).any():
        return np.full((len(ENDS), *samples.shape[1:]), math.nan)
    return np.asarray(np.nanquantile(samples, ENDS, axis=0, method="weibull"))


def observed(sweep: Sweep, store: RunStore, found: xr.Dataset) -> Iterator[Observed]:
    """What is seen of a sampled scene, from its data set with the runs' fields.

    Of a wave its crest at the end, of a sensor its largest reading, of all else in time the value
    at the end.
    """
    from longwave.runs.sweep_dataset import cell_run

    done = np.flatnonzero(found["status"].values == "done")
    if not done.size:
        return
    scene, run = sweep.scene(0), cell_run(sweep, store, sample=int(done[0]))
    estimates = found["error_estimate"].values[done] * scene.eps ** run.attrs.get("power", 1)
    numerics = float(np.max(estimates))
    if {"strain", "analytic", "background"} <= set(found):
        last = found.isel(time=-1)
        own, theory = (
            np.asarray(np.abs(last[name] - last["background"])).reshape(found.sizes[SAMPLE], -1)
            for name in ("strain", "analytic")
        )
        own, theory = own.max(axis=1), theory.max(axis=1)
        yield Observed("crest", own, float(np.nanmax(np.abs(own - theory))), numerics)
    known = numerics if scene.bench else math.nan
    for name in map(str, found.data_vars):
        if name.endswith(OF_MEANS):
            continue
        values, over = found[name], found[name].dims[1:]
        if name.startswith("sensor_"):
            for place, site in enumerate(found["sensor"].values):
                read = np.abs(values.isel(sensor=place).values).reshape(values.shape[0], -1)
                what = f"cell {site}: largest {name.removeprefix('sensor_')}"
                yield Observed(what, read.max(axis=1), numerics=known)
        elif over == ("time",) and name.removeprefix("run_") not in APART:
            yield Observed(name.replace("_", " "), values.values[:, -1], numerics=known)
        elif over == ("time", "mode"):
            for place, mode in enumerate(found["mode"].values):
                what = f"{name.replace('_', ' ')} {mode}"
                yield Observed(what, values.values[:, -1, place], numerics=known)


def write_samples(
    sweep: Sweep, store: RunStore, path: str | Path
) -> tuple[xr.Dataset, list[Observed]]:
    """Write the data set of a sampled scene as NetCDF-4; return it, and what is seen.

    A run's variable has its interval at each of its places: ``strain_interval(quantile, ...)``.
    Raises OSError that names the file.
    """
    from longwave.runs.sweep_dataset import sweep_dataset

    found = sweep_dataset(sweep, store)
    seen = list(observed(sweep, store, found))
    added: dict[str, Any] = {}
    for name, values in found.data_vars.items():
        if values.dims[:1] == (SAMPLE,) and values.ndim > 1 and values.dtype.kind == "f":
            told = {**values.attrs, "comment": f"of {SAMPLE}s, at the quantiles"}
            added[f"{name}_interval"] = (
                ("quantile", *values.dims[1:]),
                _quantiles(values.values),
                told,
            )
    held = {name: values for name, values in found.data_vars.items() if values.dims == (SAMPLE,)}
    made = found[list(held)].assign_coords(quantile=list(ENDS)).assign(added)
    content = file_content(made)
    write_atomically(Path(path), lambda draft: draft.write_bytes(content))
    return made, seen
