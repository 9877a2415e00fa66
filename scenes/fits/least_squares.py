"""Fits of least squares: deviations, correlations, chi^2, and constants that are not told apart."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
from scipy import linalg, stats

from longwave.scenes.fits.force_data import Points
from longwave.support.html_tables import html_table

DOUBTFUL = 0.01
"""Probability below which residuals are no accident."""

SAME = 1e-8
"""Share of the largest singular value of the scaled Jacobian below which constants are not told
apart."""

LEAST_P_VALUE = 1e-300
"""Probability below which doubles tell none."""

SPARE = 3
"""Points more than constants: from 3 degrees of freedom Student's distribution has a variance."""


class LeastSquares:
    """Constants at which the sum of squared residuals is least, and their covariance."""

    values: Points
    covariance: Points

    @property
    @abstractmethod
    def residuals(self) -> Points:
        """Measured less fitted, over the standard deviations; in one dimension."""

    @property
    @abstractmethod
    def has_deviations(self) -> bool:
        """Whether the standard deviations were measured, and not taken from the residuals."""

    @property
    @abstractmethod
    def names(self) -> Sequence[str]:
        """The names of the constants."""

    @property
    @abstractmethod
    def doubts(self) -> list[str]:
        """Reasons, in words, to think that it does not describe what was measured."""

    def _constants(self) -> list[tuple[str, str]]:
        found = zip(self.names, self.values, self.deviations, strict=True)
        return [(name, f"{value:.6g} \u00b1 {error:.2g}") for name, value, error in found]

    def __repr__(self) -> str:
        told = ", ".join(f"{name} = {value}" for name, value in self._constants())
        return f"<{type(self).__name__}: {told}>"

    def _repr_html_(self) -> str:
        doubts = [("doubt", doubt) for doubt in self.doubts]
        return html_table(type(self).__name__, [*self._constants(), *doubts])

    @property
    def deviations(self) -> Points:
        """The standard deviations of the values."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlations(self) -> Points:
        """The correlations of the values."""
        return self.covariance / np.outer(self.deviations, self.deviations)

    @property
    def degrees(self) -> int:
        """The degrees of freedom: points less constants."""
        return self.residuals.size - self.values.size

    @property
    def chi_squared(self) -> float:
        """The sum of squared residuals; the degrees of freedom where the noise is from them."""
        return float(self.residuals @ self.residuals)

    @property
    def p_value(self) -> float:
        """How often chi^2 is as large if the law is right; NaN where it says nothing."""
        if not self.has_deviations:
            return math.nan
        return float(stats.chi2.sf(self.chi_squared, self.degrees))

    def doubts_of_size(self, law: str, points: str, level: float = DOUBTFUL) -> list[str]:
        """Reasons, in words, to think that residuals are too large, or too small."""
        found, reduced = [], self.chi_squared / self.degrees
        if self.p_value < level:
            found.append(
                f"{law} misses the {points} by more than their deviations: chi^2 is "
                f"{reduced:.3g} a degree of freedom, {probability(self.p_value, 1)}"
            )
        if self.p_value > 1 - level / 10:
            found.append(
                f"the {points} scatter less than their deviations say: chi^2 is {reduced:.2g} a "
                "degree of freedom"
            )
        return found


def inverse_square(jacobian: Points, names: Sequence[object], told_by: str, remedy: str) -> Points:
    """The covariance of constants with these derivatives of residuals whose deviations are 1.

    Raises ValueError with the names of those that are not told apart; a ``remedy`` takes the first.
    """
    scales = norms(jacobian)
    _, singular, rows = linalg.svd(jacobian / scales, full_matrices=False)
    alike = [str(n) for n, part in zip(names, rows[-1], strict=True) if abs(part) > 0.1]
    if singular[-1] > SAME * singular[0]:
        with np.errstate(all="ignore"):
            inverse = rows.T / singular**2 @ rows / np.outer(scales, scales)
        beyond = ~np.isfinite(np.diag(inverse))
        if not beyond.any():
            return np.asarray((inverse + inverse.T) / 2)
        alike = [str(n) for n, lost in zip(names, beyond, strict=True) if lost]
    raise ValueError(
        f"constants must be told apart by the {told_by}, got {', '.join(alike)}, other values "
        f"of which fit as well ({remedy.format(alike[0])})"
    )


def of_residuals(inverse: Points, residuals: Points, least: float) -> tuple[Points, float]:
    """The covariance where one deviation for all points, ``least`` at the least, is taken from what
    is left, and that deviation: the variance is that of Student's distribution."""
    degrees = residuals.size - len(inverse)
    noise = max(math.sqrt(float(residuals @ residuals) / degrees), least)
    return inverse * (noise**2 * degrees / (degrees - 2)), noise


def probability(p_value: float, digits: int = 2) -> str:
    """Return a p-value as text, which is never 0.

    >>> probability(0.123), probability(4e-44, 1), probability(0.0)
    ('p = 0.12', 'p = 4e-44', 'p < 1e-300')
    """
    return f"p = {p_value:.{digits}g}" if p_value > LEAST_P_VALUE else f"p < {LEAST_P_VALUE:g}"


def norms(columns: Points) -> Points:
    """The lengths of columns; 1 for one of zeros."""
    found = linalg.norm(columns, axis=0)
    return np.where(found > 0, found, 1.0)
