"""Which sites are computed: a window moving with the wave, or a fixed ring.

Both store their sites on a ring, so the kernels know one boundary only. What crosses the ring's
seam is wrong; a domain keeps it away from the compared sites.
"""

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lattice.seam import FADING_DEPTH, Fading, fade_at_seam, negate_at_seam
from lattice.state import WATCHED, BlowUp, InflowCheck, State, empty_state
from lattice.stepper import Domain
from solutions import Wave
from verify.comparison.initial_data import Tail, initial_data
from verify.comparison.observables import observable_named
from verify.comparison.scene import Scene
from verify.comparison.view import frame
from verify.comparison.wave_bounds import MARGIN, front, seam_room

Array = NDArray[np.float64]

STRIDE = 64
"""Most sites by which a window moves at once."""

BISECTIONS = 40
"""Halvings to the speed that a ring holds."""


def least_window(compared: int) -> int:
    """Fewest sites of a window whose ends keep away from the compared sites."""
    return 2 * (compared + 2 * (STRIDE + MARGIN))


def least_ring(scene: Scene, strain: Array) -> int:
    """Fewest sites of a ring whose seam cannot be felt at the compared sites.

    ``strain`` holds strains about which waves may run; the fastest of them counts.
    """
    duration = scene.end - scene.t0
    fastest = scene.constants.highest_frequency(strain) / 2.0
    travelled = scene.constants.sound_speed() * duration / 2.0 + fastest * duration
    return 2 * (scene.compared + math.ceil(travelled + front(fastest, duration)))


def speed_held(scene: Scene, sites: float) -> float:
    """The fastest signal for which a ring of that many sites is wide enough; see `least_ring`."""
    duration = scene.end - scene.t0
    room = 0.5 * sites - scene.compared - scene.constants.sound_speed() * duration / 2.0
    slow, fast = 0.0, max(0.0, room) / duration
    for _ in range(BISECTIONS):
        speed = 0.5 * (slow + fast)
        if speed * duration + front(speed, duration) <= room:
            slow = speed
        else:
            fast = speed
    return slow


def creeping(scene: Scene, wave: Wave) -> int:
    """Sites by which sound on the wave's constant background gains on c t during the scene."""
    background = scene.eps * (wave.constant_background or 0.0)
    gain = scene.constants.sound_speed(background) - scene.constants.sound_speed()
    return math.ceil(max(0.0, gain) * (scene.end - scene.t0))


def window_moves(scene: Scene) -> tuple[float, ...]:
    """The times, counted from t0, after which sound has gone ``STRIDE`` sites again."""
    stay = STRIDE / scene.constants.sound_speed()
    count = math.ceil((scene.end - scene.t0) / stay)
    return tuple(scene.t0 + stay * move for move in range(1, count + 1))


@dataclass
class SiteRing:
    """A fixed ring of sites about the middle of the wave's path; nothing is fed or dropped.

    Its seam, where the wave does not close up or is made to, sends signals at the speed of sound.
    On a closed ring they fade once they can no longer reach a compared site, unless all of the
    sites are asked for.
    Raises ValueError if they could reach a compared site before the run ends.
    """

    scene: Scene
    wave: Wave
    moves: frozenset[float] = frozenset()
    mismatch: float = 0.0
    _fading: Fading | None = field(default=None, init=False)

    def start(self) -> State:
        """The initial state on all sites of the ring."""
        scene = self.scene
        middle = (frame(scene, scene.t0) + frame(scene, scene.end)) // 2
        state = empty_state(
            scene.t0, middle - scene.discretisation.sites // 2, scene.discretisation.sites
        )
        state.store(state.sites, *self._data(state))
        self._check(state)
        self._fading = self._build_fading()
        return state

    def fade(self, state: State) -> None:
        """On a closed ring, let fade what can no longer reach a compared site."""
        if self._fading is not None:
            self._fading.at(state)

    def _build_fading(self) -> Fading | None:
        scene, wave = self.scene, self.wave
        whole = any(observable_named(name).all_sites for name in scene.observables)
        if scene.discretisation.domain != "closed_ring" or whole or scene.end == scene.t0:
            return None
        speed = speed_held(scene, scene.discretisation.sites - seam_room(wave, scene.eps))
        level = scene.eps * (wave.constant_background or 0.0)
        depth = max(float(FADING_DEPTH), (wave.wavelength or 0.0) / scene.eps)
        return Fading(scene.t0, speed, level, depth)

    def _data(self, state: State) -> tuple[Array, Array]:
        """The wave's data; on a closed ring they pass smoothly over the seam.

        A jump there could be more than the lattice bears, and so could two copies of a periodic
        wave that do not fit.
        """
        scene, wave = self.scene, self.wave
        room = seam_room(wave, scene.eps)
        if scene.discretisation.domain == "ring" or room == 0.0:
            return initial_data(wave, scene, state.sites)
        middle = state.left + 0.5 * state.size
        length, x = float(state.size), np.asarray(state.sites - middle, dtype=np.float64)
        if wave.wavelength is not None:
            y, s = initial_data(wave, scene, state.sites)
            return fade_at_seam(y, s, scene.constants.sound_speed(), length, 0.5 * room, x)

        def profile(x: Array) -> Array:
            return np.stack(initial_data(wave, scene, x + middle))

        crest = wave.phase_zeros(scene.t0, scene.eps)[0] - middle
        y, s = negate_at_seam(profile, length, crest, x)
        return y, s

    def follow(self, state: State) -> BlowUp | None:
        """Nothing: the ring stays where it is."""

    def locate(self, found: BlowUp, state: State) -> BlowUp:
        """``found``, with its distance from the seam if the seam's signals can have been there."""
        if self.scene.discretisation.domain == "closed_ring":
            return found
        distance = min(found.site - state.left, state.left + state.size - 1 - found.site)
        reach = self.scene.constants.sound_speed() * (found.t - self.scene.t0) + MARGIN
        return replace(found, from_seam=distance) if distance <= reach else found

    def _check(self, state: State) -> None:
        least, sites = least_ring(self.scene, state.y), self.scene.discretisation.sites
        if sites < least:
            raise ValueError(
                f"sites must satisfy sites >= {least} on this ring, got {sites} "
                "(else signals from the seam reach the compared sites; widen it or end earlier)"
            )


@dataclass
class Window:
    """Sites about c t on a constant background: front cells are fed, rear cells are dropped.

    It moves at fixed times, whatever the time step: two runs that differ in their step alone have
    the same error from the window, which cancels in their difference.

    The front is fed with the initial wave's own far field, moved at the background's speed of
    sound. Cells that the seam's signals can have reached since the last move are fed anew with it;
    the window outruns those at its rear. A monitor compares each feed with the sites behind it.
    Raises ValueError for a wave without a constant
    background, and for compared sites too near the window's ends.
    """

    scene: Scene
    wave: Wave

    def __post_init__(self) -> None:
        background = self.wave.constant_background
        if background is None:
            raise ValueError(
                f"domain must be 'ring' for {self.scene.wave_name}, got 'window' "
                "(its background is not constant)"
            )
        self.monitor = InflowCheck(self.scene.eps)
        self.background_speed = self.scene.constants.sound_speed(self.scene.eps * background)
        self.moves = frozenset(window_moves(self.scene))
        least, sites = least_window(self.scene.compared), self.scene.discretisation.sites
        if sites < least:
            raise ValueError(
                f"sites must satisfy sites >= {least} in this window, got {sites} "
                "(its ends would touch the compared sites; widen it)"
            )

    @property
    def mismatch(self) -> float:
        """Largest difference of y/eps between what was fed and the sites next to it."""
        return self.monitor.mismatch

    def start(self) -> State:
        """The initial state, centred on c t0."""
        scene = self.scene
        state = empty_state(
            scene.t0,
            frame(scene, scene.t0) - scene.discretisation.sites // 2,
            scene.discretisation.sites,
        )
        state.store(state.sites, *initial_data(self.wave, scene, state.sites))
        return state

    def fade(self, state: State) -> None:
        """Nothing: what is dropped is gone."""

    def locate(self, found: BlowUp, state: State) -> BlowUp:
        """``found``: a window has no seam."""
        return found

    def follow(self, state: State) -> BlowUp | None:
        """Move the window to c t, feeding the cells in front; a feed that does not fit is told."""
        left = frame(self.scene, state.t) - self.scene.discretisation.sites // 2
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
        scene = self.scene
        gain = self.background_speed - scene.constants.sound_speed()
        drift = gain * (scene.end - scene.t0)
        end = (scene.discretisation.sites + 1) // 2
        begin = end - (2 * (STRIDE + 1) + MARGIN + WATCHED)
        low, high = begin - 1 - max(0.0, drift), end + 1 - min(0.0, drift)
        return Tail(self.wave, scene, self.background_speed, low, high)


def build_domain(scene: Scene, wave: Wave) -> Domain:
    """The domain that the scene asks for."""
    return Window(scene, wave) if scene.discretisation.domain == "window" else SiteRing(scene, wave)
