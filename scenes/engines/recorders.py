"""What sees a run at its moments, and records what the scene asks for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from longwave.scenes.observed.observables import (
    TIME,
    TIME_DIMENSION,
    Moment,
    Observable,
    Variable,
    observable_named,
)

if TYPE_CHECKING:
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.observed.view import View
    from longwave.support.checkpoint import Memory

Array = NDArray[np.float64]

LOOK_EVALUATIONS = 1088
"""Fewest force evaluations a site between two looks: a look then costs a hundredth of the run."""


MOMENT_BYTES = 1000.0
"""For each time at which something is seen, beside what is kept of it."""


@dataclass
class Moments:
    """Exact ``times``, or looks at the first stop after every ``interval`` if there are none.

    >>> looks = Moments((), 2.0)
    >>> [t for t in (0.0, 1.5, 2.5, 4.0, 4.5) if looks.due(t)]
    [0.0, 2.5, 4.5]
    """

    times: tuple[float, ...]
    interval: float = 0.0

    def __post_init__(self) -> None:
        self._exact = frozenset(self.times)
        self.next = -np.inf

    def due(self, t: float) -> bool:
        """Whether the run is to be seen at the stop ``t``; to be asked once for each stop."""
        if self.times:
            return t in self._exact
        if t < self.next:
            return False
        self.next = t + self.interval
        return True


def moments_of(scene: Scene, kind: Moment) -> Moments:
    """The moments of one kind in a scene."""
    if kind == "snapshots":
        return Moments(scene.snapshots)
    if kind == "curve":
        return Moments(_equidistant(scene, scene.curve_points))
    if scene.look_points is not None:
        return Moments(_equidistant(scene, scene.look_points))
    share = (scene.end - scene.t0) / scene.curve_points
    least = LOOK_EVALUATIONS / scene.discretisation.table.stages * scene.discretisation.step
    return Moments((), max(least, share) * (1.0 - 1e-12))


def _equidistant(scene: Scene, points: int) -> tuple[float, ...]:
    """Equidistant times of the run, and the snapshots."""
    equidistant = np.linspace(scene.t0, scene.end, points)
    return tuple(sorted({float(t) for t in equidistant} | set(scene.snapshots)))


def exact_times(scene: Scene) -> tuple[float, ...]:
    """The times that the scene's observables want exactly."""
    kinds = {observable_named(name).seen for name in scene.observables}
    times = {t for kind in kinds if _is_exact(scene, kind) for t in moments_of(scene, kind).times}
    return tuple(sorted(times.union(scene.snapshots)))


def _is_exact(scene: Scene, kind: Moment) -> bool:
    """Whether these are times, not the first stops after an interval."""
    return kind in ("snapshots", "curve") or (kind == "looks" and scene.look_points is not None)


Variables = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]
"""Name -> (dimensions, values, attributes)."""


class Recorder:
    """Records the entries that share one kind of moment, and one time dimension."""

    def __init__(self, entries: Sequence[Observable], moments: Moments, dimension: str) -> None:
        self.entries = tuple(entries)
        self.moments = moments
        self.dimension = dimension
        self.times: list[float] = []
        self._rows: dict[str, list[Any]] = {}

    def see(self, view: View) -> None:
        """Measure every entry once."""
        self.add(view.t, self.measured(view))

    def measured(self, view: View) -> dict[str, Any]:
        """What every entry measures of a view."""
        return {
            name: value for entry in self.entries for name, value in entry.measure(view).items()
        }

    def add(self, t: float, row: Mapping[str, Any]) -> None:
        """Record what was measured at a time."""
        for name, value in row.items():
            self._rows.setdefault(name, []).append(value)
        self.times.append(t)

    def memory(self) -> Memory:
        """What was recorded, and when it is to look next."""
        return {"times": self.times, "rows": self._rows, "next": self.moments.next}

    def recall(self, memory: Memory) -> None:
        """Have recorded that."""
        self.times, self._rows, self.moments.next = (memory[k] for k in ("times", "rows", "next"))

    def variables(self) -> Variables:
        """What was measured at ``times``, and they unless they are the snapshots'.

        It is handed over: of a large ring there is no room for it twice.
        """
        found: Variables = {}
        for variable in (variable for entry in self.entries for variable in entry.variables):
            if variable.name in self._rows:
                values = np.array(self._rows.pop(variable.name)[: len(self.times)])
                dimensions = (self.dimension, *_dimensions(variable, values.ndim - 1))
                found[variable.name] = (dimensions, values, variable.attributes)
        if self.dimension != "time":
            times = np.array(self.times)
            found[self.dimension] = ((self.dimension,), times, TIME)
        return found


def _dimensions(variable: Variable, count: int) -> tuple[str, ...]:
    """Those of its values at one time; on a plane cells have rows, and a state may have fields."""
    given = variable.dimensions
    if count == len(given):
        return given
    return (*given, "row") if given[-1] == "site" else ("field", *given)


def build_recorders(scene: Scene) -> list[Recorder]:
    """One recorder for each kind of moment at which the scene wants something seen."""
    entries = [observable_named(name) for name in scene.observables]
    kinds: tuple[Moment, ...] = ("snapshots", "curve", "looks")
    return [
        Recorder(group, moments_of(scene, kind), TIME_DIMENSION[kind])
        for kind in kinds
        if (group := [entry for entry in entries if entry.seen == kind])
    ]


class Samples:
    """What ``take`` takes of a view at some times, and nothing else: the strains unless given."""

    def __init__(
        self, times: Sequence[float], take: Callable[[Any], Array] = attrgetter("numerics")
    ) -> None:
        self.moments = Moments(tuple(times))
        self.samples: list[Array] = []
        self._take = take

    def see(self, view: View) -> None:
        """Keep what is taken at one time."""
        self.samples.append(self._take(view))

    def memory(self) -> Memory:
        """The samples."""
        return {"samples": self.samples}

    def recall(self, memory: Memory) -> None:
        """Have kept those samples."""
        self.samples = memory["samples"]


Observer: TypeAlias = Recorder | Samples
"""Sees the run at its moments, and remembers what it has seen."""
