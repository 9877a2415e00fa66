"""Running the lattice through a scene, seen by observers at their moments.

Recorders measure what the scene asks for; the data set that a run returns holds what was recorded,
with the scene, the versions and the cost, and so does what Ctrl-C leaves of a run.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from typing import Any, Protocol

import numpy as np
import xarray as xr

from verify.comparison.observables import (
    TIME_DIMENSION,
    Moment,
    Observable,
    axis_values,
    observable_named,
)
from verify.comparison.scene import Scene
from verify.comparison.view import View

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


def build_dataset(
    scene: Scene, reached: Sequence[float], variables: Variables, cost: Mapping[str, object]
) -> xr.Dataset:
    """The run of ``scene``; ``reached`` are the snapshots that were got to."""
    coordinates: dict[str, object] = {"time": ("time", list(reached), {"units": "lattice time"})}
    for dimension in {name for dimensions, _, _ in variables.values() for name in dimensions}:
        axis = axis_values(dimension, scene.compared)
        if axis is not None:
            coordinates[dimension] = (dimension, *axis)
    names = {name for name, (dimensions, _, _) in variables.items() if dimensions == (name,)}
    coordinates |= {name: variables[name] for name in names}
    data = {name: value for name, value in variables.items() if name not in names}
    attributes = {
        "scene": scene.json(),
        "title": scene.title or scene.name,
        **cost,
        "versions": _versions(),
    }
    return xr.Dataset(data, coordinates, attributes)


@cache
def _versions() -> str:
    """Those of the packages that a run's numbers depend on; each takes a file to be found."""
    return ", ".join(f"{package} {version(package)}" for package in PACKAGES)


LONG = 10.0
"""Seconds from which work is announced."""


class UnfinishedRun(KeyboardInterrupt):
    """Ctrl-C during a run, which had recorded something: ``run``.

    The run's attribute ``unfinished`` says why it is not what the scene asks for.
    """

    def __init__(self, run: xr.Dataset) -> None:
        super().__init__("interrupted")
        self.run = run


def unfinished(
    run: xr.Dataset | None, error: float | None, planning_seconds: float
) -> KeyboardInterrupt:
    """The best run of a search that Ctrl-C ended; ``error`` is its estimated one, if measured."""
    if run is None:
        return KeyboardInterrupt("before anything was recorded")
    found = run.assign_attrs(planning_seconds=planning_seconds)
    why = run.attrs.get("unfinished", "Ctrl-C before the tolerance was met")
    if error is None:
        found.attrs["unfinished"] = f"{why}, its error not estimated"
    else:
        found.attrs |= {"unfinished": why, "error_estimate": error}
    return UnfinishedRun(found)


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
