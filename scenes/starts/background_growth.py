"""How long a run about a periodic background can be trusted: the stability of that, by Hill.

A perturbation e^{lambda tau} W(xi - V tau) of the wave U0(xi - V tau) obeys, in the normal form,

    lambda W = V W' - W''' - 6 s (U0^2 W)',    W(x) = e^{i kappa x} sum_j W_j e^{2 pi i j x / P}.

Truncated in j it is a matrix; no time step enters (Deconinck, Kutz, J. Comput. Phys. 219 (2006)
296).
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
"""Wavenumbers that are tried before the best is refined to a thousandth of the zone's edge."""

DIGITS = 8
"""Of a rate: with other numbers of threads LAPACK gives others from the twelfth on (measured)."""

LEAST_MODES = 12
MOST_MODES = 96

TAIL = 1e-7
"""Modes of the wave below this share of its largest are left out."""


def fastest_rate(U: Array, wavelength: float, speed: float, s: int) -> float:
    """Largest growth rate (per tau) over all perturbations of the infinite line, to ``DIGITS``.

    ``U`` are the wave's samples over one wavelength, several for each mode that counts. NaN if
    those are too many: a train of crests that are very far apart.
    """
    modes = resolving_modes(U)
    if modes > MOST_MODES:
        return float("nan")
    edge = np.pi / wavelength

    def rate(kappa: float) -> float:
        return mkdv_rate(U, wavelength, speed, s, kappa, modes)

    apart = edge / BLOCH_POINTS
    found = {kappa: rate(kappa) for kappa in apart * np.arange(1, BLOCH_POINTS + 1)}
    while apart > 1e-3 * edge:
        best, apart = max(found, key=found.__getitem__), 0.5 * apart
        found |= {kappa: rate(kappa) for kappa in (best - apart, best + apart) if kappa <= edge}
    return float(f"{max(found.values()):.{DIGITS}g}")


def resolving_modes(U: Array) -> int:
    """How many Fourier modes the perturbations of a wave with samples ``U`` need."""
    sizes = np.abs(np.fft.rfft(U))
    last = int(np.flatnonzero(sizes > TAIL * np.max(sizes))[-1])
    return max(last, LEAST_MODES)


def mkdv_rate(U: Array, wavelength: float, speed: float, s: int, kappa: float, modes: int) -> float:
    """Largest growth rate (per tau) at the Bloch wavenumber kappa, with 2 modes + 1 modes."""
    j = np.arange(-modes, modes + 1)
    q = kappa + 2.0 * np.pi * j / wavelength
    potential = 6.0 * s * multiplication(U * U, j)
    matrix = np.diag(1j * (speed * q + q**3)) - 1j * q[:, None] * potential
    return float(np.max(np.linalg.eigvals(matrix).real))


def multiplication(samples: Array, j: NDArray[np.int64]) -> Complex:
    """The matrix, in the modes j, of multiplication by a periodic function with these samples."""
    modes = np.fft.fft(samples) / samples.size
    found: Complex = modes[np.subtract.outer(j, j) % samples.size]
    return found


UNIT_ROUNDOFF = 2.0**-53
"""Relative size of the perturbation that rounding seeds."""

USUAL_TOLERANCE = 1e-4
"""What rounding may reach, of y/eps, in a scene that states no tolerance."""

FLOOR = 1e-6
"""Growth rates per tau below this are the rounding of a multiple eigenvalue, not growth."""

SAMPLES = 8 * MOST_MODES


@dataclass(frozen=True)
class Trust:
    """Growth rate (per lattice time) of the fastest perturbation, and the time it leaves."""

    rate: float
    predictability_time: float


@lru_cache(maxsize=64)
def trust_in(scene: Scene, tolerance: float) -> Trust:
    """How long rounding stays below ``tolerance`` (of y/eps) on the scene's background.

    The rate is that of the reduced equation, of relative accuracy eps^2, the largest over all
    perturbations of the infinite lattice. It is 0, and the horizon infinite, on a constant
    background and on stable periodic ones; both are NaN where the background is too sharp for
    `fastest_rate`.
    """
    wave = moving_wave(scene).wave
    if wave.wavelength is None:
        return Trust(0.0, math.inf)
    per_tau = _fastest_rate(wave)
    rate = 0.0 if per_tau <= FLOOR else per_tau * wave.numbers.b * scene.eps**3
    return Trust(rate, predictability_time(rate, tolerance, UNIT_ROUNDOFF))


def trust_attributes(scene: Scene) -> dict[str, float]:
    """``trust_rate`` and ``trust_horizon`` for a run's attributes; {} on a constant background.

    The horizon is the time after t0 until rounding has grown to the scene's tolerance.
    """
    if moving_wave(scene).wave.wavelength is None:
        return {}
    trust = trust_in(scene, scene.tolerance or USUAL_TOLERANCE)
    return {"trust_rate": trust.rate, "trust_horizon": trust.predictability_time}


def check_trust(scene: Scene) -> None:
    """Refuse a tolerance that rounding alone exceeds before the scene's end; ValueError."""
    if scene.tolerance is None:
        return
    trust = trust_in(scene, scene.tolerance)
    if scene.t0 + trust.predictability_time < scene.end:
        raise ValueError(
            f"snapshots must satisfy t <= {scene.t0 + trust.predictability_time:.4g} with "
            f"tolerance {scene.tolerance:g}, got {scene.end:g} (the background is unstable: its "
            f"fastest perturbation grows like exp({trust.rate:.3g} t), and rounding has then grown "
            "to the tolerance; end earlier, or state a step to run on regardless)"
        )


def predictability_time(rate: float, tolerance: float, rounding: float) -> float:
    """Time until a perturbation as small as ``rounding`` has grown to ``tolerance`` at ``rate``.

    A run about an unstable wave is trustworthy up to then, however small its step.

    >>> round(predictability_time(0.001, 1e-4, 1e-16))
    27631
    """
    return math.inf if rate == 0.0 else max(0.0, math.log(tolerance / rounding)) / rate


def _fastest_rate(wave: NumericWave) -> float:
    """Largest growth rate per tau; the wave's speed is read off where it is steepest."""
    period = float(wave.wavelength or 0.0)
    a, b, s = wave.numbers.a, wave.numbers.b, wave.numbers.s
    bare = wave.far_field(period * np.arange(SAMPLES) / SAMPLES, 0.0, "left")
    steepest = int(np.argmax(np.abs(bare.Y_X)))
    speed = -(bare.Y_T[steepest] / b) / (bare.Y_X[steepest] / a)
    return fastest_rate(bare.Y, a * period, float(speed), s)
