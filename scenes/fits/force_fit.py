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
from functools import cache, cached_property
from itertools import product
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
    SPARE,
    LeastSquares,
    inverse_square,
    norms,
    of_residuals,
    probability,
)
from longwave.scenes.fits.residual_tests import (
    SERIAL,
    SIZE,
    SMOOTH,
    ResidualTest,
    ResidualTests,
    level,
)

HIGHEST = 6
"""Power of the stretch in the polynomials that are tried."""

KNOTS, NEAR = 12, 0.1
"""The most of a spline; the share of the largest stretch within which there are none of 0."""

AS_GOOD = 2.0
"""Differences of AICc that do not tell two laws apart (Burnham and Anderson)."""

FEWEST_TO_CHOOSE = 12
"""Points from which a law is chosen without a warning: the coverage by points is in the docs."""

WIDENED = 1.3
"""Factor of a deviation, by the choice of the law, above which the choice matters."""

CERTAIN = 5.0
"""Standard deviations from 0 at which a constant is declared to be positive."""

SCALES = (0.1, 1.0, 10.0)
"""Of a constant that enters otherwise than linearly, in powers of the largest stretch."""

MOST_STARTS, BEST_STARTS = 1000, 3
"""Starts that are tried, and those from which a fit is made."""

EVALUATIONS, AT_REST = 300, 0.01
"""Most steps of a search, and the standard deviations by which one more may move the law."""

ROUNDING = 1e-13
"""Share of the largest force that is taken for noise where residuals are smaller."""


@dataclass(frozen=True, repr=False)
class ForceFit(LeastSquares):
    """A law fitted to points.

    ``values`` and ``covariance`` are those of ``law.free``, ``errors`` the standard deviations of
    the points, one for all where they are not measured.  ``evidence`` has the constants of each law
    that was tried and its AICc, if the order was chosen by it; ``alone`` is then the covariance
    that the constants have if the law is known.
    """

    data: ForceData
    law: ForceLaw
    values: Points
    covariance: Points
    errors: Points
    evidence: tuple[tuple[str, float], ...] = ()
    alone: Points | None = None

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

    @property
    def is_exact(self) -> bool:
        """Whether the residuals are but rounding."""
        size = linalg.norm(self.residuals * self.errors) / math.sqrt(self.data.stretch.size)
        return float(size) <= _rounding(self.data)

    @cached_property
    def tests(self) -> tuple[ResidualTest, ...]:
        """Tests of the residuals; none where they are but rounding."""
        if self.is_exact:
            return ()
        weight = 1 / self.errors
        slopes = self.law.values.slopes(self.data.stretch, self.values)
        made = ResidualTests(
            self.data.stretch,
            self.residuals,
            slopes * weight[:, np.newaxis],
            weight,
            self.data.rows,
            self.has_deviations,
        )
        return made.all

    @property
    def smooth_p_value(self) -> float:
        """How often smooth curves fit the residuals as well if the law is right."""
        return next((test.p_value for test in self.tests if test.kind == SMOOTH), math.nan)

    @property
    def widening(self) -> Points:
        """Deviations over those that the constants have if the law was not chosen but known."""
        alone = self.covariance if self.alone is None else self.alone
        return np.asarray(self.deviations / np.sqrt(np.diag(alone)))

    @property
    def doubts(self) -> list[str]:
        """Reasons, in words, to think that the law does not describe the points."""
        found = self.doubts_of_size("the law", "points", level(SIZE, self.has_deviations))
        curves = [test for test in self.tests if test.is_alarm and test.kind != SERIAL]
        if curves:
            found.append(
                "the residuals follow a smooth curve along the stretch, as those of a wrong law "
                f"do: {_p_values(curves)}"
            )
        alike = [test for test in self.tests if test.is_alarm and test.kind == SERIAL]
        if alike:
            found.append(
                "the residuals of neighbours are alike, as those of a wrong law or of disturbed "
                f"readings are: {_p_values(alike)}"
            )
        return found + self._doubts_of_choice() + self._doubts_of_constants()

    def _doubts_of_choice(self) -> list[str]:
        """Return reasons to think that the intervals of a chosen law may not hold."""
        points = self.data.stretch.size
        if not self.evidence or self.is_exact:
            return []
        if points < FEWEST_TO_CHOOSE:
            return [
                f"{points} points are too few to choose a law by, and the intervals may not hold: "
                f"measure {FEWEST_TO_CHOOSE} or more, or state the law"
            ]
        worst = int(np.argmax(self.widening))
        if self.widening[worst] <= WIDENED:
            return []
        return [
            "the points do not tell the law, and other laws that describe them as well make the "
            f"interval of {self.names[worst]} {self.widening[worst]:.2g} times as wide: state the "
            "law, or measure more"
        ]

    def _doubts_of_constants(self) -> list[str]:
        """Return the constants whose intervals reach where the law is another one."""
        curved = zip(self.names, self.law.values.linear, self.values, self.deviations, strict=True)
        return [
            f"{name} is not determined: its deviation is larger than itself"
            for name, linear, value, deviation in curved
            if not linear and deviation > abs(value)
        ]

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
    fits = list(_told_apart(data, tried))
    evidence = [_aicc(fit) for fit in fits]
    good = [f for f, value in zip(fits, evidence, strict=True) if value <= min(evidence) + AS_GOOD]
    names = (" ".join(map(str, fit.law.free)) for fit in fits)
    chosen = min(good, key=lambda fit: (fit.values.size, _aicc(fit)))
    covariance = chosen.covariance if law == TABLE else _averaged(chosen, fits, evidence)
    return replace(
        chosen,
        evidence=tuple(zip(names, evidence, strict=True)),
        covariance=covariance,
        alone=chosen.covariance,
    )


def _told_apart(data: ForceData, laws: Iterable[ForceLaw]) -> Iterator[ForceFit]:
    """Yield the fits of the laws whose constants the points tell apart; ValueError if none are."""
    found, refused = False, ""
    for law in laws:
        try:
            fit = _fitted(data, law)
        except ValueError as error:
            refused = str(error)
        else:
            found = True
            yield fit
    if not found:
        raise ValueError(refused)


def _averaged(chosen: ForceFit, fits: list[ForceFit], evidence: list[float]) -> Points:
    """Return the covariance of the chosen law's constants over all laws, weighted by exp(-AICc/2).

    A law adds its own covariance and the squares of how far its constants are from the chosen
    ones; those that it lacks are 0 in it (Buckland, Burnham and Augustin 1997).
    """
    weights = np.exp((min(evidence) - np.array(evidence)) / 2)
    total = np.zeros_like(chosen.covariance)
    for weight, fit in zip(weights / weights.sum(), fits, strict=True):
        places = [fit.names.index(name) if name in fit.names else -1 for name in chosen.names]
        values = np.append(fit.values, 0.0)[places]
        covariance = np.pad(fit.covariance, (0, 1))[np.ix_(places, places)]
        total += weight * (covariance + np.outer(d := values - chosen.values, d))
    return np.asarray((total + total.T) / 2)


def _p_values(tests: list[ResidualTest]) -> str:
    return ", ".join(f"{test.seeks}, {probability(test.p_value, 1)}" for test in tests)


@cache
def _polynomial(powers: range) -> ForceLaw:
    """Return the law that is a sum of these powers of the stretch."""
    return ForceLaw(sum(Symbol(f"K{power + 1}", real=True) * x**power for power in powers))


def _polynomials(data: ForceData) -> Iterator[ForceLaw]:
    """Polynomials that the points can tell, and odd ones where both signs were measured."""
    both = data.stretch[0] < 0 < data.stretch[-1]
    for highest in range(1, HIGHEST + 1):
        for step in (1, 2) if both and highest % 2 and highest > 1 else (1,):
            powers = range(1, highest + 1, step)
            if min(data.stretch.size - SPARE, len(np.unique(data.stretch)) - 1) >= len(powers):
                yield _polynomial(powers)


def _splines(data: ForceData) -> Iterator[ForceLaw]:
    """Cubics, and cubics to which others are added beyond up to `KNOTS` knots among the points.

    About no stretch, within `NEAR` of the largest, the law is that of K2, K3 and K4 alone.
    """
    if data.stretch.size < 3 + SPARE:
        raise ValueError(
            f"points must be at least {3 + SPARE} for a table, got {data.stretch.size} (measure "
            "more, or state a law)"
        )
    near = NEAR * float(np.max(np.abs(data.stretch)))
    cubic = _polynomial(range(1, 4)).force
    tried = set()
    for count in range(min(KNOTS, data.stretch.size - SPARE - 3) + 1):
        places = np.quantile(data.stretch, np.arange(1, count + 1) / (count + 1))
        far = places[abs(places) > near].tolist()
        tried.add(tuple(sorted({Rational(f"{place:.3g}") for place in far})))
    for knots in sorted(tried, key=len):
        beyond = (contact(x - knot if knot > 0 else knot - x) ** 3 for knot in knots)
        names = symbols(f"C1:{len(knots) + 1}", real=True)
        yield ForceLaw(cubic + sum(name * part for name, part in zip(names, beyond, strict=True)))


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
    values = problem.least()
    inverse = inverse_square(
        problem.jacobian(values),
        law.free,
        "points",
        "fix one, such as {}=1, or state another law",
    )
    problem.check_rest(values)
    errors = data.deviation
    if errors is None:
        inverse, noise = of_residuals(inverse, problem.residuals(values), _rounding(data))
        errors = np.full(points, noise)
    return ForceFit(data, law, values, inverse, errors)


class _Problem:
    """Least squares of a law: its residuals, where they may start, and where they are least.

    The constants that enter the law linearly are those that fit best for the others, so that only
    the others are searched for (variable projection; Golub and Pereyra 1973, Kaufman 1975).
    """

    def __init__(self, data: ForceData, law: ForceLaw) -> None:
        self._law, self._data = law, data
        self._weight = 1.0 if data.deviation is None else 1 / data.deviation
        self._linear = np.array(law.values.linear)

    def residuals(self, constants: Points) -> Points:
        """Return fitted less measured forces, over the deviations."""
        forces = self._law.values.forces(self._data.stretch, constants)
        return (forces - self._data.force) * self._weight

    def jacobian(self, constants: Points) -> Points:
        """Return the derivatives of the residuals by the constants."""
        slopes = self._law.values.slopes(self._data.stretch, constants)
        return slopes * np.reshape(self._weight, (-1, 1))

    def completed(self, chosen: Points) -> Points:
        """Return all constants, given those that enter otherwise than linearly.

        They are NaN where the law or a derivative has no value.
        """
        found = np.zeros(self._linear.size)
        found[~self._linear] = chosen
        if self._linear.any():
            offset, slopes = self.residuals(found), self.jacobian(found)[:, self._linear]
            if not (np.isfinite(offset).all() and np.isfinite(slopes).all()):
                return np.full(found.size, math.nan)
            sizes = norms(slopes)
            found[self._linear] = linalg.lstsq(slopes / sizes, -offset)[0] / sizes
        good = np.isfinite(self.residuals(found)).all() and np.isfinite(self.jacobian(found)).all()
        return found if good else np.full(found.size, math.nan)

    def least(self) -> Points:
        """Return the constants of least chi^2 from all starts; ValueError for a law without any."""
        with np.errstate(all="ignore"):
            starts = sorted(self._starts(), key=lambda start: start[0])[:BEST_STARTS]
            if not starts:
                raise ValueError(
                    f"law must have a value at all stretches, got {self._law.text}, which has none "
                    f"from {self._data.stretch[0]:g} to {self._data.stretch[-1]:g} (state another)"
                )
            return min((self._descent(start) for _, start in starts), key=lambda one: one[1])[0]

    def _descent(self, start: Points) -> tuple[Points, float]:
        """Return the constants to which the search from there leads, and their chi^2."""
        if start.size:
            start = optimize.least_squares(
                lambda chosen: self.residuals(self.completed(chosen)),
                start,
                self._projected_jacobian,
                x_scale="jac",
                max_nfev=EVALUATIONS,
                xtol=1e-13,
                ftol=1e-13,
            ).x
        found = self.completed(start)
        return found, float(np.sum(self.residuals(found) ** 2))

    def check_rest(self, constants: Points) -> None:
        """Refuse constants that a further step of least squares moves by part of a deviation."""
        left, slopes = self.residuals(constants), self.jacobian(constants)
        known, _ = linalg.qr(slopes / norms(slopes), mode="economic")
        noise = 1.0
        if self._data.deviation is None:
            noise = float(linalg.norm(left)) / math.sqrt(left.size - constants.size)
        rounding = _rounding(self._data) * float(linalg.norm(np.ones(left.size) * self._weight))
        if not float(linalg.norm(known.T @ left)) <= AT_REST * noise + rounding:
            raise ValueError(
                f"law must have constants of least chi^2, got {self._law.text}, whose constants "
                "still move where the search ends (fix one, or state another law)"
            )

    def _projected_jacobian(self, chosen: Points) -> Points:
        """Return the derivatives of the least residuals by the constants that are searched for."""
        slopes = self.jacobian(self.completed(chosen))
        others = slopes[:, ~self._linear]
        if not self._linear.any():
            return others
        linear = slopes[:, self._linear]
        known, _ = linalg.qr(linear / norms(linear), mode="economic")
        return np.asarray(others - known @ (known.T @ others))

    def _starts(self) -> Iterable[tuple[float, Points]]:
        """Yield constants that enter the law otherwise than linearly, with the least chi^2."""
        reach = float(np.max(np.abs(self._data.stretch)))
        sizes = sorted({scale * reach**power for scale in SCALES for power in (-1, 0, 1)})
        choices = [
            sizes if positive else [sign * size for size in sizes for sign in (1, -1)]
            for positive, linear in zip(self._law.values.positive, self._linear, strict=True)
            if not linear
        ]
        every: Iterable[tuple[float, ...]] = product(*choices)
        if math.prod(map(len, choices)) > MOST_STARTS:
            draw = random.Random(0).choice
            every = [tuple(map(draw, choices)) for _ in range(MOST_STARTS)]
        for chosen in map(np.array, every):
            left = self.residuals(self.completed(chosen))
            if np.isfinite(left).all():
                yield float(left @ left), chosen
