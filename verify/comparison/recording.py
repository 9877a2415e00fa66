"""Running the lattice through a scene, seen by observers at their moments.

Recorders measure what the scene asks for; the record of a run holds what was recorded, with the
scene, the versions and the cost, and so does what Ctrl-C leaves of a run. A data set is made of it
where one is asked for.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from verify.comparison.observables import (
    TIME_DIMENSION,
    Moment,
    Observable,
    axis_values,
    observable_named,
)
from verify.comparison.scene import Scene
from verify.comparison.view import View

if TYPE_CHECKING:
    import xarray as xr

LOOK_EVALUATIONS = 1088
"""Fewest force evaluations a site between two looks: a look then costs a hundredth of the run."""


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
        self._next = -np.inf

    def due(self, t: float) -> bool:
        """Whether the run is to be seen at the stop ``t``; to be asked once for each stop."""
        if self.times:
            return t in self._exact
        if t < self._next:
            return False
        self._next = t + self.interval
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


Variables = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]
"""Name -> (dimensions, values, attributes)."""


class Observer(Protocol):
    """Sees the run at its moments."""

    @property
    def moments(self) -> Moments:
        """When it wants to see the run."""

    def see(self, view: View) -> None:
        """Record the run at one of the moments."""


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
        found = [entry.measure(view) for entry in self.entries]
        for name, value in ((name, row[name]) for row in found for name in row):
            self._rows.setdefault(name, []).append(value)
        self.times.append(view.state.t)

    def variables(self) -> Variables:
        """What was measured at ``times``, and they unless they are the snapshots'."""
        found: Variables = {}
        for variable in (variable for entry in self.entries for variable in entry.variables):
            if variable.name in self._rows:
                dimensions = (self.dimension, *variable.dimensions)
                values = np.array(self._rows[variable.name][: len(self.times)])
                found[variable.name] = (dimensions, values, variable.attributes)
        if self.dimension != "time":
            times = np.array(self.times)
            found[self.dimension] = ((self.dimension,), times, {"units": "lattice time"})
        return found


def build_recorders(scene: Scene) -> list[Recorder]:
    """One recorder for each kind of moment at which the scene wants something seen."""
    entries = [observable_named(name) for name in scene.observables]
    kinds: tuple[Moment, ...] = ("snapshots", "curve", "looks")
    return [
        Recorder(group, moments_of(scene, kind), TIME_DIMENSION[kind])
        for kind in kinds
        if (group := [entry for entry in entries if entry.seen == kind])
    ]


PACKAGES = ("longwave", "numpy", "numba", "sympy", "xarray")


@dataclass
class RunRecord:
    """A run of ``scene`` as it was recorded: a `Dataset` before anyone needs one.

    ``reached`` are the snapshots that were got to; ``attrs`` is what was told of the run, its cost
    first, and may be added to until the data set is made.
    """

    scene: Scene
    reached: Sequence[float]
    variables: Variables
    attrs: dict[str, Any]

    def values(self, name: str) -> NDArray[Any]:
        """The values of a variable, in the order of its times."""
        return np.asarray(self.variables[name][1])

    @cached_property
    def dataset(self) -> "xr.Dataset":
        """The run with its coordinates, the scene and the versions."""
        from importlib.metadata import version

        import xarray as xr  # 0.4 s, for those who want a data set

        used = {name for dimensions, _, _ in self.variables.values() for name in dimensions}
        axes = {name: axis_values(name, self.scene.compared) for name in used}
        coordinates: dict[str, object] = {
            "time": ("time", list(self.reached), {"units": "lattice time"})
        }
        coordinates |= {name: (name, *axis) for name, axis in axes.items() if axis is not None}
        names = {name for name, (found, _, _) in self.variables.items() if found == (name,)}
        coordinates |= {name: self.variables[name] for name in names}
        data = {name: value for name, value in self.variables.items() if name not in names}
        attributes = {
            "scene": self.scene.json(),
            "title": self.scene.title or self.scene.name,
            **self.attrs,
            "versions": ", ".join(f"{package} {version(package)}" for package in PACKAGES),
        }
        return xr.Dataset(data, coordinates, attributes)


LONG = 10.0
"""Seconds from which work is announced."""


class UnfinishedRun(KeyboardInterrupt):
    """Ctrl-C during a run, which had recorded something: ``run``, and ``record`` before it.

    The run's attribute ``unfinished`` says why it is not what the scene asks for.
    """

    def __init__(self, record: RunRecord) -> None:
        super().__init__("interrupted")
        self.record = record

    @property
    def run(self) -> "xr.Dataset":
        """What was recorded."""
        return self.record.dataset


def unfinished(
    run: RunRecord | None, error: float | None, planning_seconds: float
) -> KeyboardInterrupt:
    """The best run of a search that Ctrl-C ended; ``error`` is its estimated one, if measured."""
    if run is None:
        return KeyboardInterrupt("before anything was recorded")
    run.attrs["planning_seconds"] = planning_seconds
    why = run.attrs.get("unfinished", "Ctrl-C before the tolerance was met")
    if error is None:
        run.attrs["unfinished"] = f"{why}, its error not estimated"
    else:
        run.attrs |= {"unfinished": why, "error_estimate": error}
    return UnfinishedRun(run)


class Announcer:
    """Passes on how many seconds are expected, if they are many and not what was said before.

    >>> told = Announcer(print)
    >>> for seconds in (3.0, 30.0, 40.0, 90.0):
    ...     told(seconds)
    30.0
    90.0
    """

    def __init__(self, announce: Callable[[float], None]) -> None:
        self._announce = announce
        self._said = LONG / 2.0

    def __call__(self, seconds: float) -> None:
        """Announce work to come."""
        if seconds >= max(LONG, 2.0 * self._said):
            self._said = seconds
            self._announce(seconds)
