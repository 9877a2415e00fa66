"""Absorbers, at the seam of a moving ring, of left-going and short waves.

In the frame that moves at c, left-going waves travel at -2c. On the infinite lattice, what the wave
radiates to the left never returns; on a ring it meets the wave again every L/(2c) and shifts it a
little each time. The domain's error therefore fell like the number of such meetings, 1/L, whatever
the data at the seam. With an absorber, it depends only on the ring's own tails.

The left-going strain f has the modes p_+/(2 i w). Its mean is a convention, fixed by f = 0 at the
seam at the start. The mean of the f that is absorbed is removed from the mean of y; on the infinite
lattice it has travelled away. Only waves longer than a cutoff are absorbed, because the short ones
of a periodic background must stay.

Short right-going waves, of group velocity c cos(k/2), fall behind the frame, pass the seam and come
back from the front. Those that can travel that far are absorbed as well, at a rate that makes one
passage of the fastest of them cost as much as one of a left-going wave.
"""

import math

import ducc0  # type: ignore[import-not-found]
import numpy as np

from longwave.lattice.spectral.field_ring import FieldRing, modes_of, values_of
from longwave.support.real_arrays import Array, Complex

ABSORBER_WIDTH = 1.0 / 12.0
"""Width of the absorber, in circumferences; its profile is exp(-(distance to the seam/width)^2).

A strength of 28 leaves 7e-13 of a wave; with half and twice the width, 2e-8 and 9e-9. At the
default strength all three widths are alike (`benchmarks/lattice_constants.py`).
"""

SHORT_ABSORBER_WIDTH = 1.0 / 24.0
"""Width of the absorber of short waves, in circumferences; slow waves feel a wide one from further
away. With half of this width 4e-6 of a wave are left whatever the strength, with this width 4e-11
(`benchmarks/lattice_constants.py`)."""

ABSORBER_STRENGTH = 14.0
"""Default logarithm of the factor by which one passage reduces a wave: 8e-7 of the wave are
left."""

ABSORPTION_DISTANCE = 1.0 / 64.0
"""Distance, in circumferences, that left-going waves travel between two absorptions."""

MAX_STEP_DISTANCE = 1.0 / 8.0
"""Largest distance, in circumferences, that left-going waves may travel in a step; with longer
steps nothing is absorbed."""

MAX_ABSORBED_RATIO = 1.5
"""Largest wavenumber absorbed, in units of the cutoff; exp(-(k/cutoff)^8) is the absorbed
fraction."""


class LeftAbsorber:
    """Absorbs left-going waves of wavenumbers below ``cutoff`` at the seam of the ring ``state``.

    ``w`` are the frequencies of the modes in ``p``, ``speed`` is the speed of the ring, ``step``
    the time step. ``every`` is the number of steps between two absorptions, 0 if a step is too
    long.
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
        every = max(1, int(ABSORPTION_DISTANCE * length / travel))
        self.every = 0 if travel > MAX_STEP_DISTANCE * length else every
        numbers = 2.0 * math.pi / length * np.arange(w.size)
        self._mode_count = int(np.count_nonzero(numbers < MAX_ABSORBED_RATIO * cutoff))
        self._count = 2 * int(ducc0.fft.good_size(2 * self._mode_count, True))
        self._share = np.exp(-((numbers[: self._mode_count] / cutoff) ** 8))
        self._lift = 2j * w[: self._mode_count]
        distance = 0.5 - np.abs(np.arange(self._count) / self._count - 0.5)
        profile = np.exp(-((distance / ABSORBER_WIDTH) ** 2))
        self._loss = np.expm1(-strength * _along(profile, self.every * travel / length))
        self.level = 0.0
        self.level = -float(np.average(self._strain(p), weights=profile))

    def absorb(self, p: Complex) -> float:
        """Damp, in place, the left-going waves at the seam; return the change of the mean of y."""
        change = modes_of(self._strain(p) * self._loss)[: self._mode_count] * self._share
        p[1, : self._mode_count] += self._lift * change
        mean = float(change[0].real)
        self.level += mean
        return mean

    def _strain(self, p: Complex) -> Array:
        """Return the left-going strain on the absorber's points."""
        modes = np.zeros(self._count // 2 + 1, dtype=np.complex128)
        modes[1 : self._mode_count] = p[1, 1 : self._mode_count] / self._lift[1:] * self._share[1:]
        modes[0] = self.level
        return values_of(modes, self._count)


class ShortAbsorber:
    """Absorbs right-going waves of wavenumbers above ``cutoff`` at the seam of the ring ``state``.

    ``w`` are the frequencies of the modes, 0 for modes that stand still; ``speed`` is the speed of
    the ring, ``step`` the time step. ``every`` is the number of steps between two absorptions.
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
        self.every = max(1, int(ABSORPTION_DISTANCE / travel))
        self._count = count
        self._share = -np.expm1(-((numbers / cutoff) ** 8))
        self._share[w == 0.0] = 0.0
        self._inverse = np.zeros_like(w)
        np.divide(self._share, 2.0 * w, out=self._inverse, where=w > 0.0)
        self._lift = -2j * w * self._share
        distance = 0.5 - np.abs(np.arange(count) / count - 0.5)
        profile = np.exp(-((distance / SHORT_ABSORBER_WIDTH) ** 2))
        rate = strength / float(np.mean(profile))
        self._loss = np.expm1(-rate * self.every * travel * profile)

    def absorb(self, p: Complex) -> None:
        """Damp, in place, the short waves at the seam."""
        strain = values_of(1j * self._inverse * p[0], self._count)
        p[0] += self._lift * modes_of(strain * self._loss)


def _along(profile: Array, travel: float) -> Array:
    """Return the absorption along the path of length ``travel`` that ends at each point."""
    modes = modes_of(profile)
    phase = 2j * math.pi * np.arange(modes.size)
    share = np.ones_like(modes)
    share[1:] = np.expm1(phase[1:] * travel) / (phase[1:] * travel) if travel > 0 else 1.0
    return travel / float(modes[0].real) * values_of(modes * share, profile.size)
