"""Where a scene's wave is and how large it becomes: what a plan must know before any step."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.lattice.comparison import Comparison
from verify.lattice.domain import compared_sites
from verify.lattice.scene import Scene
from verify.lattice.state import State

TIMES = 17
"""Equidistant times at which the wave is looked at, beside the snapshots."""

CREST_SHARE = 0.05
"""Share of the largest deviation from the background that still counts as crest."""


@dataclass(frozen=True)
class Extent:
    """``strain``: the smallest and the largest on the compared sites at any time.

    ``crest`` is the half-width in sites about c t outside which the wave is within ``CREST_SHARE``
    of its background.
    """

    strain: NDArray[np.float64]
    crest: int


def watched_times(scene: Scene) -> tuple[float, ...]:
    """The snapshots and a few equidistant times."""
    equidistant = np.linspace(scene.t0, scene.end, TIMES)
    return tuple(sorted({float(t) for t in equidistant} | set(scene.snapshots)))


def extent_of(scene: Scene, wave: Wave) -> Extent:
    """Evaluate the closed form on the compared sites at the watched times."""
    low, high, heights = np.inf, -np.inf, []
    for t in watched_times(scene):
        empty = np.empty(0)
        view = Comparison(scene, wave, State(t, int(compared_sites(scene, t)[0]), empty, empty))
        low = min(low, float(view.analytic.min()))
        high = max(high, float(view.analytic.max()))
        heights.append(np.abs(view.analytic - view.level))
    crest = np.max(heights, axis=0)
    inside = np.flatnonzero(crest > CREST_SHARE * crest.max())
    width = int(np.abs(inside - scene.compared).max())
    return Extent(np.array([low, high]), width)
