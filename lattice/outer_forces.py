"""Forces from outside and other functions of time that drive a chain: what is to be known of them.

A kind of force is an entry: `SiteForce`, or a subclass that says otherwise on which cells it acts,
or by which law of their own displacement. Its kicks in the machine code, its work and heat, the
steps that see it, its derivatives and its cost follow.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.force_program import ForceProgram

Array = NDArray[np.float64]
TimeFunction = Callable[[Array], Array]
"""Of an array of times."""

LOOKED_AT = 2**17 + 1
"""Times at which what drives a chain is looked at before it is run. Steps resolve what is seen."""

JUMP, MOST_CORNERS = 0.25, 100
"""Share of the range of slopes by which one jumps at a corner, and corners beyond which it is taken
for a drive that is fast."""

TAIL = 1e-6
"""Share of the range of all slopes below which what is left beside followed spans has no corner."""

CLOSER, MOST_HIDDEN, HIDDEN = 6, 2**12, 0.1
"""Times that a formula is looked at 64 times closer, in at most so many gaps in which it may change
by that share of all its change: a push may lie in a gap. It went unseen with a width of 1e-4 in a
run of 2000. Where it still may when times can hardly be told apart, it jumps or has no bound."""


@dataclass(frozen=True)
class SiteForce:
    """The force ``value(t)`` on a field of the cell ``site``."""

    site: int
    value: TimeFunction
    field: int = 0

    @property
    def law(self) -> ForceProgram | None:
        """By what of its own displacement the force on a cell is multiplied; None for 1."""
        return None

    def shares(self, masses: Array) -> Array:
        """How much of it each cell feels, of those with these masses of the field."""
        found = np.zeros_like(masses)
        found[self.site] = 1.0
        return found

    def check(self, cells: int, fields: int) -> None:
        """Refuse what a chain of so many cells and fields does not have."""
        for name, value, size in (("site", self.site, cells), ("field", self.field, fields)):
            if value not in range(size):
                raise ValueError(f"{name} of a force must be 0 to {size - 1}, got {value}")

    def at(self, f: Array, times: Array, masses: Array) -> Array:
        """The forces on the cells at these times, where these are the fields, (times, cells)."""
        shares = self.shares(masses)
        found = values_at(self.value, times)[:, np.newaxis] * shares
        if self.law is not None:
            [cells] = np.nonzero(shares)
            found[:, cells] *= self.law(f[self.field][:, cells])
        return found


def slope_of(value: TimeFunction | None) -> TimeFunction:
    """The velocity of a wall."""
    found: TimeFunction | None = getattr(value, "slope", None)
    if found is None:
        raise ValueError(
            "displacement of a wall whose velocity is felt must have a slope, its velocity, got a "
            "bare function (longwave.scenes.description.time_functions.time_function makes one)"
        )
    return found


def values_at(value: TimeFunction, times: Array) -> Array:
    """A function's values at the times; ValueError where they are no numbers."""
    with np.errstate(all="ignore"):
        found = np.broadcast_to(np.asarray(value(times), dtype=np.float64), times.shape)
    if not np.isfinite(found).all():
        t = float(times[~np.isfinite(found)][0])
        raise ValueError(
            f"a force or displacement in time must be finite, got {found[~np.isfinite(found)][0]} "
            f"at t = {t:g} (end earlier or change the formula)"
        )
    return found


def looked_at(
    drives: Sequence[TimeFunction], begin: float, end: float, followed: Array | None = None
) -> tuple[float, bool]:
    """The least time in which a drive changes by all that it does, and whether one has a corner.

    Apart from times that are ``followed`` with steps of their own, (begin and end, spans).
    """
    times = np.linspace(begin, end, LOOKED_AT)
    least, turns = math.inf, False
    for value in drives:
        seen = _looked_closer(value, times)
        values = values_at(value, seen)
        slopes = np.diff(values) / (np.diff(seen) if end > begin else 1.0)
        is_open = _is_apart(seen, followed)
        steepest = float(np.abs(slopes).max(where=is_open, initial=0.0))
        spread = float(np.ptp(slopes[is_open])) if is_open.any() else 0.0
        least = min(least, float(np.ptp(values)) / steepest if steepest else math.inf)
        bends = np.abs(np.diff(slopes))[is_open[:-1] & is_open[1:]]
        jumps = np.count_nonzero(bends > JUMP * spread)
        spreads = spread > (0.0 if is_open.all() else TAIL * float(np.ptp(slopes)))
        turns = turns or bool(spreads and 0 < jumps <= MOST_CORNERS)
    return least, turns


def _is_apart(times: Array, spans: Array | None) -> NDArray[np.bool_]:
    """Whether what lies between two times meets none of the spans."""
    if spans is None or not spans.size:
        return np.ones(times.size - 1, dtype=np.bool_)
    begun = np.searchsorted(spans[0], times[1:], "left")
    return np.asarray(begun == np.searchsorted(spans[1], times[:-1], "right"))


def _looked_closer(value: TimeFunction, times: Array) -> Array:
    """The times, and more where a formula may do between two of them what neither shows."""
    if not isinstance(value, ForceProgram) or times[0] == times[-1]:
        return times
    for _ in range(CLOSER):
        values = values_at(value, times)
        with np.errstate(all="ignore"):
            low, high = value.enclosed(times[:-1], times[1:])
            widths = np.nan_to_num(high - low, nan=math.inf, posinf=math.inf)
        allowed = HIDDEN * max(np.ptp(values), widths.max(initial=0.0, where=widths < math.inf))
        [places] = np.nonzero(widths > allowed)
        if not 0 < places.size <= MOST_HIDDEN:
            return times
        between = np.linspace(times[places], times[places + 1], 65)[1:-1]
        times = np.union1d(times, between)
    raise ValueError(
        "a force or displacement in time must be bounded and without jumps, got one that is not "
        f"near t = {times[places[0]]:g} (end earlier or change the formula)"
    )
