"""A perturbed plane wave of an envelope equation, and a ring of a lattice on which it fits.

On the plane wave ``a exp(i q a^2 T)`` of ``i A_T + p A_XX + q |A|^2 A = 0`` the perturbation
``b exp(i kappa X + lambda T) + conj(c) exp(-i kappa X + conj(lambda) T)`` is one of the equation
where ``lambda^2 = p kappa^2 (2 q a^2 - p kappa^2)``: it grows where that is positive (Benjamin and
Feir, J. Fluid Mech. 27 (1967) 417), and else moves. On a lattice b and c are two waves beside the
carrier.
"""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Rational, pi

Array = NDArray[np.float64]

SIZE = 1e-5
"""Of the perturbation at first: 1e-3 when its growth has been measured, which adds 1e-6 to the
rate; rounding is as much smaller."""


def squared_rate(p: Any, q: Any, a: Any, kappa: Any) -> Any:
    """lambda^2 of a perturbation: ``p kappa^2 (2 q a^2 - p kappa^2)``; numbers or arrays."""
    linear = p * kappa**2
    return linear * (2 * q * a**2 - linear)


def chosen_kappa(p: Any, q: Any, given: Mapping[str, float]) -> Any:
    """The ``kappa`` that is ``given``, or its ``share``, 1 unless told, of the fastest growing one.

    That is ``amplitude sqrt(|q/p|)``; numbers or arrays.
    """
    with np.errstate(all="ignore"):
        fastest = np.sqrt(np.abs(np.divide(q, p)))
    return given.get("kappa", given.get("share", 1.0) * given["amplitude"] * fastest)


@dataclass(frozen=True)
class PerturbedPlane:
    """The plane wave of amplitude ``a`` with the one perturbation that grows, or moves."""

    a: float
    p: float
    q: float
    kappa: float

    @property
    def rate(self) -> complex:
        """lambda: the growth rate in T, or an imaginary number where the wave is stable."""
        squared = squared_rate(self.p, self.q, self.a, self.kappa)
        return complex(np.sqrt(squared)) if squared >= 0 else self._turning(np.sqrt(-squared))

    def _turning(self, frequency: float) -> complex:
        """Of the two rates that with which b is the larger wave."""
        linear, steep = self._terms
        return -1j * frequency if linear > steep else 1j * frequency

    @property
    def growth(self) -> float:
        """The growth rate in T, 0 where the wave is stable."""
        return self.rate.real

    @property
    def largest_growth(self) -> float:
        """That of the perturbation that grows fastest, if any does: ``|q| a^2``."""
        return abs(self.q) * self.a**2

    @property
    def _terms(self) -> tuple[float, float]:
        return self.p * self.kappa**2, self.q * self.a**2

    def jets(self, X: Array, T: float, highest: int) -> Any:
        """A and its X-derivatives, complex, (highest + 1, *points)."""
        linear, steep = self._terms
        c = -1j * steep / (self.rate + 1j * (steep - linear))
        size = SIZE / abs(complex(1.0, abs(c)))
        ahead = size * cmath.exp(self.rate * T) * np.exp(1j * self.kappa * np.asarray(X))
        behind = np.conj(c * ahead)
        powers = (1j * self.kappa) ** np.arange(highest + 1)
        found = np.multiply.outer(powers, ahead) + np.multiply.outer(np.conj(powers), behind)
        found[0] += 1
        return self.a * cmath.exp(1j * steep * T) * found


@dataclass(frozen=True)
class PlaneDomain:
    """A ring of ``cells`` round which the carrier comes ``turns`` times and the perturbation
    ``waves`` times.
    """

    cells: int
    turns: int
    waves: int

    @property
    def k(self) -> Expr:
        """The carrier's wavenumber."""
        return 2 * pi * Rational(self.turns, self.cells)

    @property
    def perturbation(self) -> float:
        """That of the perturbation, in radians a cell."""
        return 2 * np.pi * self.waves / self.cells


NEAR_K, NEAR_KAPPA = 1e-3, 1e-2
"""How far the ring's wavenumber may be from that asked for, and, as a share of it, kappa."""

CLOSED = 1e-9
"""A carrier that misses less than that of a turn comes round."""

MOST_WAVES = 100
"""Of the perturbation round a ring."""

LARGEST_PART = 200
"""A k that is a part of pi with no larger denominator is taken exactly."""


def plane_domain(k: Expr, perturbation: float) -> PlaneDomain:
    """The smallest ring that holds both waves, ``perturbation`` in radians a cell.

    A part of pi is held exactly, any other k within `NEAR_K`, and the perturbation within its
    `NEAR_KAPPA`. Raises ValueError where the lower sideband would have no wavenumber in 0 .. pi,
    and where no ring is small enough.

    >>> plane_domain(pi / 2, 0.1)
    PlaneDomain(cells=188, turns=47, waves=3)
    >>> ring = plane_domain(Rational(13, 10), 0.1)
    >>> ring, round(float(ring.k), 5)
    (PlaneDomain(cells=314, turns=65, waves=5), 1.30066)
    """
    angle, part = float(k), k / pi
    if not perturbation < angle:
        raise ValueError(
            f"kappa must leave a wave below the carrier, eps kappa < k, got {perturbation:.4g} "
            f"and k = {angle:.4g} (take a smaller kappa, eps or amplitude)"
        )
    is_part = bool(part.is_Rational and part.q <= LARGEST_PART)
    for waves in range(1, MOST_WAVES + 1):
        middle = 2 * np.pi * waves / perturbation
        reach = int(min(NEAR_KAPPA * middle, 2 * LARGEST_PART)) + 1
        cells = round(middle) + np.arange(-reach, reach + 1)
        cells = cells[(cells > 2 * waves) & (np.abs(middle / cells - 1) <= NEAR_KAPPA)]
        turns = np.rint(angle * cells / (2 * np.pi))
        off = np.abs(angle * cells / (2 * np.pi) - turns)
        good = off <= CLOSED if is_part else 2 * np.pi * off <= NEAR_K * cells
        good &= (turns > waves) & (2 * turns <= cells)
        if np.any(good):
            nearest = np.argmin(np.where(good, np.abs(cells - middle), np.inf))
            return PlaneDomain(int(cells[nearest]), int(turns[nearest]), waves)
    raise ValueError(
        f"k must fit on a ring with the perturbation, got {k} and {perturbation:.4g} radians a "
        "cell (take a number or a part of pi with a small denominator)"
    )
