"""A force law fitted to measured points: constants with covariance, and whether it describes them.

The sum of squared residuals, each over its standard deviation, is least.  Where deviations are not
measured, one for all points is taken from the residuals; the covariance is then that of Student's
distribution, so that 1.96 standard deviations are 95 % with few points, too.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import product
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import linalg, optimize, stats
from sympy import Expr, Rational, Symbol, symbols

from longwave.derive.algebra.contact import contact
from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.lattice import Lattice
from longwave.derive.lattice_file import lattice_of
from longwave.derive.measured import Measured
from longwave.derive.symbols import x
from longwave.scenes.fits.force_data import ForceData, Points
from longwave.scenes.fits.force_law import TABLE, ForceLaw, stated_law
from longwave.scenes.fits.least_squares import (
    DOUBTFUL,
    SAME,
    SPARE,
    LeastSquares,
    inverse_square,
    norms,
    of_residuals,
)

HIGHEST = 6
"""Power of the stretch in the polynomials that are tried."""

KNOTS, NEAR = 12, 0.1
"""The most of a spline; the share of the largest stretch within which there are none of 0."""

AS_GOOD = 2.0
"""Differences of AICc that do not tell two laws apart (Burnham and Anderson)."""

SMOOTH = 5
"""Degree of the curves that residuals are compared with."""

CERTAIN = 5.0
"""Standard deviations from 0 at which a constant is declared to be positive."""

SCALES = (0.1, 1.0, 10.0)
"""Of a constant that enters otherwise than linearly, in powers of the largest stretch."""

MOST_STARTS, BEST_STARTS = 1000, 3
"""Starts that are tried, and those from which a fit is made."""

EVALUATIONS = 300

ROUNDING = 1e-13
"""Share of the largest force that is taken for noise where residuals are smaller."""


@dataclass(frozen=True, repr=False)
class ForceFit(LeastSquares):
    """A law fitted to points.

    ``values`` and ``covariance`` are those of ``law.free``, ``errors`` the standard deviations of
    the points, one for all where they are not measured.  ``evidence`` has the constants of each law
    that was tried and its AICc, if the order was chosen by it.
    """

    data: ForceData
    law: ForceLaw
    values: Points
    covariance: Points
    errors: Points
    evidence: tuple[tuple[str, float], ...] = ()

    def forces(self, stretch: Points) -> Points:
        """The forces of the fitted law."""
        return self.law.values.forces(stretch, self.values)

    @property
    def names(self) -> list[str]:
        """The names of the constants that were fitted."""
        return [str(symbol) for symbol in self.law.free]

    @property
    def has_deviations(self) -> bool:
        """Whether those of the points were measured."""
        return self.data.deviation is not None

    @property
    def residuals(self) -> Points:
        """Measured less fitted forces, over the standard deviations of the points."""
        return (self.data.force - self.forces(self.data.stretch)) / self.errors

    @cached_property
    def smooth_p_value(self) -> float:
        """How often a smooth curve fits the residuals as well if the law is right.

        The curves are the Legendre polynomials to `SMOOTH`, less what the constants could take up.
        Runs of signs notice less: of 400 cubic laws at 41 points 36 % where this does 98 %.
        """
        if self.errors[0] <= _rounding(self.data):
            return math.nan
        stretch, weight = self.data.stretch, 1 / self.errors[:, np.newaxis]
        slopes = self.law.values.slopes(stretch, self.values) * weight
        known, _ = linalg.qr(slopes / norms(slopes), mode="economic")
        scaled = 2 * (stretch - stretch[0]) / np.ptp(stretch) - 1
        curves = np.polynomial.legendre.legvander(scaled, SMOOTH) * weight
        curves /= norms(curves)
        basis, sizes, _ = linalg.svd(curves - known @ (known.T @ curves), full_matrices=False)
        basis = basis[:, sizes > SAME]
        count, left = basis.shape[1], self.residuals
        taken, rest = float(np.sum((basis.T @ left) ** 2)), self.degrees - count
        if self.data.deviation is not None:
            return float(stats.chi2.sf(taken, count))
        if rest < 1:
            return math.nan
        left_over = max(float(left @ left) - taken, ROUNDING)
        return float(stats.f.sf(taken / count * rest / left_over, count, rest))

    @property
    def doubts(self) -> list[str]:
        """Reasons, in words, to think that the law does not describe the points."""
        found = self.doubts_of_size("the law", "points")
        if self.smooth_p_value < DOUBTFUL:
            found.append(
                "the residuals follow a smooth curve along the stretch, as those of a wrong law "
                f"do: p = {self.smooth_p_value:.1g}"
            )
        return found

    @property
    def measured(self) -> Measured:
        """The constants with their covariance, and those that were fixed without."""
        names = self.names
        rows = [dict(zip(names, row, strict=True)) for row in self.covariance.tolist()]
        fixed = {str(symbol): value for symbol, value in self.law.fixed.items()}
        values = {**dict(zip(names, self.values.tolist(), strict=True)), **fixed}
        return Measured.of(values, dict(zip(names, rows, strict=True)))

    def document(self) -> dict[str, object]:
        """The tables of a lattice file: a chain of unit masses with this force."""
        certain = self.values > CERTAIN * self.deviations
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
        """The chain of unit masses with this force, its constants measured."""
        return lattice_of(self.document())


def fit_force(
    stretch: ArrayLike,
    force: ArrayLike,
    deviation: ArrayLike | None = None,
    law: str | None = None,
    fixed: Mapping[str, Number] | None = None,
) -> ForceFit:
    """Fit a force law to points, in the order in which they were measured.

    ``law`` is a formula in the stretch x and constants, of which those in ``fixed`` have values, or
    "hertz", or "table", a cubic spline.  Without one it is a polynomial K2 x + K3 x^2 + ..., or an
    odd one.  Of these, and of splines, it is that of the fewest constants among those whose AICc is
    within `AS_GOOD` of the least.  Raises ValueError for points and laws that are none, and for
    constants that the points do not tell apart.

    >>> fitted = fit_force([-2, -1, 0, 1, 2], [-2.1, -0.9, 0.1, 1.0, 1.9], law="K2*x")
    >>> f"{fitted.values[0]:.2f} +- {fitted.deviations[0]:.2f}"
    '0.99 +- 0.04'
    """
    return fit_points(ForceData.of(stretch, force, deviation), stated_law(law, fixed))


def fit_points(data: ForceData, law: ForceLaw | Literal["table"] | None = None) -> ForceFit:
    """The same of points and a law that are checked."""
    if isinstance(law, ForceLaw):
        return _fitted(data, law)
    tried = _splines(data) if law == TABLE else _polynomials(data)
    fits = [_fitted(data, ForceLaw(force)) for force in tried]
    evidence = [_aicc(fit) for fit in fits]
    good = [f for f, value in zip(fits, evidence, strict=True) if value <= min(evidence) + AS_GOOD]
    names = (" ".join(map(str, fit.law.free)) for fit in fits)
    chosen = min(good, key=lambda fit: (fit.values.size, _aicc(fit)))
    return replace(chosen, evidence=tuple(zip(names, evidence, strict=True)))


def _polynomials(data: ForceData) -> Iterator[Expr]:
    """Polynomials that the points can tell, and odd ones where both signs were measured."""
    both = data.stretch[0] < 0 < data.stretch[-1]
    for highest in range(1, HIGHEST + 1):
        for step in (1, 2) if both and highest % 2 and highest > 1 else (1,):
            powers = range(1, highest + 1, step)
            if min(data.stretch.size - SPARE, len(np.unique(data.stretch)) - 1) >= len(powers):
                yield sum(Symbol(f"K{power + 1}", real=True) * x**power for power in powers)


def _splines(data: ForceData) -> Iterator[Expr]:
    """Cubics, and cubics to which others are added beyond up to `KNOTS` knots among the points.

    About no stretch, within `NEAR` of the largest, the law is that of K2, K3 and K4 alone.
    """
    near = NEAR * float(np.max(np.abs(data.stretch)))
    cubic = sum(Symbol(f"K{power + 1}", real=True) * x**power for power in (1, 2, 3))
    tried = set()
    for count in range(min(KNOTS, data.stretch.size - SPARE - 3) + 1):
        places = np.quantile(data.stretch, np.arange(1, count + 1) / (count + 1))
        far = places[abs(places) > near].tolist()
        tried.add(tuple(sorted({Rational(f"{place:.3g}") for place in far})))
    for knots in sorted(tried, key=len):
        beyond = (contact(x - knot if knot > 0 else knot - x) ** 3 for knot in knots)
        names = symbols(f"C1:{len(knots) + 1}", real=True)
        yield cubic + sum(name * part for name, part in zip(names, beyond, strict=True))


def _aicc(fit: ForceFit) -> float:
    """Akaike's information criterion with its correction for few points."""
    points, count, lost = fit.data.stretch.size, fit.values.size, fit.chi_squared
    if fit.data.deviation is None:  # the noise is one more constant
        count += 1
        lost = points * math.log(fit.errors[0] ** 2 * fit.degrees / points)
    return lost + 2 * count + 2 * count * (count + 1) / (points - count - 1)


def _rounding(data: ForceData) -> float:
    return ROUNDING * float(np.max(np.abs(data.force)))


def _fitted(data: ForceData, law: ForceLaw) -> ForceFit:
    """The law at the constants of least chi^2."""
    count, points = len(law.free), data.stretch.size
    if points < count + SPARE:
        raise ValueError(
            f"points must be at least {count + SPARE} for the {count} constants of {law.text}, got "
            f"{points} (measure more, or state a law with fewer)"
        )
    problem = _Problem(data, law)
    found = problem.least()
    inverse = inverse_square(
        found.jac, law.free, "points", "fix one, such as {}=1, or state another law"
    )
    errors = data.deviation
    if errors is None:
        inverse, noise = of_residuals(inverse, found.fun, _rounding(data))
        errors = np.full(points, noise)
    return ForceFit(data, law, found.x, inverse, errors)


class _Problem:
    """Least squares of a law: its residuals, where they may start, and where they are least."""

    def __init__(self, data: ForceData, law: ForceLaw) -> None:
        self._law, self._data = law, data
        self._weight = 1.0 if data.deviation is None else 1 / data.deviation

    def residuals(self, constants: Points) -> Points:
        """Fitted less measured forces, over the deviations."""
        forces = self._law.values.forces(self._data.stretch, constants)
        return (forces - self._data.force) * self._weight

    def jacobian(self, constants: Points) -> Points:
        """Their derivatives."""
        slopes = self._law.values.slopes(self._data.stretch, constants)
        return slopes * np.reshape(self._weight, (-1, 1))

    def least(self) -> optimize.OptimizeResult:
        """The fit of the least chi^2 from all starts; ValueError if none comes to rest."""
        starts = sorted(self._starts(), key=lambda start: start[0])[:BEST_STARTS]
        if not starts:
            raise ValueError(
                f"law must have a value at all stretches, got {self._law.text}, which has none "
                f"from {self._data.stretch[0]:g} to {self._data.stretch[-1]:g} (state another)"
            )
        options = {"x_scale": "jac", "max_nfev": EVALUATIONS, "xtol": 1e-13, "ftol": 1e-13}
        with np.errstate(all="ignore"):
            found = [
                optimize.least_squares(self.residuals, start, self.jacobian, **options)
                for _, start in starts
            ]
        best = min(found, key=lambda one: one.cost)
        if not best.success:
            raise ValueError(
                f"law must come to rest at constants of least chi^2, got {self._law.text}, whose "
                "still move (fix a constant, or state another law)"
            )
        return best

    def _starts(self) -> Iterable[tuple[float, Points]]:
        """Starts with their chi^2: of some constants that enter the law otherwise than linearly,
        with those of the others that fit best then."""
        linear = np.array(self._law.values.linear)
        reach = float(np.max(np.abs(self._data.stretch)))
        sizes = sorted({scale * reach**power for scale in SCALES for power in (-1, 0, 1)})
        choices = [
            sizes if positive else [sign * size for size in sizes for sign in (1, -1)]
            for positive, is_linear in zip(self._law.values.positive, linear, strict=True)
            if not is_linear
        ]
        every: Iterable[tuple[float, ...]] = product(*choices)
        if math.prod(map(len, choices)) > MOST_STARTS:
            draw = random.Random(0).choice
            every = [tuple(map(draw, choices)) for _ in range(MOST_STARTS)]
        for chosen in every:
            start = np.zeros(linear.size)
            start[~linear] = chosen
            offset = self.residuals(start)
            slopes = self.jacobian(start)[:, linear]
            if np.isfinite(offset).all() and np.isfinite(slopes).all():
                if linear.any():
                    start[linear] = linalg.lstsq(slopes / (s := norms(slopes)), -offset)[0] / s
                left = self.residuals(start)
                if np.isfinite(left).all() and np.isfinite(self.jacobian(start)).all():
                    yield float(left @ left), start
