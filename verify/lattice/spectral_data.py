"""The initial data of a spectral ring, from a closed form."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.lattice.closing import REACH, blend_seam, close_circumference, rest_at_seam
from verify.lattice.constants import Constants
from verify.lattice.domain import MARGIN
from verify.lattice.initial import lattice_data
from verify.lattice.ring_state import RingState

Array = NDArray[np.float64]

LEAST = 16
"""Fewest wavelengths on a ring."""

BLEND = 16.0
"""On a constant background the data are blended within width/BLEND of the seam."""

SCALES = 6.0
"""They are blended within so many units of the wave's variable xi at least."""

FRONT = 8.0
"""Airy lengths by which a signal's front runs ahead of the sound: Ai(8) is 5e-8."""

SEEN = 4096
"""Points at which the largest strain is looked for."""

ABSORBED = 2.0
"""On a constant background left-going waves of numbers below this are absorbed."""

ABSORBED_SHARE = 0.25
"""On a periodic one those below this share of its own wave number."""


@dataclass(frozen=True)
class Ring:
    """Where a ring lies: its middle is ``ahead`` of c t.

    On a ``causal`` one no signal from the seam reaches the compared sites in time.
    """

    circumference: float
    ahead: float = 0.0
    causal: bool = False


@dataclass(frozen=True)
class RingData:
    """A wave on the lattice at time ``t0``, ready to be put on rings of any size.

    ``width`` is that of the compared region. A run that takes the time ``duration`` needs no ring
    wider than the causal one.
    """

    constants: Constants
    wave: Wave
    eps: float
    t0: float
    width: int
    duration: float = math.inf

    @property
    def periodic(self) -> bool:
        """Whether the background is a periodic wave."""
        return self.wave.wavelength is not None

    @property
    def unit(self) -> float:
        """What circumferences are counted in: the wavelength in sites, else ``width``."""
        wavelength = self.wave.wavelength
        return float(self.width) if wavelength is None else wavelength / self.eps

    @property
    def smallest(self) -> int:
        """Units on the smallest ring: it is twice as wide as the compared region."""
        if not self.periodic:
            return 2
        return max(LEAST, math.ceil(2 * self.width / self.unit))

    @property
    def reach(self) -> float:
        """The data within this distance of the seam are not the wave's."""
        if self.periodic:
            return self.unit
        scale = SCALES / (float(self.wave.normal_form.a) * self.eps)
        return max(self.unit / BLEND, scale)

    def absorbed(self, ring: Ring) -> float:
        """Left-going waves of numbers below this are absorbed at the seam; 0 if none are."""
        if ring.causal:
            return 0.0
        return 2.0 * math.pi / self.unit * ABSORBED_SHARE if self.periodic else ABSORBED

    def ring(self, count: int) -> Ring:
        """About ``count`` units, or the causal ring if that is not wider."""
        limit = self.causal
        if limit is not None and count * self.unit >= limit.circumference:
            return limit
        return Ring(self._closed(count, 0.0))

    @cached_property
    def causal(self) -> Ring | None:
        """The ring whose seam cannot be felt within ``duration``, None if that is infinite.

        No signal is faster than sqrt(max V'') about the strains that it runs through, here those
        of the data, except that the front of a dispersive one is some Airy lengths wide. In the
        frame that moves at c the compared sites rest, and the seam's signals cover the distances
        (c_max - c) t from behind and (c_max + c) t from the front.
        """
        if math.isinf(self.duration):
            return None
        c = self.constants.sound_speed()
        strain = self._strain(self.unit * self.smallest * (np.arange(SEEN) / SEEN - 0.5))
        fastest = self.constants.highest_frequency(strain) / 2.0
        front = MARGIN + FRONT * (c * self.duration / 8.0) ** (1.0 / 3.0)
        half = 0.5 * self.width + fastest * self.duration + front + self.reach
        ahead = c * self.duration
        count = math.ceil(2.0 * half / self.unit + 0.5) if self.periodic else 2.0 * half / self.unit
        return Ring(self._closed(count, ahead), ahead, causal=True)

    def state(self, ring: Ring, points: int) -> RingState:
        """The ring at t0, blended at its seam, without mean velocity."""
        length = ring.circumference
        x = length * (np.arange(points) / points - 0.5)
        width = self.reach / REACH
        y, s = blend_seam(lambda x: self._data(x + ring.ahead), length, width, x)
        left = self._middle + ring.ahead - 0.5 * length
        return RingState(self.t0, left, length, y, rest_at_seam(s, length, width, x))

    def _closed(self, count: float, ahead: float) -> float:
        """About ``count`` units; on a periodic background the length that closes the ring."""
        if not self.periodic:
            return count * self.unit
        return close_circumference(lambda x: self._strain(x + ahead), self.unit, round(count))

    @property
    def _middle(self) -> float:
        return self.constants.sound_speed() * self.t0

    def _strain(self, x: Array) -> Array:
        strain: Array = self._data(x)[0]
        return strain

    def _data(self, x: Array) -> Array:
        value = self.wave.at(self._middle + x, self.t0, self.eps)
        return np.stack(lattice_data(value, self.constants.sound_speed(), self.eps))
