"""Features of force laws that a run may step over, and the steps that do not.

A bump of a force that stretches pass within a step leaves no trace in either of two runs that are
compared. The range of stretches that a run has visited is covered by panels on which the force's
integral, the energy that a bond stores, is known; where they are short, a step may take a stretch
no further than a share of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.force_program import PLACES, ForceProgram
from longwave.lattice.time_integral import Integral

Array = NDArray[np.float64]

PANELS = 64
"""Of a range of stretches, at first."""

FOLLOWED = 1e-2
"""Share of the velocity that is allowed to a feature which is passed and not resolved."""

TRAVEL = 0.5
"""Share of a panel that a stretch may move in a step."""

CORNER, FINER = 4.0, 1e-4
"""The factor by which panels become shorter at a corner with that share of what is allowed."""

SEEN = 1e-3
"""Share of the largest slope by which slopes between samples may differ from a cubic through them:
there a law is smooth, and two runs that are compared show what steps cost."""

ROUNDING = 1e-13
"""Share of the largest force, times a panel, that is taken for rounding."""


@dataclass(frozen=True)
class Feature:
    """The ``width`` that a step must resolve, infinite where all is smooth; whether there are
    corners, at which errors fall with a low order."""

    width: float
    turns: bool = False


def find_feature(force: ForceProgram, low: float, high: float, impulse: float) -> Feature:
    """The narrowest feature of a law between two stretches.

    ``impulse`` is the energy that may go unseen, a velocity times the rate of stretch.
    """
    if force.is_smooth or not low < high:
        return Feature(math.inf)
    with np.errstate(all="ignore"):
        if not np.isfinite(force(np.linspace(low, high, PLACES))).all():  # a run through a pole
            return Feature(math.inf)
        return _feature(force, low, high, impulse)


def _feature(force: ForceProgram, low: float, high: float, impulse: float) -> Feature:
    width = _narrowest(force, low, high, FOLLOWED * impulse)
    if width == math.inf:
        return Feature(math.inf)
    turns = _narrowest(force, low, high, FINER * FOLLOWED * impulse) < width / CORNER
    seen = float(np.max(np.abs(force.slope(np.linspace(low, high, PLACES)))))
    if turns and force.steepest_between(low, high, seen) == seen:
        return Feature(math.inf, True)
    return Feature(width, turns)


def _narrowest(force: ForceProgram, low: float, high: float, allowed: float) -> float:
    """The shortest panel of a feature that is no contact's opening; infinite if there is none."""
    with np.errstate(all="ignore"):
        largest = float(np.max(np.abs(force(np.linspace(low, high, PLACES)))))
    rounding = ROUNDING * largest * (high - low) / PANELS
    try:
        edges = Integral.of(force, low, high, PANELS, allowed + rounding).edges
    except ValueError:
        return 0.0
    lengths = np.diff(edges)
    if _is_seen(force, low, high, edges):
        return math.inf
    halved = lengths < 0.6 * (high - low) / PANELS
    if force.opening is not None:
        apart = np.fmax(edges[:-1] - force.opening, force.opening - edges[1:])
        halved &= lengths < 0.5 * apart
    return float(lengths.min(initial=math.inf, where=halved))


def _is_seen(force: ForceProgram, low: float, high: float, edges: Array) -> bool:
    """Whether samples of the slope show what it is at and between the edges of panels."""
    gap = (high - low) / (PLACES - 1)
    x = np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])])
    if force.opening is not None:
        x = x[np.abs(x - force.opening) > 3.0 * gap]
    slopes = force.slope(np.linspace(low, high, PLACES))
    first = np.clip(((x - low) / gap).astype(np.int64) - 1, 0, PLACES - 4)
    t = (x - low) / gap - first
    weights = (
        (t - 1.0) * (t - 2.0) * (t - 3.0) / -6.0,
        t * (t - 2.0) * (t - 3.0) / 2.0,
        t * (t - 1.0) * (t - 3.0) / -2.0,
        t * (t - 1.0) * (t - 2.0) / 6.0,
    )
    expected = sum(weight * slopes[first + place] for place, weight in enumerate(weights))
    off = np.abs(force.slope(x) - expected).max(initial=0.0)
    return bool(off <= SEEN * np.abs(slopes).max())


def finite_range(force: ForceProgram, low: float, high: float, room: float) -> tuple[float, float]:
    """The range widened by ``room`` to either side, as far as there are forces."""
    found = []
    for end, side in ((low, -1.0), (high, 1.0)):
        places = end + side * room * np.linspace(0.0, 1.0, PLACES)
        with np.errstate(all="ignore"):
            broken = ~(np.isfinite(force(places)) & np.isfinite(force.slope(places)))
        found.append(float(places[max(0, int(np.argmax(broken)) - 1) if broken.any() else -1]))
    return found[0], found[1]
