"""What the spectral engine begins with: a wave's data on rings, and its scales."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.model import Model
from longwave.lattice.seam import (
    BLEND_REACH,
    blend_seam,
    close_circumference,
    negate_at_seam,
    rest_at_seam,
)
from longwave.lattice.spectral.field_ring import FieldRing, modes_of, values_of
from longwave.scenes.engines.domain_plan import front
from longwave.scenes.starts.moving_wave import MovingWave, WaveBounds, find_bounds

Array = NDArray[np.float64]

LEAST = 16
"""Fewest wavelengths on a ring."""

ROOM = 1.5
"""Least circumference, in units of what it must hold, beside the blended parts."""

BLEND = 32.0
"""On a constant background the data are blended within circumference/BLEND of the seam."""

SCALES = 6.0
"""They are blended within so many units of the wave's variable xi at least."""

SEEN = 4096
"""Points at which the largest strain is looked for."""

ABSORBED = 2.0
"""Left-going waves of numbers below this are absorbed."""

PASSED = 0.125
"""Right-going waves that fall farther behind c t, in circumferences, are absorbed."""

SMOOTH = 48.0
"""Least number of a wave that is absorbed as a short one, times the circumference: where the
absorber ends is then no step for it."""


@dataclass(frozen=True)
class SpectralDomain:
    """Where a ring lies: its middle is ``ahead`` of c t.

    On a ``causal`` one no signal from the seam reaches the compared sites in time.
    """

    circumference: float
    ahead: float = 0.0
    causal: bool = False


@dataclass(frozen=True)
class SpectralStart:
    """A moving wave's data, ready to be put on rings of any size.

    ``bounds`` holds the wave and the compared sites at all times. No ring needs to be wider than
    the causal one.
    """

    moving: MovingWave
    bounds: WaveBounds

    @property
    def periodic(self) -> bool:
        """Whether the background is a periodic wave."""
        return self.moving.wave.wavelength is not None

    @property
    def unit(self) -> float:
        """The background's wavelength in sites; one site, if it is constant."""
        wavelength = self.moving.wave.wavelength
        return 1.0 if wavelength is None else wavelength / self.moving.eps

    @property
    def steepness(self) -> float:
        """The wave's variable xi per site."""
        return self.moving.wave.numbers.a * self.moving.eps

    @property
    def smallest(self) -> float:
        """The smallest circumference: it holds the wave at all times, and the compared sites."""
        least = ROOM * self.bounds.width
        if self.periodic:
            return max(LEAST * self.unit, least + 2.0 * self.unit)
        return least + 2.0 * self.seam(least)

    @property
    def absorbed(self) -> float:
        """Left-going waves of numbers below this may be absorbed at the seam; 0 if none may.

        A periodic background has such waves of its own, and so has the step in strain that closes
        the ring of a kink.
        """
        return 0.0 if self.moving.wave.constant_background is None else ABSORBED

    def short(self, circumference: float) -> float:
        """Right-going waves of numbers above this may be absorbed at the seam; 0 if none need be.

        Of group velocity c cos(k/2), they fall 2 c sin^2(k/4) a unit of time behind.
        """
        way = 2.0 * self.moving.speed * self.moving.duration
        behind = PASSED * circumference / way if way > 0.0 else math.inf
        if not self.absorbed or behind >= math.sin(math.pi / 4.0) ** 2:
            return 0.0
        return max(SMOOTH / circumference, 4.0 * math.asin(math.sqrt(behind)))

    def ring(self, circumference: float, shift: float = 0.0) -> SpectralDomain:
        """A ring of about that circumference, its middle off the usual place by ``shift`` of it.

        It is the causal ring if that is not wider.
        """
        if circumference >= self.causal.circumference:
            return self.causal
        ahead = self.bounds.middle + shift * circumference
        return SpectralDomain(self._closed(circumference, ahead), ahead)

    @cached_property
    def causal(self) -> SpectralDomain:
        """The ring whose seam cannot be felt in time.

        No signal is faster than sqrt(max V'') about the strains that it runs through, here those
        of the wave, except that the front of a dispersive one is some Airy lengths wide. In the
        frame that moves at c the compared sites rest, and the seam's signals cover the distances
        (c_max - c) t from behind and (c_max + c) t from the front.
        """
        moving, fastest = self.moving, self.fastest
        way = fastest * moving.duration
        reach = self.seam(2.0 * fastest * moving.duration + 2 * moving.compared)
        half = moving.compared + way + front(fastest, moving.duration) + reach
        ahead = moving.speed * moving.duration
        return SpectralDomain(self._closed(2.0 * half + 0.5 * self.unit, ahead), ahead, causal=True)

    @property
    def fastest(self) -> float:
        """The largest speed of sound about the strains of the bounds and of the data."""
        x = self.smallest * (np.arange(SEEN) / SEEN - 0.5) + self.bounds.middle
        strain = np.concatenate([self._strain(x), self.bounds.strain])
        return self.moving.constants.highest_frequency(strain) / 2.0

    def state(self, ring: SpectralDomain, points: int) -> FieldRing:
        """The ring at t0, blended at its seam, without mean velocity."""
        length = ring.circumference
        x = length * (np.arange(points) / points - 0.5)
        left = self._middle + ring.ahead - 0.5 * length
        if self.kink:
            crest = (
                self.moving.wave.phase_zeros(self.moving.t0, self.moving.eps)[0]
                - self._middle
                - ring.ahead
            )
            y, s = negate_at_seam(lambda x: self._data(x + ring.ahead), length, round(crest), x)
        else:
            width = self.seam(length) / BLEND_REACH
            y, s = blend_seam(lambda x: self._data(x + ring.ahead), length, width, x)
            s = rest_at_seam(s, length, width, x)
        return FieldRing(self.moving.t0, (left,), (length,), y[None], s[None])

    def seam(self, circumference: float) -> float:
        """The data within this distance of the seam are not the wave's."""
        if self.periodic:
            return self.unit
        if self.kink:
            return float(self.moving.seam_room(self.moving.t0))
        least = SCALES / self.steepness
        return max(min(circumference, 4.0 * self.bounds.width) / BLEND, least)

    @property
    def kink(self) -> bool:
        """Whether the far fields are constants that differ.

        What such a wave sends to the left changes the strain behind it for good: each time that
        comes round a ring it turns its sign, and rings of many sizes show the same of it.
        """
        return self.moving.wave.constant_background is None and not self.periodic

    def _closed(self, circumference: float, ahead: float) -> float:
        """On a periodic background the length about ``circumference`` that closes the ring."""
        if not self.periodic:
            return circumference
        count = round(circumference / self.unit)
        return close_circumference(lambda x: self._strain(x + ahead), self.unit, count)

    @property
    def _middle(self) -> float:
        return self.moving.speed * self.moving.t0

    def _strain(self, x: Array) -> Array:
        strain: Array = self._data(x)[0]
        return strain

    def _data(self, x: Array) -> Array:
        return np.concatenate(self.moving.state(self._middle + x, self.moving.t0))


def spectral_start(moving: MovingWave, tolerance: float) -> SpectralStart:
    """The data of a wave with its bounds."""
    return SpectralStart(moving, find_bounds(moving, tolerance))


PER_RADIAN = 2.0
"""First sampling: points per unit of the wave's own variable xi."""


def first_density(moving: MovingWave) -> float:
    """Points per site to begin with."""
    return PER_RADIAN * moving.wave.numbers.a * moving.eps


FEWEST = 16
"""Steps of the first attempt, at least: differences between fewer say nothing about the order. Two
solitons were 1.9e-5 off with 4 steps and 1.6e-5 with 7."""


def first_step(speed: float, duration: float, k: float, turning: float) -> float:
    """The time in which the nonlinear part or dispersion turns a typical wave, or a run's share.

    ``turning`` is the `turning_time` of waves of number ``k``, the `rms_wavenumber`. In the
    long-wave limit both are fixed parts of the slow time T, so the number of steps does not depend
    on eps. Dispersion is the faster one for small waves on short ones.
    """
    longest = duration / FEWEST if duration > 0 else 1.0
    return min(longest, turning, 24.0 / (speed * k**3))


def turning_time(constants: Model, state: FieldRing, k: float) -> float:
    """The time in which the nonlinear part turns the phase of a wave of number ``k`` by one.

    About a strain y it runs ahead of the mean by (V''(y) - mean)/(2 c) k.
    """
    stiffness = constants.stiffness(state.f)
    spread = float(np.max(np.abs(stiffness - np.mean(stiffness))))
    if spread == 0.0:
        return math.inf
    return 2.0 * constants.sound_speed() / (spread * k)


def rms_wavenumber(state: FieldRing) -> float:
    """The root mean square wave number of the strain's spectrum, its mean apart, or of its flank.

    The spectrum of a kink is that of its far fields, so the steepest slope counts as well, in units
    of the largest strain.
    """
    modes = modes_of(state.f[0])
    k = 2.0 * math.pi / state.circumferences[0] * np.arange(modes.size)
    power = np.abs(modes[1:]) ** 2
    total = float(np.sum(power))
    if total == 0.0:
        return float(k[1])
    modes[0] = 0.0
    strain, slope = (values_of(part, state.counts[-1]) for part in (modes, 1j * k * modes))
    flank = float(np.max(np.abs(slope)) / np.max(np.abs(strain)))
    return max(flank, math.sqrt(float(np.sum(power * k[1:] ** 2)) / total))
