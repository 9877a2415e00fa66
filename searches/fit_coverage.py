"""Coverage of fits of force laws: how often intervals hold, and how often wrong laws are told.

Points of hidden polynomials are made with NumPy alone: evenly spread, one-sided, clustered or
repeated, with noise that is known or not.  Counted are

* how often the 95 % intervals of a stated law hold the hidden constants,
* the same of the intervals of a law that the fit chooses, over the fits that give no warning, and
  how many give one,
* how often a right law is doubted, a law that lacks the fifth power at 3 standard deviations, and a
  right law under noise of which neighbours are correlated by one half,
* errors other than a ValueError in one line, for points of any size, with outliers, without noise.

    python -m searches.fit_coverage [--count 500] [--seed 0] [--only "even, cubic"]

With ``--only``, the experiments whose line begins so, and nothing else.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from longwave.scenes.fits.force_data import ForceData
from longwave.scenes.fits.force_fit import ForceFit, fit_points
from longwave.scenes.fits.force_law import ForceLaw, stated_law

Array = NDArray[np.float64]

HIDDEN = {
    "line": (1.0,),
    "small cubic": (1.0, 0.0, 0.12),
    "cubic": (1.0, 0.0, 2.0),
    "asymmetric": (1.0, 0.3, 0.8),
    "fifth power": (1.0, 0.0, 1.2, 0.0, 3.2),
}
"""Factors of x, x**2, ... of the hidden forces."""

NOISE, REACH = 0.01, 0.5

LAYOUTS = ("even", "one-sided", "clustered", "repeated")

POINTS = (5, 6, 7, 8, 10, 12, 15, 20, 30, 50)

WIDE = 1.959964
"""Standard deviations of a 95 % interval."""

CUBIC = "K2*x + K4*x**3"

HELD = (0.93, 0.97)
"""Shares of intervals that hold."""

TOLD = 0.8
"""Share of laws that lack the fifth power that are to be doubted."""


@dataclass(frozen=True)
class Experiment:
    """Points of a hidden law: where they lie, how many there are, and whether noise is known."""

    hidden: str
    layout: str
    points: int
    known: bool

    @property
    def stretch(self) -> Array:
        """The stretches at which the force is measured."""
        places = np.linspace(-1.0, 1.0, self.points)
        if self.layout == "one-sided":
            places = np.linspace(1.0 / self.points, 1.0, self.points)
        if self.layout == "clustered":
            places = np.sign(places) * np.abs(places) ** 3
        if self.layout == "repeated":
            places = np.repeat(np.linspace(-1.0, 1.0, (self.points + 1) // 2), 2)[: self.points]
        return REACH * places

    @property
    def is_stated(self) -> bool:
        """Whether whoever states the law has points for it: three to spare, and told apart."""
        terms, places = sum(map(bool, HIDDEN[self.hidden])), np.abs(self.stretch)
        is_determined = np.unique(places[places > 0.0]).size >= terms
        return self.points >= terms + 3 and is_determined and self.layout != "clustered"

    def data(self, noise: Array, more: Array | float = 0.0) -> ForceData:
        """Return the points with that noise, in units of its deviation, and further forces."""
        stretch = self.stretch
        force = sum(factor * stretch**p for p, factor in enumerate(HIDDEN[self.hidden], 1))
        deviation = np.full(stretch.size, NOISE) if self.known else None
        return ForceData.of(stretch, force + NOISE * noise + more, deviation)

    def law(self) -> ForceLaw:
        """Return the hidden law, as whoever knows it states it."""
        terms = [f"K{p + 1}*x**{p}" for p, f in enumerate(HIDDEN[self.hidden], 1) if f]
        return _formula(" + ".join(terms))

    def holds(self, fit: ForceFit) -> bool:
        """Return whether the interval of the stiffness at rest, K2, holds the hidden one."""
        place = fit.names.index("K2")
        distance = abs(fit.values[place] - HIDDEN[self.hidden][0])
        return bool(distance <= WIDE * np.sqrt(fit.covariance[place, place]))


def _formula(text: str) -> ForceLaw:
    law = stated_law(text)
    if not isinstance(law, ForceLaw):
        raise TypeError(f"a formula was expected, got {text}")
    return law


def draws(count: int, points: int, seed: int, correlation: float = 0.0) -> Iterator[Array]:
    """Yield normal noise of variance 1, of which neighbours have this correlation."""
    for draw in range(count):
        noise = np.random.default_rng([seed, points, draw]).standard_normal(points)
        for row in range(1, points if correlation else 0):
            fresh = np.sqrt(1.0 - correlation**2) * noise[row]
            noise[row] = correlation * noise[row - 1] + fresh
        yield noise


def coverage(experiment: Experiment, count: int, seed: int, states: bool) -> tuple[float, float]:
    """Return the share of fits without a warning, and of these the share that hold."""
    law = experiment.law() if states else None
    covered = []
    for noise in draws(count, experiment.points, seed):
        fit = fit_points(experiment.data(noise), law)
        if states or not fit.doubts:
            covered.append(experiment.holds(fit))
    return len(covered) / count, float(np.mean(covered)) if covered else np.nan


def missing_term(stretch: Array, size: float) -> Array:
    """Return forces of the fifth power, so many standard deviations of it beside the cubic law."""
    columns = np.column_stack([stretch, stretch**3, stretch**5]) / REACH
    inverse = np.linalg.inv(columns.T @ columns)
    return np.asarray(size * NOISE * np.sqrt(inverse[2, 2]) * columns[:, 2])


def doubted(points: int, known: bool, count: int, seed: int, case: str) -> float:
    """Return the share of cubic fits that are doubted: right, without the fifth power, or with
    correlated noise."""
    experiment, law = Experiment("cubic", "even", points, known), _formula(CUBIC)
    more = missing_term(experiment.stretch, 3.0) if case == "missing" else 0.0
    noises = draws(count, points, seed, 0.5 if case == "correlated" else 0.0)
    return float(np.mean([bool(fit_points(experiment.data(n, more), law).doubts) for n in noises]))


def hostile(seed: int) -> str | None:
    """Fit points that are meant to break the fit; return what went wrong, or None."""
    random = np.random.default_rng([seed, 7])
    points = int(random.integers(4, 30))
    stretch = random.uniform(-1.0, 1.0, points)
    kind = random.integers(5)
    if kind == 1:
        stretch = np.sign(stretch) * np.abs(stretch) ** random.uniform(3, 12)
    if kind == 2:
        stretch = random.choice(stretch[:5], points)
    if kind == 3:
        stretch = 1.0 + 10.0 ** random.uniform(-12, -2) * stretch
    force = stretch + random.normal() * stretch**3
    if kind != 4:
        force = force + 10.0 ** random.uniform(-16, 1) * random.standard_normal(points)
    force = force + 1e6 * (random.uniform(size=points) < 0.05)
    deviation = 10.0 ** random.uniform(-8, 2, points) if random.integers(2) else None
    lengths, forces = 10.0 ** random.uniform(-14, 14, 2)
    law = random.choice(["", "table", "hertz", "K2*x", CUBIC, "a*(exp(b*x) - 1)", "-A/(d + x)**p"])
    order = np.argsort(stretch)
    given = stretch[order] * lengths, force[order] * forces
    try:
        with np.errstate(all="raise", under="ignore"):
            data = ForceData.of(*given, None if deviation is None else deviation * forces)
            fit = fit_points(data, stated_law(str(law) or None))
        whole = np.isfinite(fit.covariance).all() and np.isfinite(fit.values).all()
        messages = fit.doubts + [str(test.p_value) for test in fit.tests]
        return None if whole and "\n" not in "".join(messages) else f"seed {seed}: {law}, {fit!r}"
    except ValueError as error:
        good = "must" in str(error) and "\n" not in str(error)
        return None if good else f"seed {seed}: {law}, {error}"
    except Exception as error:
        return f"seed {seed}: {law}, {type(error).__name__}: {error}"


def main() -> int:
    """Run the experiments and print what they came to."""
    words = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    words.add_argument("--count", type=int, default=500)
    words.add_argument("--seed", type=int, default=0)
    words.add_argument("--only", default="")
    options = words.parse_args()
    bad = 0
    allowed = 3.0 * np.sqrt(0.05 * 0.95 / options.count)
    for layout, hidden, known in product(LAYOUTS, HIDDEN, (True, False)):
        label = f"{layout}, {hidden}, {'known' if known else 'unknown'}"
        if not label.startswith(options.only):
            continue
        print(f"{label}: stated/quiet*chosen:", end="", flush=True)
        for points in POINTS:
            experiment = Experiment(hidden, layout, points, known)
            stated = ""
            if experiment.is_stated:
                _, covered = coverage(experiment, options.count, options.seed, states=True)
                bad += not HELD[0] - allowed <= covered <= HELD[1] + allowed
                stated = f"{100 * covered:.0f}/"
            quiet, covered = coverage(experiment, options.count, options.seed, states=False)
            bad += bool(quiet) and quiet * (1.0 - covered) > 1.0 - HELD[0] + allowed
            chosen = f"{100 * quiet:.0f}*{100 * covered:.0f}" if quiet else "0"
            print(f" {points}: {stated}{chosen}", end="", flush=True)
        print()
    if not options.only:
        bad += residual_tests(options.count, options.seed, allowed)
        broken = [b for s in range(options.seed, options.seed + options.count) if (b := hostile(s))]
        print("\n".join([f"{len(broken)} of {options.count} hostile fits broke", *broken]))
        bad += len(broken)
    return int(bad > 0)


def residual_tests(count: int, seed: int, allowed: float) -> int:
    """Print how often cubic fits are doubted; return how many of the shares are not as promised."""
    bad = 0
    for known, points in product((True, False), (8, 10, 15, 21, 31, 41, 81)):
        shares = {
            case: doubted(points, known, count, seed, case)
            for case in ("right", "missing", "correlated")
        }
        bad += shares["right"] > 0.05 + allowed
        bad += (known or points > 30) and shares["missing"] < TOLD - allowed
        shares_text = ", ".join(f"{case} {100 * share:.0f}" for case, share in shares.items())
        print(f"{points} points, {'known' if known else 'unknown'} noise: % doubted: {shares_text}")
    return bad


if __name__ == "__main__":
    sys.exit(main())
