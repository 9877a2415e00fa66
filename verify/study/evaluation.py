"""How exact the evaluation is: worst errors of Y, Y_X, Y_T against mpmath at 60 digits.

The points are given as (site, time, eps), as a lattice run gives them: where double is worst, on
crests, at zeros, on steep slopes, at random, and as far as |X| = 1e6 and |T| = 1e4. Errors are in
units of max(1, |value|).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import sympy as sp
from numpy.typing import NDArray

from solutions import Wave
from verify.study.evaluation_cases import Case

__all__ = ["TOLERANCE", "Accuracy", "measure", "worst_of"]

Array = NDArray[np.float64]

TOLERANCE = 1e-13
"""The promised bound on every error."""

REFERENCE_DIGITS = 60
EPS = 0.05
TIMES = (0, 2960, 800_000, 80_000_000, -80_000_000)
"""Lattice times: T = 0, 0.37, 100, 1e4 and -1e4."""

FARTHEST = 1e6
HALF_WIDTHS = (4.0, 60.0)
GRID = 6001


@dataclass(frozen=True)
class Accuracy:
    """The worst errors of Y, Y_X, Y_T over some points of one wave, and where they occur."""

    name: str
    precisions: tuple[str, ...]
    points: int
    errors: tuple[float, float, float]
    worst: str

    @property
    def passed(self) -> bool:
        """Whether every error is within the promised bound (NaN is not)."""
        return all(error <= TOLERANCE for error in self.errors)

    def json(self) -> dict[str, object]:
        """The record as JSON data."""
        errors = dict(zip(("Y", "Y_X", "Y_T"), self.errors, strict=True))
        return {
            "wave": self.name, "precisions": list(self.precisions), "points": self.points,
            "errors": errors, "worst": self.worst,
        }  # fmt: skip


def measure(
    case: Case,
    times: Iterable[int] = TIMES,
    per_time: int = 9,
    precision: str | None = None,
    grid: int = GRID,
) -> Accuracy:
    """The worst errors of one case at ``per_time`` points for each lattice time.

    ``grid`` sites on either scale around a centre are searched for these points.

    Raises FloatingPointError if NumPy sees an overflow, a division by zero or a NaN.
    """
    wave = case.wave(precision)
    rng = np.random.default_rng(1)
    worst, where, count = np.zeros(3), "", 0
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for t in times:
            for n in sample_sites(wave, t, rng, grid)[:per_time]:
                errors = errors_at(wave, n, t)
                if not np.max(errors) <= np.max(worst):
                    where = f"{case} n = {n!r}, t = {t}".strip()
                worst = np.maximum(worst, errors)
                count += 1
    return Accuracy(case.name, (wave.precision,), count, _three(worst), where)


def sample_sites(wave: Wave, t: int, rng: np.random.Generator, grid: int) -> list[float]:
    """The worst sites for double, crest, zero, steepest slope, farthest X, and random sites.

    The worst are found by setting double beside double-double on a dense grid around every place
    where a phase of the wave vanishes.
    """
    centres = [float(wave.normal_form.c) * t, *wave.phase_zeros(t, EPS)]
    offsets = [width / EPS * np.linspace(-1, 1, grid) for width in HALF_WIDTHS]
    sites = np.concatenate([centre + offset for centre in centres for offset in offsets])
    cheap = Wave(wave.form, wave.normal_form, precision="double", **_by_name(wave))
    found, exact = cheap.at(sites, t, EPS), wave.pairs_at(sites, t, EPS)
    worst = [abs(v - r[0]) / np.maximum(1, abs(r[0])) for v, r in zip(found, exact, strict=True)]
    values = abs(exact.Y[0])
    special = (*map(np.argmax, worst), np.argmax(values), np.argmin(values))
    steepest = np.argmax(abs(exact.Y_X[0]))
    far = centres[0] + FARTHEST / EPS * (-1.0) ** rng.integers(2)
    scattered = [float(rng.choice(sites)), centres[0] + float(rng.normal(scale=1e3 / EPS))]
    return [*(float(sites[i]) for i in (*special, steepest)), float(far), *scattered]


def _by_name(wave: Wave) -> dict[str, object]:
    return {str(symbol): value for symbol, value in wave.parameters.items()}


def errors_at(wave: Wave, n: float, t: int) -> Array:
    """The errors of Y, Y_X, Y_T at one site and time, in units of max(1, |value|)."""
    eps, speed = Fraction(str(EPS)), Fraction(sp.Rational(wave.normal_form.c).p)
    exact = wave.mp(eps * (Fraction(n) - speed * t), eps**3 * t, REFERENCE_DIGITS)
    found = [float(part) for part in wave.at(n, t, EPS)]
    pairs = zip(found, exact, strict=True)
    return np.array([float(abs(v - r) / max(1, abs(r))) for v, r in pairs])


def worst_of(results: Iterable[Accuracy]) -> Accuracy:
    """The cases of one wave in one record."""
    all_results = list(results)
    top = max(all_results, key=lambda result: max(result.errors))
    errors = np.max([result.errors for result in all_results], axis=0)
    precisions = {precision for result in all_results for precision in result.precisions}
    count = sum(result.points for result in all_results)
    return Accuracy(top.name, tuple(sorted(precisions)), count, _three(errors), top.worst)


def _three(errors: Array) -> tuple[float, float, float]:
    return float(errors[0]), float(errors[1]), float(errors[2])
