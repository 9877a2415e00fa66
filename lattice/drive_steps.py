"""Steps that resolve the drives of a chain: one step size, and additional stops at short features.

Where a drive changes faster than a step for a short while, as at a pulse or a corner, the stops are
so close that the scheme's stages integrate it to the tolerance. Such features are found on panels
on which the drive's integral is known to rounding and its slope is enclosed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from longwave.lattice.force_program import ForceProgram
from longwave.lattice.numeric_lattice import DriveSteps
from longwave.lattice.outer_forces import TimeFunction, shortest_time_scale
from longwave.lattice.schemes import DriftKick, Scheme
from longwave.lattice.time_integral import LEAST_PANEL, Integral
from longwave.support.real_arrays import Array

PANEL_ERROR_FRACTION = 1e-5
"""Fraction of the tolerance allowed for the error of a drive's integral on one panel."""

MAX_STOPS_FRACTION = 0.1
"""Largest fraction of a run's time that may be covered by additional stops."""

PANEL_SHIFT = 0.618034
"""Shift of the panels, in panel lengths, so that corners at round times lie on no panel's edge."""

MAX_STOPS, MAX_PANELS = 2**14, 2**17
"""Largest number of additional stops, and largest number of panels examined."""

INTEGRAL_ROUNDING = 2.0**-48
"""Rounding error of a drive's integral, as a fraction of its largest absolute value."""


def drive_steps(
    drives: Sequence[TimeFunction],
    begin: float,
    end: float,
    step: float,
    scheme: Scheme,
    tolerance: float,
) -> tuple[DriveSteps, float]:
    """Return steps of at most ``step`` that resolve the drives, and the remaining time scale.

    The remaining time scale is the shortest one of the drives outside the spans with additional
    stops. ``tolerance`` is the allowed error of the velocities that the drives cause.
    """
    stops, spans, missed = [np.zeros(0)], [np.zeros((2, 0))], 0.0
    for value in drives:
        formula = value.slope if isinstance(value, Integral) else value
        if isinstance(formula, ForceProgram) and isinstance(scheme, DriftKick) and begin < end:
            step, panels, error = _step_and_panels(formula, begin, end, step, scheme, tolerance)
            if panels.size:
                missed += error
                stops.append(np.unique(panels))
                spans.append(_merged_spans(*panels))
    added = np.unique(np.concatenate(stops))
    covered = _merged_spans(*np.concatenate(spans, axis=1))
    within, turns = shortest_time_scale(drives, begin, end, covered)
    return DriveSteps(step, added[(begin < added) & (added < end)], turns, missed), within


@lru_cache(maxsize=16)
def _exact_integral(formula: ForceProgram, begin: float, end: float) -> Integral | None:
    """Return the integral of a drive, or None if the drive changes too fast to integrate it."""
    try:
        return Integral.of(formula, begin, end)
    except ValueError:
        return None


@lru_cache(maxsize=16)
def _step_and_panels(
    formula: ForceProgram,
    begin: float,
    end: float,
    step: float,
    scheme: DriftKick,
    tolerance: float,
) -> tuple[float, Array, float]:
    """Return the usual step, the panels that need shorter steps, and those panels' total error."""
    exact, no_panels = _exact_integral(formula, begin, end), np.zeros((2, 0))
    if exact is None or not np.isfinite(exact.sums).all():
        return step, no_panels, 0.0
    count = max(2, math.ceil((end - begin) / step))
    if count > MAX_PANELS:
        return step, no_panels, 0.0
    inner = begin + (end - begin) * (np.arange(1, count - 1) + PANEL_SHIFT) / count
    edges = np.concatenate([[begin], inner, [end]])
    panels = _refined(exact, np.array([edges[:-1], edges[1:]]), 0.0, None)
    allowed = PANEL_ERROR_FRACTION * tolerance
    lengths, bound = panels[1] - panels[0], step
    for _ in range(60):
        short = lengths < 0.6 * bound
        if lengths[short].sum() <= MAX_STOPS_FRACTION * (end - begin):
            short_panels = _refined(exact, panels[:, short], allowed, scheme)
            if short_panels.shape[1] <= MAX_STOPS:
                return (
                    bound,
                    short_panels,
                    float(_panel_errors(exact, short_panels[0], short_panels[1], scheme).sum()),
                )
        bound /= 2.0
    return bound, no_panels, 0.0


def _panel_errors(exact: Integral, low: Array, high: Array, scheme: DriftKick | None) -> Array:
    """Return each panel's error by the scheme's stages, or by Gauss's rule if ``scheme`` is None.

    Gauss's rule is compared with the integrals up to every intermediate point, because it gives no
    reliable integral of an oscillation that it does not resolve. The stages are compared with the
    integral over the whole panel.
    """
    if scheme is None:
        return np.asarray(exact.missed_within(low, high))
    nodes = np.cumsum(scheme.drifts)[:-1]
    with np.errstate(all="ignore"):
        slopes = exact.slope(np.add.outer(low, 0.0 * nodes) + np.outer(high - low, nodes))
    length = high - low
    velocity_error = length * (slopes @ scheme.kicks) - (exact(high) - exact(low))
    position_error = length * (slopes @ (scheme.kicks * (1.0 - nodes))) - exact.moment(low, high)
    return np.asarray(np.maximum(np.abs(velocity_error), np.abs(position_error)))


def _refined(exact: Integral, panels: Array, allowed: float, scheme: DriftKick | None) -> Array:
    """Halve the panels until the error of each is at most ``allowed`` plus rounding."""
    done, count = [panels[:, :0]], panels.shape[1]
    rounding = INTEGRAL_ROUNDING * float(np.abs(exact.sums).max())
    while panels.size and count <= MAX_PANELS:
        low, high = panels
        errors = _panel_errors(exact, low, high, scheme)
        rough = ~(errors <= exact.rounding(low, high) + rounding + allowed)
        rough &= high - low > 2.0 * LEAST_PANEL * np.maximum(np.abs(low), np.abs(high))
        done.append(panels[:, ~rough])
        low, high = panels[:, rough]
        middle = (low + high) / 2.0
        panels = np.array([np.append(low, middle), np.append(middle, high)])
        count += low.size
    done.append(panels)
    result = np.concatenate(done, axis=1)
    return result[:, np.argsort(result[0])]


def _merged_spans(low: Array, high: Array) -> Array:
    """Return the union of the spans from ``low`` to ``high`` as ascending disjoint spans."""
    order = np.argsort(low)
    low, high = low[order], np.maximum.accumulate(high[order]) if low.size else high
    first = np.append(True, low[1:] > high[:-1]) if low.size else np.zeros(0, dtype=np.bool_)
    return np.array([low[first], high[np.append(first[1:], True)] if low.size else high])
