"""Tests of a fit's residuals for signs of a wrong law: missing terms, trends, correlation.

Together they raise false alarms at the rate `ALARM_RATE`; each test has a share of this rate. The
largest share goes to the test for the next odd term, such as x**5 after K2*x + K4*x**3: a test for
this term alone is the most powerful one and detects a term of 3 standard deviations in 85 of 100
cases.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import linalg, stats

from longwave.scenes.fits.force_data import Points
from longwave.scenes.fits.least_squares import RANK_TOLERANCE, norms

ALARM_RATE = 0.05
"""Rate of false alarms: fraction of fits of a right law that are doubted."""

OVERLAP_FACTOR = 1.06
"""Ratio of the sum of all significance levels to `ALARM_RATE`; above 1, as some alarms coincide."""

ODD, EVEN, SMOOTH, SERIAL, SIZE = "odd", "even", "smooth", "serial", "size"

ALARM_SHARES = {ODD: 18.0, EVEN: 0.5, SMOOTH: 0.5, SERIAL: 2.0, SIZE: 1.5}
"""Relative shares of the false alarm rate by kind of test. `SIZE` is the test of chi^2, which needs
known deviations."""

HIGHEST_TERM = 8
"""Highest power of the stretch tested as a missing term."""

TREND_DEGREE = 5
"""Degree of the polynomial trend tested."""


def level(kind: str, known: bool) -> float:
    """Return a test's significance level by its ``kind`` and whether deviations are ``known``."""
    total = sum(share for name, share in ALARM_SHARES.items() if known or name != SIZE)
    return OVERLAP_FACTOR * ALARM_RATE * ALARM_SHARES[kind] / total


@dataclass(frozen=True)
class ResidualTest:
    """Result of a test: its ``kind``, the effect it ``seeks``, its p-value and its level."""

    kind: str
    seeks: str
    p_value: float
    level: float

    @property
    def is_alarm(self) -> bool:
        """Whether the test rejects the law at its significance level."""
        return self.p_value < self.level


@dataclass(frozen=True)
class ResidualTests:
    """Tests of weighted residuals at points of rising stretch.

    ``slopes`` are the derivatives of the residuals by the constants, ``weight`` is 1 over the
    deviations, ``rows`` is the row in which each point was measured.  If deviations are ``known``,
    residuals have standard deviation 1; otherwise it is estimated from them.
    """

    stretch: Points
    residuals: Points
    slopes: Points
    weight: Points
    rows: NDArray[np.intp]
    known: bool

    @cached_property
    def _basis(self) -> Points:
        """Orthonormal basis, as columns, of the changes of the residuals with the constants."""
        return np.asarray(linalg.qr(self.slopes / norms(self.slopes), mode="economic")[0])

    @cached_property
    def all(self) -> tuple[ResidualTest, ...]:
        """Results of the tests for missing odd and even powers, smooth trends and correlation."""
        results = [
            (kind, f"x**{power}", self._p_value(self._left_over(self._scaled**power)), 1)
            for kind, power in ((ODD, self._next_power(1)), (EVEN, self._next_power(2)))
            if power
        ]
        low, high = self.stretch[0], self.stretch[-1]
        centred = (self.stretch - (low + high) / 2) / ((high - low) / 2)
        curves = np.polynomial.legendre.legvander(centred, TREND_DEGREE)
        results.append(
            (SMOOTH, f"degree {TREND_DEGREE}", self._p_value(self._left_over(curves)), 1)
        )
        orders = [("along the stretch", np.arange(self.rows.size))]
        steps = np.diff(self.rows)
        if not ((steps > 0).all() or (steps < 0).all()):
            orders.append(("in the order of measurement", np.argsort(self.rows)))
        results += [(SERIAL, name, self._serial(order), len(orders)) for name, order in orders]
        return tuple(
            ResidualTest(kind, seeks, p_value, level(kind, self.known) / parts)
            for kind, seeks, p_value, parts in results
        )

    @property
    def _scaled(self) -> Points:
        """Stretch divided by its largest magnitude."""
        return self.stretch / np.max(np.abs(self.stretch))

    def _left_over(self, curves: NDArray[Any]) -> Points:
        """Return an orthonormal basis of the weighted curves with `_basis` projected out."""
        weighted = np.reshape(curves.T, (-1, self.weight.size)).T * self.weight[:, np.newaxis]
        weighted = weighted / norms(weighted)
        for _ in range(2):  # twice is enough (Kahan and Parlett)
            weighted = weighted - self._basis @ (self._basis.T @ weighted)
        basis, sizes, _ = linalg.svd(weighted, full_matrices=False)
        return np.asarray(basis[:, sizes > RANK_TOLERANCE])

    def _next_power(self, least: int) -> int:
        """Return the lowest power, from ``least`` in steps of 2, that the law lacks; 0 if none."""
        powers = range(least, HIGHEST_TERM + 1, 2)
        return next((p for p in powers if self._left_over(self._scaled**p).size), 0)

    def _p_value(self, curves: Points) -> float:
        """Return the p-value (chi^2 or F test) of the part of the residuals along the curves."""
        count = curves.shape[1]
        explained = float(np.sum((curves.T @ self.residuals) ** 2))
        if self.known:
            return float(stats.chi2.sf(explained, count)) if count else math.nan
        degrees = self.residuals.size - self._basis.shape[1] - count
        unexplained = float(self.residuals @ self.residuals) - explained
        if degrees < 1 or not count:
            return math.nan
        if unexplained <= 0.0:
            return 0.0
        return float(stats.f.sf(explained / count * degrees / unexplained, count, degrees))

    def _serial(self, order: NDArray[Any]) -> float:
        """Return the p-value of the correlation between residuals that are neighbours in ``order``.

        Mean and variance of the correlation are exact for normal noise and the fitted law; its
        distribution is approximated by a beta distribution (Durbin and Watson 1951).
        """
        residuals, basis = self.residuals[order], self._basis[order]
        points, constants = basis.shape
        degrees = points - constants
        total = float(residuals @ residuals)
        if not total:
            return math.nan
        averaged = np.zeros_like(basis)
        averaged[:-1] += basis[1:] / 2
        averaged[1:] += basis[:-1] / 2
        inner = basis.T @ averaged
        trace = -float(np.trace(inner))
        square = (points - 1) / 2 - 2 * float(np.sum(averaged**2)) + float(np.sum(inner**2))
        mean = trace / degrees
        variance = 2 * (degrees * square - trace**2) / (degrees**2 * (degrees + 2))
        reach = math.cos(math.pi / (points + 1))
        middle = (mean + reach) / (2 * reach)
        concentration = (
            middle * (1 - middle) / (variance / (4 * reach**2)) - 1 if variance > 0 else 0.0
        )
        if not concentration > 0:
            return math.nan
        scaled = (float(residuals[1:] @ residuals[:-1]) / total + reach) / (2 * reach)
        return float(stats.beta.sf(scaled, middle * concentration, (1 - middle) * concentration))
