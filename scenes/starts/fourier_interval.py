"""Functions on an interval by their Fourier series: on its points, and between them."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MOST_AT_ONCE = 2048
"""Points at which a series is summed at once."""


class FourierInterval:
    """An interval with equidistant ``points``; of the modes the lower two thirds are kept.

    A function is its modes, of real values.  Outside the interval it ``repeats`` or is 0.
    """

    def __init__(self, interval: tuple[float, float], points: int, repeats: bool = False) -> None:
        self.interval, self.points, self.repeats = interval, points, repeats
        self.length = interval[1] - interval[0]
        self.k = 2.0 * np.pi / self.length * np.arange(points // 3 + 1)

    @cached_property
    def X(self) -> Array:
        """The points."""
        return np.asarray(self.interval[0] + self.length * np.arange(self.points) / self.points)

    def modes(self, values: Array) -> Complex:
        """The modes of a function with these values at the points."""
        return np.asarray(np.fft.rfft(values)[: self.k.size] / self.points)

    def values(self, modes: Complex, derivatives: int = 0) -> Array:
        """A derivative of the function at the points."""
        return np.asarray(
            np.fft.irfft((1j * self.k) ** derivatives * modes * self.points, self.points)
        )

    def jets(self, modes: Complex, X: ArrayLike, highest: int) -> Array:
        """The function and its derivatives anywhere: an array (highest + 1, *points)."""
        places = np.asarray(X, dtype=np.float64)
        factors = np.array([(1j * self.k) ** count for count in range(highest + 1)])
        found = self._summed(places, factors * modes)
        if not self.repeats:
            found[:, np.abs(places - sum(self.interval) / 2) > self.length / 2] = 0.0
        return found

    def antiderivative(self, modes: Complex, X: ArrayLike) -> Array:
        """An antiderivative anywhere; constant outside the interval if the function is 0 there."""
        places = np.asarray(X, dtype=np.float64)
        if not self.repeats:
            places = np.clip(places, *self.interval)
        rest = np.zeros_like(modes)
        rest[1:] = modes[1:] / (1j * self.k[1:])
        return np.asarray(self._summed(places, rest[None])[0] + modes[0].real * places)

    def _summed(self, X: Array, rows: Complex) -> Array:
        flat = X.ravel() - self.interval[0]
        doubled = rows * np.where(self.k > 0.0, 2.0, 1.0)
        starts = range(0, max(flat.size, 1), MOST_AT_ONCE)
        waves = (np.exp(1j * np.outer(self.k, flat[i : i + MOST_AT_ONCE])) for i in starts)
        # not `@`: the last digits of a BLAS product depend on its number of threads
        parts = [np.einsum("rk,kx->rx", doubled, wave).real for wave in waves]
        return np.concatenate(parts, axis=1).reshape(-1, *X.shape)
