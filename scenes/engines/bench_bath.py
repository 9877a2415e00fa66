"""A chain in a bath: means over runs, each with noise of its own, and how well these are known.

A step of the chain without losses lies between two halves of what the bath does to velocities,
``v -> a v + sqrt(T (1 - a^2) / m) xi`` with ``a = exp(-g h / (2 m))``. Both leave a chain of the
bath's temperature as it is. Each run is made twice, with steps h and h / 2 and the same noise: the
means are of the finer, and a third of its difference from the coarser tells what its steps cost.
"""

from __future__ import annotations

import math
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

from longwave.lattice.state import State
from longwave.scenes.description.bench import OF_MEANS
from longwave.scenes.engines.bench_readings import BenchReadings, chain_of
from longwave.support.checkpoint import begin_loop
from longwave.support.request_limits import ExpectedCost, check_request

if TYPE_CHECKING:
    from longwave.lattice.driving import DrivenChain
    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress
    from longwave.scenes.description.bench import Bench
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.engines.run_record import RunRecord

Array = NDArray[np.float64]

FIRST_RUNS, MOST_RUNS = 64, 100_000
"""Few runs that are small by chance are spread little, too: of 95 % intervals at which runs stopped
after 8 or more, 86 of 100 held for energies of modes, which are spread like exponentials."""

CONFIDENCE, NOMINAL = 0.95, 0.97
"""Of the interval of each mean, and of Student's that is taken for it: after 64 runs or more those
of 0.95 held in 92 to 94 of 100 for such energies, these in 93 to 97."""

LONGEST_STEP = 0.5
"""In units of the inverse highest frequency, and of the inverse rate at which velocities shrink."""

MOST_TURNED = 2.0
"""A step that is so many times longer than one about what runs have met is shortened."""

HOT = 4.0
"""The energy of a bond, in units of the temperature, up to which the first step follows it."""

MEETINGS = 8
"""Steps between two looks at what a run meets: each takes a third of a step's time on 8 cells."""

CURE, MOST_CURED = 0.25, 4
"""Factor on the step after a run that broke down, and how often in turn it is taken before the
chain is said to fly apart."""

CERTAIN = 3.0
"""Standard errors beyond which a difference is not by chance."""

SPARE = 1.1
"""Runs beyond those that the spread of the first asks for."""


class BrokenRunError(ArithmeticError):
    """A run whose fields are no numbers at the time ``t``."""

    def __init__(self, t: float) -> None:
        super().__init__(t)
        self.t = t


class Bath:
    """Runs of a chain in its bath, whose step follows what they meet."""

    def __init__(self, scene: Scene, bench: Bench, chain: DrivenChain) -> None:
        assert bench.noise is not None
        self.noise, self.cells = bench.noise, bench.sites
        self.readings = BenchReadings(scene, *chain_of(scene, lossless=True))
        self.engine, self.chain = self.readings.engine, self.readings.chain
        self.masses = self.chain.cell_masses[:, : self.cells]
        losses = np.array(chain.losses) * np.array(chain.masses)
        self.rates = losses[:, np.newaxis] / self.masses
        highest = max(self.engine.first_frequency, float(self.rates.max()))
        self.step = min(LONGEST_STEP / highest, self.engine.first().step)
        self.steps = self.cured = 0
        self.ranges = self._warm_ranges()
        warm = LONGEST_STEP / self.engine.dynamics.highest_frequency(self.ranges)
        self.step = warm if self.step > MOST_TURNED * warm else self.step

    def _warm_ranges(self) -> Array:
        """The ranges at the start, widened to where bonds store as much as a bath gives them."""
        found = self.engine.dynamics.ranges(self.engine.state)
        sizes = np.geomspace(1e-12, 1e12, 481)
        for row, bond in zip(found, self.chain.bonds, strict=False):
            for end, sign in enumerate((-1.0, 1.0)):
                with np.errstate(all="ignore"):
                    stored = bond.force.potential(sign * sizes)
                few = (stored >= 0.0) & (stored < HOT * self.noise.temperature)
                whole = int(np.argmin(few)) if not few.all() else 0
                if whole and stored[whole] >= 0.0:
                    row[end] += sign * sizes[whole - 1]
        return found

    def followed_pair(self, number: int) -> tuple[Array, Array] | None:
        """That `pair`; None if the step had to be shortened, with which all runs begin anew."""
        try:
            made = self.pair(number)
        except BrokenRunError as error:
            self.has_shortened_step(error)
            return None
        return None if self.has_shortened_step(None) else made

    def has_shortened_step(self, broken: BrokenRunError | None) -> bool:
        """Shorten the step where runs broke down, or met faster waves than it can follow.

        Raises ValueError where shorter and shorter steps did not help.
        """
        longest = LONGEST_STEP / self.engine.dynamics.highest_frequency(self.ranges)
        if broken is None and self.step <= MOST_TURNED * longest:
            return False
        if broken is not None or longest < CURE * self.step:
            self.cured += 1
        if self.cured > MOST_CURED:
            t = self.readings.times[-1] if broken is None else broken.t
            raise ValueError(
                f"times must end before the chain flies apart, got {t:g} (as with longer steps, "
                f"with those of {self.step:.2g}; end earlier, or a lower temperature)"
            )
        self.step *= CURE if broken is not None else max(CURE, longest / self.step)
        self.ranges = self._warm_ranges()
        return True

    def _meet(self, f: Array, v: Array, t: float) -> None:
        """Note the strains of a state."""
        met = self.engine.dynamics.ranges(State(t, f, v))
        if not np.isfinite(met).all():
            raise BrokenRunError(t)
        self.ranges[:, 0] = np.minimum(self.ranges[:, 0], met[:, 0])
        self.ranges[:, 1] = np.maximum(self.ranges[:, 1], met[:, 1])

    def pair(self, number: int) -> tuple[Array, Array]:
        """What is watched at all times, (times, values), in that run's coarse and fine version.

        Raises BrokenRunError where fields are no numbers.
        """
        random = np.random.default_rng([self.noise.seed, number])
        start, engine = self.engine.state, self.engine
        coarse, fine = ((start.f.copy(), start.v.copy()) for _ in range(2))
        read: list[tuple[Array, Array]] = []
        t, times = start.t, set(self.readings.times.tolist())
        for end in engine.stops.tolist():
            count = math.ceil((end - t) / self.step - 1e-9)
            h = (end - t) / max(count, 1)
            kept = np.exp(-0.25 * h * self.rates)
            size = np.sqrt(self.noise.temperature * (1.0 - kept**2) / self.masses)
            for place in range(count):
                kicks = size * random.standard_normal((4, *size.shape))
                self._advance(coarse, kept, kicks, ((0, 1), (2, 3)), t + place * h, h)
                self._advance(fine, kept, kicks, ((0,), (1, 2), (3,)), t + place * h, 0.5 * h)
                if place % MEETINGS == MEETINGS - 1:
                    self._meet(*coarse, t + (place + 1) * h)
            self.steps += count
            t = end
            self._meet(*fine, t)
            if t in times:
                pair = (self.readings.read(State(t, *ring)) for ring in (coarse, fine))
                read.append(tuple(pair))  # type: ignore[arg-type]
        return tuple(np.array(values) for values in zip(*read, strict=True))  # type: ignore[return-value]

    def _advance(
        self,
        ring: tuple[Array, Array],
        kept: Array,
        kicks: Array,
        parts: tuple[tuple[int, ...], ...],
        t: float,
        h: float,
    ) -> None:
        """A step, or two, between the quarters of the noise of a coarse one."""
        f, v = ring
        moving = v[:, : self.cells]
        for place, quarters in enumerate(parts):
            if place:
                begin = t + (place - 1) * h
                self.engine.dynamics.advance(self.engine.scheme, f, v, h, 1, begin)
            for quarter in quarters:
                moving *= kept
                moving += kicks[quarter]


class Means:
    """Means of values and of their differences over runs, and how far single runs lie from them."""

    def __init__(self) -> None:
        self.runs = 0
        self._mean: Array = np.zeros(())
        self._squares: Array = np.zeros(())

    def add(self, coarse: Array, fine: Array) -> None:
        """One run more."""
        values = np.array([fine, coarse - fine])
        self.runs += 1
        before = values - self._mean
        self._mean = self._mean + before / self.runs
        self._squares = self._squares + before * (values - self._mean)

    @property
    def mean(self) -> Array:
        """Of the finer runs."""
        return np.asarray(self._mean[0])

    @property
    def spread(self) -> Array:
        """The standard deviation of a run."""
        return np.asarray(np.sqrt(self._squares[0] / (self.runs - 1)))

    @property
    def by_chance(self) -> Array:
        """Half the interval of each mean."""
        quantile = student.ppf(0.5 * (1.0 + NOMINAL), self.runs - 1)
        return np.asarray(quantile * self.spread / math.sqrt(self.runs))

    @property
    def by_steps(self) -> Array:
        """What steps cost the finer runs, of order 2."""
        return np.asarray(np.abs(self._mean[1]) / 3.0)

    def asks_for_shorter_steps(self, allowed: float) -> bool:
        """Whether steps cost more than half of what is allowed, and not by chance."""
        chance = np.sqrt(self._squares[1] / (self.runs - 1) / self.runs)
        told = np.abs(self._mean[1]) > CERTAIN * chance
        return bool((told & (self.by_steps > 0.5 * allowed)).any())


def record_means(
    scene: Scene, bench: Bench, chain: DrivenChain, progress: Progress, announce: Announce
) -> RunRecord:
    """Run until the interval of each mean is within the tolerance.

    Raises ValueError in one line for a chain that flies apart and OverBudgetError for what would
    take too long.
    """
    loop, allowed = begin_loop("means of a bath"), scene.target.tolerance
    bath, means, wanted = Bath(scene, bench, chain), Means(), FIRST_RUNS
    assert allowed is not None
    if loop.memory is not None:
        bath.step, bath.steps, wanted = (loop.memory[name] for name in ("step", "steps", "wanted"))
        vars(means).update(loop.memory["means"])
    last = perf_counter()
    while True:
        while means.runs < wanted:
            last = perf_counter()
            made = bath.followed_pair(means.runs)
            if made is None:
                means, wanted = Means(), FIRST_RUNS
                continue
            means.add(*made)
            progress(means.runs / wanted)
            kept = {"step": bath.step, "steps": bath.steps, "wanted": wanted, "means": vars(means)}
            loop.offer(kept.copy)
        chance, steps = float(means.by_chance.max()), float(means.by_steps.max())
        if float((means.by_chance + means.by_steps).max()) <= allowed:
            break
        halved = means.asks_for_shorter_steps(allowed)
        needed = SPARE * (chance / (allowed - min(steps, 0.5 * allowed))) ** 2 * means.runs
        if needed > MOST_RUNS:
            raise ValueError(
                f"tolerance must be one that {MOST_RUNS} runs reach, got {allowed:g} (after "
                f"{means.runs} runs the means are known to {chance:.1g}; a larger one)"
            )
        each = (perf_counter() - last) * (2.0 if halved else 1.0)
        remaining = ExpectedCost(seconds=each * max(needed - means.runs * (not halved), FIRST_RUNS))
        check_request(scene.name, remaining, "a larger tolerance, or end earlier")
        announce(remaining.seconds)
        if halved:
            bath.step, means, wanted = 0.5 * bath.step, Means(), FIRST_RUNS
        else:
            wanted = max(means.runs + 1, math.ceil(min(needed, 4.0 * means.runs)))
    error, spread = OF_MEANS
    half, told = means.by_chance + means.by_steps, f"half of the {CONFIDENCE:.0%} interval of the "
    variables = bath.readings.variables(means.mean, meaning="mean ")
    variables |= bath.readings.variables(half, error, f"{told}mean ")
    variables |= bath.readings.variables(means.spread, spread, "standard deviation, a run's, of ")
    record = bath.readings.record(variables, bath.steps, perf_counter() - loop.begun)
    record.attrs |= {
        "tolerance": allowed,
        "error_estimate": float(half.max()),
        "step_error": float(means.by_steps.max()),
        "runs": means.runs,
        "next_decade": 100.0,
        "planning_seconds": 0.0,
    }
    return record
