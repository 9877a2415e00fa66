"""What a run leaves: a record of what was seen and told, of which a data set is made on request.

So does what Ctrl-C leaves of a run.
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
from longwave.scenes.observed.observables import TIME, axis_values
from longwave.support.checkpoint import spared_seconds
from longwave.support.html_tables import html_table
from longwave.support.labelled_arrays import LabelledArray, LabelledArrays
from longwave.support.provenance import provenance

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce, Refined
    from longwave.lattice.trial import Engine, Progress
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.engines.recorders import Variables


def error_unit(power: int) -> str:
    """The unit in which errors are told, that power of eps, in words.

    >>> error_unit(1), error_unit(2)
    ('eps', 'eps^2')
    """
    return "eps" if power == 1 else f"eps^{power}"


@dataclass(repr=False)
class RunRecord:
    """A run of ``scene`` as it was recorded: a `Dataset` before anyone needs one.

    ``reach`` says how many cells are compared on either side along each axis; ``reached`` are the
    snapshots that were got to; ``attrs`` is what was told of the run, its cost first, and may be
    added to until the data set is made. ``asked`` is the scene that was asked for, if step and
    domain of ``scene`` were chosen.
    """

    scene: Scene
    reach: tuple[int, ...]
    reached: Sequence[float]
    variables: Variables
    attrs: dict[str, Any]
    asked: Scene | None = None

    def __repr__(self) -> str:
        return f"<RunRecord of {self.scene.name}: {len(self.reached)} times, {self._error}>"

    def _repr_html_(self) -> str:
        rows = [("variables", ", ".join(self.variables)), ("error", self._error)]
        return html_table(f"Run of {self.scene.title or self.scene.name}", rows)

    @property
    def _error(self) -> str:
        held = self.values("error") if "error" in self.variables else np.empty(0)
        largest = np.max(held, initial=-1.0, where=np.isfinite(held))
        return f"error at most {largest:.3g}" if largest >= 0.0 else "no error against a wave"

    def values(self, name: str) -> NDArray[Any]:
        """The values of a variable, in the order of its times."""
        return np.asarray(self.variables[name][1])

    @cached_property
    def arrays(self) -> LabelledArrays:
        """The run with its coordinates, the scene and what made it."""
        used = {name for dimensions, _, _ in self.variables.values() for name in dimensions}
        axes = {name: axis_values(name, self.reach) for name in used}
        held: Variables = {"time": (("time",), list(self.reached), dict(TIME))}
        held |= {name: ((name,), *axis) for name, axis in axes.items() if axis is not None}
        held |= self.variables
        asked = self.asked or self.scene
        attributes = {
            "title": asked.title or asked.name,
            "scene": asked.toml(),
            **({} if asked is self.scene else {"plan": self.scene.toml()}),
            **self.attrs,
            **provenance(),
        }
        found = {
            name: LabelledArray(dimensions, np.asarray(values), told)
            for name, (dimensions, values, told) in held.items()
        }
        return LabelledArrays(found, attributes)

    @cached_property
    def dataset(self) -> xr.Dataset:
        """The `arrays` as a data set."""
        import xarray as xr  # 0.4 s, for those who want a data set

        held = {n: (v.dims, v.values, v.attrs) for n, v in self.arrays.variables.items()}
        axes = {name: held.pop(name) for name in list(held) if held[name][0] == (name,)}
        return xr.Dataset(held, axes, self.arrays.attrs)


def judged(record: RunRecord, found: Refined, asked: Scene, begun: float) -> RunRecord:
    """The record of a run to a tolerance, with what the judge says of it.

    ``error_estimate`` is of what is compared, in its unit, sup over the compared cells and all
    exact times, against the infinite lattice; ``rounding_estimate`` is its part for rounding,
    ``next_decade`` the factor by which ten times more accuracy costs more. ``begun`` is when the
    search did, as `perf_counter` tells.
    """
    record.asked = asked
    record.attrs |= {
        "tolerance": asked.target.tolerance,
        "error_estimate": found.error,
        "rounding_estimate": found.rounding,
        "next_decade": found.next_decade,
        "planning_seconds": time.perf_counter() - begun + spared_seconds() - found.trial.seconds,
    }
    return record


class UnfinishedRun(KeyboardInterrupt):
    """Ctrl-C during a run, which had recorded something: ``run``, and ``record`` before it.

    The run's attribute ``unfinished`` says why it is not what the scene asks for.
    """

    def __init__(self, record: RunRecord) -> None:
        super().__init__("interrupted")
        self.record = record

    @property
    def run(self) -> xr.Dataset:
        """What was recorded."""
        return self.record.dataset


def unfinished(
    run: RunRecord | None, asked: Scene, error: float | None, planning_seconds: float
) -> KeyboardInterrupt:
    """The best run of a search that Ctrl-C ended; ``error`` is its estimated one, if measured."""
    if run is None:
        return KeyboardInterrupt("before anything was recorded")
    run.asked = asked
    run.attrs |= {"tolerance": asked.tolerance, "planning_seconds": planning_seconds}
    why = run.attrs.get("unfinished", "Ctrl-C before the tolerance was met")
    if error is None:
        run.attrs["unfinished"] = f"{why}, its error not estimated"
    else:
        run.attrs |= {"unfinished": why, "error_estimate": error}
    return UnfinishedRun(run)


def searched(
    engine: Engine,
    scene: Scene,
    progress: Progress,
    announce: Announce,
    record_of: Callable[[Trial], RunRecord | None] = lambda trial: trial.payload,
) -> Refined:
    """What `refine` finds for the scene's tolerance; ``record_of`` gives the record of a run.

    Raises what that raises, and on Ctrl-C UnfinishedRun with the best of them.
    """
    try:
        return refine(engine, scene.target.tolerance, progress, announce)
    except StoppedSearch as stop:
        run = None if stop.trial is None else record_of(stop.trial)
        raise unfinished(run, scene, stop.error, stop.before) from None


def searched_on_part(
    within: Engine, whole: Engine, scene: Scene, progress: Progress, announce: Announce
) -> Refined | None:
    """What a search on a part of the cells finds, and one run of the ``whole`` with that step.

    A search takes four or five runs, all but one of them to see what a shorter step changes. Where
    some of the cells show all that the wave does, these are of them alone, ``within`` a domain of
    its own. The whole is judged on them, too, and must give what the last of those gave: what it
    differs by is in the error. None where that is more than the tolerance. Raises as `searched`.
    """
    sizes = within.first().size * USUAL_WORK, whole.first().size
    share = sizes[0] / sum(sizes)
    try:
        found = refine(
            within, scene.target.tolerance, lambda done: progress(share * done), announce
        )
    except StoppedSearch:
        raise unfinished(None, scene, None, 0.0) from None
    choices = replace(whole.first(), step=found.trial.choices.step)
    announce(found.trial.seconds * whole.work(choices) / within.work(found.trial.choices))
    try:
        trial = whole.run(choices, True, lambda done: progress(share + (1.0 - share) * done))
    except StoppedTrial as stop:
        raise unfinished(stop.trial.payload, scene, found.error, 0.0) from None
    error = found.error + difference(trial, found.trial) + trial.common_error
    return replace(found, trial=trial, error=error) if error <= scene.target.tolerance else None
