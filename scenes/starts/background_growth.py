"""Predictability of a run on a periodic background, from its stability by Hill's method.

A perturbation e^{lambda tau} W(xi - V tau) of the wave U0(xi - V tau) obeys, in the normal form,

    lambda W = V W' - W''' - 6 s (U0^2 W)',    W(x) = e^{i kappa x} sum_j W_j e^{2 pi i j x / P}.

Truncated in j this is a matrix eigenvalue problem, without any time step (Deconinck and Kutz,
J. Comput. Phys. 219 (2006) 296).
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from longwave.scenes.description.scene import Scene
from longwave.scenes.starts.moving_wave import moving_wave
from longwave.solutions import NumericWave

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

BLOCH_POINTS = 25
"""Number of Bloch wavenumbers on the first grid. The wavenumber of fastest growth is then refined
to 1e-3 of the zone's edge."""

RATE_DIGITS = 8
"""Significant digits kept of a rate. LAPACK's results vary from the twelfth digit on with the
number of threads (measured)."""

LEAST_MODES = 12
"""Minimum number of Fourier modes used on either side of 0."""

MOST_MODES = 96
"""Maximum number of Fourier modes used on either side of 0."""

NEGLECTED_MODE = 1e-7
"""Modes of the wave smaller than this fraction of the largest are neglected."""


def fastest_rate(U: Array, wavelength: float, speed: float, s: int) -> float:
    """Return the largest growth rate per tau over all perturbations, to `RATE_DIGITS` digits.

    ``U`` are samples of the wave over one wavelength, several for each significant mode; ``s`` is
    the sign in the normal form. NaN if more than `MOST_MODES` modes are needed, as for a train of
    very distant crests.
    """
    modes = resolving_modes(U)
    if modes > MOST_MODES:
        return float("nan")
    edge = np.pi / wavelength

    def rate(kappa: float) -> float:
        return mkdv_rate(U, wavelength, speed, s, kappa, modes)

    spacing = edge / BLOCH_POINTS
    rates = {kappa: rate(kappa) for kappa in spacing * np.arange(1, BLOCH_POINTS + 1)}
    while spacing > 1e-3 * edge:
        best, spacing = max(rates, key=rates.__getitem__), 0.5 * spacing
        neighbours = (best - spacing, best + spacing)
        rates |= {kappa: rate(kappa) for kappa in neighbours if kappa <= edge}
    return float(f"{max(rates.values()):.{RATE_DIGITS}g}")


def resolving_modes(U: Array) -> int:
    """Return the number of Fourier modes needed for perturbations of a wave with samples ``U``."""
    sizes = np.abs(np.fft.rfft(U))
    last = int(np.flatnonzero(sizes > NEGLECTED_MODE * np.max(sizes))[-1])
    return max(last, LEAST_MODES)


def mkdv_rate(U: Array, wavelength: float, speed: float, s: int, kappa: float, modes: int) -> float:
    """Return the largest growth rate per tau at Bloch wavenumber ``kappa``; see `fastest_rate`.

    Uses 2 ``modes`` + 1 Fourier modes.
    """
    j = np.arange(-modes, modes + 1)
    q = kappa + 2.0 * np.pi * j / wavelength
    potential = 6.0 * s * multiplication(U * U, j)
    matrix = np.diag(1j * (speed * q + q**3)) - 1j * q[:, None] * potential
    return float(np.max(np.linalg.eigvals(matrix).real))


def multiplication(samples: Array, j: NDArray[np.int64]) -> Complex:
    """Return the matrix, on the Fourier modes ``j``, of multiplication by a sampled function."""
    modes = np.fft.fft(samples) / samples.size
    matrix: Complex = modes[np.subtract.outer(j, j) % samples.size]
    return matrix


UNIT_ROUNDOFF = 2.0**-53
"""Relative magnitude of the perturbation caused by rounding."""

USUAL_TOLERANCE = 1e-4
"""Rounding error of y/eps up to which a run without a tolerance can be trusted."""

STABLE_RATE = 1e-6
"""Growth rate per tau, such as rounding causes, up to which a background counts as stable."""

WAVE_SAMPLES = 8 * MOST_MODES
"""Number of points per wavelength at which a periodic background is sampled."""


@dataclass(frozen=True)
class Trust:
    """Growth rate per lattice time of the fastest perturbation, and the predictability time."""

    rate: float
    predictability_time: float


@lru_cache(maxsize=64)
def trust_in(scene: Scene, tolerance: float) -> Trust:
    """Return the growth rate of perturbations and the time until rounding reaches ``tolerance``.

    ``tolerance`` is that of y/eps. The rate follows from the reduced equation, with a relative
    error of order eps^2, and is the maximum over all perturbations of the infinite lattice. On a
    constant or stable background the rate is 0 and the time infinite. Both are NaN if the
    background is too sharp for `fastest_rate`.
    """
    wave = moving_wave(scene).wave
    if wave.wavelength is None:
        return Trust(0.0, math.inf)
    per_tau = _fastest_rate(wave)
    rate = 0.0 if per_tau <= STABLE_RATE else per_tau * wave.numbers.b * scene.eps**3
    return Trust(rate, predictability_time(rate, tolerance, UNIT_ROUNDOFF))


def trust_attributes(scene: Scene) -> dict[str, float]:
    """Return the run attributes ``trust_rate`` and ``trust_horizon``; {} on a constant background.

    The horizon is the time after t0 until rounding errors reach the scene's tolerance.
    """
    if moving_wave(scene).wave.wavelength is None:
        return {}
    trust = trust_in(scene, scene.tolerance or USUAL_TOLERANCE)
    return {"trust_rate": trust.rate, "trust_horizon": trust.predictability_time}


def check_trust(scene: Scene) -> None:
    """Raise ValueError for a tolerance that rounding errors exceed before the scene's end."""
    if scene.tolerance is None:
        return
    trust = trust_in(scene, scene.tolerance)
    if scene.t0 + trust.predictability_time < scene.end:
        raise ValueError(
            f"snapshots must satisfy t <= {scene.t0 + trust.predictability_time:.4g} with "
            f"tolerance {scene.tolerance:g}, got {scene.end:g} (the background is unstable: its "
            f"fastest perturbation grows like exp({trust.rate:.3g} t), so rounding errors reach "
            "the tolerance by then; end earlier, or state a step to run without a tolerance)"
        )


def predictability_time(rate: float, tolerance: float, rounding: float) -> float:
    """Return the time in which a perturbation grows from ``rounding`` to ``tolerance`` at ``rate``.

    A run on an unstable background can be trusted for this time only, however small its step.

    >>> round(predictability_time(0.001, 1e-4, 1e-16))
    27631
    """
    return math.inf if rate == 0.0 else max(0.0, math.log(tolerance / rounding)) / rate


def _fastest_rate(wave: NumericWave) -> float:
    """Return the largest growth rate per tau of a wave's periodic background.

    The background's speed is -Y_T / Y_X where the background is steepest.
    """
    period = float(wave.wavelength or 0.0)
    a, b, s = wave.numbers.a, wave.numbers.b, wave.numbers.s
    bare = wave.far_field(period * np.arange(WAVE_SAMPLES) / WAVE_SAMPLES, 0.0, "left")
    steepest = int(np.argmax(np.abs(bare.Y_X)))
    speed = -(bare.Y_T[steepest] / b) / (bare.Y_X[steepest] / a)
    return fastest_rate(bare.Y, a * period, float(speed), s)
