"""Extent of a wave: the cells on which it deviates from its background at any time of a run.

A domain must be chosen before the first step, so the wave's extent must be known. It is sampled on
the whole line, not only on the compared cells: outwards from the zeros of its phases, on a grid
whose spacing grows with the distance. A domain that contains the extent contains the wave at all
times, so no part of it can go round a ring or be cut off by a window.
"""

from collections.abc import Sequence

import numpy as np

from longwave.support.real_arrays import Array

SAMPLED_TIMES = 17
"""Number of equidistant times at which the wave is sampled, in addition to some snapshots."""

DISTANCES = np.concatenate([np.linspace(0.0, 1.0, 21)[:-1], np.geomspace(1.0, 1e5, 360)])
"""Distances of sample points from a phase's zero, in units of xi; beyond 1 in steps of 3.2 %."""

LEVEL_FRACTION = 0.01
"""Least deviation from the far field counted as part of the wave, in units of the tolerance."""

CREST_FRACTION = 0.05
"""Least deviation counted as part of a wave with algebraic decay, in units of the largest
deviation."""

POWER_RATIO = 0.05
"""Threshold of the ratio of the deviations at twice a distance and at the distance itself; a larger
ratio means algebraic decay."""

DRIFT_FRACTION = 0.1
"""Margin added to a wave's ends, as a fraction of their drift over the run, because the wave on the
lattice may drift differently from the closed form."""


def sampled_times(times: Sequence[float]) -> list[float]:
    """Return equidistant times, some of ``times``, and t = 0 (rogue waves' peak) if between."""
    t0, end = times[0], times[-1]
    crest = {0.0} if t0 < 0.0 < end else set()
    subset = times[:: max(1, len(times) // SAMPLED_TIMES)]
    return sorted({*np.linspace(t0, end, SAMPLED_TIMES).tolist(), *subset, *crest})


def sample_points(zeros: Sequence[float], unit: float) -> Array:
    """Return sorted points at `DISTANCES`, in this ``unit``, on both sides of the ``zeros``."""
    offsets = unit * np.concatenate([-DISTANCES[:0:-1], DISTANCES])
    return np.unique(np.concatenate([zero + offsets for zero in zeros]))


def extent(supports: Sequence[tuple[float, float] | None]) -> tuple[float, float]:
    """Return the ends of a wave over all times, from its ends at some times, with a margin.

    (inf, -inf) if there is no wave at any of the times.
    """
    ends = [support for support in supports if support is not None]
    if not ends:
        return np.inf, -np.inf
    lows, highs = np.array(ends).T
    low = float(lows.min()) - DRIFT_FRACTION * float(np.ptp(lows))
    return low, float(highs.max()) + DRIFT_FRACTION * float(np.ptp(highs))


def support_of(x: Array, deviation: Array, tolerance: float) -> tuple[float, float] | None:
    """Return the ends of a wave from its deviation at points x; None if the deviation is too small.

    Outside the ends the deviation is below a fraction of ``tolerance`` or, for algebraic decay,
    below a fraction of its largest value; a control run in another domain reveals the effect of the
    part cut off.
    """
    level, largest = LEVEL_FRACTION * tolerance, float(deviation.max())
    if largest <= level:
        return None
    inside = np.flatnonzero(deviation > level)
    first, last = int(inside[0]), int(inside[-1])
    if _decays_like_a_power(x, deviation, first) or _decays_like_a_power(x, deviation, last):
        inside = np.flatnonzero(deviation > max(level, CREST_FRACTION * largest))
        first, last = int(inside[0]), int(inside[-1])
    step = 1 if last + 1 < x.size else 0
    return float(x[max(first - 1, 0)]), float(x[last + step])


def _decays_like_a_power(x: Array, deviation: Array, index: int) -> bool:
    """Return whether the deviation falls like a power beyond the wave's end, at ``x[index]``."""
    crest = float(x[int(np.argmax(deviation))])
    if index in (0, x.size - 1):
        return True
    beyond = crest + 2.0 * (x[index] - crest)
    rest = x >= beyond if x[index] > crest else x <= beyond
    return not rest.any() or float(np.max(deviation[rest])) > POWER_RATIO * float(deviation[index])
