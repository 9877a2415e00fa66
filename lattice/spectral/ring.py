"""A real periodic function of position, sampled: strain and velocity on a ring at one time."""

import math
from dataclasses import dataclass

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

TAIL = 8
"""The spectrum's tail is its last 1/TAIL."""


def forward(values: Array) -> Complex:
    """Fourier coefficients 0 .. M/2 of a real periodic function, divided by M."""
    modes: Complex = ducc0.fft.r2c(values, inorm=2, nthreads=1)
    return modes


def backward(modes: Complex, count: int, out: Array | None = None) -> Array:
    """The real function with the coefficients ``modes`` at ``count`` points."""
    values: Array = ducc0.fft.c2r(modes, lastsize=count, forward=False, out=out, nthreads=1)
    return values


@dataclass(frozen=True)
class RingState:
    """Samples of strain and velocity at x = left + j L/M, j = 0 .. M - 1, at time ``t``."""

    t: float
    left: float
    circumference: float
    y: Array
    s: Array

    @property
    def points(self) -> Array:
        """The sample points."""
        steps = np.arange(self.y.size, dtype=np.float64)
        points: Array = self.left + self.circumference / self.y.size * steps
        return points

    def strain(self, x: ArrayLike) -> Array:
        """Strain at any real positions (trigonometric interpolation to 1e-12)."""
        return self._at(self.y, x)

    def velocity(self, x: ArrayLike) -> Array:
        """Velocity at any real positions."""
        return self._at(self.s, x)

    def tail(self) -> float:
        """Sum of the moduli in the last 1/TAIL of the strain's spectrum.

        It bounds what these modes add to the strain anywhere. What a finer sampling would resolve
        beyond them is smaller, for spectra that fall.
        """
        return spectrum_tail(forward(self.y))

    def _at(self, samples: Array, x: ArrayLike) -> Array:
        modes = forward(samples)
        modes[1 : (samples.size + 1) // 2] *= 2.0
        phase = (2.0 * math.pi / self.circumference) * (np.asarray(x, dtype=np.float64) - self.left)
        grid = np.concatenate([np.zeros(modes.size - 1), modes]).astype(np.complex128)
        values = ducc0.nufft.u2nu(
            grid=grid[:-1] if grid.size % 2 else grid,
            coord=np.mod(phase, 2.0 * math.pi)[:, None],
            forward=False,
            epsilon=1e-12,
            periodicity=2.0 * math.pi,
        )
        real: Array = np.ascontiguousarray(values.real, dtype=np.float64)
        return real

    def resampled(self, count: int) -> "RingState":
        """The same function at ``count`` points."""
        y, s = (_resample(values, count) for values in (self.y, self.s))
        return RingState(self.t, self.left, self.circumference, y, s)


def spectrum_tail(modes: Complex) -> float:
    """Twice the sum of the moduli in the last 1/TAIL of a real function's coefficients."""
    return 2.0 * float(np.sum(np.abs(modes[-(modes.size // TAIL) :])))


def _resample(values: Array, count: int) -> Array:
    modes = np.zeros(count // 2 + 1, dtype=np.complex128)
    source = forward(values)
    kept = min(modes.size, source.size) - 1
    modes[:kept] = source[:kept]
    return backward(modes, count)
