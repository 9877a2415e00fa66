"""Run records: the variables and attributes of a finished or interrupted run.

A record is converted to an xarray Dataset on request.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.refine import USUAL_WORK, StoppedSearch, refine
from longwave.lattice.trial import StoppedTrial, Trial, difference
from longwave.scenes.observed.observables import TIME_ATTRIBUTES, axis_values
from longwave.support.checkpoint import restored_seconds
from longwave.support.html_tables import html_table
from longwave.support.labelled_arrays import LabelledArray, LabelledArrays
from longwave.support.provenance import provenance

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce, Refined
    from longwave.lattice.schemes import Scheme
    from longwave.lattice.trial import Engine, Progress
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.engines.recorders import Variables


def error_unit(power: int) -> str:
    """Return the unit of reported errors, a power of eps, as text.

    >>> error_unit(1), error_unit(2)
    ('eps', 'eps^2')
    """
    return "eps" if power == 1 else f"eps^{power}"


@dataclass(repr=False)
class RunRecord:
    """Recorded run of ``scene``, from which `dataset` builds an xarray Dataset.

    ``reach`` is the number of compared cells on either side along each axis; ``reached`` are the
    snapshots that the run reached; ``attrs`` are its attributes, cost first, which may be extended
    until the data set is built. ``requested`` is the scene as requested, if step and domain of
    ``scene`` were chosen for it.
    """

    scene: Scene
    reach: tuple[int, ...]
    reached: Sequence[float]
    variables: Variables
    attrs: dict[str, Any]
    requested: Scene | None = None

    def __repr__(self) -> str:
        return f"<RunRecord of {self.scene.name}: {len(self.reached)} times, {self._error}>"

    def _repr_html_(self) -> str:
        rows = [("variables", ", ".join(self.variables)), ("error", self._error)]
        return html_table(f"Run of {self.scene.title or self.scene.name}", rows)

    @property
    def _error(self) -> str:
        errors = self.values("error") if "error" in self.variables else np.empty(0)
        largest = np.max(errors, initial=-1.0, where=np.isfinite(errors))
        return f"error at most {largest:.3g}" if largest >= 0.0 else "no error against a wave"

    def values(self, name: str) -> NDArray[Any]:
        """Return the values of a variable, in the order of its times."""
        return np.asarray(self.variables[name][1])

    @cached_property
    def arrays(self) -> LabelledArrays:
        """Run as labelled arrays, with coordinates, scene and provenance."""
        used = {name for dimensions, _, _ in self.variables.values() for name in dimensions}
        axes = {name: axis_values(name, self.reach) for name in used}
        entries: Variables = {"time": (("time",), list(self.reached), dict(TIME_ATTRIBUTES))}
        entries |= {name: ((name,), *axis) for name, axis in axes.items() if axis is not None}
        entries |= self.variables
        requested = self.requested or self.scene
        attributes = {
            "title": requested.title or requested.name,
            "scene": requested.toml(),
            **({} if requested is self.scene else {"plan": self.scene.toml()}),
            **self.attrs,
            **provenance(),
        }
        labelled = {
            name: LabelledArray(dimensions, np.asarray(values), labels)
            for name, (dimensions, values, labels) in entries.items()
        }
        return LabelledArrays(labelled, attributes)

    @cached_property
    def dataset(self) -> xr.Dataset:
        """Run as an xarray Dataset, with coordinates, scene and provenance."""
        import xarray as xr  # takes 0.4 s, so only on request

        data = {n: (v.dims, v.values, v.attrs) for n, v in self.arrays.variables.items()}
        axes = {name: data.pop(name) for name in list(data) if data[name][0] == (name,)}
        return xr.Dataset(data, axes, self.arrays.attrs)


def stencil_cost(
    scheme: Scheme, steps: int, sites: int, seconds: float, blow_up: object, **more: float
) -> dict[str, Any]:
    """Return the attributes of a run cell by cell: its engine, scheme, cost and ``blow_up``."""
    return {
        "engine": "stencil",
        "scheme": scheme.name,
        "order": scheme.order,
        "steps": steps,
        "force_evaluations": steps * scheme.stages,
        "sites": sites,
        **more,
        "seconds": seconds,
        "blow_up": str(blow_up or ""),
    }


def add_error_estimate(
    record: RunRecord, result: Refined, requested: Scene, begun: float
) -> RunRecord:
    """Add the error estimate of a search to the record of its last run, and return the record.

    ``error_estimate`` is the sup over the compared cells and all exact times of the difference from
    the infinite lattice, in the unit of the compared values. ``rounding_estimate`` is the part due
    to rounding, ``next_decade`` the cost factor for ten times more accuracy. ``begun`` is the start
    of the search in `perf_counter` seconds.
    """
    record.requested = requested
    record.attrs |= {
        "tolerance": requested.target.tolerance,
        "error_estimate": result.error,
        "rounding_estimate": result.rounding,
        "next_decade": result.next_decade,
        "planning_seconds": time.perf_counter() - begun + restored_seconds() - result.trial.seconds,
    }
    return record


class UnfinishedRun(KeyboardInterrupt):
    """Ctrl-C during a run; ``record`` and the Dataset ``run`` hold the values recorded so far.

    The run's attribute ``unfinished`` says when or why it was interrupted.
    """

    def __init__(self, record: RunRecord) -> None:
        super().__init__("interrupted")
        self.record = record

    @property
    def run(self) -> xr.Dataset:
        """Recorded part of the run, as a Dataset."""
        return self.record.dataset


def search_interrupt(
    run: RunRecord | None, requested: Scene, error: float | None, planning_seconds: float
) -> KeyboardInterrupt:
    """Return the exception for a search ended by Ctrl-C: UnfinishedRun with its best run.

    Returns a plain KeyboardInterrupt if ``run`` is None. ``error`` is the run's estimated error, or
    None if it was not estimated.
    """
    if run is None:
        return KeyboardInterrupt("before anything was recorded")
    run.requested = requested
    run.attrs |= {"tolerance": requested.tolerance, "planning_seconds": planning_seconds}
    why = run.attrs.get("unfinished", "Ctrl-C before the tolerance was met")
    if error is None:
        run.attrs["unfinished"] = f"{why}, its error not estimated"
    else:
        run.attrs |= {"unfinished": why, "error_estimate": error}
    return UnfinishedRun(run)


def refine_scene(
    engine: Engine,
    scene: Scene,
    progress: Progress,
    announce: Announce,
    record_of: Callable[[Trial], RunRecord | None] = lambda trial: trial.payload,
) -> Refined:
    """Run `refine` to the scene's tolerance; ``record_of`` returns the record of a trial run.

    Raises the errors of `refine`, and on Ctrl-C UnfinishedRun with the best run so far.
    """
    try:
        return refine(engine, scene.target.tolerance, progress, announce)
    except StoppedSearch as stop:
        run = None if stop.trial is None else record_of(stop.trial)
        raise search_interrupt(run, scene, stop.error, stop.before) from None


def refine_on_part(
    within: Engine, whole: Engine, scene: Scene, progress: Progress, announce: Announce
) -> Refined | None:
    """Search for the step on a part of the cells, then run the ``whole`` once with that step.

    A search takes four or five runs, all but one of them to measure the effect of a shorter step.
    If a part of the cells represents the whole wave, these runs compute that part alone
    (``within``). The final run is compared with the last run of the part; their difference is added
    to the error. Returns None if the error then exceeds the tolerance. Raises the errors of
    `refine_scene`.
    """
    sizes = within.first().size * USUAL_WORK, whole.first().size
    share = sizes[0] / sum(sizes)
    try:
        result = refine(
            within, scene.target.tolerance, lambda done: progress(share * done), announce
        )
    except StoppedSearch:
        raise search_interrupt(None, scene, None, 0.0) from None
    choices = replace(whole.first(), step=result.trial.choices.step)
    announce(result.trial.seconds * whole.work(choices) / within.work(result.trial.choices))
    try:
        trial = whole.run(choices, True, lambda done: progress(share + (1.0 - share) * done))
    except StoppedTrial as stop:
        raise search_interrupt(stop.trial.payload, scene, result.error, 0.0) from None
    error = result.error + difference(trial, result.trial) + trial.common_error
    return replace(result, trial=trial, error=error) if error <= scene.target.tolerance else None
