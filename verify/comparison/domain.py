"""Which sites are computed: a window moving with the wave, or a fixed ring; and where the wave is.

Both store their sites on a ring, so the kernels know one boundary only. What crosses the ring's
seam is wrong; a domain keeps it away from the compared sites.

A plan must know before any step where the wave is and how large it becomes. It is looked for on
the whole line, not on the compared sites alone: outwards from where its phases vanish, on a grid
whose spacing grows with the distance. A domain that holds the bounds holds the wave at all times,
so nothing of it can come back round a ring or be cut off by a window.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from lattice.model import WATCHED, BlowUp, InflowCheck, Model, State, empty_state
from lattice.seam import FADING_DEPTH, Fading, fade_at_seam, negate_at_seam
from lattice.stepper import Domain
from solutions import Wave
from verify.comparison.moving_wave import MovingWave, Tail

Array = NDArray[np.float64]

MARGIN = 64
"""Sites beyond the distance of sound that a window leaves for a signal's dispersive front."""

FRONT = 12.0
"""Airy lengths by which a signal's front runs ahead of the sound: Ai(12) is 1e-13."""

KINK = 80.0
"""Room for a kink at the seam, in units of its width."""

STRIDE = 64
"""Most sites by which a window moves at once."""

BISECTIONS = 40
"""Halvings to the speed that a ring holds."""


def front(speed: float, duration: float) -> float:
    """Sites by which the dispersive front of a signal of that speed is ahead of it."""
    return max(MARGIN, FRONT * (speed * duration / 8.0) ** (1.0 / 3.0))


def seam_room(moving: MovingWave) -> float:
    """Sites that a ring's ends take to pass into each other; 0 if they fit as they are."""
    wave, eps = moving.wave, moving.eps
    if wave.constant_background is not None:
        return 0.0
    if wave.wavelength is not None:
        return 2.0 * wave.wavelength / eps
    height = float(np.max(np.abs(wave.far_field(0.0, 0.0, "right").Y)))
    return KINK / (float(wave.normal_form.a) * eps * height)


def least_window(compared: int) -> int:
    """Fewest sites of a window whose ends keep away from the compared sites."""
    return 2 * (compared + 2 * (STRIDE + MARGIN))


def least_ring(moving: MovingWave, strain: Array) -> int:
    """Fewest sites of a ring whose seam cannot be felt at the compared sites.

    ``strain`` holds strains about which waves may run; the fastest of them counts.
    """
    duration = moving.duration
    fastest = moving.constants.highest_frequency(strain) / 2.0
    travelled = moving.speed * duration / 2.0 + fastest * duration
    return 2 * (moving.compared + math.ceil(travelled + front(fastest, duration)))


def speed_held(moving: MovingWave, sites: float) -> float:
    """The fastest signal for which a ring of that many sites is wide enough; see `least_ring`."""
    duration = moving.duration
    room = 0.5 * sites - moving.compared - moving.speed * duration / 2.0
    slow, fast = 0.0, max(0.0, room) / duration
    for _ in range(BISECTIONS):
        speed = 0.5 * (slow + fast)
        if speed * duration + front(speed, duration) <= room:
            slow = speed
        else:
            fast = speed
    return slow


def creeping(moving: MovingWave) -> int:
    """Sites by which sound on the wave's constant background gains on c t in that time."""
    gain = moving.constants.sound_speed(moving.level) - moving.speed
    return math.ceil(max(0.0, gain) * moving.duration)


def window_moves(moving: MovingWave) -> tuple[float, ...]:
    """The times, counted from t0, after which sound has gone ``STRIDE`` sites again."""
    stay = STRIDE / moving.speed
    count = math.ceil(moving.duration / stay)
    return tuple(moving.t0 + stay * move for move in range(1, count + 1))


@dataclass
class SiteRing(Domain):
    """A fixed ring of sites about the middle of the wave's path; nothing is fed or dropped.

    Its seam, where the wave does not close up or is made to, sends signals at the speed of sound.
    A ``closed`` one passes smoothly over it. If it ``fades``, they do once they can no longer reach
    a compared site: all of the sites may then not be asked for.
    Raises ValueError if they could reach a compared site before the run ends.
    """

    moving: MovingWave
    size: int
    closed: bool = False
    fades: bool = False

    def start(self) -> State:
        """The initial state on all sites of the ring."""
        moving = self.moving
        middle = (moving.frame(moving.t0) + moving.frame(moving.end)) // 2
        state = empty_state(moving.t0, middle - self.size // 2, self.size)
        state.store(state.sites, *self._data(state))
        least = least_ring(moving, state.y)
        if self.size < least:
            raise ValueError(
                f"sites must satisfy sites >= {least} on this ring, got {self.size} "
                "(else signals from the seam reach the compared sites; widen it or end earlier)"
            )
        return state

    def fade(self, state: State) -> None:
        """On a closed ring, let fade what can no longer reach a compared site."""
        if self._fading is not None:
            self._fading.at(state)

    @cached_property
    def _fading(self) -> Fading | None:
        moving, wavelength = self.moving, self.moving.wave.wavelength
        if not self.fades or moving.duration == 0.0:
            return None
        speed = speed_held(moving, self.size - seam_room(moving))
        depth = max(float(FADING_DEPTH), (wavelength or 0.0) / moving.eps)
        return Fading(moving.t0, speed, moving.level, depth)

    def _data(self, state: State) -> tuple[Array, Array]:
        """The wave's data; on a closed ring they pass smoothly over the seam.

        A jump there could be more than the lattice bears, and so could two copies of a periodic
        wave that do not fit.
        """
        moving = self.moving
        room = seam_room(moving)
        if not self.closed or room == 0.0:
            return moving.initial_data(state.sites)
        middle = state.left + 0.5 * state.size
        length, x = float(state.size), np.asarray(state.sites - middle, dtype=np.float64)
        if moving.wave.wavelength is not None:
            y, s = moving.initial_data(state.sites)
            return fade_at_seam(y, s, moving.speed, length, 0.5 * room, x)

        def profile(x: Array) -> Array:
            return np.stack(moving.initial_data(x + middle))

        crest = moving.wave.phase_zeros(moving.t0, moving.eps)[0] - middle
        y, s = negate_at_seam(profile, length, crest, x)
        return y, s

    def locate(self, found: BlowUp, state: State) -> BlowUp:
        """``found``, with its distance from the seam if the seam's signals can have been there."""
        if self.closed:
            return found
        distance = min(found.site - state.left, state.left + state.size - 1 - found.site)
        reach = self.moving.speed * (found.t - self.moving.t0) + MARGIN
        return replace(found, from_seam=distance) if distance <= reach else found


@dataclass
class Window(Domain):
    """Sites about c t on a constant background: front cells are fed, rear cells are dropped.

    It moves at fixed times, whatever the time step: two runs that differ in their step alone have
    the same error from the window, which cancels in their difference.

    The front is fed with the initial wave's own far field, moved at the background's speed of
    sound. Cells that the seam's signals can have reached since the last move are fed anew with it;
    the window outruns those at its rear. A monitor compares each feed with the sites behind it.
    Raises ValueError for a wave without a constant background, and for compared sites too near the
    window's ends.
    """

    moving: MovingWave
    size: int

    def __post_init__(self) -> None:
        background = self.moving.wave.constant_background
        if background is None:
            raise ValueError(
                f"domain must be 'ring' for {self.moving.wave.form.name}, got 'window' "
                "(its background is not constant)"
            )
        self.monitor = InflowCheck(self.moving.eps)
        self.background_speed = self.moving.constants.sound_speed(self.moving.level)
        self.moves = frozenset(window_moves(self.moving))
        least = least_window(self.moving.compared)
        if self.size < least:
            raise ValueError(
                f"sites must satisfy sites >= {least} in this window, got {self.size} "
                "(its ends would touch the compared sites; widen it)"
            )

    @property
    def mismatch(self) -> float:
        """Largest difference of y/eps between what was fed and the sites next to it."""
        return self.monitor.mismatch

    def start(self) -> State:
        """The initial state, centred on c t0."""
        moving = self.moving
        state = empty_state(moving.t0, moving.frame(moving.t0) - self.size // 2, self.size)
        state.store(state.sites, *moving.initial_data(state.sites))
        return state

    def follow(self, state: State) -> BlowUp | None:
        """Move the window to c t, feeding the cells in front; a feed that does not fit is told."""
        left = self.moving.frame(state.t) - self.size // 2
        fed = 2 * (left - state.left) + MARGIN
        state.left = left
        end = left + state.size
        front = np.arange(end - fed - WATCHED, end)
        y, s = self._tail.at(front, state.t)
        fault = self.monitor.compare(state, front[:WATCHED], y[:WATCHED])
        state.store(front[WATCHED:], y[WATCHED:], s[WATCHED:])
        return fault

    @cached_property
    def _tail(self) -> Tail:
        """The far field on all offsets from the background's sound at which moves feed or watch."""
        drift = (self.background_speed - self.moving.speed) * self.moving.duration
        end = (self.size + 1) // 2
        begin = end - (2 * (STRIDE + 1) + MARGIN + WATCHED)
        low, high = begin - 1 - max(0.0, drift), end + 1 - min(0.0, drift)
        return Tail(self.moving, self.background_speed, low, high)


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
