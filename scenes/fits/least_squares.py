"""Results of least-squares fits: deviations, correlations, chi^2 and unidentifiable constants."""

import math
from abc import abstractmethod
from collections.abc import Sequence

import numpy as np
from scipy import linalg, stats

from longwave.scenes.fits.force_data import Points
from longwave.support.html_tables import html_table

DOUBT_LEVEL = 0.01
"""Significance level: p-values below it cast doubt on a fit."""

RANK_TOLERANCE = 1e-8
"""Least ratio of the smallest to the largest singular value of the scaled Jacobian at which all
constants count as identifiable."""

LEAST_P_VALUE = 1e-300
"""Smallest probability that is reported as a number, not as an upper bound."""

MIN_DEGREES = 3
"""Fewest degrees of freedom for which the variance of Student's distribution is finite."""


class LeastSquares:
    """Result of a least-squares fit: ``values`` of the constants and their ``covariance``."""

    values: Points
    covariance: Points

    @property
    @abstractmethod
    def residuals(self) -> Points:
        """Measured minus fitted values, over the standard deviations, as a flat array."""

    @property
    @abstractmethod
    def has_deviations(self) -> bool:
        """Whether the standard deviations were measured rather than estimated from residuals."""

    @property
    @abstractmethod
    def names(self) -> Sequence[str]:
        """Names of the constants."""

    @property
    @abstractmethod
    def doubts(self) -> list[str]:
        """Reasons, as sentences, to doubt that the fit describes the measurements."""

    def _constants(self) -> list[tuple[str, str]]:
        rows = zip(self.names, self.values, self.deviations, strict=True)
        return [(name, f"{value:.6g} \u00b1 {error:.2g}") for name, value, error in rows]

    def __repr__(self) -> str:
        constants = ", ".join(f"{name} = {value}" for name, value in self._constants())
        return f"<{type(self).__name__}: {constants}>"

    def _repr_html_(self) -> str:
        doubts = [("doubt", doubt) for doubt in self.doubts]
        return html_table(type(self).__name__, [*self._constants(), *doubts])

    @property
    def deviations(self) -> Points:
        """Standard deviations of the constants."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def correlations(self) -> Points:
        """Correlation matrix of the constants."""
        return self.covariance / np.outer(self.deviations, self.deviations)

    @property
    def degrees(self) -> int:
        """Degrees of freedom: number of points minus number of constants."""
        return self.residuals.size - self.values.size

    @property
    def chi_squared(self) -> float:
        """Sum of squared residuals; equals `degrees` if the deviations were estimated from them."""
        return float(self.residuals @ self.residuals)

    @property
    def p_value(self) -> float:
        """Probability of so large a chi^2 if the law holds; NaN if deviations are unmeasured."""
        if not self.has_deviations:
            return math.nan
        return float(stats.chi2.sf(self.chi_squared, self.degrees))

    def undetermined_constants(self, is_linear: Sequence[bool] | None = None) -> list[str]:
        """Return a sentence for each nonlinear constant whose deviation exceeds its value."""
        flags = is_linear or [False] * len(self.names)
        rows = zip(self.names, flags, self.values, self.deviations, strict=True)
        return [
            f"{name} is not determined: its deviation exceeds its value"
            for name, linear, value, deviation in rows
            if not linear and deviation > abs(value)
        ]

    def doubts_of_size(self, law: str, points: str, level: float = DOUBT_LEVEL) -> list[str]:
        """Return sentences that say whether the residuals are too large or too small.

        ``law`` and ``points`` are the words for the model and its data in these sentences;
        ``level`` is the significance level.
        """
        doubts, reduced = [], self.chi_squared / self.degrees
        if self.p_value < level:
            doubts.append(
                f"{law} differs from the {points} by more than their deviations: chi^2 is "
                f"{reduced:.3g} per degree of freedom, {probability(self.p_value, 1)}"
            )
        if self.p_value > 1 - level / 10:
            doubts.append(
                f"the {points} scatter less than their deviations: chi^2 is {reduced:.2g} per "
                "degree of freedom"
            )
        return doubts


def unit_covariance(jacobian: Points, names: Sequence[object], data: str, remedy: str) -> Points:
    """Return the covariance (J^T J)^-1 of constants whose residuals have deviation 1.

    Raises ValueError with the names of constants that cannot be determined separately. ``data`` is
    the word for the measurements in the message; ``remedy`` is a format for the first such name.
    """
    scales = norms(jacobian)
    _, singular, rows = linalg.svd(jacobian / scales, full_matrices=False)
    dependent = [str(n) for n, part in zip(names, rows[-1], strict=True) if abs(part) > 0.1]
    if singular[-1] > RANK_TOLERANCE * singular[0]:
        with np.errstate(all="ignore"):
            inverse = rows.T / singular**2 @ rows / np.outer(scales, scales)
        overflows = ~np.isfinite(np.diag(inverse))
        if not overflows.any():
            return np.asarray((inverse + inverse.T) / 2)
        dependent = [str(n) for n, lost in zip(names, overflows, strict=True) if lost]
    raise ValueError(
        f"constants must be determined by the {data}, got {', '.join(dependent)}, other values "
        f"of which fit as well ({remedy.format(dependent[0])})"
    )


def estimate_noise(inverse: Points, residuals: Points, least: float) -> tuple[Points, float]:
    """Estimate one deviation for all points; return (covariance of the constants, deviation).

    ``inverse`` is the covariance for deviation 1, ``least`` the smallest deviation returned. The
    returned covariance is that of Student's distribution.
    """
    degrees = residuals.size - len(inverse)
    noise = max(math.sqrt(float(residuals @ residuals) / degrees), least)
    return inverse * (noise**2 * degrees / (degrees - 2)), noise


def probability(p_value: float, digits: int = 2) -> str:
    """Return a p-value as text with ``digits`` digits, or as "p < ..." if it is tiny.

    >>> probability(0.123), probability(4e-44, 1), probability(0.0)
    ('p = 0.12', 'p = 4e-44', 'p < 1e-300')
    """
    return f"p = {p_value:.{digits}g}" if p_value > LEAST_P_VALUE else f"p < {LEAST_P_VALUE:g}"


def norms(columns: Points) -> Points:
    """Return the Euclidean norm of each column, or 1 for a column of zeros."""
    lengths = linalg.norm(columns, axis=0)
    return np.where(lengths > 0, lengths, 1.0)
