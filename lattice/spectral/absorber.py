"""Takes off a moving ring, at its seam, what is not its wave's: left-going and short waves.

In the frame that moves at c left-going waves travel at -2c. What the wave radiates to the left
leaves the infinite lattice's wave for good; on a ring it meets the wave again every L/(2c) and
shifts it a little each time. So the domain's error fell like the number of meetings, 1/L, whatever
the data at the seam. An absorber there leaves what the ring's own tails are worth.

The left-going strain f has the modes p_+/(2 i w). Its mean is a convention, fixed here by f = 0 at
the seam at first; the mean of f that is absorbed is gone from the mean of y, as on the infinite
lattice it has gone out of sight. Only waves longer than a cutoff are absorbed: those of a periodic
background itself, which never end, must stay.

Short right-going waves, of group velocity c cos(k/2), fall behind the frame, pass the seam and come
back from the front. Those that can come so far are absorbed as well, by a rate that makes one
passage of the fastest of them cost as much as one of a left-going wave.
"""

import math

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import NDArray

from longwave.lattice.spectral.field_ring import FieldRing, modes_of, values_of

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

WIDTH = 1.0 / 12.0
"""Width of the absorber, in circumferences: it is exp(-(distance to the seam/width)^2) strong.

A strength of 28 leaves 7e-13 of a wave so, and 2e-8 and 9e-9 with half and twice the width; at the
usual one they are alike (`benchmarks/lattice_constants.py`)."""

NARROW = 1.0 / 24.0
"""The same for short waves, whose slow ones feel it from farther off. With half of it 4e-6 of a
wave are left whatever the strength, so 4e-11 (`benchmarks/lattice_constants.py`)."""

ABSORBER_STRENGTH = 14.0
"""Logarithm of what one passage divides a wave by, usually: 8e-7 of it are left."""

OFTEN = 1.0 / 64.0
"""A left-going wave travels this far between two absorptions, in circumferences, or one step."""

FARTHEST = 1.0 / 8.0
"""If it travels farther in one step, in circumferences, nothing is absorbed."""

EDGE = 1.5
"""In units of the cutoff: the share exp(-(k/cutoff)^8) of a wave that is absorbed ends here."""


class LeftAbsorber:
    """Absorbs left-going waves of numbers below ``cutoff`` at the seam of the ring ``state``.

    ``w`` are the frequencies of the modes in ``p``, ``speed`` is that of the ring, ``step`` the
    time step. ``every`` is the number of steps between two absorptions, 0 if a step is too long.
    """

    def __init__(
        self,
        state: FieldRing,
        p: Complex,
        w: Array,
        speed: float,
        step: float,
        cutoff: float,
        strength: float = ABSORBER_STRENGTH,
    ) -> None:
        (length,), travel = state.circumferences, 2.0 * speed * step
        self.every = 0 if travel > FARTHEST * length else max(1, int(OFTEN * length / travel))
        numbers = 2.0 * math.pi / length * np.arange(w.size)
        self._kept = int(np.count_nonzero(numbers < EDGE * cutoff))
        self._count = 2 * int(ducc0.fft.good_size(2 * self._kept, True))
        self._share = np.exp(-((numbers[: self._kept] / cutoff) ** 8))
        self._lift = 2j * w[: self._kept]
        distance = 0.5 - np.abs(np.arange(self._count) / self._count - 0.5)
        profile = np.exp(-((distance / WIDTH) ** 2))
        self._loss = np.expm1(-strength * _along(profile, self.every * travel / length))
        self.level = 0.0
        self.level = -float(np.average(self._strain(p), weights=profile))

    def absorb(self, p: Complex) -> float:
        """Take off, in place, what has passed the absorber since the last time.

        The mean, which has no place in p, changes by what is returned.
        """
        change = modes_of(self._strain(p) * self._loss)[: self._kept] * self._share
        p[1, : self._kept] += self._lift * change
        mean = float(change[0].real)
        self.level += mean
        return mean

    def _strain(self, p: Complex) -> Array:
        """The left-going strain."""
        modes = np.zeros(self._count // 2 + 1, dtype=np.complex128)
        modes[1 : self._kept] = (p[1, 1 : self._kept] / self._lift[1:]) * self._share[1:]
        modes[0] = self.level
        return values_of(modes, self._count)


class ShortAbsorber:
    """Absorbs right-going waves of numbers above ``cutoff`` at the seam of the ring ``state``.

    ``w`` are the frequencies of the modes, 0 for those that stand still; ``speed`` is that of the
    ring, ``step`` the time step. ``every`` is the number of steps between two absorptions.
    """

    def __init__(
        self,
        state: FieldRing,
        w: Array,
        speed: float,
        step: float,
        cutoff: float,
        strength: float = ABSORBER_STRENGTH,
    ) -> None:
        (length,), (count,) = state.circumferences, state.counts
        numbers = 2.0 * math.pi / length * np.arange(w.size)
        shortest = min(math.pi, float(numbers[-1]))
        travel = speed * step * (1.0 - math.cos(0.5 * shortest)) / length
        self.every = max(1, int(OFTEN / travel))
        self._count = count
        self._share = -np.expm1(-((numbers / cutoff) ** 8))
        self._share[w == 0.0] = 0.0
        self._inverse = np.zeros_like(w)
        np.divide(self._share, 2.0 * w, out=self._inverse, where=w > 0.0)
        self._lift = -2j * w * self._share
        distance = 0.5 - np.abs(np.arange(count) / count - 0.5)
        profile = np.exp(-((distance / NARROW) ** 2))
        rate = strength / float(np.mean(profile))
        self._loss = np.expm1(-rate * self.every * travel * profile)

    def absorb(self, p: Complex) -> None:
        """Take off, in place, what is at the seam."""
        strain = values_of(1j * self._inverse * p[0], self._count)
        p[0] += self._lift * modes_of(strain * self._loss)


def _along(profile: Array, travel: float) -> Array:
    """The share of the absorber on the way of length ``travel`` that ends at each point."""
    modes = modes_of(profile)
    phase = 2j * math.pi * np.arange(modes.size)
    share = np.ones_like(modes)
    share[1:] = np.expm1(phase[1:] * travel) / (phase[1:] * travel) if travel > 0 else 1.0
    return travel / float(modes[0].real) * values_of(modes * share, profile.size)
