"""Least-squares fits of force laws to measured points, with covariance and tests of the law.

Residuals are weighted by their standard deviations.  If deviations were not measured, one for all
points is estimated from the residuals; the covariance is then that of Student's distribution, so
that 1.96 standard deviations are 95 % for few points, too.
"""

import math
import random
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from itertools import product
from operator import itemgetter
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, optimize
from sympy import Rational, Symbol, symbols

from longwave.derive.algebra.contact import contact
from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.lattice import Lattice
from longwave.derive.lattice_file import lattice_of
from longwave.derive.measured import Measured
from longwave.derive.symbols import x
from longwave.scenes.fits.force_data import ForceData, Points
from longwave.scenes.fits.force_law import TABLE, ForceLaw, stated_law
from longwave.scenes.fits.least_squares import (
    MIN_DEGREES,
    LeastSquares,
    estimate_noise,
    norms,
    probability,
    unit_covariance,
)
from longwave.scenes.fits.residual_tests import (
    SERIAL,
    SIZE,
    SMOOTH,
    ResidualTest,
    ResidualTests,
    level,
)

HIGHEST_POWER = 6
"""Highest power of the stretch in the polynomials tried."""

MAX_KNOTS, KNOT_FREE = 12, 0.1
"""Maximum number of knots of a spline, and the distance from stretch 0, as a fraction of the
largest stretch, within which there are none."""

AICC_MARGIN = 2.0
"""Difference of AICc up to which two laws count as equally good (Burnham and Anderson)."""

MIN_POINTS_TO_CHOOSE = 12
"""Minimum number of points from which a law is chosen without a warning."""

MAX_WIDENING = 1.3
"""Largest factor by which the choice of a law may widen a constant's interval without a warning."""

POSITIVE_DEVIATIONS = 5.0
"""Number of standard deviations above 0 from which a constant is declared positive."""

START_FACTORS = (0.1, 1.0, 10.0)
"""Factors whose products with powers of the largest stretch are starting values of nonlinear
constants."""

MAX_STARTS, BEST_STARTS = 1000, 3
"""Maximum number of starting points evaluated, and the number of best ones from which to fit."""

MAX_EVALUATIONS, CONVERGED_DEVIATIONS = 300, 0.01
"""Maximum number of evaluations of a search, and the largest change of the law in a further step,
in standard deviations, at which the search counts as converged."""

ROUNDING_FRACTION = 1e-13
"""Least noise, as a fraction of the largest force; smaller residuals are rounding errors."""


@dataclass(frozen=True, repr=False)
class ForceFit(LeastSquares):
    """Force law fitted to points.

    ``values`` and ``covariance`` are those of ``law.free``, ``errors`` the standard deviations of
    the points, equal for all if they were not measured.  If the law was chosen by AICc,
    ``evidence`` lists the constants and the AICc of each law tried, and ``alone`` is the covariance
    without the uncertainty from choosing the law.
    """

    data: ForceData
    law: ForceLaw
    values: Points
    covariance: Points
    errors: Points
    evidence: tuple[tuple[str, float], ...] = ()
    alone: Points | None = None

    def forces(self, stretch: Points) -> Points:
        """Return the forces of the fitted law at given stretches."""
        return self.law.values.forces(stretch, self.values)

    @property
    def names(self) -> list[str]:
        """Names of the fitted constants."""
        return [str(symbol) for symbol in self.law.free]

    @property
    def has_deviations(self) -> bool:
        """Whether the standard deviations of the points were measured."""
        return self.data.deviation is not None

    @property
    def residuals(self) -> Points:
        """Measured minus fitted forces, over the standard deviations of the points."""
        return (self.data.force - self.forces(self.data.stretch)) / self.errors

    @property
    def is_exact(self) -> bool:
        """Whether the residuals are only rounding errors."""
        rms = linalg.norm(self.residuals * self.errors) / math.sqrt(self.data.stretch.size)
        return float(rms) <= _rounding(self.data)

    @cached_property
    def tests(self) -> tuple[ResidualTest, ...]:
        """Results of tests of the residuals; empty if residuals are only rounding errors."""
        if self.is_exact:
            return ()
        data, weight = self.data, 1 / self.errors
        slopes = self.law.values.slopes(data.stretch, self.values) * weight[:, np.newaxis]
        known = self.has_deviations
        return ResidualTests(data.stretch, self.residuals, slopes, weight, data.rows, known).all

    @property
    def smooth_p_value(self) -> float:
        """p-value of a smooth trend in the residuals if the law is right; NaN if untested."""
        return next((test.p_value for test in self.tests if test.kind == SMOOTH), math.nan)

    @property
    def widening(self) -> Points:
        """Factors by which choosing the law enlarges the standard deviations of the constants."""
        alone = self.covariance if self.alone is None else self.alone
        return np.asarray(self.deviations / np.sqrt(np.diag(alone)))

    @property
    def doubts(self) -> list[str]:
        """Reasons, as sentences, to doubt that the law describes the points."""
        doubts = self.doubts_of_size("the law", "points", level(SIZE, self.has_deviations))
        for is_serial, finding in (
            (False, "follow a smooth curve along the stretch, as for a wrong law"),
            (True, "of neighbours are correlated, as for a wrong law or disturbed readings"),
        ):
            alarms = [t for t in self.tests if t.is_alarm and (t.kind == SERIAL) == is_serial]
            p_values = ", ".join(f"{t.seeks}, {probability(t.p_value, 1)}" for t in alarms)
            doubts += [f"the residuals {finding}: {p_values}"] if alarms else []
        is_linear = self.law.values.linear
        return doubts + self._doubts_of_choice() + self.undetermined_constants(is_linear)

    def _doubts_of_choice(self) -> list[str]:
        """Return warnings that intervals may be too narrow because AICc chose the law."""
        points = self.data.stretch.size
        if not self.evidence or self.is_exact:
            return []
        if points < MIN_POINTS_TO_CHOOSE:
            return [
                f"{points} points are too few to choose a law by, and the intervals may not hold: "
                f"measure {MIN_POINTS_TO_CHOOSE} or more, or state the law"
            ]
        worst = int(np.argmax(self.widening))
        if self.widening[worst] <= MAX_WIDENING:
            return []
        return [
            "the points do not determine the law, and other laws that describe them as well make "
            f"the interval of {self.names[worst]} {self.widening[worst]:.2g} times as wide: state "
            "the law, or measure more"
        ]

    @property
    def measured(self) -> Measured:
        """Constants of the law: the fitted ones with their covariance, the fixed ones without."""
        names = self.names
        rows = [dict(zip(names, row, strict=True)) for row in self.covariance.tolist()]
        fixed = {str(symbol): value for symbol, value in self.law.fixed.items()}
        values = {**dict(zip(names, self.values.tolist(), strict=True)), **fixed}
        return Measured.of(values, dict(zip(names, rows, strict=True)))

    def document(self) -> dict[str, object]:
        """Return the tables of a lattice file for a chain of unit masses with this force."""
        certain = self.values > POSITIVE_DEVIATIONS * self.deviations
        free = zip(self.law.free, certain, strict=True)
        positive = [str(s) for s, sure in free if sure or s.is_positive]
        positive += [str(s) for s, value in self.law.fixed.items() if value > 0]
        measured = self.measured
        return {
            "fields": ["u"],
            "masses": [1],
            "positive": sorted(positive),
            "spring": [{"between": ["u[n]", "u[n+1]"], "force": text} for text in self.law.parts],
            "constants": {name: float(value) for name, value in measured.values},
            "covariance": {n: row for n, row in measured.table.items() if any(row.values())},
        }

    @property
    def lattice(self) -> Lattice:
        """Chain of unit masses with this force and the measured constants."""
        return lattice_of(self.document())


def fit_force(
    stretch: ArrayLike,
    force: ArrayLike,
    deviation: ArrayLike | None = None,
    law: str | None = None,
    fixed: Mapping[str, Number] | None = None,
) -> ForceFit:
    """Fit a force law to points, given in the order of measurement.

    ``law`` is a formula in the stretch x and constants, some of them ``fixed`` to values, or
    "hertz", or "table" for a cubic spline.  The default is a polynomial K2 x + K3 x^2 + ..., or
    an odd one.  Of the polynomials or splines whose AICc is within `AICC_MARGIN` of the least, the
    one with the fewest constants is chosen.  Raises ValueError for invalid points or laws, and for
    constants that the points do not determine.

    >>> fitted = fit_force([-2, -1, 0, 1, 2], [-2.1, -0.9, 0.1, 1.0, 1.9], law="K2*x")
    >>> f"{fitted.values[0]:.2f} +- {fitted.deviations[0]:.2f}"
    '0.99 +- 0.04'
    """
    return fit_points(ForceData.of(stretch, force, deviation), stated_law(law, fixed))


def fit_points(data: ForceData, law: ForceLaw | Literal["table"] | None = None) -> ForceFit:
    """Fit a force law to checked points; see `fit_force`."""
    if isinstance(law, ForceLaw):
        return _fit_law(data, law)
    candidates = _splines(data) if law == TABLE else _polynomials(data)
    fits = _identifiable_fits(data, candidates)
    evidence = [_aicc(fit) for fit in fits]
    limit = min(evidence) + AICC_MARGIN
    good = [fit for fit, value in zip(fits, evidence, strict=True) if value <= limit]
    names = (" ".join(map(str, fit.law.free)) for fit in fits)
    chosen = min(good, key=lambda fit: (fit.values.size, _aicc(fit)))
    covariance = chosen.covariance if law == TABLE else _averaged(chosen, fits, evidence)
    named = tuple(zip(names, evidence, strict=True))
    return replace(chosen, evidence=named, covariance=covariance, alone=chosen.covariance)


def _identifiable_fits(data: ForceData, laws: Iterable[ForceLaw]) -> list[ForceFit]:
    """Return the fits of the laws whose constants the points determine; ValueError if none."""
    fits, reason = [], ""
    for law in laws:
        try:
            fits.append(_fit_law(data, law))
        except ValueError as error:
            reason = str(error)
    if not fits:
        raise ValueError(reason)
    return fits


def _averaged(chosen: ForceFit, fits: list[ForceFit], evidence: list[float]) -> Points:
    """Return the covariance of the chosen law's constants, averaged over all laws by exp(-AICc/2).

    Each law contributes its own covariance and the squared differences of its constants from the
    chosen ones; constants that it lacks count as 0 (Buckland, Burnham and Augustin 1997).
    """
    weights = np.exp((min(evidence) - np.array(evidence)) / 2)
    total = np.zeros_like(chosen.covariance)
    for weight, fit in zip(weights / weights.sum(), fits, strict=True):
        indices = [fit.names.index(name) if name in fit.names else -1 for name in chosen.names]
        values = np.append(fit.values, 0.0)[indices]
        covariance = np.pad(fit.covariance, (0, 1))[np.ix_(indices, indices)]
        total += weight * (covariance + np.outer(d := values - chosen.values, d))
    return np.asarray((total + total.T) / 2)


@cache
def _polynomial(powers: range) -> ForceLaw:
    """Return the polynomial law with these powers of the stretch."""
    return ForceLaw(sum(Symbol(f"K{power + 1}", real=True) * x**power for power in powers))


def _polynomials(data: ForceData) -> Iterator[ForceLaw]:
    """Yield polynomials of few enough constants; also odd ones for stretches of both signs."""
    has_both_signs = data.stretch[0] < 0 < data.stretch[-1]
    for highest in range(1, HIGHEST_POWER + 1):
        for step in (1, 2) if has_both_signs and highest % 2 and highest > 1 else (1,):
            powers = range(1, highest + 1, step)
            most = min(data.stretch.size - MIN_DEGREES, len(np.unique(data.stretch)) - 1)
            if len(powers) <= most:
                yield _polynomial(powers)


def _splines(data: ForceData) -> Iterator[ForceLaw]:
    """Yield cubic splines with up to `MAX_KNOTS` knots at quantiles of the stretch.

    Within `KNOT_FREE` of stretch 0 there are no knots, so the law is given by K2, K3 and K4 alone.
    Raises ValueError for too few points.
    """
    if data.stretch.size < 3 + MIN_DEGREES:
        raise ValueError(
            f"points must be at least {3 + MIN_DEGREES} for a table, got {data.stretch.size} "
            "(measure more, or state a law)"
        )
    near = KNOT_FREE * float(np.max(np.abs(data.stretch)))
    cubic = _polynomial(range(1, 4)).force
    candidates = set()
    for count in range(min(MAX_KNOTS, data.stretch.size - MIN_DEGREES - 3) + 1):
        quantiles = np.quantile(data.stretch, np.arange(1, count + 1) / (count + 1))
        far = quantiles[abs(quantiles) > near].tolist()
        candidates.add(tuple(sorted({Rational(f"{knot:.3g}") for knot in far})))
    for knots in sorted(candidates, key=len):
        terms = (contact(x - knot if knot > 0 else knot - x) ** 3 for knot in knots)
        names = symbols(f"C1:{len(knots) + 1}", real=True)
        yield ForceLaw(cubic + sum(name * term for name, term in zip(names, terms, strict=True)))


def _aicc(fit: ForceFit) -> float:
    """Return Akaike's information criterion with the correction for few points."""
    points, count, misfit = fit.data.stretch.size, fit.values.size, fit.chi_squared
    if fit.data.deviation is None:  # the noise is one more constant
        count += 1
        misfit = points * math.log(fit.errors[0] ** 2 * fit.degrees / points)
    return misfit + 2 * count + 2 * count * (count + 1) / (points - count - 1)


def _rounding(data: ForceData) -> float:
    return ROUNDING_FRACTION * float(np.max(np.abs(data.force)))


def _fit_law(data: ForceData, law: ForceLaw) -> ForceFit:
    """Fit a law to points; ValueError for too few points or constants they do not determine."""
    count, points = len(law.free), data.stretch.size
    if points < count + MIN_DEGREES:
        raise ValueError(
            f"points must be at least {count + MIN_DEGREES} for the {count} constants of "
            f"{law.text}, got {points} (measure more, or state a law with fewer)"
        )
    problem = _Problem(data, law)
    values = problem.least()
    remedy = "fix one, such as {}=1, or state another law"
    inverse = unit_covariance(problem.jacobian(values), law.free, "points", remedy)
    problem.check_converged(values)
    errors = data.deviation
    if errors is None:
        inverse, noise = estimate_noise(inverse, problem.residuals(values), _rounding(data))
        errors = np.full(points, noise)
    return ForceFit(data, law, values, inverse, errors)


class _Problem:
    """Least-squares problem of a law, solved by variable projection.

    The linear constants follow from the nonlinear ones by linear least squares, so only the
    nonlinear ones are searched for (Golub and Pereyra 1973, Kaufman 1975).
    """

    def __init__(self, data: ForceData, law: ForceLaw) -> None:
        self._law, self._data = law, data
        self._weight = 1.0 if data.deviation is None else 1 / data.deviation
        self._linear = np.array(law.values.linear)

    def residuals(self, constants: Points) -> Points:
        """Return fitted minus measured forces, over the deviations."""
        forces = self._law.values.forces(self._data.stretch, constants)
        return (forces - self._data.force) * self._weight

    def jacobian(self, constants: Points) -> Points:
        """Return the derivatives of the residuals by the constants."""
        slopes = self._law.values.slopes(self._data.stretch, constants)
        return slopes * np.reshape(self._weight, (-1, 1))

    def completed(self, nonlinear: Points) -> Points:
        """Return all constants: the given nonlinear ones with the best linear ones.

        All constants are NaN if the law or its derivatives are undefined at ``nonlinear``.
        """
        constants = np.zeros(self._linear.size)
        constants[~self._linear] = nonlinear
        undefined = np.full(constants.size, math.nan)
        if self._linear.any():
            offset, slopes = self.residuals(constants), self.jacobian(constants)[:, self._linear]
            if not (np.isfinite(offset).all() and np.isfinite(slopes).all()):
                return undefined
            sizes = norms(slopes)
            constants[self._linear] = linalg.lstsq(slopes / sizes, -offset)[0] / sizes
        if not np.isfinite(self.residuals(constants)).all():
            return undefined
        return constants if np.isfinite(self.jacobian(constants)).all() else undefined

    def least(self) -> Points:
        """Return the constants of least chi^2; ValueError if every start is undefined."""
        with np.errstate(all="ignore"):
            starts = sorted(self._starts(), key=itemgetter(0))[:BEST_STARTS]
            if not starts:
                raise ValueError(
                    f"law must be defined from stretch {self._data.stretch[0]:g} to "
                    f"{self._data.stretch[-1]:g}, got {self._law.text}, which is undefined for all "
                    "starting values (state another law)"
                )
            return min((self._descent(start) for _, start in starts), key=itemgetter(1))[0]

    def _descent(self, start: Points) -> tuple[Points, float]:
        """Return the constants to which a search from ``start`` converges, and their chi^2."""
        if start.size:
            start = optimize.least_squares(
                lambda nonlinear: self.residuals(self.completed(nonlinear)),
                start,
                self._projected_jacobian,
                x_scale="jac",
                max_nfev=MAX_EVALUATIONS,
                xtol=1e-13,
                ftol=1e-13,
            ).x
        constants = self.completed(start)
        return constants, float(np.sum(self.residuals(constants) ** 2))

    def check_converged(self, constants: Points) -> None:
        """Raise ValueError if another least-squares step would move the law noticeably."""
        residuals, slopes = self.residuals(constants), self.jacobian(constants)
        basis, _ = linalg.qr(slopes / norms(slopes), mode="economic")
        noise = 1.0
        if self._data.deviation is None:
            noise = float(linalg.norm(residuals)) / math.sqrt(residuals.size - constants.size)
        weights = np.ones(residuals.size) * self._weight
        rounding = _rounding(self._data) * float(linalg.norm(weights))
        if not float(linalg.norm(basis.T @ residuals)) <= CONVERGED_DEVIATIONS * noise + rounding:
            raise ValueError(
                f"law must have constants of least chi^2, got {self._law.text}, whose constants "
                "have not converged at the end of the search (fix one, or state another law)"
            )

    def _projected_jacobian(self, nonlinear: Points) -> Points:
        """Return the derivatives by nonlinear constants of the residuals after the linear fit."""
        slopes = self.jacobian(self.completed(nonlinear))
        others = slopes[:, ~self._linear]
        if not self._linear.any():
            return others
        linear = slopes[:, self._linear]
        basis, _ = linalg.qr(linear / norms(linear), mode="economic")
        return np.asarray(others - basis @ (basis.T @ others))

    def _starts(self) -> Iterable[tuple[float, Points]]:
        """Yield pairs (chi^2, starting values of nonlinear constants) where chi^2 is finite."""
        reach = float(np.max(np.abs(self._data.stretch)))
        sizes = sorted({scale * reach**power for scale in START_FACTORS for power in (-1, 0, 1)})
        choices = [
            sizes if positive else [sign * size for size in sizes for sign in (1, -1)]
            for positive, linear in zip(self._law.values.positive, self._linear, strict=True)
            if not linear
        ]
        starts: Iterable[tuple[float, ...]] = product(*choices)
        if math.prod(map(len, choices)) > MAX_STARTS:
            draw = random.Random(0).choice
            starts = [tuple(map(draw, choices)) for _ in range(MAX_STARTS)]
        for start in map(np.array, starts):
            residuals = self.residuals(self.completed(start))
            if np.isfinite(residuals).all():
                yield float(residuals @ residuals), start
