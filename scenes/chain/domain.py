"""The ring of sites on which the paper's waves on periodic backgrounds are computed.

The kernels know one boundary only. What crosses the ring's seam is wrong; it is kept away from the
compared sites.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.seam import FADING_DEPTH, Fading, fade_at_seam, negate_at_seam
from longwave.lattice.state import BlowUp, Domain, State, empty_chain
from longwave.scenes.chain.moving_wave import MovingWave
from longwave.scenes.engines.window import MARGIN, front
from longwave.support.checkpoint import Memory

Array = NDArray[np.float64]

KINK = 80.0
"""Room for a kink at the seam, in units of its width."""

BISECTIONS = 40
"""Halvings to the speed that a ring holds."""


def seam_room(moving: MovingWave) -> float:
    """Sites that a ring's ends take to pass into each other; 0 if they fit as they are."""
    wave, eps = moving.wave, moving.eps
    if wave.constant_background is not None:
        return 0.0
    if wave.wavelength is not None:
        return 2.0 * wave.wavelength / eps
    height = float(np.max(np.abs(wave.far_field(0.0, 0.0, "right").Y)))
    return KINK / (wave.numbers.a * eps * height)


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
