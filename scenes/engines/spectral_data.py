"""Initial data of the spectral engine: a moving wave on rings of any size, and its scales."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from longwave.lattice import seam
from longwave.lattice.model import Model
from longwave.lattice.spectral.field_ring import FieldRing, modes_of, values_of
from longwave.scenes.engines.domain_plan import front
from longwave.scenes.starts.moving_wave import MovingWave, WaveBounds, find_bounds
from longwave.support.real_arrays import Array

MIN_WAVELENGTHS = 16
"""Minimum number of wavelengths of a periodic background on a ring."""

WIDTH_FACTOR = 1.5
"""Least circumference without its blended parts, in units of `WaveBounds.width`."""

BLEND_DIVISOR = 32.0
"""On a constant background the data are blended within at most circumference/BLEND_DIVISOR of the
seam, but at least within `MIN_BLEND_WIDTH`."""

MIN_BLEND_WIDTH = 6.0
"""Least width of the blended part, in units of the wave's variable xi."""

SPEED_SAMPLES = 4096
"""Number of strains at which the speed of sound is evaluated to find its maximum."""

ABSORBED_WAVENUMBER = 2.0
"""Wavenumber, in radians per site, below which left-going waves are absorbed."""

ABSORBED_LAG = 0.125
"""Distance behind c t, in circumferences, beyond which right-going waves are absorbed."""

SMOOTH_EDGE = 48.0
"""Least wavenumber of absorbed short waves, times the circumference. The edge of the absorber is
smooth on the scale of such a wave."""


@dataclass(frozen=True)
class SpectralDomain:
    """Circumference and position of a ring, whose middle is ``lead`` sites ahead of c t.

    On a ``causal`` ring no signal from the seam reaches the compared sites in time.
    """

    circumference: float
    lead: float = 0.0
    causal: bool = False


@dataclass(frozen=True)
class SpectralStart:
    """Initial data of a moving wave for rings of any size up to the causal one.

    ``bounds`` encloses the wave and the compared sites at all times.
    """

    moving: MovingWave
    bounds: WaveBounds

    @property
    def periodic(self) -> bool:
        """Whether the background is a periodic wave."""
        return self.moving.wave.wavelength is not None

    @property
    def unit(self) -> float:
        """Wavelength of the background in sites; 1 if the background is constant."""
        wavelength = self.moving.wave.wavelength
        return 1.0 if wavelength is None else wavelength / self.moving.eps

    @property
    def smallest(self) -> float:
        """Smallest circumference that contains the wave and the compared sites at all times."""
        least = WIDTH_FACTOR * self.bounds.width
        if self.periodic:
            return max(MIN_WAVELENGTHS * self.unit, least + 2.0 * self.unit)
        return least + 2.0 * self.seam(least)

    @property
    def absorbed(self) -> float:
        """Wavenumber below which left-going waves may be absorbed at the seam; 0 if none may.

        A periodic background contains such waves itself, and so does the step in strain that closes
        the ring of a kink.
        """
        return 0.0 if self.moving.wave.constant_background is None else ABSORBED_WAVENUMBER

    def short(self, circumference: float) -> float:
        """Return the wavenumber above which right-going waves may be absorbed; 0 if none need be.

        Their group velocity is c cos(k/2): they lag behind c t by 2 c sin^2(k/4) per time.
        """
        distance = 2.0 * self.moving.speed * self.moving.duration
        lag = ABSORBED_LAG * circumference / distance if distance > 0.0 else math.inf
        if not self.absorbed or lag >= math.sin(math.pi / 4.0) ** 2:
            return 0.0
        return max(SMOOTH_EDGE / circumference, 4.0 * math.asin(math.sqrt(lag)))

    def ring(self, circumference: float, shift: float = 0.0) -> SpectralDomain:
        """Return a ring of this circumference, or the causal ring if that is not larger.

        The ring's middle is moved ahead by ``shift``, in circumferences.
        """
        if circumference >= self.causal.circumference:
            return self.causal
        lead = self.bounds.middle + shift * circumference
        return SpectralDomain(self._closed(circumference, lead), lead)

    @cached_property
    def causal(self) -> SpectralDomain:
        """Causal ring: no signal from its seam reaches the compared sites during the run.

        The fastest signals travel at sqrt(max V''), maximised over the strains of the wave; their
        dispersive front adds some Airy lengths. In the frame that moves at c the compared sites
        rest, and signals from the seam travel (c_max - c) t from behind and (c_max + c) t from the
        front.
        """
        moving, fastest = self.moving, self.fastest
        distance = fastest * moving.duration
        reach = self.seam(2.0 * fastest * moving.duration + 2 * moving.compared)
        half = moving.compared + distance + front(fastest, moving.duration) + reach
        lead = moving.speed * moving.duration
        return SpectralDomain(self._closed(2.0 * half + 0.5 * self.unit, lead), lead, causal=True)

    @property
    def fastest(self) -> float:
        """Largest speed of sound over the strains of ``bounds`` and of the initial data."""
        x = self.smallest * (np.arange(SPEED_SAMPLES) / SPEED_SAMPLES - 0.5) + self.bounds.middle
        strain = np.concatenate([self._strain(x), self.bounds.strain])
        return self.moving.constants.highest_frequency(strain) / 2.0

    def state(self, ring: SpectralDomain, points: int) -> FieldRing:
        """Return the initial state on a ring, blended at its seam and with zero mean velocity."""
        length = ring.circumference
        x = length * (np.arange(points) / points - 0.5)
        left = self._middle + ring.lead - 0.5 * length

        def data(x: Array) -> Array:
            return self._data(x + ring.lead)

        if self.kink:
            zero = self.moving.wave.phase_zeros(self.moving.t0, self.moving.eps)[0]
            crest = round(zero - self._middle - ring.lead)
            y, s = seam.negate_at_seam(data, length, crest, x)
        else:
            width = self.seam(length) / seam.BLEND_REACH
            y, s = seam.blend_seam(data, length, width, x)
            s = seam.rest_at_seam(s, length, width, x)
        return FieldRing(self.moving.t0, (left,), (length,), y[None], s[None])

    def seam(self, circumference: float) -> float:
        """Return the distance from the seam within which the data are blended."""
        if self.periodic:
            return self.unit
        if self.kink:
            return float(self.moving.seam_room(self.moving.t0))
        least = MIN_BLEND_WIDTH / (self.moving.wave.numbers.a * self.moving.eps)
        return max(min(circumference, 4.0 * self.bounds.width) / BLEND_DIVISOR, least)

    @property
    def kink(self) -> bool:
        """Whether the wave is a kink, with two different constants as far fields.

        The waves that a kink radiates to the left change the strain behind it permanently. Each
        time they go round the ring their sign changes, so rings of several sizes can agree on the
        same wrong result.
        """
        return self.moving.wave.constant_background is None and not self.periodic

    def _closed(self, circumference: float, lead: float) -> float:
        """Return the length near ``circumference`` on which a periodic background closes.

        The ring's middle is ``lead`` sites ahead of c t.
        """
        if not self.periodic:
            return circumference
        count = round(circumference / self.unit)
        return seam.close_circumference(lambda x: self._strain(x + lead), self.unit, count)

    @property
    def _middle(self) -> float:
        return self.moving.speed * self.moving.t0

    def _strain(self, x: Array) -> Array:
        return np.asarray(self._data(x)[0])

    def _data(self, x: Array) -> Array:
        return np.concatenate(self.moving.state(self._middle + x, self.moving.t0))


def spectral_start(moving: MovingWave, tolerance: float) -> SpectralStart:
    """Return the initial data of a wave, with bounds found to ``tolerance``."""
    return SpectralStart(moving, find_bounds(moving, tolerance))


POINTS_PER_RADIAN = 2.0
"""Number of points of a search's first run, per unit of the wave's own variable xi."""


def first_density(moving: MovingWave) -> float:
    """Return the number of points per site with which a search begins."""
    return POINTS_PER_RADIAN * moving.wave.numbers.a * moving.eps


MIN_STEPS = 16
"""Minimum number of steps of the first run. With fewer, the differences between runs do not show
the order of the scheme: the error of two solitons was 1.9e-5 with 4 steps and 1.6e-5 with 7."""


def first_step(speed: float, duration: float, k: float, turning: float) -> float:
    """Return the first step: the shortest time scale of nonlinearity, dispersion and duration.

    ``turning`` is the `turning_time` of waves of wavenumber ``k``, the `rms_wavenumber`. In the
    long-wave limit both times are fixed fractions of the slow time T, so the number of steps does
    not depend on eps. For weak, short waves the time of dispersion is the shorter one.
    """
    longest = duration / MIN_STEPS if duration > 0 else 1.0
    return min(longest, turning, 24.0 / (speed * k**3))


def turning_time(constants: Model, state: FieldRing, k: float) -> float:
    """Return the time in which nonlinearity shifts the phase of waves of wavenumber ``k`` by 1 rad.

    At strain y their frequency differs from the mean by k (V''(y) - mean(V'')) / (2 c).
    """
    stiffness = constants.stiffness(state.f)
    spread = float(np.max(np.abs(stiffness - np.mean(stiffness))))
    if spread == 0.0:
        return math.inf
    return 2.0 * constants.sound_speed() / (spread * k)


def rms_wavenumber(state: FieldRing) -> float:
    """Return the root mean square wavenumber of the strain, or the relative slope if larger.

    The mean is excluded. The relative slope is the steepest slope over the largest strain; it
    matters for a kink, whose spectrum is dominated by its far fields.
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
