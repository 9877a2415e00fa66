"""A soliton that weak losses wear away: its shape that of the lossless one of its amplitude.

The crest a(T) follows the `AmplitudeLaw` of the reduction. With ``r^2 = (a(T)/a(0))^power`` the
soliton ``Y(X)`` at T = 0 becomes ``r^(2/power) Y(r (X - x(T)))``, for its width goes as 1/r and its
speed as ``r^2``. It solves the equation with losses to leading order in them.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.solutions import WaveValues

if TYPE_CHECKING:
    from longwave.derive.amplitude_law import AmplitudeLaw
    from longwave.solutions import Wave

Array = NDArray[np.float64]

LAWFUL = ("kdv_soliton", "soliton_sech")
"""Closed forms with this shape."""

FLANK = 0.1
"""A place at T = 0, in widths, where the soliton rises."""


class DampedSoliton:
    """The soliton ``wave`` from T = 0 on under a law; it has jets and antiderivative."""

    constant_background = 0.0

    def __init__(self, wave: Wave, law: AmplitudeLaw) -> None:
        self._wave, self._power = wave, law.power
        self._first = float(wave(0.0, 0.0).Y)
        flank = wave(FLANK / wave.numbers.a, 0.0)
        drift = float(wave.normal_form.drift)
        self._drift, self._speed = drift, float(-flank.Y_T / flank.Y_X) - drift
        self._fading = law.power * float(law.linear)
        self._spreading = law.power * float(law.further) * self._first**law.power

    def _worn(self, T: float) -> tuple[float, float]:
        """r and x at T, from ``s' = -fading s - spreading s^2`` with ``s = r^2``."""
        lost = -math.expm1(-self._fading * T) / self._fading if self._fading else T
        spread = 1.0 + self._spreading * lost
        if spread <= 0.0:
            raise ValueError(
                f"slow_times must be after the soliton is infinite by the law of its losses, got "
                f"{T:g} (its parameters are those at T = 0)"
            )
        path = math.log(spread) / self._spreading if self._spreading else lost
        r = math.sqrt(math.exp(-self._fading * T) / spread)
        return r, self._speed * path + self._drift * T

    def crest(self, T: float) -> float:
        """a(T)."""
        return float(self._first * self._worn(T)[0] ** (2.0 / self._power))

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Y, Y_X, Y_XX, ...: an array (highest + 1, *points)."""
        r, moved = self._worn(T)
        found = self._wave.jets(r * (np.asarray(X) - moved), 0.0, highest)
        powers = 2.0 / self._power + np.arange(highest + 1.0)
        return np.asarray(found * np.reshape(r**powers, (-1, *(1,) * (found.ndim - 1))))

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """W with ``W_X = Y``."""
        r, moved = self._worn(T)
        found = self._wave.antiderivative(r * (np.asarray(X) - moved), 0.0)
        return np.asarray(found * r ** (2.0 / self._power - 1.0))

    def background(self, X: ArrayLike, T: float) -> WaveValues:
        """None: the soliton deviates from 0."""
        return WaveValues(*np.zeros((3, *np.shape(X))))
