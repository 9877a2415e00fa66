"""Perturbed plane wave of an envelope equation, and the ring of a lattice on which it fits.

The equation is ``i A_T + p A_XX + q |A|^2 A = 0``, its plane wave ``a exp(i q a^2 T)``. The
perturbation ``b exp(i kappa X + lambda T) + conj(c) exp(-i kappa X + conj(lambda) T)`` of it has
``lambda^2 = p kappa^2 (2 q a^2 - p kappa^2)``. It grows if lambda^2 is positive (Benjamin and Feir,
J. Fluid Mech. 27 (1967) 417) and moves otherwise. On a lattice b and c are the carrier's sidebands.
"""

import cmath
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from sympy import Expr, Rational, pi

from longwave.support.real_arrays import Array

PERTURBATION_SIZE = 1e-5
"""Initial amplitude of the perturbation, in units of the plane wave's. At the end of the
measurement it is 1e-3, which adds an error of 1e-6 to the rate."""


def squared_rate(p: Any, q: Any, a: Any, kappa: Any) -> Any:
    """Return ``lambda^2 = p kappa^2 (2 q a^2 - p kappa^2)``, for numbers or arrays."""
    linear = p * kappa**2
    return linear * (2 * q * a**2 - linear)


def chosen_kappa(p: Any, q: Any, given: Mapping[str, float]) -> Any:
    """Return ``kappa`` or, if not given, ``share`` times the fastest growing wavenumber.

    The fastest growing wavenumber is ``amplitude sqrt(|q/p|)``; ``share`` is 1 by default. p and q
    are numbers or arrays; ``given`` holds the parameters of the wave.
    """
    with np.errstate(all="ignore"):
        fastest = np.sqrt(np.abs(np.divide(q, p)))
    return given.get("kappa", given.get("share", 1.0) * given["amplitude"] * fastest)


@dataclass(frozen=True)
class PerturbedPlane:
    """Plane wave of amplitude ``a`` with a perturbation of wavenumber ``kappa``."""

    a: float
    p: float
    q: float
    kappa: float

    @property
    def rate(self) -> complex:
        """Rate lambda of the perturbation in T: real if it grows, imaginary if it oscillates."""
        squared = squared_rate(self.p, self.q, self.a, self.kappa)
        if squared >= 0:
            return complex(np.sqrt(squared))
        linear, steep = self._terms
        # the sign for which |b| > |c|
        return -1j * np.sqrt(-squared) if linear > steep else 1j * np.sqrt(-squared)

    @property
    def growth(self) -> float:
        """Growth rate in T; 0 if the wave is stable."""
        return self.rate.real

    @property
    def largest_growth(self) -> float:
        """Growth rate ``|q| a^2`` of the fastest growing perturbation, if any grows."""
        return abs(self.q) * self.a**2

    @property
    def _terms(self) -> tuple[float, float]:
        return self.p * self.kappa**2, self.q * self.a**2

    def jets(self, X: Array, T: float, highest: int) -> Any:
        """Return A and its X-derivatives, complex, (highest + 1, *points)."""
        linear, steep = self._terms
        c = -1j * steep / (self.rate + 1j * (steep - linear))
        size = PERTURBATION_SIZE / abs(complex(1.0, abs(c)))
        upper = size * cmath.exp(self.rate * T) * np.exp(1j * self.kappa * np.asarray(X))
        lower = np.conj(c * upper)
        powers = (1j * self.kappa) ** np.arange(highest + 1)
        jets = np.multiply.outer(powers, upper) + np.multiply.outer(np.conj(powers), lower)
        jets[0] += 1
        return self.a * cmath.exp(1j * steep * T) * jets


@dataclass(frozen=True)
class PlaneDomain:
    """Ring of ``cells`` with ``turns`` wavelengths of a carrier and ``waves`` of a perturbation."""

    cells: int
    turns: int
    waves: int

    @property
    def k(self) -> Expr:
        """Wavenumber of the carrier, in radians per cell, as an exact multiple of pi."""
        return 2 * pi * Rational(self.turns, self.cells)

    @property
    def perturbation(self) -> float:
        """Wavenumber of the perturbation, in radians per cell."""
        return 2 * np.pi * self.waves / self.cells


NEAR_K, NEAR_KAPPA = 1e-3, 1e-2
"""Largest changes accepted to fit both waves on a ring: that of the carrier's wavenumber (absolute)
and that of the perturbation's wavenumber (relative)."""

CLOSED_MISMATCH = 1e-9
"""Largest mismatch, in wavelengths, of a carrier that closes on its ring."""

MAX_WAVES = 100
"""Maximum number of perturbation wavelengths on a ring."""

LARGEST_DENOMINATOR = 200
"""Largest denominator of k/pi at which a rational k/pi is kept exactly on the ring."""


def plane_domain(k: Expr, perturbation: float) -> PlaneDomain:
    """Return the smallest ring on which both waves fit; ``perturbation`` in radians per cell.

    A k that is a simple rational multiple of pi is kept exactly, any other k to within `NEAR_K`;
    the perturbation's wavenumber is kept to within the fraction `NEAR_KAPPA`. Raises ValueError if
    the lower sideband has no wavenumber in 0 .. pi, or if no ring is small enough.

    >>> plane_domain(pi / 2, 0.1)
    PlaneDomain(cells=188, turns=47, waves=3)
    >>> ring = plane_domain(Rational(13, 10), 0.1)
    >>> ring, round(float(ring.k), 5)
    (PlaneDomain(cells=314, turns=65, waves=5), 1.30066)
    """
    angle, ratio = float(k), k / pi
    if not perturbation < angle:
        raise ValueError(
            f"kappa must leave a wave below the carrier, eps kappa < k, got {perturbation:.4g} "
            f"and k = {angle:.4g} (take a smaller kappa, eps or amplitude)"
        )
    is_exact = bool(ratio.is_Rational and ratio.q <= LARGEST_DENOMINATOR)
    for waves in range(1, MAX_WAVES + 1):
        middle = 2 * np.pi * waves / perturbation
        reach = int(min(NEAR_KAPPA * middle, 2 * LARGEST_DENOMINATOR)) + 1
        cells = round(middle) + np.arange(-reach, reach + 1)
        cells = cells[(cells > 2 * waves) & (np.abs(middle / cells - 1) <= NEAR_KAPPA)]
        turns = np.rint(angle * cells / (2 * np.pi))
        mismatch = np.abs(angle * cells / (2 * np.pi) - turns)
        fits = mismatch <= CLOSED_MISMATCH if is_exact else 2 * np.pi * mismatch <= NEAR_K * cells
        fits &= (turns > waves) & (2 * turns <= cells)
        if np.any(fits):
            nearest = np.argmin(np.where(fits, np.abs(cells - middle), np.inf))
            return PlaneDomain(int(cells[nearest]), int(turns[nearest]), waves)
    raise ValueError(
        f"k must fit on a ring with the perturbation, got {k} and {perturbation:.4g} radians per "
        "cell (take a number or a fraction of pi with a small denominator)"
    )
