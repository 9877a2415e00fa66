"""What the first correction of a reduced equation does to a wave.

With ``Y_T = F_0 + eps^p F_p`` and ``Y = Y0 + eps^p Y1``, Y0 a solution of ``Y_T = F_0``,

    Y1_T = F_0'[Y0] Y1 + F_p[Y0],    Y1 = 0 at first.

It is solved once for all eps, by Fourier's series on an interval of X: constant coefficients are
integrated exactly, the rest by a Runge-Kutta method that finds its steps.  At second order in Y1
and with the next correction the equation has terms of the same size, so neither is kept.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from verify.lattices.jet_polynomial import JetPolynomial

if TYPE_CHECKING:
    from verify.lattices.long_wave_data import JetWave

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

TOLERANCE = 1e-8
"""Of Y1, in units of the largest change that F_p makes in a unit of T."""

MODES = 768
"""Points of the interval; of the modes two thirds are kept."""

MOST_AT_ONCE = 2048
"""Points at which the series is summed at once."""


class FirstCorrection:
    """Y1 of a wave, to be added to it with the factor ``eps**power``.

    ``interval``: the X between which it lives, the wave's period or much longer than the wave; Y1
    is 0 outside unless it ``repeats``.  `start` says when it is 0.
    """

    def __init__(
        self,
        flow: JetPolynomial,
        further: JetPolynomial,
        wave: JetWave,
        power: int,
        interval: tuple[float, float],
        repeats: bool = False,
        modes: int = MODES,
    ) -> None:
        self.power, self.interval, self.repeats = power, interval, repeats
        self._flow, self._further, self._wave = flow, further, wave
        low, high = interval
        self._X = low + (high - low) * np.arange(modes) / modes
        self._k = 2.0 * np.pi / (high - low) * np.arange(modes // 3 + 1)
        self._linear: Complex = np.zeros(self._k.size, dtype=np.complex128)
        for count, value in flow.linear.items():
            self._linear += value * (1j * self._k) ** count
        self._known: dict[float, Complex] = {}

    def start(self, T: float) -> None:
        """Let Y1 vanish at T."""
        self._known = {T: np.zeros(self._k.size, dtype=np.complex128)}

    def jets(self, X: ArrayLike, T: float, highest: int) -> Array:
        """Y1, its X-derivative and so on: an array (highest + 1, *points)."""
        factors = np.array([(1j * self._k) ** count for count in range(highest + 1)])
        places = np.asarray(X, dtype=np.float64)
        found = self._summed(places, factors * self._at(T))
        if not self.repeats:
            low, high = self.interval
            found[:, np.abs(places - (low + high) / 2) > (high - low) / 2] = 0.0
        return found

    def antiderivative(self, X: ArrayLike, T: float) -> Array:
        """W1 with ``W1_X = Y1``."""
        modes = self._at(T)
        places = np.asarray(X, dtype=np.float64)
        if not self.repeats:
            places = np.clip(places, *self.interval)
        over = np.where(self._k > 0.0, 1j * self._k, 1.0)
        rest = np.where(self._k > 0.0, modes / over, 0.0)
        return np.asarray(self._summed(places, rest[None])[0] + modes[0].real * places)

    def _summed(self, X: Array, modes: Complex) -> Array:
        """Fourier series, one a row, at points of any shape."""
        flat = X.ravel() - self.interval[0]
        doubled = modes * np.where(self._k > 0.0, 2.0, 1.0)
        parts = [
            (doubled @ np.exp(1j * np.outer(self._k, flat[i : i + MOST_AT_ONCE]))).real
            for i in range(0, flat.size, MOST_AT_ONCE)
        ]
        return np.concatenate(parts, axis=1).reshape(-1, *X.shape)

    def _at(self, T: float) -> Complex:
        """The modes at T, found from the nearest T where they are known."""
        if not self._known:
            raise ValueError(f"start must come before the corrected wave is asked for, got T = {T}")
        if T not in self._known:
            nearest = min(self._known, key=lambda known: abs(known - T))
            self._known[T] = self._advanced(self._known[nearest], nearest, T)
        return self._known[T]

    def _advanced(self, modes: Complex, begin: float, end: float) -> Complex:
        from scipy.integrate import solve_ivp

        def slope(T: float, turned: Complex) -> Complex:
            growth = np.exp(self._linear * (T - begin))
            return np.asarray(self._nonlinear(T, growth * turned) / growth)

        size = float(np.max(np.abs(self._further(self._jets(begin)))))
        found = solve_ivp(
            slope, (begin, end), modes, "DOP853", rtol=TOLERANCE, atol=TOLERANCE * size
        )
        if not found.success:
            raise ValueError(
                f"T must be reached by the corrected wave, got {end} ({found.message})"
            )
        return np.asarray(found.y[:, -1] * np.exp(self._linear * (end - begin)))

    def _jets(self, T: float) -> Array:
        highest = max(self._flow.highest, self._further.highest)
        return np.asarray(self._wave.jets(self._X, T, highest))

    def _nonlinear(self, T: float, modes: Complex) -> Complex:
        """The modes of all but what has constant coefficients."""
        jets = self._jets(T)
        total = self._further(jets)
        linear = self._flow.linear
        for count, slope in enumerate(self._flow.variation(jets)):
            rest = slope - linear.get(count, 0.0)
            if np.any(rest):
                total = total + rest * self._grid((1j * self._k) ** count * modes)
        return np.asarray(np.fft.rfft(total)[: self._k.size] / total.size)

    def _grid(self, modes: Complex) -> Array:
        return np.asarray(np.fft.irfft(modes * self._X.size, self._X.size))
