"""Synthetic experiments: hidden laws and losses, noisy sensors, and whether intervals hold.

A chain with a hidden law is struck; SciPy's DOP853 is given its equations as they are written here,
and makes what sensors read, to which noise is added. The scene is fitted from values that are off
by up to a tenth. Counted are

* how often the 95 % interval of a crest that the fit predicts for another run, struck harder and
  elsewhere, holds what DOP853 finds with the hidden constants,
* how often a scene that lacks a term of the hidden law, or its loss, is doubted, and a right one,
* by how much estimates of repeated experiments scatter, in units of the bound of Cramer and Rao,
  which is taken from differences of DOP853's readings.

    python -m searches.synthetic_experiments [--count 1000] [--wrong 200] [--repeated 50] [--seed 0]
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from longwave.derive.intervals import HALF_WIDTH
from longwave.lattice.sensitivities import Sensor
from longwave.scenes.description.scene import Scene
from longwave.scenes.fits.scene_fit import SceneFit, SceneModel, fit_scene
from longwave.scenes.fits.sensor_records import SensorRecord

Array = NDArray[np.float64]

NAMES = ("K2", "K3", "K4", "losses.site", "losses.bond")

TIMES: Array = 0.8 * np.arange(1.0, 11.0)
"""Of the readings."""

CREST_TIMES: Array = 0.4 * np.arange(1.0, 21.0)

SENSORS = 6

OFF = 0.1
"""By which share the values are off from which fits start."""

REPEATS = 8

FREE = {
    "cubic chain": ("K2", "K4", "losses.site"),
    "quadratic chain": ("K2", "K3", "K4"),
    "chain with dashpots": ("K2", "K4", "losses.bond"),
    "hidden cubic force": ("K2", "losses.site"),
    "hidden loss": ("K2", "K4"),
    "hidden dashpots": ("K2", "K4", "losses.site"),
}
"""What is fitted, by what the hidden chain is."""

RIGHT, WRONG = tuple(FREE)[:3], tuple(FREE)[3:]


@dataclass(frozen=True)
class Experiment:
    """A hidden chain, how it is struck, its sensors and their noise."""

    kind: str
    hidden: tuple[float, ...]
    cells: int
    struck: int
    velocity: float
    sensors: tuple[Sensor, ...]
    noise: tuple[float, ...]
    seed: int

    @classmethod
    def drawn(cls, kind: str, seed: int) -> Experiment:
        """Return the experiment of that seed; noise is 0.5 to 3 % of a sensor's largest reading."""
        random = np.random.default_rng([seed, list(FREE).index(kind)])
        K2, K4, site = random.uniform(0.7, 1.4), random.uniform(0.5, 2.0), random.uniform(0.02, 0.1)
        hidden = {
            "cubic chain": (K2, 0.0, K4, site, 0.0),
            "quadratic chain": (K2, random.uniform(0.3, 0.8), K4, 0.0, 0.0),
            "chain with dashpots": (K2, 0.0, K4, 0.0, site),
            "hidden cubic force": (K2, 0.0, K4, site, 0.0),
            "hidden loss": (K2, 0.0, K4, site, 0.0),
            "hidden dashpots": (K2, 0.0, K4, site, random.uniform(0.02, 0.1)),
        }[kind]
        cells = int(random.integers(8, 13))
        places = random.choice(cells, size=SENSORS, replace=False)
        quantities = random.choice(["displacement", "velocity", "strain"], size=SENSORS)
        experiment = cls(
            kind,
            tuple(map(float, hidden)),
            cells,
            int(random.integers(1, cells - 1)),
            float(random.uniform(0.5, 0.9)),
            tuple(Sensor(str(q), 0, int(p)) for q, p in zip(quantities, places, strict=True)),
            (),
            seed,
        )
        size = np.abs(experiment.exact).max(axis=0) * random.uniform(0.005, 0.03, size=SENSORS)
        return replace(experiment, noise=tuple(size.tolist()))

    def read(self, hidden: tuple[float, ...], times: Array, sensors: tuple[Sensor, ...]) -> Array:
        """Return the sensors' readings with these constants, (times, sensors), by DOP853."""
        K2, K3, K4, site, bond = hidden

        def slopes(_: float, state: Array) -> Array:
            u, v = state[: self.cells], state[self.cells :]
            x = np.diff(u, prepend=0.0, append=0.0)
            rate = np.diff(v, prepend=0.0, append=0.0)
            force = x * (K2 + x * (K3 + x * K4)) + bond * rate
            return np.concatenate([v, np.diff(force) - site * v])

        start = np.zeros(2 * self.cells)
        start[self.cells + self.struck] = self.velocity
        words = {"rtol": 1e-9, "atol": 1e-10, "t_eval": times}
        found = solve_ivp(slopes, (0.0, float(times[-1])), start, method="DOP853", **words).y
        u, v = found[: self.cells], found[self.cells :]
        strain = np.diff(u, axis=0, append=0.0)
        readings = {"displacement": u, "velocity": v, "strain": strain}
        return np.array([readings[one.quantity][one.cell] for one in sensors]).T

    @cached_property
    def exact(self) -> Array:
        """Readings of the sensors without noise."""
        return self.read(self.hidden, TIMES, self.sensors)

    def record(self, draw: int = 0) -> SensorRecord:
        """Return the readings with noise."""
        normal = np.random.default_rng([self.seed, draw, 1]).standard_normal(self.exact.shape)
        deviations = np.broadcast_to(self.noise, self.exact.shape)
        return SensorRecord(TIMES, self.sensors, self.exact + normal * deviations, deviations)

    def scene(self, values: tuple[float, ...]) -> Scene:
        """Return the scene for the fit: these values, and the exact ones of the rest.

        What is hidden of a wrong one is not there.
        """
        known = dict(zip(NAMES, self.hidden, strict=True))
        if self.kind in WRONG:
            known = dict.fromkeys(NAMES, 0.0)
        known |= dict(zip(FREE[self.kind], values, strict=True))
        return Scene.of(
            name=f"experiment_{self.seed}",
            lattice="fput",
            constants={name: known[name] for name in NAMES[:3]},
            times=(0.0, float(TIMES[-1])),
            tolerance=0.02 * min(self.noise),
            chain={"sites": self.cells},
            start={"impact": {"site": self.struck, "velocity": self.velocity}},
            losses={"site": known["losses.site"], "bond": known["losses.bond"]},
        )

    @property
    def truth(self) -> tuple[float, ...]:
        """The hidden values of what is fitted."""
        hidden = dict(zip(NAMES, self.hidden, strict=True))
        return tuple(hidden[name] for name in FREE[self.kind])

    def fitted(self) -> SceneFit:
        """Fit the constants, from wrong initial values."""
        random = np.random.default_rng([self.seed, 2])
        off = np.array(self.truth) * random.uniform(1 - OFF, 1 + OFF, len(self.truth))
        return fit_scene(self.scene(tuple(off.tolist())), [self.record()], FREE[self.kind])

    def elsewhere(self) -> Experiment:
        """Return the predicted run: struck at the mirror cell, a fifth harder."""
        mirrored, harder = self.cells - 1 - self.struck, 1.2 * self.velocity
        return replace(self, struck=mirrored, velocity=harder)


def crest_apart(experiment: Experiment, fit: SceneFit) -> float:
    """Return the predicted crest less the true one, in its standard deviations.

    The crest is the largest size of the strain in the middle of the chain.
    """
    other = experiment.elsewhere()
    sensor = (Sensor("strain", 0, other.cells // 2),)
    true = np.abs(other.read(other.hidden, CREST_TIMES, sensor)).max()
    model = SceneModel(other.scene(tuple(fit.values.tolist())), FREE[experiment.kind])
    read = model.readings(fit.values, CREST_TIMES, sensor, fit.step)[:, 0]
    value, *slopes = read[np.argmax(np.abs(read[:, 0]))]
    deviation = np.sqrt(slopes @ fit.covariance @ slopes)
    return float((abs(value) - true) / deviation)


def scatter(experiment: Experiment) -> Array:
    """Return root mean squares of errors of repeated fits, over the bounds of Cramer and Rao."""
    free, truth = FREE[experiment.kind], np.array(experiment.truth)
    columns = []
    for name in free:
        place, size = NAMES.index(name), 1e-4
        ends = []
        for sign in (1, -1):
            moved = list(experiment.hidden)
            moved[place] += sign * size
            ends.append(experiment.read(tuple(moved), TIMES, experiment.sensors))
        columns.append(((ends[0] - ends[1]) / (2 * size) / experiment.noise).ravel())
    information = np.array(columns) @ np.array(columns).T
    bound = np.sqrt(np.diag(np.linalg.inv(information)))
    scene = experiment.scene(experiment.truth)
    errors = [
        fit_scene(scene, [experiment.record(draw)], free).values - truth for draw in range(REPEATS)
    ]
    return np.asarray(np.sqrt(np.mean(np.square(errors), axis=0)) / bound)


def main() -> int:
    """Run the experiments and print what they came to."""
    words = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    for name, count in (("count", 1000), ("wrong", 200), ("repeated", 50), ("seed", 0)):
        words.add_argument(f"--{name}", type=int, default=count)
    options = words.parse_args()
    covered, doubted, spread = 0, 0, []
    for seed in range(options.seed, options.seed + options.count):
        experiment = Experiment.drawn(RIGHT[seed % len(RIGHT)], seed)
        fit = experiment.fitted()
        deviation = crest_apart(experiment, fit)
        spread.append(deviation)
        covered += abs(deviation) <= HALF_WIDTH
        doubted += _is_doubted(fit)
        if abs(deviation) > 2.5 * HALF_WIDTH:
            print(f"seed {seed}: {experiment.kind}, crest off by {deviation:.1f}", flush=True)
    share, root = covered / options.count, float(np.sqrt(np.mean(np.square(spread))))
    print(
        f"{options.count} right scenes: the interval of the crest holds it in {100 * share:.1f} %, "
        f"errors {root:.3f} of their deviation; doubted {100 * doubted / options.count:.1f} %",
        flush=True,
    )
    found = []
    for place, kind in enumerate(WRONG):
        seeds = range(options.seed + place, options.seed + options.wrong, len(WRONG))
        hits = [_is_doubted(Experiment.drawn(kind, seed).fitted()) for seed in seeds]
        found += hits
        print(f"{len(hits)} scenes with a {kind}: {100 * np.mean(hits):.1f} % doubted", flush=True)
    drawn = [Experiment.drawn(RIGHT[s % len(RIGHT)], s) for s in range(options.repeated)]
    ratios = np.array([scatter(experiment) for experiment in drawn]).ravel()
    print(
        f"{options.repeated} experiments, each {REPEATS} times: scatter "
        f"{np.sqrt(np.mean(ratios**2)):.3f} of the bound, at most {ratios.max():.2f}"
    )
    good = 0.93 <= share <= 0.97 and np.mean(found) >= 0.9 and ratios.max() <= 2.0
    return int(not good)


def _is_doubted(fit: SceneFit) -> bool:
    return any("differs from" in doubt or "correlated" in doubt for doubt in fit.doubts)


if __name__ == "__main__":
    sys.exit(main())
