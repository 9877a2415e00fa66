"""How long a run about a periodic background can be trusted."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from solutions import Wave
from verify.lattice.initial import build_wave
from verify.lattice.scene import Scene
from verify.study.floquet import horizon, mkdv_rate
from verify.study.travelling import MODES, OVERSAMPLING

ROUNDING = 2.0**-53
"""Relative size of the perturbation that rounding seeds."""

FLOOR = 1e-6
"""Growth rates per tau below this are the rounding of a multiple eigenvalue, not growth."""

BLOCH_POINTS = 25


@dataclass(frozen=True)
class Trust:
    """Growth rate (per lattice time) of the fastest perturbation, and the time it leaves."""

    rate: float
    horizon: float


def trust_in(scene: Scene, tolerance: float) -> Trust:
    """How long rounding stays below ``tolerance`` (of y/eps) on the scene's background.

    The rate is that of the reduced equation, of relative accuracy eps^2, the largest over all
    perturbations of the infinite lattice. It is 0, and the horizon infinite, on a constant
    background and on stable periodic ones.
    """
    wave = build_wave(scene)
    if wave.wavelength is None:
        return Trust(0.0, float("inf"))
    b = float(wave.normal_form.b)
    per_tau = _largest_rate(wave)
    rate = per_tau * b * scene.eps**3 if per_tau > FLOOR else 0.0
    return Trust(rate, horizon(rate, tolerance, ROUNDING))


def _largest_rate(wave: Wave) -> float:
    """Largest growth rate per tau over all Bloch wavenumbers."""
    period = float(wave.wavelength or 0.0)
    a, b, s = (float(getattr(wave.normal_form, name)) for name in ("a", "b", "s"))
    X = period * np.arange(OVERSAMPLING * MODES) / (OVERSAMPLING * MODES)
    background = wave.background(X, 0.0)
    steepest = int(np.argmax(np.abs(background.Y_X)))
    speed = -(background.Y_T[steepest] / b) / (background.Y_X[steepest] / a)

    def negative(kappa: float) -> float:
        return -mkdv_rate(background.Y, a * period, float(speed), int(s), kappa)

    edge = np.pi / (a * period)
    points = edge * np.arange(1, BLOCH_POINTS + 1) / BLOCH_POINTS
    best = points[int(np.argmin([negative(float(kappa)) for kappa in points]))]
    around = (max(best - points[0], 0.5 * points[0]), min(best + points[0], edge))
    refined = minimize_scalar(negative, bounds=around, method="bounded")
    return -float(min(refined.fun, negative(float(best))))
