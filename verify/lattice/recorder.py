"""Recorders: they see a run at their moments and give its variables at the end."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from verify.lattice.moments import Moments, moments_of
from verify.lattice.observables.entry import TIME_DIMENSION, Entry, Moment, View
from verify.lattice.observables.table import entry_named
from verify.lattice.scene import Scene

Variables = dict[str, tuple[tuple[str, ...], Any, dict[str, str]]]


class Observable(Protocol):
    """Sees the run at its moments; gives its variables at the end."""

    @property
    def moments(self) -> Moments:
        """When it wants to see the run."""

    def see(self, view: View) -> None:
        """Record the run at one of the moments."""

    def variables(self) -> Variables:
        """Name -> (dimensions, values, attributes)."""


class Recorder:
    """Records the entries that share one kind of moment, and one time dimension."""

    def __init__(self, entries: Sequence[Entry], moments: Moments, dimension: str) -> None:
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
    entries = [entry_named(name) for name in scene.observables]
    kinds: tuple[Moment, ...] = ("snapshots", "curve", "looks")
    return [
        Recorder(group, moments_of(scene, kind), TIME_DIMENSION[kind])
        for kind in kinds
        if (group := [entry for entry in entries if entry.seen == kind])
    ]
