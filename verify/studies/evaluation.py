"""How exact the evaluation is: worst errors of Y, Y_X, Y_T against mpmath at 60 digits.

The points are given as (site, time, eps), as a lattice run gives them: crests, the smallest values
of each of the three, zeros of Y_T to the last bit of the site, steep slopes, far tails and random
ones. Errors are in units of max(1, |value|). The reference evaluates the canonical expression,
with differences for derivatives, and doubles its digits until two results agree.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from solutions import Wave
from verify.studies.evaluation_cases import FARTHEST_SITE, WaveCase

__all__ = ["PROMISED_ERROR", "Accuracy", "measure_accuracy", "worst_of"]

Array = NDArray[np.float64]

PROMISED_ERROR = 1e-13
"""The promised bound on every error."""

REFERENCE_DIGITS = 60
WIDTHS = (4.0, 60.0)
"""Half-widths, in units of xi, of the places that are searched for points."""

GRID = 2001
BISECTIONS = 60


@dataclass(frozen=True)
class Accuracy:
    """The worst errors of Y, Y_X, Y_T over some points of one wave, and where they occur."""

    name: str
    points: int
    errors: tuple[float, float, float]
    worst: str

    @property
    def passed(self) -> bool:
        """Whether every error is within the promised bound (NaN is not)."""
        return all(error <= PROMISED_ERROR for error in self.errors)

    def json(self) -> dict[str, object]:
        """The record as JSON data."""
        errors = dict(zip(("Y", "Y_X", "Y_T"), self.errors, strict=True))
        return {"wave": self.name, "points": self.points, "errors": errors, "worst": self.worst}


def measure_accuracy(
    case: WaveCase, times: Iterable[float] | None = None, per_time: int = 9, grid: int = GRID
) -> Accuracy:
    """The worst errors of one case at ``per_time`` points for each lattice time.

    ``grid`` sites on either scale around a centre are searched for these points. ``times`` are
    the case's own if None.

    Raises FloatingPointError if NumPy sees an overflow, a division by zero or a NaN.
    """
    wave, eps = case.wave(), float(case.eps)
    rng = np.random.default_rng(1)
    worst, where, count = np.zeros(3), "", 0
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for t in case.times if times is None else times:
            for n in sample_sites(wave, t, eps, rng, grid)[:per_time]:
                errors = errors_at(wave, n, t, eps)
                if not np.max(errors) <= np.max(worst):
                    where = f"{case} n = {n!r}, t = {t:.12g}".strip()
                worst = np.maximum(worst, errors)
                count += 1
    return Accuracy(case.name, count, _three(worst), where)


def sample_sites(
    wave: Wave, t: float, eps: float, rng: np.random.Generator, grid: int
) -> list[float]:
    """A zero of Y_T, the smallest of |Y_X| and |Y|, crest, steepest slope, random and far sites.

    They are found on a grid around every place where a phase of the wave vanishes.
    """
    rate = float(wave.normal_form.a) * eps
    centre = float(wave.normal_form.c) * t
    places = [z for z in wave.phase_zeros(t, eps) if abs(z) <= 2 * FARTHEST_SITE]
    centres = [centre, *places]
    sharpest = max(1.0, *(abs(float(value)) for value in wave.parameters.values()), 1.0)
    widths = [width / rate / scale for width in WIDTHS for scale in {1.0, sharpest}]
    offsets = np.concatenate([width * np.linspace(-1, 1, grid) for width in widths])
    sites = np.concatenate([place + offsets for place in centres])
    found = [np.abs(part) for part in wave.at(sites, t, eps)]
    zero = _last_zero(wave, t, eps, np.sort(sites))
    chosen = (np.argmin(found[1]), np.argmax(found[2]), np.argmin(found[0]), np.argmax(found[0]))
    near = float(rng.choice(sites))
    scattered = near, float(round(near)), centre + float(rng.normal(scale=1e3 / rate))
    far = FARTHEST_SITE * (-1.0) ** rng.integers(2)
    return [zero, *(float(sites[i]) for i in chosen), *scattered, float(far)]


def _last_zero(wave: Wave, t: float, eps: float, sites: Array) -> float:
    """The site, to the last bit, at which Y_T changes its sign; the smallest |Y_T| if none does."""
    rates = wave.at(sites, t, eps).Y_T
    turns = np.flatnonzero(rates[1:] * np.sign(rates[:-1]) < 0)
    if turns.size == 0:
        return float(sites[np.argmin(abs(rates))])
    turn = turns[turns.size // 2]
    low, high, sign = float(sites[turn]), float(sites[turn + 1]), np.sign(rates[turn])
    for _ in range(BISECTIONS):
        middle = low + (high - low) / 2
        if np.sign(wave.at(middle, t, eps).Y_T) == sign:
            low = middle
        else:
            high = middle
    return low


def errors_at(wave: Wave, n: float, t: float, eps: float) -> Array:
    """The errors of Y, Y_X, Y_T at one site and time, in units of max(1, |value|)."""
    exact = wave.mp_at(n, t, eps, REFERENCE_DIGITS)
    found = [float(part) for part in wave.at(n, t, eps)]
    pairs = zip(found, exact, strict=True)
    return np.array([float(abs(v - r) / max(1, abs(r))) for v, r in pairs])


def worst_of(results: Iterable[Accuracy]) -> Accuracy:
    """The cases of one wave in one record."""
    all_results = list(results)
    top = max(all_results, key=lambda result: max(result.errors))
    errors = np.max([result.errors for result in all_results], axis=0)
    count = sum(result.points for result in all_results)
    return Accuracy(top.name, count, _three(errors), top.worst)


def _three(errors: Array) -> tuple[float, float, float]:
    return float(errors[0]), float(errors[1]), float(errors[2])
