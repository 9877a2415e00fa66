"""Narrow features of force laws, and step sizes that resolve them.

A narrow bump in a force that stretches cross within one step leaves no trace in either of two runs
that are compared. Therefore the range of stretches visited by a run is covered by panels on which
the force's integral, the bond's stored energy, is accurate. Where panels are short, a step may
change the stretch by a fraction of a panel only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from longwave.lattice.force_program import SLOPE_SAMPLES, ForceProgram
from longwave.lattice.time_integral import Integral
from longwave.support.real_arrays import Array

INITIAL_PANELS = 64
"""Initial number of panels on a range of stretches."""

MISSED_FRACTION = 1e-2
"""Largest fraction of the allowed velocity error that an unresolved feature may cause."""

STEP_FRACTION = 0.5
"""Largest change of a stretch in one step, as a fraction of the narrowest feature's width."""

CORNER_RATIO, CORNER_ERROR_RATIO = 4.0, 1e-4
"""A feature is a corner if its panels get shorter by more than the factor `CORNER_RATIO` when the
allowed error is multiplied by `CORNER_ERROR_RATIO`."""

MAX_SLOPE_ERROR = 1e-3
"""Largest error of cubic interpolation between slope samples, in units of the largest slope, at
which a law counts as smooth: comparing two runs then shows the error of the step."""

INITIAL_GAPS, FITTED_POINTS, MAX_GAPS = 8, 8, 640
"""First number of gaps between sampled slopes, number of points that each polynomial is fitted to,
and largest number of gaps. Narrower features show on the panels of the integral."""

SMOOTH_ERROR_RATIO, END_FRACTION = 64.0, 0.1
"""Least factor by which halving the gaps reduces the polynomials' error for a smooth law (256
asymptotically), and fraction of a range, at either end, that is not checked."""

PANEL_ROUNDING = 1e-13
"""Rounding error of a panel's integral, in units of the largest force times the length."""


@dataclass(frozen=True)
class Feature:
    """Narrowest feature of a force: its ``width`` (inf if smooth); ``turns`` marks a corner."""

    width: float
    turns: bool = False


def find_feature(
    force: ForceProgram, low: float, high: float, impulse: float, gaps: int = INITIAL_GAPS
) -> Feature:
    """Return the narrowest feature of a force law between two stretches.

    ``impulse`` is the allowed velocity error times the rate of stretch; a feature may be missed if
    its energy is below the fraction `MISSED_FRACTION` of that. Slopes sampled first with ``gaps``
    gaps identify smooth laws.
    """
    if force.is_smooth or not low < high:
        return Feature(math.inf)
    with np.errstate(all="ignore"):
        stretches = np.linspace(low, high, SLOPE_SAMPLES)
        if not np.isfinite(force(stretches)).all():  # the range contains a pole
            return Feature(math.inf)
        width = _narrowest(force, low, high, MISSED_FRACTION * impulse, gaps)
        if width == math.inf:
            return Feature(math.inf)
        lower = CORNER_ERROR_RATIO * MISSED_FRACTION * impulse
        turns = _narrowest(force, low, high, lower, gaps) < width / CORNER_RATIO
        sampled = float(np.max(np.abs(force.slope(stretches))))
    if turns and force.steepest_between(low, high, sampled) == sampled:
        return Feature(math.inf, True)
    return Feature(width, turns)


def _narrowest(force: ForceProgram, low: float, high: float, allowed: float, gaps: int) -> float:
    """Return the width of the narrowest feature but a contact's opening; inf if there is none."""
    with np.errstate(all="ignore"):
        largest = float(np.max(np.abs(force(np.linspace(low, high, SLOPE_SAMPLES)))))
    allowed += PANEL_ROUNDING * largest * (high - low) / INITIAL_PANELS
    try:
        edges = Integral.of(force, low, high, INITIAL_PANELS, allowed).edges
    except ValueError:
        return 0.0
    sample_width, lengths = _sample_width(force, low, high, allowed, gaps), np.diff(edges)
    if _is_resolved(force, low, high, edges):
        return sample_width
    halved = lengths < 0.6 * (high - low) / INITIAL_PANELS
    if force.opening is not None:
        distance = np.fmax(edges[:-1] - force.opening, force.opening - edges[1:])
        halved &= lengths < 0.5 * distance
    return min(sample_width, float(lengths.min(initial=math.inf, where=halved)))


def _is_resolved(force: ForceProgram, low: float, high: float, edges: Array) -> bool:
    """Return whether cubics through sampled slopes reproduce the slope on all panels."""
    gap = (high - low) / (SLOPE_SAMPLES - 1)
    x = np.concatenate([edges, 0.5 * (edges[1:] + edges[:-1])])
    if force.opening is not None:
        x = x[np.abs(x - force.opening) > 3.0 * gap]
    slopes = force.slope(np.linspace(low, high, SLOPE_SAMPLES))
    error = _interpolation_error(slopes, (x - low) / gap, force.slope(x), 4)
    return bool(error.max(initial=0.0) <= MAX_SLOPE_ERROR * np.abs(slopes).max())


def _sample_width(force: ForceProgram, low: float, high: float, allowed: float, gaps: int) -> float:
    """Return twice the sample distance at which polynomials through the slopes reproduce the force.

    The test is that their error falls as for a smooth law; comparing two runs then shows the error
    of the step. Infinite if the first number of ``gaps`` is enough.
    """
    width, before = math.inf, 0.0
    while gaps <= MAX_GAPS:
        error = _sampling_error(force, low, high, gaps)
        if before > allowed and error > before / SMOOTH_ERROR_RATIO:
            width = 2.0 * (high - low) / gaps
        gaps, before = 2 * gaps, error
    return width


def _sampling_error(force: ForceProgram, low: float, high: float, gaps: int) -> float:
    """Return the error of polynomials through sampled slopes, times the gap squared.

    The error expected near a contact's opening is subtracted; the ends of the range are left out.
    """
    gap = (high - low) / gaps
    samples: Array = np.linspace(low, high, gaps + 1)
    x = samples[:-1] + 0.5 * gap
    x = x[(x - low > END_FRACTION * (high - low)) & (high - x > END_FRACTION * (high - low))]
    slopes, values = force.slope(samples), force.slope(x)
    error = _interpolation_error(slopes, (x - low) / gap, values, FITTED_POINTS)
    if force.opening is not None:
        distance = np.abs(x - force.opening) / gap
        expected = np.abs(values) / np.fmax(distance, 1.0) ** 6
        error -= np.where(distance < FITTED_POINTS, np.inf, expected)
    return float(gap**2 * np.maximum(error, 0.0).max(initial=0.0))


def _interpolation_error(samples: Array, t: Array, values: Array, points: int) -> Array:
    """Return abs(values - interpolant) at ``t`` (in gaps); a polynomial has ``points`` samples."""
    first = np.clip(t.astype(np.int64) - (points // 2 - 1), 0, samples.size - points)
    t = t - first
    expected = np.zeros_like(t)
    for index in range(points):
        others = [other for other in range(points) if other != index]
        weight = np.prod([(t - other) / (index - other) for other in others], axis=0)
        expected += weight * samples[first + index]
    return np.asarray(np.abs(values - expected))


def finite_range(force: ForceProgram, low: float, high: float, pad: float) -> tuple[float, float]:
    """Return the range widened at each end by ``pad``, or less where the slope is unbounded."""
    ends = []
    for end, side in ((low, -1.0), (high, 1.0)):
        samples = end + side * pad * np.linspace(0.0, 1.0, SLOPE_SAMPLES)
        pairs = np.sort([samples[:-1], samples[1:]], axis=0)
        with np.errstate(all="ignore"):
            broken = ~np.isfinite([force(samples[1:]), *force.slope_enclosed(*pairs)]).all(axis=0)
        ends.append(float(samples[int(np.argmax(broken)) if broken.any() else -1]))
    return ends[0], ends[1]
