"""Where a wave is: the cells on which it deviates from its background, at all times of a run.

A plan must know before any step where the wave is. It is looked for on the whole line, not on the
compared cells alone: outwards from where its phases vanish, on a grid whose spacing grows with the
distance. A domain that holds these cells holds the wave at all times, so nothing of it can come
back round a ring or be cut off by a window.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TIMES = 17
"""Equidistant times at which the wave is looked at, beside the snapshots (as many at most)."""

DISTANCES = np.concatenate([np.linspace(0.0, 1.0, 21)[:-1], np.geomspace(1.0, 1e5, 360)])
"""Distances from the zero of a phase, in units of the wave's variable xi; they grow by 3.2 %."""

LEVEL = 0.01
"""Deviation from the far field below which there is no wave, in units of the tolerance."""

CREST_SHARE = 0.05
"""The same in units of the largest deviation, for waves that decay like a power."""

POWER = 0.05
"""What is left of the deviation at twice the distance, at least, where it decays like a power."""

DRIFT_SHARE = 0.1
"""The lattice's wave may run this share of its drift ahead of the closed form."""


def watched_times(times: Sequence[float]) -> list[float]:
    """Equidistant times, some of those given, and the crest's."""
    t0, end = times[0], times[-1]
    crest = {0.0} if t0 < 0.0 < end else set()
    some = times[:: max(1, len(times) // TIMES)]
    return sorted({*np.linspace(t0, end, TIMES).tolist(), *some, *crest})


def places_about(zeros: Sequence[float], unit: float) -> Array:
    """Places in order, close together about the zeros and ever farther apart beyond them."""
    offsets = unit * np.concatenate([-DISTANCES[:0:-1], DISTANCES])
    return np.unique(np.concatenate([zero + offsets for zero in zeros]))


def extent(supports: Sequence[tuple[float, float] | None]) -> tuple[float, float]:
    """The ends of a wave at all times, from those at some; inside out if it is nowhere."""
    ends = [support for support in supports if support is not None]
    if not ends:
        return np.inf, -np.inf
    lows, highs = np.array(ends).T
    low = float(lows.min()) - DRIFT_SHARE * float(np.ptp(lows))
    return low, float(highs.max()) + DRIFT_SHARE * float(np.ptp(highs))


def support_of(x: Array, deviation: Array, tolerance: float) -> tuple[float, float] | None:
    """The ends of what counts of a wave with this deviation at the places, None if nothing does.

    It rises above a share of ``tolerance`` there or, if it decays like a power, above a share of
    its largest deviation: the rest is a matter of the domain's size.
    """
    level, largest = LEVEL * tolerance, float(deviation.max())
    if largest <= level:
        return None
    inside = np.flatnonzero(deviation > level)
    first, last = int(inside[0]), int(inside[-1])
    if _decays_like_a_power(x, deviation, first) or _decays_like_a_power(x, deviation, last):
        inside = np.flatnonzero(deviation > max(level, CREST_SHARE * largest))
        first, last = int(inside[0]), int(inside[-1])
    step = 1 if last + 1 < x.size else 0
    return float(x[max(first - 1, 0)]), float(x[last + step])


def _decays_like_a_power(x: Array, deviation: Array, index: int) -> bool:
    """Whether what is beyond the end at ``index`` falls slowly."""
    crest = float(x[int(np.argmax(deviation))])
    if index in (0, x.size - 1):
        return True
    beyond = crest + 2.0 * (x[index] - crest)
    rest = x >= beyond if x[index] > crest else x <= beyond
    return not rest.any() or float(np.max(deviation[rest])) > POWER * float(deviation[index])
