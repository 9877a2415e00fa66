"""The seam of a ring: closing the wave across it, and damping what it emits.

A localised wave on a periodic background approaches its far field through a phase that decays like
1/x, so the data at the two ends of m wavelengths differ by O(1/m). The circumference of a spectral
ring is any real number. The one that makes Y(x + L) = Y(x) across the seam in the least-squares
sense leaves a mismatch of a higher order. If the phase jumps by a constant, as across the dark
breather, the ring closes exactly.

A kink between -A and A closes with its own negative, placed at the seam, which is also a wave of
the lattice if the force is odd.

The remaining mismatch has a mean velocity, with which the mean strain would drift. It is subtracted
at the seam only, so that the data elsewhere are the wave's own.

What the seam of a closed ring emits may grow until waves cease to exist there, although the lattice
itself is sound. Sites that can no longer reach the compared ones are therefore relaxed to a
constant strain at rest. The relaxation sets in gently, because a sharp edge would reflect waves,
whose strains add to those that arrive.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from longwave.lattice.state import State
from longwave.support.real_arrays import Array

Profile = Callable[[Array], Array]

SAMPLES = 64
"""Number of points on the wavelength about the seam, and number of circumferences tried first."""

GAUSS_NEWTON_STEPS, DIFFERENCE_STEP = 12, 1e-5
"""Largest number of Gauss-Newton steps, and the difference step (in wavelengths) for their
slopes."""

BLEND_REACH = 6.0
"""Distance from the seam, in blend widths, within which the blend runs from 0 to 1 in doubles."""


def close_circumference(profile: Profile, wavelength: float, count: int) -> float:
    """Return the circumference near ``count`` wavelengths that closes the profile best.

    It differs from ``count`` wavelengths by at most half a wavelength. ``profile`` maps x to Y; the
    seam is at x = -L/2 and x = L/2.

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
        below, miss, above = misses(best + DIFFERENCE_STEP * np.array([-1.0, 0.0, 1.0]))
        slope = (above - below) / (2.0 * DIFFERENCE_STEP)
        steep = float(slope @ slope)
        step = float(miss @ slope) / steep if steep > 0.0 else 0.0
        best = min(max(best - step, first - 1.0 / SAMPLES), first + 1.0 / SAMPLES)
        if abs(step) < 2.0**-50:
            break
    return wavelength * (count + best)


def blend_seam(profile: Profile, circumference: float, width: float, x: Array) -> Array:
    """Return the profile made smoothly periodic, at points -L/2 <= x <= L/2 (its last axis).

    Within ``BLEND_REACH * width`` of the seam it is blended with its copy a circumference away,
    so that the mismatch causes no kink and no short waves.

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
    """Return a kink's profile with its negative about the seam, at points -L/2 <= x <= L/2.

    ``crest`` is the position of the site nearest to the kink. Half-way between kink and seam the
    profile passes to its negative. The negative kink lies between two sites as the kink does,
    because the strains of a steep kink depend on that.

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
    """Return the velocity ``s`` with zero mean, changed near the seam only (-L/2 <= x <= L/2).

    >>> x = np.linspace(-5.0, 5.0, 100, endpoint=False)
    >>> rest = rest_at_seam(np.ones(100), 10.0, 0.5, x)
    >>> abs(round(float(np.mean(rest)), 12)), float(rest[50])
    (0.0, 1.0)
    """
    distance = 0.5 * circumference - np.abs(x)
    bump = np.exp(-((distance / width) ** 2)) * (distance < BLEND_REACH * width)
    return np.asarray(s - float(np.mean(s)) / float(np.mean(bump)) * bump)


FADING_DEPTH = 128
"""Smallest number of sites over which the damping sets in."""

FADING_STRENGTH = 12.0
"""Damping rate at full depth, in units of the inverse time in which the boundary crosses that
depth: a wave that enters at twice its speed has lost 86 % there."""


@dataclass
class Fading:
    """Damping of the sites of a ring whose signals can no longer reach a compared site.

    Signals travel at ``speed``. At ``t0`` the signals of all sites can reach a compared site; at t
    only those of sites further than ``speed * (t - t0)`` from the seam. ``level`` is the strain to
    which the other sites relax, ``depth`` the number of sites over which the damping sets in.
    """

    t0: float
    speed: float
    level: float
    depth: float

    def __post_init__(self) -> None:
        self.faded_until = self.t0

    def at(self, state: State) -> None:
        """Damp the sites that no longer matter, over the time from the last call to ``state.t``."""
        elapsed, self.faded_until = state.t - self.faded_until, state.t
        faded = min(math.floor(self.speed * (state.t - self.t0)), (state.size + 1) // 2)
        if faded <= 0 or elapsed <= 0.0:
            return
        inside = np.arange(faded, 0, -1.0) / self.depth
        rate = FADING_STRENGTH * self.speed / self.depth * np.minimum(inside, 1.0) ** 2
        factors = np.exp(-rate * elapsed)
        ends = (state.sites[:faded], factors), (state.sites[-faded:], factors[::-1])
        for sites, factor in ends:
            y, s = state.at(sites)
            state.store(sites, self.level + factor * (y - self.level), factor * s)
