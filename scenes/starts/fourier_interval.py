"""Fourier series on an interval: values and derivatives at its points and between them."""

from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MAX_POINTS_AT_ONCE = 2048
"""Maximum number of points at which a series is summed in one array operation."""


class FourierInterval:
    """Interval with equidistant ``points``; the lower two thirds of the Fourier modes are used.

    Functions are real and given by their modes. Outside the interval they are 0, or periodic if the
    interval ``repeats``.
    """

    def __init__(self, interval: tuple[float, float], points: int, repeats: bool = False) -> None:
        self.interval, self.points, self.repeats = interval, points, repeats
        self.length = interval[1] - interval[0]
        self.k = 2.0 * np.pi / self.length * np.arange(points // 3 + 1)

    @cached_property
    def X(self) -> Array:
        """Points of the interval."""
        return np.asarray(self.interval[0] + self.length * np.arange(self.points) / self.points)

    def modes(self, values: Array) -> Complex:
        """Return the Fourier modes of a real function from its values at the points."""
        return np.asarray(np.fft.rfft(values)[: self.k.size] / self.points)

    def values(self, modes: Complex, derivatives: int = 0) -> Array:
        """Return a function, or its derivative of order ``derivatives`` > 0, at the points."""
        return np.asarray(
            np.fft.irfft((1j * self.k) ** derivatives * modes * self.points, self.points)
        )

    def jets(self, modes: Complex, X: ArrayLike, highest: int) -> Array:
        """Return a function and its derivatives up to ``highest`` at any X, (highest + 1, *X)."""
        positions = np.asarray(X, dtype=np.float64)
        factors = np.array([(1j * self.k) ** count for count in range(highest + 1)])
        values = self._sum(positions, factors * modes)
        if not self.repeats:
            values[:, np.abs(positions - sum(self.interval) / 2) > self.length / 2] = 0.0
        return values

    def antiderivative(self, modes: Complex, X: ArrayLike) -> Array:
        """Return an antiderivative at any X; constant outside an interval that does not repeat."""
        positions = np.asarray(X, dtype=np.float64)
        if not self.repeats:
            positions = np.clip(positions, *self.interval)
        varying = np.zeros_like(modes)
        varying[1:] = modes[1:] / (1j * self.k[1:])
        return np.asarray(self._sum(positions, varying[None])[0] + modes[0].real * positions)

    def _sum(self, X: Array, rows: Complex) -> Array:
        """Return the Fourier sums of several rows of modes at X, (rows, *X)."""
        flat = X.ravel() - self.interval[0]
        doubled = rows * np.where(self.k > 0.0, 2.0, 1.0)
        starts = range(0, max(flat.size, 1), MAX_POINTS_AT_ONCE)
        waves = (np.exp(1j * np.outer(self.k, flat[i : i + MAX_POINTS_AT_ONCE])) for i in starts)
        # not `@`, because the last digits of a BLAS product depend on the number of threads
        parts = [np.einsum("rk,kx->rx", doubled, wave).real for wave in waves]
        return np.concatenate(parts, axis=1).reshape(-1, *X.shape)
