"""Soliton damped by weak losses: at each time it has the shape of a lossless soliton.

The crest a(T) follows the `AmplitudeLaw` of the reduction. With ``r^2 = (a(T)/a(0))^power`` the
soliton ``Y(X)`` at T = 0 becomes ``r^(2/power) Y(r (X - x(T)))``, since its width scales as 1/r and
its speed as ``r^2``. It solves the equation with losses to leading order in the losses.
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

DAMPED_WAVES = ("kdv_soliton", "soliton_sech")
"""Closed forms whose crest follows an amplitude law under losses."""

FLANK_POSITION = 0.1
"""Position on the soliton's flank, in widths, from which its speed is computed."""


class DecayingWave:
    """Base of waves that tend to 0 on both sides: their background is 0."""

    constant_background = 0.0

    def background(self, X: ArrayLike, T: float) -> WaveValues:
        """Return the background and its derivatives, all 0."""
        return WaveValues(*np.zeros((3, *np.shape(X))))


class DampedSoliton(DecayingWave):
    """Soliton ``wave`` damped from T = 0 on by an amplitude law; implements `JetWave`."""

    def __init__(self, wave: Wave, law: AmplitudeLaw) -> None:
        self._wave, self._power = wave, law.power
        self._first = float(wave(0.0, 0.0).Y)
        flank = wave(FLANK_POSITION / wave.numbers.a, 0.0)
        self._drift = float(wave.normal_form.drift)
        self._speed = float(-flank.Y_T / flank.Y_X) - self._drift
        self._linear = law.power * float(law.linear)
        self._quadratic = law.power * float(law.further) * self._first**law.power

    def _scale_and_position(self, T: float) -> tuple[float, float]:
        """Return scale r and position x at T, from ``s' = -linear s - quadratic s^2``, ``s = r^2``.

        Raises ValueError for a T at which the law gives an infinite soliton.
        """
        lapse = -math.expm1(-self._linear * T) / self._linear if self._linear else T
        divisor = 1.0 + self._quadratic * lapse
        if divisor <= 0.0:
            raise ValueError(
                "slow_times must be later than the time at which the law of the losses gives an "
                f"infinite soliton, got {T:g} (its parameters are those at T = 0)"
            )
        path = math.log(divisor) / self._quadratic if self._quadratic else lapse
        r = math.sqrt(math.exp(-self._linear * T) / divisor)
        return r, self._speed * path + self._drift * T

    def crest(self, T: float) -> float:
        """Return the height a(T) of the crest, in Y."""
        return float(self._first * self._scale_and_position(T)[0] ** (2.0 / self._power))

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Return Y and its X-derivatives up to order ``highest``, (highest + 1, *points)."""
        r, position = self._scale_and_position(T)
        values = self._wave.jets(r * (np.asarray(X) - position), 0.0, highest)
        powers = 2.0 / self._power + np.arange(highest + 1.0)
        return np.asarray(values * np.reshape(r**powers, (-1, *(1,) * (values.ndim - 1))))

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """Return W with ``W_X = Y``."""
        r, position = self._scale_and_position(T)
        values = self._wave.antiderivative(r * (np.asarray(X) - position), 0.0)
        return np.asarray(values * r ** (2.0 / self._power - 1.0))
