"""Which sites are computed: a window moving with the wave, or a fixed ring.

Both store their sites on a ring, so the kernels know one boundary only. What crosses the ring's
seam is wrong; a domain keeps it away from the compared sites.

A window's feed is the wave's initial far field, moved rigidly. In the frame that moves with it this
is one smooth function, wanted on few hundred sites over and over again. It is therefore evaluated
once, on Chebyshev points, and interpolated from there.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from longwave.lattice.seam import FADING_DEPTH, Fading, fade_at_seam, negate_at_seam
from longwave.lattice.state import BlowUp, Domain, Sites, State, empty_chain
from longwave.scenes.chain.moving_wave import MovingWave
from longwave.support.checkpoint import Memory
from longwave.support.compiled.jit import njit

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
    return KINK / (wave.numbers.a * eps * height)


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


def fastest_contained_signal(moving: MovingWave, sites: float) -> float:
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


def sound_drift(moving: MovingWave) -> int:
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
        state = empty_chain(moving.t0, middle - self.size // 2, self.size)
        state.store(state.sites, *self._data(state))
        least = least_ring(moving, state.f)
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

    def recall(self, memory: Memory, t: float) -> None:
        """Have faded until ``t``."""
        if self._fading is not None:
            self._fading.faded_until = t

    @cached_property
    def _fading(self) -> Fading | None:
        moving, wavelength = self.moving, self.moving.wave.wavelength
        if not self.fades or moving.duration == 0.0:
            return None
        speed = fastest_contained_signal(moving, self.size - seam_room(moving))
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


DEGREES = (16, 32, 64, 128)
"""Degrees tried: Y2's far field takes the first of them."""

INTERPOLATION_ERROR = 1e-14
"""Largest error of the interpolation, of y/eps or of what is largest."""


_jit = njit(cache=True, fastmath={"contract"}, error_model="numpy")


def _chebyshev_sums(coefficients: Array, u: Array) -> Array:
    """Sums of coefficients[:, k] T_k(u), of shape (rows of ``coefficients``, u.size)."""
    found = np.empty((len(coefficients), u.size))
    _clenshaw(coefficients, u, found, np.empty_like(u))
    return found


@_jit
def _clenshaw(coefficients: Array, u: Array, found: Array, work: Array) -> None:
    """Clenshaw's sums, all places a term at a time: the processor then takes several at once."""
    rows, terms = coefficients.shape
    for row in range(rows):
        found[row] = work[:] = 0.0
        for k in range(terms - 1, 0, -1):
            c = coefficients[row, k]
            for i in range(u.size):
                last = found[row, i]
                found[row, i] = c + 2.0 * u[i] * last - work[i]
                work[i] = last
        c = coefficients[row, 0]
        for i in range(u.size):
            found[row, i] = c + u[i] * found[row, i] - work[i]


@dataclass(frozen=True)
class Tail:
    """The initial strain that moves at ``speed``, and its velocity, on a stretch of its frame.

    ``low`` and ``high`` are offsets in sites from the place that began at c t0.
    """

    moving: MovingWave
    speed: float
    low: float
    high: float

    def at(self, sites: Sites, t: float) -> tuple[Array, Array]:
        """Strain and velocity at time t on the sites, which must be in the stretch by then."""
        offsets = self.moving.rigid_offsets(self.speed, sites, t)
        if self._coefficients is None:
            return self.moving.rigid_data(self.speed, offsets)
        y, s = _chebyshev_sums(self._coefficients, self._unit(offsets))
        return y, s

    def _unit(self, offsets: Array) -> Array:
        """The stretch as -1 .. 1."""
        return (offsets - 0.5 * (self.low + self.high)) * (2.0 / (self.high - self.low))

    def _exact(self, u: Array) -> Array:
        offsets = 0.5 * (self.low + self.high) + 0.5 * (self.high - self.low) * u
        return np.stack(self.moving.rigid_data(self.speed, offsets))

    @cached_property
    def _coefficients(self) -> Array | None:
        """Those of strain and velocity; None if no degree gives what lies between its points."""
        for degree in DEGREES:
            points = chebyshev.chebpts1(degree + 1)
            values = self._exact(points)
            level = values[:, 0]  # small coefficients then have small roundings
            found = (values.T - level).T @ chebyshev.chebvander(points, degree) * 2.0 / points.size
            found[:, 0] = 0.5 * found[:, 0] + level
            between = np.concatenate([[-1.0], 0.5 * (points[1:] + points[:-1]), [1.0]])
            exact = self._exact(between)
            error = np.abs(_chebyshev_sums(found, between) - exact).max()
            if error <= INTERPOLATION_ERROR * max(self.moving.eps, np.abs(exact).max()):
                return found
        return None


WATCHED = 8
"""Sites next to the fed ones on which feed and lattice are compared."""

LARGEST_MISFIT = 1e-5
"""Largest difference of y/eps between feed and lattice; a sound feed stays far below it."""


@dataclass
class Window(Domain):
    """Sites about c t on a constant background: front cells are fed, rear cells are dropped.

    It moves at fixed times, whatever the time step: two runs that differ in their step alone have
    the same error from the window, which cancels in their difference.

    The front is fed with the initial wave's own far field, moved at the background's speed of
    sound. Cells that the seam's signals can have reached since the last move are fed anew with it;
    the window outruns those at its rear. Each feed is compared with the sites behind it;
    ``mismatch`` is the largest difference of y/eps so far. Raises ValueError for a wave without a
    constant background, and for compared sites too near the window's ends.
    """

    moving: MovingWave
    size: int
    mismatch: float = field(default=0.0, init=False)

    def __post_init__(self) -> None:
        background = self.moving.wave.constant_background
        if background is None:
            raise ValueError(
                f"domain must be 'ring' for {self.moving.wave.numbers.name}, got 'window' "
                "(its background is not constant)"
            )
        self.background_speed = self.moving.constants.sound_speed(self.moving.level)
        self.moves = frozenset(window_moves(self.moving))
        least = least_window(self.moving.compared)
        if self.size < least:
            raise ValueError(
                f"sites must satisfy sites >= {least} in this window, got {self.size} "
                "(its ends would touch the compared sites; widen it)"
            )

    def memory(self) -> Memory:
        """The largest mismatch of a feed so far."""
        return {"mismatch": self.mismatch}

    def recall(self, memory: Memory, t: float) -> None:
        """Have seen that mismatch."""
        self.mismatch = memory["mismatch"]

    def start(self) -> State:
        """The initial state, centred on c t0."""
        moving = self.moving
        state = empty_chain(moving.t0, moving.frame(moving.t0) - self.size // 2, self.size)
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
        fault = self._misfit(state, front[:WATCHED], y[:WATCHED])
        state.store(front[WATCHED:], y[WATCHED:], s[WATCHED:])
        return fault

    def _misfit(self, state: State, sites: Sites, feed: Array) -> BlowUp | None:
        """The fault at the first site where feed and lattice differ too much, None if none does."""
        misses = np.abs(state.f[0].take(sites, mode="wrap") - feed) / self.moving.eps
        most = float(misses.max())
        self.mismatch = max(self.mismatch, most)
        if not most > LARGEST_MISFIT:
            return None
        criterion = (
            f"the window's feed misses the lattice by {most:.2g} eps, "
            f"more than {LARGEST_MISFIT:g} eps (the wave's far field is not what is fed)"
        )
        return BlowUp(criterion, state.t, int(sites[misses > LARGEST_MISFIT][0]))

    @cached_property
    def _tail(self) -> Tail:
        """The far field on all offsets from the background's sound at which moves feed or watch."""
        drift = (self.background_speed - self.moving.speed) * self.moving.duration
        end = (self.size + 1) // 2
        begin = end - (2 * (STRIDE + 1) + MARGIN + WATCHED)
        low, high = begin - 1 - max(0.0, drift), end + 1 - min(0.0, drift)
        return Tail(self.moving, self.background_speed, low, high)
