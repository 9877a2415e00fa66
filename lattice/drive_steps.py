"""Steps that follow what drives a chain in time: one for all times, and more stops at features.

Where a drive changes faster than a step for a short while, as at a pulse or a corner, stops are
put so close that the scheme's stages give its integral there. What is short is found on the panels
of its integral to rounding, on which its slope is enclosed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import DriveSteps
from longwave.lattice.outer_forces import TimeFunction, looked_at
from longwave.lattice.schemes import DriftKick, Scheme
from longwave.lattice.time_integral import LEAST_PANEL, Integral

Array = NDArray[np.float64]

FOLLOWED = 1e-5
"""Share of the tolerance that the integral of a drive may be off by on one panel."""

SHORT = 0.1
"""Share of a run's time that may take stops of its own."""

ASIDE = 0.618034
"""Share of a panel by which they are moved aside: a corner at a round time lies on none's edge."""

MOST_STOPS, MOST_HALVED = 2**14, 2**17
"""Stops beside those that are asked for, and panels that are looked at."""

ROUNDING = 2.0**-48
"""Share of the largest integral that is taken for rounding."""


def drive_steps(
    drives: Sequence[TimeFunction],
    begin: float,
    end: float,
    step: float,
    scheme: Scheme,
    tolerance: float,
) -> tuple[DriveSteps, float]:
    """The steps, none longer than ``step``, and the time in which drives change beside the stops.

    ``tolerance`` is that of the velocities that drives give.
    """
    stops, spans, missed = [np.zeros(0)], [np.zeros((2, 0))], 0.0
    for value in drives:
        formula = value.slope if isinstance(value, Integral) else value
        if isinstance(formula, ForceProgram) and isinstance(scheme, DriftKick) and begin < end:
            step, found, off = _followed(formula, begin, end, step, scheme, tolerance)
            if found.size:
                missed += off
                stops.append(np.unique(found))
                spans.append(_joined(*found))
    own = np.unique(np.concatenate(stops))
    followed = _joined(*np.concatenate(spans, axis=1))
    within, turns = looked_at(drives, begin, end, followed)
    return DriveSteps(step, own[(begin < own) & (own < end)], turns, missed), within


@lru_cache(maxsize=16)
def _exact(formula: ForceProgram, begin: float, end: float) -> Integral | None:
    """Its integral; None where it changes too fast for that."""
    try:
        return Integral.of(formula, begin, end)
    except ValueError:
        return None


@lru_cache(maxsize=16)
def _followed(
    formula: ForceProgram,
    begin: float,
    end: float,
    step: float,
    scheme: DriftKick,
    tolerance: float,
) -> tuple[float, Array, float]:
    """Return the step at most times, and the panels, (2, panels), followed with shorter ones.

    And the sum of what the scheme's stages miss of the integral on each of these panels.
    """
    exact, nothing = _exact(formula, begin, end), np.zeros((2, 0))
    if exact is None or not np.isfinite(exact.sums).all():
        return step, nothing, 0.0
    count = max(2, math.ceil((end - begin) / step))
    if count > MOST_HALVED:
        return step, nothing, 0.0
    inner = begin + (end - begin) * (np.arange(1, count - 1) + ASIDE) / count
    edges = np.concatenate([[begin], inner, [end]])
    panels = _halved(exact, np.array([edges[:-1], edges[1:]]), 0.0, None)
    allowed = FOLLOWED * tolerance
    lengths, bound = panels[1] - panels[0], step
    for _ in range(60):
        short = lengths < 0.6 * bound
        if lengths[short].sum() <= SHORT * (end - begin):
            found = _halved(exact, panels[:, short], allowed, scheme)
            if found.shape[1] <= MOST_STOPS:
                return bound, found, float(_missed(exact, found[0], found[1], scheme).sum())
        bound /= 2.0
    return bound, nothing, 0.0


def _missed(exact: Integral, low: Array, high: Array, scheme: DriftKick | None) -> Array:
    """Return how far Gauss's rule, or a scheme's stages, are off the integral on each panel.

    What swings to and fro has no integral on a panel where it hides: Gauss's rule must give that to
    any place between, and the stages what the integral itself comes to.
    """
    if scheme is None:
        return np.asarray(exact.missed_within(low, high))
    nodes = np.cumsum(scheme.drifts)[:-1]
    with np.errstate(all="ignore"):
        found = exact.slope(np.add.outer(low, 0.0 * nodes) + np.outer(high - low, nodes))
    length = high - low
    pushed = length * (found @ scheme.kicks) - (exact(high) - exact(low))
    moved = length * (found @ (scheme.kicks * (1.0 - nodes))) - exact.moment(low, high)
    return np.asarray(np.maximum(np.abs(pushed), np.abs(moved)))


def _halved(exact: Integral, panels: Array, allowed: float, scheme: DriftKick | None) -> Array:
    """The panels, halved until Gauss's rule, or a scheme's stages, give each one's integral."""
    done, count = [panels[:, :0]], panels.shape[1]
    rounding = ROUNDING * float(np.abs(exact.sums).max())
    while panels.size and count <= MOST_HALVED:
        low, high = panels
        apart = _missed(exact, low, high, scheme)
        rough = ~(apart <= exact.rounding(low, high) + rounding + allowed)
        rough &= high - low > 2.0 * LEAST_PANEL * np.maximum(np.abs(low), np.abs(high))
        done.append(panels[:, ~rough])
        low, high = panels[:, rough]
        middle = (low + high) / 2.0
        panels = np.array([np.append(low, middle), np.append(middle, high)])
        count += low.size
    done.append(panels)
    found = np.concatenate(done, axis=1)
    return found[:, np.argsort(found[0])]


def _joined(low: Array, high: Array) -> Array:
    """Spans that do not meet, in their order, in the place of those that do."""
    order = np.argsort(low)
    low, high = low[order], np.maximum.accumulate(high[order]) if low.size else high
    first = np.append(True, low[1:] > high[:-1]) if low.size else np.zeros(0, dtype=np.bool_)
    return np.array([low[first], high[np.append(first[1:], True)] if low.size else high])
