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

GAPS, FITTED, MOST_GAPS = 8, 8, 640
"""Gaps between samples of a slope at first, points of the polynomials through them, and the most
gaps: what is narrower shows on the panels of the integral."""

SMOOTH, MARGIN = 64.0, 0.1
"""The factor by which halving gaps lessens what polynomials are off by where a law is smooth (256
in the end), and the share of a range at its ends that is not looked at."""

ROUNDING = 1e-13
"""Share of the largest force, times a panel, that is taken for rounding."""


@dataclass(frozen=True)
class Feature:
    """The ``width`` that a step must resolve, infinite where all is smooth; whether there are
    corners, at which errors fall with a low order."""

    width: float
    turns: bool = False


def find_feature(
    force: ForceProgram, low: float, high: float, impulse: float, gaps: int = GAPS
) -> Feature:
    """The narrowest feature of a law between two stretches.

    ``impulse`` is the energy that may go unseen, a velocity times the rate of stretch. Samples of
    the slope with so many ``gaps`` between them show what is smooth.
    """
    if force.is_smooth or not low < high:
        return Feature(math.inf)
    with np.errstate(all="ignore"):
        if not np.isfinite(force(np.linspace(low, high, PLACES))).all():  # a run through a pole
            return Feature(math.inf)
        return _feature(force, low, high, impulse, gaps)


def _feature(force: ForceProgram, low: float, high: float, impulse: float, gaps: int) -> Feature:
    width = _narrowest(force, low, high, FOLLOWED * impulse, gaps)
    if width == math.inf:
        return Feature(math.inf)
    turns = _narrowest(force, low, high, FINER * FOLLOWED * impulse, gaps) < width / CORNER
    seen = float(np.max(np.abs(force.slope(np.linspace(low, high, PLACES)))))
    if turns and force.steepest_between(low, high, seen) == seen:
        return Feature(math.inf, True)
    return Feature(width, turns)


def _narrowest(force: ForceProgram, low: float, high: float, allowed: float, gaps: int) -> float:
    """The shortest panel of a feature that is no contact's opening; infinite if there is none."""
    with np.errstate(all="ignore"):
        largest = float(np.max(np.abs(force(np.linspace(low, high, PLACES)))))
    allowed += ROUNDING * largest * (high - low) / PANELS
    try:
        edges = Integral.of(force, low, high, PANELS, allowed).edges
    except ValueError:
        return 0.0
    fitted, lengths = _fitted(force, low, high, allowed, gaps), np.diff(edges)
    if _is_seen(force, low, high, edges):
        return fitted
    halved = lengths < 0.6 * (high - low) / PANELS
    if force.opening is not None:
        apart = np.fmax(edges[:-1] - force.opening, force.opening - edges[1:])
        halved &= lengths < 0.5 * apart
    return min(fitted, float(lengths.min(initial=math.inf, where=halved)))


def _is_seen(force: ForceProgram, low: float, high: float, edges: Array) -> bool:
    """Whether samples of the slope show what it is at and between the edges of panels."""
    gap = (high - low) / (PLACES - 1)
    x = np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])])
    if force.opening is not None:
        x = x[np.abs(x - force.opening) > 3.0 * gap]
    slopes = force.slope(np.linspace(low, high, PLACES))
    off = _off_polynomials(slopes, (x - low) / gap, force.slope(x), 4)
    return bool(off.max(initial=0.0) <= SEEN * np.abs(slopes).max())


def _fitted(force: ForceProgram, low: float, high: float, allowed: float, gaps: int) -> float:
    """Twice the distance of samples from which on polynomials through slopes give the force.

    They do where what they are off by falls as it does for a smooth law: then two runs that are
    compared show what steps cost. Infinite where ``gaps`` between samples are enough.
    """
    width, before = math.inf, 0.0
    while gaps <= MOST_GAPS:
        off = _off_samples(force, low, high, gaps)
        if before > allowed and off > before / SMOOTH:
            width = 2.0 * (high - low) / gaps
        gaps, before = 2 * gaps, off
    return width


def _off_samples(force: ForceProgram, low: float, high: float, gaps: int) -> float:
    """How far, times a gap squared, slopes between samples are off polynomials through these.

    Beyond what there is about a contact's opening, and away from the range's ends.
    """
    gap = (high - low) / gaps
    samples: Array = np.linspace(low, high, gaps + 1)
    x = samples[:-1] + 0.5 * gap
    x = x[(x - low > MARGIN * (high - low)) & (high - x > MARGIN * (high - low))]
    slopes, between = force.slope(samples), force.slope(x)
    off = _off_polynomials(slopes, (x - low) / gap, between, FITTED)
    if force.opening is not None:
        apart = np.abs(x - force.opening) / gap
        off -= np.where(apart < FITTED, np.inf, np.abs(between) / np.fmax(apart, 1.0) ** 6)
    return float(gap**2 * np.maximum(off, 0.0).max(initial=0.0))


def _off_polynomials(samples: Array, t: Array, values: Array, points: int) -> Array:
    """How far values at ``t``, in gaps, are off polynomials through ``points`` samples nearby."""
    first = np.clip(t.astype(np.int64) - (points // 2 - 1), 0, samples.size - points)
    t = t - first
    expected = np.zeros_like(t)
    for place in range(points):
        others = [other for other in range(points) if other != place]
        weight = np.prod([(t - other) / (place - other) for other in others], axis=0)
        expected += weight * samples[first + place]
    return np.asarray(np.abs(values - expected))


def finite_range(force: ForceProgram, low: float, high: float, room: float) -> tuple[float, float]:
    """The range widened by ``room`` to either side, as far as slopes are bounded."""
    found = []
    for end, side in ((low, -1.0), (high, 1.0)):
        places = end + side * room * np.linspace(0.0, 1.0, PLACES)
        pairs = np.sort([places[:-1], places[1:]], axis=0)
        with np.errstate(all="ignore"):
            broken = ~np.isfinite([force(places[1:]), *force.slope_enclosed(*pairs)]).all(axis=0)
        found.append(float(places[int(np.argmax(broken)) if broken.any() else -1]))
    return found[0], found[1]
