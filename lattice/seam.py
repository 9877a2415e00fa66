"""The seam of a ring: closing it, and letting fade what it sends out.

A localised wave on a periodic background approaches its far field through a phase that decays like
1/x, so the data at the two ends of m wavelengths miss each other by O(1/m). The circumference of a
spectral ring is any real number: the one for which Y(x + L) = Y(x) across the seam in the sense of
least squares leaves a miss of a higher order. Where the phase jumps by a constant, as across the
dark breather, it closes exactly.

A kink between -A and A closes with its own negative, which is a wave of the lattice, too, where the
force is odd: it stands at the seam.

What is left of the miss leaves a mean velocity, with which the mean strain would drift. It is taken
off at the seam, not everywhere: the data elsewhere are the wave's own.

What the seam of a closed ring sends out may grow until waves cease to exist there, although the
lattice itself is sound. The sites beyond the cone of the compared ones, which grows narrower all
the time, are therefore drawn to a constant strain at rest, gently: a sudden end would send a wave
back, whose strains add to those that arrive.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.state import State

Array = NDArray[np.float64]
Profile = Callable[[Array], Array]

SAMPLES = 64
"""Points on the wavelength about the seam, and circumferences tried within one wavelength."""

GAUSS_NEWTON_STEPS, APART = 12, 1e-5
"""Most steps from the best of those tried; the slope is a difference over so many wavelengths."""

BLEND_REACH = 6.0
"""The blend runs from 0 to 1, to double precision, within so many of its widths on either side."""


def close_circumference(profile: Profile, wavelength: float, count: int) -> float:
    """The circumference within half a wavelength of ``count`` of them that closes the profile best.

    ``profile`` is Y against x, the seam lies at x = -L/2 and x = L/2.

    >>> round(close_circumference(lambda x: np.cos(x - np.arctan(x) / 2), 2 * np.pi, 8), 4)
    51.7975
    """
    offsets = wavelength * ((np.arange(SAMPLES) + 0.5) / SAMPLES - 0.5)

    def misses(shifts: Array) -> Array:
        half = 0.5 * wavelength * (count + shifts[:, None])
        ends = np.stack([half + offsets, -half + offsets])
        values = np.asarray(profile(ends.ravel())).reshape(ends.shape)
        return values[0] - values[1]

    shifts = np.arange(-SAMPLES // 2, SAMPLES // 2) / SAMPLES
    first = best = float(shifts[np.argmin(np.sum(misses(shifts) ** 2, axis=1))])
    for _ in range(GAUSS_NEWTON_STEPS):
        below, miss, above = misses(best + APART * np.array([-1.0, 0.0, 1.0]))
        slope = (above - below) / (2.0 * APART)
        steep = float(slope @ slope)
        step = float(miss @ slope) / steep if steep > 0.0 else 0.0
        best = min(max(best - step, first - 1.0 / SAMPLES), first + 1.0 / SAMPLES)
        if abs(step) < 2.0**-50:
            break
    return wavelength * (count + best)


def blend_seam(profile: Profile, circumference: float, width: float, x: Array) -> Array:
    """The profile made smoothly periodic, at points -L/2 <= x <= L/2 (its last axis).

    Within BLEND_REACH ``width`` of the seam it passes over into its own copy a circumference away,
    so that what is left of the miss puts no kink, and no short waves, there.

    >>> x = np.array([-5.0, 0.0, 5.0])
    >>> blend_seam(lambda x: x, 10.0, 0.5, x)
    array([0., 0., 0.])
    """
    values = np.array(profile(x), dtype=np.float64)
    for sign in (-1.0, 1.0):
        inside = sign * x - 0.5 * circumference
        near = inside > -BLEND_REACH * width
        share = 0.5 * np.array([math.erfc(-z / width) for z in inside[near]])
        copy = profile(x[near] - sign * circumference)
        values[..., near] += share * (np.asarray(copy) - values[..., near])
    return values


def negate_at_seam(profile: Profile, circumference: float, crest: float, x: Array) -> Array:
    """A kink's profile with its negative about the seam, at points -L/2 <= x <= L/2.

    ``crest`` is the place of the site nearest to the kink. Half-way between it and the seam the two
    pass into each other. The negative lies between sites as the kink does: a steep one's strains
    depend on that.

    >>> values = negate_at_seam(np.tanh, 80.0, 0.0, np.array([-40.0, -30.0, 0.0, 30.0, 39.0]))
    >>> values.round(3) + 0.0
    array([ 0.   , -1.   ,  0.   ,  1.   ,  0.762])
    """
    values = np.array(profile(x), dtype=np.float64)
    past = x - np.where(x > 0.0, 0.5, -0.5) * circumference
    near = np.abs(past) < 0.5 * (0.5 * circumference - abs(crest))
    values[..., near] = -np.asarray(profile(past[near] + crest))
    return values


def rest_at_seam(s: Array, circumference: float, width: float, x: Array) -> Array:
    """The velocity ``s`` without its mean, taken off where it is blended (-L/2 <= x <= L/2).

    >>> x = np.linspace(-5.0, 5.0, 100, endpoint=False)
    >>> rest = rest_at_seam(np.ones(100), 10.0, 0.5, x)
    >>> abs(round(float(np.mean(rest)), 12)), float(rest[50])
    (0.0, 1.0)
    """
    distance = 0.5 * circumference - np.abs(x)
    bump = np.exp(-((distance / width) ** 2)) * (distance < BLEND_REACH * width)
    rest: Array = s - float(np.mean(s)) / float(np.mean(bump)) * bump
    return rest


FADING_DEPTH = 128
"""Least sites over which the fading sets in."""

FADING_STRENGTH = 12.0
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
        self.faded_until = self.t0

    def at(self, state: State) -> None:
        """Fade what no longer matters at ``state.t``, for the time since the last call."""
        passed, self.faded_until = state.t - self.faded_until, state.t
        gone = min(math.floor(self.speed * (state.t - self.t0)), (state.size + 1) // 2)
        if gone <= 0 or passed <= 0.0:
            return
        inside = np.arange(gone, 0, -1.0) / self.depth
        rate = FADING_STRENGTH * self.speed / self.depth * np.minimum(inside, 1.0) ** 2
        kept = np.exp(-rate * passed)
        for sites, left in ((state.sites[:gone], kept), (state.sites[-gone:], kept[::-1])):
            y, s = state.at(sites)
            state.store(sites, self.level + left * (y - self.level), left * s)
