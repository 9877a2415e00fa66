"""The initial data of a spectral ring, from a closed form."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.lattice.closing import REACH, blend_seam, close_circumference
from verify.lattice.constants import Constants
from verify.lattice.initial import lattice_data
from verify.lattice.ring_state import RingState

Array = NDArray[np.float64]

LEAST = 16
"""Fewest wavelengths on a ring."""

BLEND = 16
"""On a constant background the data are blended within 1/BLEND of the ring from the seam."""


@dataclass(frozen=True)
class RingData:
    """A wave on the lattice at time ``t0``, ready to be put on rings of any size.

    ``unit`` is what circumferences are counted in: the wavelength in sites, or on a constant
    background the ``width`` of the compared region.
    """

    constants: Constants
    wave: Wave
    eps: float
    t0: float
    width: int

    @property
    def periodic(self) -> bool:
        """Whether the background is a periodic wave."""
        return self.wave.wavelength is not None

    @property
    def unit(self) -> float:
        """What circumferences are counted in, in sites."""
        wavelength = self.wave.wavelength
        return float(self.width) if wavelength is None else wavelength / self.eps

    @property
    def smallest(self) -> int:
        """Units on the smallest ring: it is twice as wide as the compared region."""
        if not self.periodic:
            return 2
        return max(LEAST, math.ceil(2 * self.width / self.unit))

    def circumference(self, count: int) -> float:
        """About ``count`` units; on a periodic background the length that closes the ring."""
        if not self.periodic:
            return count * self.unit
        return close_circumference(self._strain, self.unit, count)

    def state(self, circumference: float, points: int) -> RingState:
        """``moving_state`` without the mean velocity that the miss at the seam makes.

        It would let the mean strain drift, by much more than the seam itself disturbs.
        """
        return self.moving_state(circumference, points).at_rest()

    def moving_state(self, circumference: float, points: int) -> RingState:
        """The ring at t0, centred on c t0, blended at its seam."""
        x = circumference * (np.arange(points) / points - 0.5)
        reach = self.unit if self.periodic else circumference / BLEND
        y, s = blend_seam(self._data, circumference, reach / REACH, x)
        left = self._middle - 0.5 * circumference
        return RingState(self.t0, left, circumference, y, s)

    @property
    def _middle(self) -> float:
        return self.constants.sound_speed() * self.t0

    def _strain(self, x: Array) -> Array:
        strain: Array = self._data(x)[0]
        return strain

    def _data(self, x: Array) -> Array:
        value = self.wave.at(self._middle + x, self.t0, self.eps)
        return np.stack(lattice_data(value, self.constants.sound_speed(), self.eps))
