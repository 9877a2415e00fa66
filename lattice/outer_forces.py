"""External forces and other functions of time that drive a chain: their values and time scales.

A kind of force is one class: `SiteForce`, or a subclass that acts on other cells or depends on
their displacement. Compiled kicks, work and heat, step sizes, derivatives and costs follow from it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from longwave.lattice.force_program import ForceProgram
from longwave.support.real_arrays import Array, Mask

TimeFunction = Callable[[Array], Array]
"""Function of an array of times."""

SAMPLED_TIMES = 2**17 + 1
"""Times at which drives are sampled before a run, to find the steps that resolve them."""

CORNER_JUMP, MAX_CORNERS = 0.25, 100
"""Least jump of a slope at a corner, as a fraction of the slopes' range, and largest number of
corners of a drive: a drive with more jumps counts as fast, without corners."""

MIN_SLOPE_RANGE = 1e-6
"""Range of slopes outside the followed spans, as a fraction of the range of all slopes, below which
there are no corners."""

MAX_REFINEMENTS, MAX_REFINED_GAPS, HIDDEN_FRACTION = 6, 2**12, 0.1
"""Largest number of refinements of the sampling by 64, largest number of gaps refined, and fraction
of the total change that may hide in a gap (without them, a pulse of width 1e-4 in a run of 2000 was
missed). If a gap may hide more even where times are hardly distinct, the drive jumps or is
unbounded."""


@dataclass(frozen=True)
class SiteForce:
    """External force ``value(t)`` on a field of the cell ``site``."""

    site: int
    value: TimeFunction
    field: int = 0

    @property
    def law(self) -> ForceProgram | None:
        """Factor of the force as a function of the cell's displacement; None if it is always 1."""
        return None

    def shares(self, masses: Array) -> Array:
        """Return each cell's factor of ``value(t)``, given the masses of the field in all cells."""
        shares = np.zeros_like(masses)
        shares[self.site] = 1.0
        return shares

    def check(self, cells: int, fields: int) -> None:
        """Raise ValueError if the chain does not have the force's cell or field."""
        for name, value, size in (("site", self.site, cells), ("field", self.field, fields)):
            if value not in range(size):
                raise ValueError(
                    f"{name} of a force must be 0 to {size - 1}, got {value} (take one of these)"
                )

    def at(self, f: Array, times: Array, masses: Array) -> Array:
        """Return the force on each cell, (times, cells), for the fields ``f`` at these times."""
        shares = self.shares(masses)
        forces = values_at(self.value, times)[:, np.newaxis] * shares
        if self.law is not None:
            [cells] = np.nonzero(shares)
            forces[:, cells] *= self.law(f[self.field][:, cells])
        return forces


def slope_of(value: TimeFunction | None) -> TimeFunction:
    """Return the slope of a wall's displacement ``value``; raise ValueError if it has none."""
    slope: TimeFunction | None = getattr(value, "slope", None)
    if slope is None:
        raise ValueError(
            "displacement of a wall with dashpots must have a slope, its velocity, got a bare "
            "function (longwave.scenes.description.time_functions.time_function builds one)"
        )
    return slope


def values_at(value: TimeFunction, times: Array) -> Array:
    """Return a function's values at the times. Raises ValueError if one is not finite."""
    with np.errstate(all="ignore"):
        values = np.broadcast_to(np.asarray(value(times), dtype=np.float64), times.shape)
    if not np.isfinite(values).all():
        t = float(times[~np.isfinite(values)][0])
        raise ValueError(
            "a force or displacement in time must be finite, got "
            f"{values[~np.isfinite(values)][0]} at t = {t:g} (end earlier or change the formula)"
        )
    return values


def shortest_time_scale(
    drives: Sequence[TimeFunction], begin: float, end: float, followed: Array | None = None
) -> tuple[float, bool]:
    """Return the shortest time scale of the drives, and whether one has a corner.

    A drive's time scale is the range of its values over its steepest slope. The spans ``followed``,
    (begin and end, spans), are left out, because they have steps of their own.
    """
    times = np.linspace(begin, end, SAMPLED_TIMES)
    least, turns = math.inf, False
    for value in drives:
        sampled = _refined_times(value, times)
        values = values_at(value, sampled)
        slopes = np.diff(values) / (np.diff(sampled) if end > begin else 1.0)
        is_open = _is_outside(sampled, followed)
        steepest = float(np.abs(slopes).max(where=is_open, initial=0.0))
        slope_range = float(np.ptp(slopes[is_open])) if is_open.any() else 0.0
        least = min(least, float(np.ptp(values)) / steepest if steepest else math.inf)
        bends = np.abs(np.diff(slopes))[is_open[:-1] & is_open[1:]]
        jumps = np.count_nonzero(bends > CORNER_JUMP * slope_range)
        least_range = 0.0 if is_open.all() else MIN_SLOPE_RANGE * float(np.ptp(slopes))
        turns = turns or bool(slope_range > least_range and 0 < jumps <= MAX_CORNERS)
    return least, turns


def _is_outside(times: Array, spans: Array | None) -> Mask:
    """Return a mask of the gaps between successive times that meet none of the spans."""
    if spans is None or not spans.size:
        return np.ones(times.size - 1, dtype=np.bool_)
    started = np.searchsorted(spans[0], times[1:], "left")
    return np.asarray(started == np.searchsorted(spans[1], times[:-1], "right"))


def _refined_times(value: TimeFunction, times: Array) -> Array:
    """Return the times, and more times where a formula may change unnoticed between two of them."""
    if not isinstance(value, ForceProgram) or times[0] == times[-1]:
        return times
    for _ in range(MAX_REFINEMENTS):
        values = values_at(value, times)
        with np.errstate(all="ignore"):
            low, high = value.enclosed(times[:-1], times[1:])
            widths = np.nan_to_num(high - low, nan=math.inf, posinf=math.inf)
        largest = max(np.ptp(values), widths.max(initial=0.0, where=widths < math.inf))
        allowed = HIDDEN_FRACTION * largest
        [gaps] = np.nonzero(widths > allowed)
        if not 0 < gaps.size <= MAX_REFINED_GAPS:
            return times
        between = np.linspace(times[gaps], times[gaps + 1], 65)[1:-1]
        times = np.union1d(times, between)
    raise ValueError(
        "a force or displacement in time must be bounded and without jumps, got one that is not "
        f"near t = {times[gaps[0]]:g} (end earlier or change the formula)"
    )
