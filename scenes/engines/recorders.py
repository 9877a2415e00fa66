"""Recorders: measure a scene's observables during a run and store the values."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from longwave.scenes.observed import observables
from longwave.support.real_arrays import Array

if TYPE_CHECKING:
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.observed.view import View
    from longwave.support.checkpoint import Memory


LOOK_EVALUATIONS = 1088
"""Minimum number of force evaluations per site between looks; looks then take 1 % of a run."""


MOMENT_BYTES = 1000.0
"""Bytes of overhead for each time at which observables are measured."""


@dataclass
class Moments:
    """Times at which to measure: the exact ``times``, or the first stop after each ``interval``.

    >>> looks = Moments((), 2.0)
    >>> [t for t in (0.0, 1.5, 2.5, 4.0, 4.5) if looks.is_due(t)]
    [0.0, 2.5, 4.5]
    """

    times: tuple[float, ...]
    interval: float = 0.0

    def __post_init__(self) -> None:
        self._exact = frozenset(self.times)
        self.next = -np.inf

    def is_due(self, t: float) -> bool:
        """Return whether to measure at the stop ``t``. Call once for each stop, in order."""
        if self.times:
            return t in self._exact
        if t < self.next:
            return False
        self.next = t + self.interval
        return True


def moments_of(scene: Scene, kind: observables.Moment) -> Moments:
    """Return the times at which a scene measures observables with this ``measured_at``."""
    if kind == "snapshots":
        return Moments(scene.snapshots)
    if kind == "curve":
        return Moments(_equidistant(scene, scene.curve_points))
    if scene.look_points is not None:
        return Moments(_equidistant(scene, scene.look_points))
    spacing = (scene.end - scene.t0) / scene.curve_points
    shortest = LOOK_EVALUATIONS / scene.discretisation.table.stages * scene.discretisation.step
    return Moments((), max(shortest, spacing) * (1.0 - 1e-12))


def _equidistant(scene: Scene, points: int) -> tuple[float, ...]:
    """Return ``points`` equidistant times from start to end of the run, and the snapshots."""
    equidistant = np.linspace(scene.t0, scene.end, points)
    return tuple(sorted({float(t) for t in equidistant} | set(scene.snapshots)))


def exact_times(scene: Scene) -> tuple[float, ...]:
    """Return the times that the scene's observables require exactly, snapshots included."""
    kinds = {observables.observable_named(name).measured_at for name in scene.observables}
    exact = {"snapshots", "curve"} | ({"looks"} if scene.look_points is not None else set())
    times = {t for kind in kinds if kind in exact for t in moments_of(scene, kind).times}
    return tuple(sorted(times.union(scene.snapshots)))


Variables = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]
"""Dataset variables by name, each as (dimensions, values, attributes)."""


class Recorder:
    """Recorder of the observables that are measured at the same times, on one time dimension."""

    def __init__(
        self, entries: Sequence[observables.Observable], moments: Moments, dimension: str
    ) -> None:
        self.entries = tuple(entries)
        self.moments = moments
        self.dimension = dimension
        self.times: list[float] = []
        self._rows: dict[str, list[Any]] = {}

    def observe(self, view: View) -> None:
        """Measure all observables of a view and store the values."""
        self.add(view.t, self.measure(view))

    def measure(self, view: View) -> dict[str, Any]:
        """Return the measured values of all observables, by variable name."""
        return {
            name: value for entry in self.entries for name, value in entry.measure(view).items()
        }

    def add(self, t: float, row: Mapping[str, Any]) -> None:
        """Store the values measured at time ``t``."""
        for name, value in row.items():
            self._rows.setdefault(name, []).append(value)
        self.times.append(t)

    def memory(self) -> Memory:
        """Return the checkpoint state: recorded values and the time of the next look."""
        return {"times": self.times, "rows": self._rows, "next": self.moments.next}

    def recall(self, memory: Memory) -> None:
        """Restore the state from a checkpoint."""
        self.times, self._rows, self.moments.next = (memory[k] for k in ("times", "rows", "next"))

    def variables(self) -> Variables:
        """Return the recorded variables, and their times unless these are the snapshots.

        The values are removed from the recorder, as a large ring has no memory for a second copy.
        """
        recorded: Variables = {}
        for variable in (variable for entry in self.entries for variable in entry.variables):
            if variable.name in self._rows:
                values = np.array(self._rows.pop(variable.name)[: len(self.times)])
                dimensions = (self.dimension, *_dimensions(variable, values.ndim - 1))
                recorded[variable.name] = (dimensions, values, variable.attributes)
        if self.dimension != "time":
            times = np.array(self.times)
            recorded[self.dimension] = ((self.dimension,), times, observables.TIME_ATTRIBUTES)
        return recorded


def _dimensions(variable: observables.Variable, count: int) -> tuple[str, ...]:
    """Return the names of the ``count`` dimensions of a variable's values at one time.

    Cells of a plane add the dimension "row"; a state with several fields adds "field".
    """
    declared = variable.dimensions
    if count == len(declared):
        return declared
    return (*declared, "row") if declared[-1] == "site" else ("field", *declared)


def build_recorders(scene: Scene) -> list[Recorder]:
    """Return one recorder for each kind of measurement times that the scene's observables need."""
    entries = [observables.observable_named(name) for name in scene.observables]
    kinds: tuple[observables.Moment, ...] = ("snapshots", "curve", "looks")
    return [
        Recorder(group, moments_of(scene, kind), observables.TIME_DIMENSION[kind])
        for kind in kinds
        if (group := [entry for entry in entries if entry.measured_at == kind])
    ]


def recorded_variables(recorders: Sequence[Recorder]) -> Variables:
    """Return the variables of all recorders; their values are removed from the recorders."""
    return {name: row for recorder in recorders for name, row in recorder.variables().items()}


class Samples:
    """Observer that stores what ``take`` extracts from views; default: the compared quantities."""

    def __init__(
        self, times: Sequence[float], take: Callable[[Any], Array] = attrgetter("numerics")
    ) -> None:
        self.moments = Moments(tuple(times))
        self.samples: list[Array] = []
        self._take = take

    def observe(self, view: View) -> None:
        """Extract one sample from a view and store it."""
        self.samples.append(self._take(view))

    def memory(self) -> Memory:
        """Return the checkpoint state: the samples so far."""
        return {"samples": self.samples}

    def recall(self, memory: Memory) -> None:
        """Restore the samples from a checkpoint."""
        self.samples = memory["samples"]


Observer: TypeAlias = Recorder | Samples
"""Object that measures a run at given times and stores the values."""
