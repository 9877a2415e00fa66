"""Tests of a fit's residuals for what a right law does not leave: terms, trends, correlation.

Each has its share of the rate of false alarms, `RATE`.  Most of it is the share of the next odd
term, such as x**5 after K2*x + K4*x**3: no test at that rate tells a term of 3 standard deviations
more often than the one that looks for this term alone, in 85 of 100 cases.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, stats

from longwave.scenes.fits.force_data import Points
from longwave.scenes.fits.least_squares import SAME, norms

RATE = 0.05
"""Share of fits of a right law that are doubted."""

OVERLAP = 1.06
"""Factor by which the sum of the shares may exceed `RATE`, for alarms that come together."""

ODD, EVEN, SMOOTH, SERIAL, SIZE = "odd", "even", "smooth", "serial", "size"

SHARES = {ODD: 18.0, EVEN: 0.5, SMOOTH: 0.5, SERIAL: 2.0, SIZE: 1.5}
"""Shares of the rate, up to a factor; that of chi^2 is there where deviations are known."""

HIGHEST_TERM = 8
"""Power of the stretch up to which a term is looked for."""

DEGREE = 5
"""Degree of the smooth curves."""


def level(kind: str, known: bool) -> float:
    """Return the probability below which a test of that kind doubts the law."""
    total = sum(share for name, share in SHARES.items() if known or name != SIZE)
    return OVERLAP * RATE * SHARES[kind] / total


@dataclass(frozen=True)
class ResidualTest:
    """A test of residuals: its ``kind``, what it ``seeks``, its p-value and its level."""

    kind: str
    seeks: str
    p_value: float
    level: float

    @property
    def is_alarm(self) -> bool:
        """Whether it doubts the law."""
        return self.p_value < self.level


@dataclass(frozen=True)
class ResidualTests:
    """The tests of residuals over their deviations at points of rising stretch.

    ``slopes`` are the derivatives of the residuals by the constants, ``weight`` is 1 over the
    deviations, ``rows`` says in which row each point was measured.  With ``known`` deviations the
    noise of a residual is 1, otherwise it follows from what is left.
    """

    stretch: Points
    residuals: Points
    slopes: Points
    weight: Points
    rows: NDArray[np.intp]
    known: bool

    @cached_property
    def _basis(self) -> Points:
        """Orthonormal columns of what the constants take up."""
        return np.asarray(linalg.qr(self.slopes / norms(self.slopes), mode="economic")[0])

    @cached_property
    def all(self) -> tuple[ResidualTest, ...]:
        """The tests that can be made."""
        found = [
            (kind, f"x**{power}", self._p_value(self._left_over(self._scaled**power)), 1)
            for kind, power in ((ODD, self._next_power(1)), (EVEN, self._next_power(2)))
            if power
        ]
        curves = np.polynomial.legendre.legvander(self._centred, DEGREE)
        found.append((SMOOTH, f"degree {DEGREE}", self._p_value(self._left_over(curves)), 1))
        orders = [("along the stretch", np.arange(self.rows.size))]
        if not self._is_monotone:
            orders.append(("in the order of measurement", np.argsort(self.rows)))
        found += [(SERIAL, name, self._serial(order), len(orders)) for name, order in orders]
        return tuple(
            ResidualTest(kind, seeks, p_value, level(kind, self.known) / parts)
            for kind, seeks, p_value, parts in found
        )

    @property
    def _scaled(self) -> Points:
        """The stretch over its largest size."""
        return self.stretch / np.max(np.abs(self.stretch))

    @property
    def _centred(self) -> Points:
        """The stretch from -1 to 1."""
        low, high = self.stretch[0], self.stretch[-1]
        return (self.stretch - (low + high) / 2) / ((high - low) / 2)

    @property
    def _is_monotone(self) -> bool:
        steps = np.diff(self.rows)
        return bool((steps > 0).all() or (steps < 0).all())

    def _left_over(self, curves: NDArray[Any]) -> Points:
        """Return orthonormal columns of curves, less what the constants take up."""
        weighted = np.reshape(curves.T, (-1, self.weight.size)).T * self.weight[:, np.newaxis]
        weighted = weighted / norms(weighted)
        for _ in range(2):  # twice is enough (Kahan and Parlett)
            weighted = weighted - self._basis @ (self._basis.T @ weighted)
        found, sizes, _ = linalg.svd(weighted, full_matrices=False)
        return np.asarray(found[:, sizes > SAME])

    def _next_power(self, least: int) -> int:
        """Return the lowest power from there, of its parity, that the law cannot follow, or 0."""
        powers = range(least, HIGHEST_TERM + 1, 2)
        return next((p for p in powers if self._left_over(self._scaled**p).size), 0)

    def _p_value(self, curves: Points) -> float:
        """Return how often curves fit the residuals as well if the law is right: chi^2 or F."""
        count = curves.shape[1]
        taken = float(np.sum((curves.T @ self.residuals) ** 2))
        if self.known:
            return float(stats.chi2.sf(taken, count)) if count else math.nan
        rest = self.residuals.size - self._basis.shape[1] - count
        left = float(self.residuals @ self.residuals) - taken
        if rest < 1 or not count:
            return math.nan
        if left <= 0.0:
            return 0.0
        return float(stats.f.sf(taken / count * rest / left, count, rest))

    def _serial(self, order: NDArray[Any]) -> float:
        """Return how often neighbours are as alike if the law is right.

        Mean and variance of the correlation with the next residual are exact for normal noise and
        the fitted law; its distribution is taken for a beta distribution (Durbin and Watson 1951).
        """
        left, basis = self.residuals[order], self._basis[order]
        points, constants = basis.shape
        degrees = points - constants
        total = float(left @ left)
        if not total:
            return math.nan
        moved = np.zeros_like(basis)
        moved[:-1] += basis[1:] / 2
        moved[1:] += basis[:-1] / 2
        inner = basis.T @ moved
        trace = -float(np.trace(inner))
        square = (points - 1) / 2 - 2 * float(np.sum(moved**2)) + float(np.sum(inner**2))
        mean = trace / degrees
        variance = 2 * (degrees * square - trace**2) / (degrees**2 * (degrees + 2))
        reach = math.cos(math.pi / (points + 1))
        middle = (mean + reach) / (2 * reach)
        size = middle * (1 - middle) / (variance / (4 * reach**2)) - 1 if variance > 0 else 0.0
        if not size > 0:
            return math.nan
        place = (float(left[1:] @ left[:-1]) / total + reach) / (2 * reach)
        return float(stats.beta.sf(place, middle * size, (1 - middle) * size))
