"""Letting fade, on a ring, what can no longer reach a compared site.

What the seam of a closed ring sends out may grow until waves cease to exist there, although the
lattice itself is sound. The sites beyond the cone of the compared ones, which grows narrower all
the time, are therefore drawn to a constant strain at rest, gently: a sudden end would send a wave
back, whose strains add to those that arrive.
"""

import math
from dataclasses import dataclass

import numpy as np

from verify.lattice.state import State

DEPTH = 128
"""Least sites over which the fading sets in."""

STRENGTH = 12.0
"""Rate of the fading at that depth and beyond, in units of the time in which the cone's end goes
it: a wave that runs into it at twice that speed has lost 86 % there."""


@dataclass
class Fading:
    """Fades the sites of a ring from which ``speed`` no longer leads to a compared site.

    At ``t0`` all sites lead there; at t those do that are further than ``speed`` (t - t0) from the
    seam. ``level`` is the strain in which the others end, ``depth`` the sites over which the
    fading sets in, a wavelength if there is one.
    """

    t0: float
    speed: float
    level: float
    depth: float

    def __post_init__(self) -> None:
        self._t = self.t0

    def at(self, state: State) -> None:
        """Fade what no longer matters at ``state.t``, for the time since the last call."""
        passed, self._t = state.t - self._t, state.t
        gone = min(math.floor(self.speed * (state.t - self.t0)), (state.size + 1) // 2)
        if gone <= 0 or passed <= 0.0:
            return
        inside = np.arange(gone, 0, -1.0) / self.depth
        rate = STRENGTH * self.speed / self.depth * np.minimum(inside, 1.0) ** 2
        kept = np.exp(-rate * passed)
        for sites, left in ((state.sites[:gone], kept), (state.sites[-gone:], kept[::-1])):
            y, s = state.strain(sites), state.velocity(sites)
            state.store(sites, self.level + left * (y - self.level), left * s)
