"""The mKdV equation on a periodic domain, by exponential integration in Fourier space.

    U_tau + 6 s U^2 U_xi + U_xixixi = 0,    s = +1 or -1

Written with the mean m of U^2 over the period (constant in time), the linear part is
i k^3 - 6 i s m k and the rest N = -2 s i k (U^3 - 3 m U)^. The linear part is exact, so the step is
set by the solution and not by k^3. It serves where no closed form exists and as a check in time of
those that do.
"""

import math
from collections.abc import Sequence

import ducc0  # type: ignore[import-not-found]
import numpy as np
from numpy.typing import NDArray

from verify.exponential.adams import ExponentialAdams

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

FIRST_STEP = 1e-2
"""First step, in units of 1/max |U|^3; the control changes it at once."""


class PeriodicMkdv:
    """A solution of the mKdV equation with period ``period``, from samples ``U`` at tau = 0.

    The samples are at xi = j period / M, j = 0 .. M - 1. Of the modes of the nonlinear term those
    above half of the highest are dropped, which removes all aliasing of the cubic. Raises
    ValueError for s other than 1 and -1, a period that is not positive and samples that are not
    finite.
    """

    def __init__(self, U: Array, period: float, s: int, step: float | None = None) -> None:
        values = np.asarray(U, dtype=np.float64)
        if s not in (1, -1):
            raise ValueError(f"s must be 1 or -1, got {s} (the sign of K4)")
        if not (math.isfinite(period) and period > 0):
            raise ValueError(f"period must satisfy period > 0, got {period:g}")
        if not np.all(np.isfinite(values)):
            raise ValueError("U must be finite at all samples (nan or inf found)")
        self.tau = 0.0
        self.period = period
        self._count = values.size
        self._mean_square = float(np.mean(values**2))
        k = 2.0 * math.pi / period * np.arange(values.size // 2 + 1)
        linear = 1j * (k**3 - 6.0 * s * self._mean_square * k)[None, :]
        self._symbol = -2j * s * k
        self._symbol[k.size // 2 :] = 0.0
        modes = ducc0.fft.r2c(values, inorm=2)
        modes[k.size // 2 :] = 0.0
        scale = max(float(np.max(np.abs(values))), 1e-3)
        self.integrator = ExponentialAdams(
            linear,
            self._nonlinearity,
            modes[None, :],
            self._norm,
            FIRST_STEP / scale**3 if step is None else step,
        )

    def advance(self, duration: float, tolerance: float) -> Array:
        """U after ``duration`` > 0; ``tolerance`` is the error allowed on the way (sup norm)."""
        if not duration > 0:
            raise ValueError(f"duration must satisfy duration > 0, got {duration:g}")
        self.integrator.advance(duration, tolerance / duration)
        self.tau += duration
        return self.U

    @property
    def U(self) -> Array:
        """The samples at the present ``tau``."""
        return self._samples(self.integrator.p[0])

    @property
    def invariants(self) -> tuple[float, float, float]:
        """Means over the period of U, U^2 and U^4 - s U_xi^2 (mass, momentum, energy)."""
        modes = self.integrator.p[0]
        U = self._samples(modes)
        k = 2.0 * math.pi / self.period * np.arange(modes.size)
        slope = self._samples(1j * k * modes)
        s = 1.0 if self._symbol[1].imag < 0 else -1.0
        energy = float(np.mean(U**4 - s * slope**2))
        return float(np.mean(U)), float(np.mean(U**2)), energy

    def _samples(self, modes: Complex) -> Array:
        values: Array = ducc0.fft.c2r(modes, lastsize=self._count, forward=False)
        return values

    def _norm(self, change: Complex) -> float:
        return float(np.max(np.abs(self._samples(change[0]))))

    def _nonlinearity(self, p: Complex) -> Complex:
        U = self._samples(p[0])
        U *= U * U - 3.0 * self._mean_square
        force: Complex = ducc0.fft.r2c(U, inorm=2)
        force *= self._symbol
        return force


def evolve(U: Array, period: float, s: int, times: Sequence[float], tolerance: float) -> Array:
    """Samples of the solution at the increasing ``times`` > 0; shape (len(times), M).

    ``tolerance`` is the error allowed at the last of them.
    """
    solution = PeriodicMkdv(U, period, s)
    rate = tolerance / times[-1]
    rows = []
    for tau in times:
        duration = tau - solution.tau
        rows.append(solution.advance(duration, rate * duration))
    return np.array(rows)
