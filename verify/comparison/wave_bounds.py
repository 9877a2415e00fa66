"""Where a scene's wave is and how large it becomes: what a plan must know before any step.

The wave is looked for on the whole line, not on the compared sites alone: outwards from where its
phases vanish, on a grid whose spacing grows with the distance. A domain that holds the bounds holds
the wave at all times, so nothing of it can come back round a ring or be cut off by a window.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lattice.model import Model
from solutions import Wave
from verify.comparison.moving_wave import MovingWave

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
"""The lattice's wave may run this share of its drift against c t ahead of the closed form."""


@dataclass(frozen=True)
class WaveBounds:
    """Sites relative to c t that hold wave and compared sites, from ``low`` to ``high``.

    ``strain`` holds the smallest and the largest strain of the wave at any time.
    """

    low: float
    high: float
    strain: Array

    @property
    def width(self) -> float:
        """Number of sites between the ends."""
        return self.high - self.low

    @property
    def middle(self) -> float:
        """Half-way between the ends."""
        return 0.5 * (self.low + self.high)

    @property
    def reach(self) -> int:
        """The farther end's distance from c t."""
        return int(np.ceil(max(-self.low, self.high)))


def find_bounds(moving: MovingWave, tolerance: float) -> WaveBounds:
    """The bounds of compared sites and wave at all times from the first to the last.

    The wave is where y/eps deviates from its far fields by more than a share of ``tolerance``, or,
    if it decays like a power, by more than a share of its largest deviation: the rest is a matter
    of the domain's size.
    """
    ends, strain = _wave_at_all_times(
        moving.constants, moving.wave, moving.eps, moving.times, tolerance
    )
    edge = float(moving.compared)
    return WaveBounds(min(-edge, ends[0]), max(edge, ends[1]), strain)


@lru_cache(maxsize=4)
def _wave_at_all_times(
    constants: Model, wave: Wave, eps: float, times: tuple[float, ...], tolerance: float
) -> tuple[tuple[float, float], Array]:
    """The wave's ends, infinitely far inside out if nothing rises, and its extreme strains.

    Whatever is chosen about a scene asks for it: the engine, the scout and the runs themselves.
    """
    places = [_places(constants, wave, eps, t) for t in _watched(times)]
    supports = [_support(x, deviation, LEVEL * tolerance) for x, deviation, _ in places]
    ends = [support for support in supports if support is not None]
    low, high = np.inf, -np.inf
    if ends:
        lows, highs = np.array(ends).T
        low = float(lows.min()) - DRIFT_SHARE * float(np.ptp(lows))
        high = float(highs.max()) + DRIFT_SHARE * float(np.ptp(highs))
    strains = [eps * value for _, _, value in places]
    least = min(float(strain.min()) for strain in strains)
    extremes = np.array([least, max(float(strain.max()) for strain in strains)])
    extremes.flags.writeable = False
    return (low, high), extremes


def _watched(times: Sequence[float]) -> list[float]:
    """Equidistant times, some of those given, and the crest's."""
    t0, end = times[0], times[-1]
    crest = {0.0} if t0 < 0.0 < end else set()
    some = times[:: max(1, len(times) // TIMES)]
    return sorted({*np.linspace(t0, end, TIMES).tolist(), *some, *crest})


def _places(constants: Model, wave: Wave, eps: float, t: float) -> tuple[Array, Array, Array]:
    """Positions relative to c t in order, the deviation from the far fields there, and Y."""
    origin = constants.sound_speed() * t
    unit = 1.0 / (float(wave.normal_form.a) * eps)
    offsets = unit * np.concatenate([-DISTANCES[:0:-1], DISTANCES])
    zeros = wave.phase_zeros(t, eps) or [origin]
    x = np.unique(np.concatenate([zero - origin + offsets for zero in zeros]))
    value = wave.at(origin + x, t, eps).Y
    left, right = (wave.far_field_at(origin + x, t, eps, side).Y for side in ("left", "right"))
    deviation = np.minimum(np.abs(value - left), np.abs(value - right))
    return x, deviation, value


def _support(x: Array, deviation: Array, level: float) -> tuple[float, float] | None:
    """The ends of what rises above the level, None if nothing does."""
    largest = float(deviation.max())
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
