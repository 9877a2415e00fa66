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

from longwave.lattice.refine import refine
from longwave.lattice.spectral.exponential import ORDER, ExponentialAdams
from longwave.lattice.trial import Choices, Progress, StepSearch, Trial, rounding_error

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

FIRST_STEP = 0.5
"""First step of `evolve`, in units of 1/max |U|^3."""


class PeriodicMkdv:
    """A solution of the mKdV equation with period ``period``, from samples ``U`` at tau = 0.

    The samples are at xi = j period / M, j = 0 .. M - 1; ``step`` is the step in tau. Of the modes
    those above half of the highest are dropped, which removes all aliasing of the cubic. Raises
    ValueError for s other than 1 and -1, a period or step that is not positive and samples that are
    not finite.
    """

    def __init__(self, U: Array, period: float, s: int, step: float) -> None:
        values = np.asarray(U, dtype=np.float64)
        if s not in (1, -1):
            raise ValueError(f"s must be 1 or -1, got {s} (the sign of K4)")
        if not (math.isfinite(period) and period > 0):
            raise ValueError(f"period must satisfy period > 0, got {period:g} (a wavelength in xi)")
        if not np.all(np.isfinite(values)):
            raise ValueError("U must be finite, got NaN or infinity (take other samples)")
        self.period = period
        self._count = values.size
        self._mean_square = float(np.mean(values**2))
        k = 2.0 * math.pi / period * np.arange(values.size // 2 + 1)
        linear = 1j * (k**3 - 6.0 * s * self._mean_square * k)[None, :]
        self._symbol = -2j * s * k
        self._symbol[k.size // 2 :] = 0.0
        modes = ducc0.fft.r2c(values, inorm=2)
        modes[k.size // 2 :] = 0.0
        self.integrator = ExponentialAdams(linear, self._nonlinearity, modes[None, :], step)
        self._modes: Complex = modes

    def at(self, tau: float) -> Array:
        """The samples at ``tau``, which must not lie before the last one."""
        for _ in range(self.integrator.whole_steps(tau)):
            self.integrator.step()
        self._modes = self.integrator.solution_at(tau)[0]
        return self._samples(self._modes)

    @property
    def invariants(self) -> tuple[float, float, float]:
        """Means over the period of U, U^2 and U^4 - s U_xi^2, at the last ``at``.

        They are the mass, momentum and energy.
        """
        modes = self._modes
        U = self._samples(modes)
        k = 2.0 * math.pi / self.period * np.arange(modes.size)
        slope = self._samples(1j * k * modes)
        s = 1.0 if self._symbol[1].imag < 0 else -1.0
        energy = float(np.mean(U**4 - s * slope**2))
        return float(np.mean(U)), float(np.mean(U**2)), energy

    def _samples(self, modes: Complex) -> Array:
        values: Array = ducc0.fft.c2r(modes, lastsize=self._count, forward=False)
        return values

    def _nonlinearity(self, p: Complex) -> Complex:
        U = self._samples(p[0])
        U *= U * U - 3.0 * self._mean_square
        force: Complex = ducc0.fft.r2c(U, inorm=2)
        force *= self._symbol
        return force


def evolve(U: Array, period: float, s: int, times: Sequence[float], tolerance: float) -> Array:
    """The solution at the increasing ``times`` >= 0, of shape (len(times), M), to ``tolerance``.

    The samples must resolve the solution, which `PeriodicMkdv` and a second sampling show. Raises
    ValueError if the tolerance is out of reach, FloatingPointError if the solution blows up.
    """
    scale = float(np.max(np.abs(U)))
    longest = max(times[-1], FIRST_STEP)
    first = min(longest, FIRST_STEP / scale**3) if scale > 0 else longest
    trial = refine(_Evolution(U, period, s, times, first), tolerance).trial
    if trial.values is None:
        raise FloatingPointError(
            f"blow-up: steps down to {trial.choices.step:.3g} do not change it"
        )
    return trial.values


class _Evolution(StepSearch):
    """Runs from the samples ``U`` through the times."""

    unstable = 10

    def __init__(
        self, U: Array, period: float, s: int, times: Sequence[float], first: float
    ) -> None:
        super().__init__(ORDER, first, np.array([0.0, times[-1]]))
        self._given, self._times = (U, period, s), times

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        """A run with that step."""
        solution = PeriodicMkdv(*self._given, choices.step)
        with np.errstate(over="ignore", invalid="ignore"):
            rows = np.array([solution.at(tau) for tau in self._times])
        values = rows if np.all(np.isfinite(rows)) else None
        rounding = rounding_error(float(np.max(np.abs(self._given[0]))), solution.integrator.steps)
        return Trial(choices, values, self.work(choices), 0.0, rounding, None)
