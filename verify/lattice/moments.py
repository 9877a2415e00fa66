"""When an observable sees the run."""

from dataclasses import dataclass

import numpy as np

from verify.lattice.observables.entry import Moment
from verify.lattice.scene import Scene

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
    least = LOOK_EVALUATIONS / scene.scheme_table.stages * scene.step
    return Moments((), max(least, share) * (1.0 - 1e-12))


def _equidistant(scene: Scene, points: int) -> tuple[float, ...]:
    """Equidistant times of the run, and the snapshots."""
    equidistant = np.linspace(scene.t0, scene.end, points)
    return tuple(sorted({float(t) for t in equidistant} | set(scene.snapshots)))
