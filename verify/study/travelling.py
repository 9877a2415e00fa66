"""Periodic travelling waves of the lattice itself, not of its long-wave limit.

y_n(t) = f(n - v t) with f of period P sites solves  v^2 f''(x) = D V'(f)(x),  in Fourier modes
q = 2 pi j / P

    v^2 q^2 f_q = 4 sin^2(q/2) V'(f)_q.

The mean and the first mode are those of the wave of the reduced equation; v and the other modes
follow by Newton's method. Even waves only.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import root

from derive import mkdv_normal_form
from solutions import Wave, closed_form
from verify.lattice.constants import Constants

Array = NDArray[np.float64]

MODES = 32
"""Highest Fourier mode of the profile."""

OVERSAMPLING = 8
"""Samples for each mode in the products; V' is cubic and V'' quadratic, so nothing is aliased."""


@dataclass(frozen=True)
class TravellingWave:
    """An even profile with cosine modes ``modes`` (0 .. MODES), speed and period in sites."""

    constants: Constants
    modes: Array
    speed: float
    period: int
    eps: float

    @cached_property
    def _wavenumbers(self) -> Array:
        return 2.0 * np.pi * np.arange(self.modes.size) / self.period

    def strain(self, x: Array) -> Array:
        """f(x)."""
        weights = np.where(np.arange(self.modes.size) == 0, 1.0, 2.0) * self.modes
        found: Array = np.cos(np.multiply.outer(x, self._wavenumbers)) @ weights
        return found

    def velocity(self, x: Array) -> Array:
        """dy_n/dt = -v f'(x)."""
        weights = 2.0 * self.modes * self._wavenumbers
        found: Array = self.speed * np.sin(np.multiply.outer(x, self._wavenumbers)) @ weights
        return found


def travelling_wave(form: str, k: float, period: int, K2: float, K4: float) -> TravellingWave:
    """The lattice's own wave next to the bare wave ``form`` with a period of ``period`` sites.

    eps follows from the period. Raises ValueError if Newton's method does not converge, or if the
    profile needs more modes.

    >>> wave = travelling_wave("wave_dn", 0.5, 27, 1, 1)
    >>> round(wave.eps, 6), round(wave.speed, 8)
    (0.050978, 1.00112504)
    """
    constants = Constants(K2, 0.0, K4)
    wave = Wave(closed_form(form), mkdv_normal_form(K2, K4), k=k)
    eps = float(wave.wavelength or math.nan) / period
    guess = _cosine_modes(wave, eps, period)
    unknown = np.concatenate([[constants.sound_speed() ** 2], guess[2:]])
    solved = root(_residual, unknown, (guess[:2], constants, period), tol=1e-15)
    modes = np.concatenate([guess[:2], solved.x[1:]])
    miss = float(np.max(np.abs(_residual(solved.x, guess[:2], constants, period))))
    tail = float(np.max(np.abs(modes[-3:])))
    if not max(miss, tail) < 1e-12:
        raise ValueError(
            f"period must give a smooth profile, got {period} with residual {miss:.1e} "
            f"and last modes {tail:.1e} (take a longer one)"
        )
    return TravellingWave(constants, modes, math.sqrt(float(solved.x[0])), period, eps)


def _cosine_modes(wave: Wave, eps: float, period: int) -> Array:
    """Modes of the bare wave, centred on its crest."""
    count = OVERSAMPLING * MODES
    samples = period * np.arange(count) / count
    crest = samples[np.argmax(wave.at(samples, 0.0, eps).Y)]
    modes: Array = np.fft.rfft(eps * wave.at(samples + crest, 0.0, eps).Y).real / count
    return modes[: MODES + 1]


def profile(modes: Array) -> Array:
    """The profile at OVERSAMPLING * MODES equidistant points of its period."""
    count = OVERSAMPLING * MODES
    samples: Array = np.fft.irfft(np.pad(modes, (0, count // 2 + 1 - modes.size)), count) * count
    return samples


def _residual(unknown: Array, known: Array, constants: Constants, period: int) -> Array:
    """v^2 f_q - (sin(q/2)/(q/2))^2 V'(f)_q for the modes 1 .. MODES."""
    modes = np.concatenate([known, unknown[1:]])
    q = 2.0 * np.pi * np.arange(1, MODES + 1) / period
    y = profile(modes)
    force = np.fft.rfft(y * (constants.K2 + constants.K4 * y * y)).real[1 : MODES + 1] / y.size
    missed: Array = unknown[0] * modes[1:] - (np.sin(0.5 * q) / (0.5 * q)) ** 2 * force
    return missed
