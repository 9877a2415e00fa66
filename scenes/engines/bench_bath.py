"""Ensemble means of a chain in a heat bath, with confidence intervals and step-size errors.

Each step h of the lossless chain lies between two half-steps of an Ornstein-Uhlenbeck process,
``v -> a v + sqrt(T (1 - a^2) / m) xi`` with ``a = exp(-g h / (2 m))``. These half-steps, like the
chain's exact flow, preserve thermal equilibrium at temperature T. Each run is computed twice, with
steps h and h / 2 and the same noise. The means are taken over the finer runs; a third of the
difference between the two estimates the finer run's step-size error.
"""

import math
from time import perf_counter

import numpy as np
from scipy.stats import t as student

from longwave.lattice.driving import DrivenChain
from longwave.lattice.refine import Announce
from longwave.lattice.state import State
from longwave.lattice.trial import Progress
from longwave.scenes.description.bench import MEAN_SUFFIXES, Bench
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.bench_readings import BenchReadings, bench_and_chain
from longwave.scenes.engines.run_record import RunRecord
from longwave.support.checkpoint import begin_loop
from longwave.support.real_arrays import Array
from longwave.support.request_limits import ExpectedCost, check_request

FIRST_RUNS, MOST_RUNS = 64, 100_000
"""Minimum and maximum number of runs. The minimum keeps the intervals honest: a small sample that
is low by chance also has a small spread. With a minimum of 8 runs only 86 of 100 intervals of 95 %
contained the true mean energy of a mode, which is distributed exponentially."""

CONFIDENCE, QUANTILE_CONFIDENCE = 0.95, 0.97
"""Stated confidence of each interval, and the larger one used for Student's quantile. After 64 runs
or more, intervals of 0.95 contained the true mode energy in 92 to 94 of 100 cases, intervals of
0.97 in 93 to 97."""

LONGEST_STEP = 0.5
"""Longest step, in units of the inverse highest frequency or damping rate, whichever is shorter."""

MAX_STEP_EXCESS = 2.0
"""Factor by which a step may exceed `LONGEST_STEP`, at the strains met, without being shortened."""

HOT_BOND_ENERGY = 4.0
"""Bond energy, in units of the temperature, up to which the first step resolves the bond."""

CHECK_INTERVAL = 8
"""Steps between two checks of the strains; on 8 cells a check takes a third of a step's time."""

STEP_REDUCTION, MOST_REDUCTIONS = 0.25, 4
"""Factor on the step after a breakdown, and maximum number of step reductions."""

SIGNIFICANT_ERRORS = 3.0
"""Number of standard errors beyond which a difference is significant."""

RUNS_SAFETY = 1.1
"""Safety factor on the number of runs predicted from the spread so far."""


class BrokenRunError(ArithmeticError):
    """Error raised when a run's fields are no longer finite at time ``t``."""

    def __init__(self, t: float) -> None:
        super().__init__(t)
        self.t = t


class Bath:
    """Runs of a chain in a heat bath, with a step adapted to the strains met."""

    def __init__(self, scene: Scene, bench: Bench, chain: DrivenChain) -> None:
        assert bench.noise is not None
        self.noise, self.cells = bench.noise, bench.sites
        self.readings = BenchReadings(scene, *bench_and_chain(scene, lossless=True))
        self.engine, self.chain = self.readings.engine, self.readings.chain
        self.masses = self.chain.cell_masses[:, : self.cells]
        losses = np.array(chain.losses) * np.array(chain.masses)
        self.rates = losses[:, np.newaxis] / self.masses
        highest = max(self.engine.first_frequency, float(self.rates.max()))
        self.step = min(LONGEST_STEP / highest, self.engine.first().step)
        self.steps = self.reductions = 0
        self.ranges = self._warm_ranges()
        warm = LONGEST_STEP / self.engine.dynamics.highest_frequency(self.ranges)
        self.step = warm if self.step > MAX_STEP_EXCESS * warm else self.step

    def _warm_ranges(self) -> Array:
        """Return the initial strain ranges, widened to the bond energies expected in the bath."""
        ranges = self.engine.dynamics.ranges(self.engine.state)
        sizes = np.geomspace(1e-12, 1e12, 481)
        for row, bond in zip(ranges, self.chain.bonds, strict=False):
            for end, sign in enumerate((-1.0, 1.0)):
                with np.errstate(all="ignore"):
                    stored = bond.force.potential(sign * sizes)
                few = (stored >= 0.0) & (stored < HOT_BOND_ENERGY * self.noise.temperature)
                whole = int(np.argmin(few)) if not few.all() else 0
                if whole and stored[whole] >= 0.0:
                    row[end] += sign * sizes[whole - 1]
        return ranges

    def pair_if_resolved(self, number: int) -> tuple[Array, Array] | None:
        """Return `pair` of run ``number``; None if the step was shortened and all runs restart."""
        try:
            values = self.pair(number)
        except BrokenRunError as error:
            self.shorten_step(error)
            return None
        return None if self.shorten_step(None) else values

    def shorten_step(self, broken: BrokenRunError | None) -> bool:
        """Shorten the step if a run is ``broken`` or it is too long; return whether it changed.

        Raises ValueError if repeated shortening fails.
        """
        longest = LONGEST_STEP / self.engine.dynamics.highest_frequency(self.ranges)
        if broken is None and self.step <= MAX_STEP_EXCESS * longest:
            return False
        if broken is not None or longest < STEP_REDUCTION * self.step:
            self.reductions += 1
        if self.reductions > MOST_REDUCTIONS:
            t = self.readings.times[-1] if broken is None else broken.t
            raise ValueError(
                f"times must end before the chain flies apart, got {t:g} (it does so with steps "
                f"down to {self.step:.2g}; end earlier or lower the temperature)"
            )
        self.step *= (
            STEP_REDUCTION if broken is not None else max(STEP_REDUCTION, longest / self.step)
        )
        self.ranges = self._warm_ranges()
        return True

    def _widen_ranges(self, f: Array, v: Array, t: float) -> None:
        """Widen the strain ranges to contain a state's strains; BrokenRunError if not finite."""
        met = self.engine.dynamics.ranges(State(t, f, v))
        if not np.isfinite(met).all():
            raise BrokenRunError(t)
        self.ranges[:, 0] = np.minimum(self.ranges[:, 0], met[:, 0])
        self.ranges[:, 1] = np.maximum(self.ranges[:, 1], met[:, 1])

    def pair(self, number: int) -> tuple[Array, Array]:
        """Return the readings of run ``number`` with steps h and h / 2, each (times, values).

        Raises BrokenRunError if a field is not finite.
        """
        random = np.random.default_rng([self.noise.seed, number])
        start, engine = self.engine.state, self.engine
        coarse, fine = ((start.f.copy(), start.v.copy()) for _ in range(2))
        read: list[tuple[Array, Array]] = []
        t, times = start.t, set(self.readings.times.tolist())
        for end in engine.stops.tolist():
            count = math.ceil((end - t) / self.step - 1e-9)
            h = (end - t) / max(count, 1)
            decay = np.exp(-0.25 * h * self.rates)
            amplitude = np.sqrt(self.noise.temperature * (1.0 - decay**2) / self.masses)
            for index in range(count):
                kicks = amplitude * random.standard_normal((4, *amplitude.shape))
                self._advance(coarse, decay, kicks, ((0, 1), (2, 3)), t + index * h, h)
                self._advance(fine, decay, kicks, ((0,), (1, 2), (3,)), t + index * h, 0.5 * h)
                if index % CHECK_INTERVAL == CHECK_INTERVAL - 1:
                    self._widen_ranges(*coarse, t + (index + 1) * h)
            self.steps += count
            t = end
            self._widen_ranges(*fine, t)
            if t in times:
                pair = (self.readings.read(State(t, *ring)) for ring in (coarse, fine))
                read.append(tuple(pair))  # type: ignore[arg-type]
        return tuple(np.array(values) for values in zip(*read, strict=True))  # type: ignore[return-value]

    def _advance(
        self,
        ring: tuple[Array, Array],
        decay: Array,
        kicks: Array,
        parts: tuple[tuple[int, ...], ...],
        t: float,
        h: float,
    ) -> None:
        """Advance the state ``ring`` over one coarse step, with its four noise ``kicks``.

        ``parts`` groups the indices of the kicks; between successive groups the chain takes one
        step ``h``. Before each kick the velocities are multiplied by ``decay``.
        """
        f, v = ring
        moving = v[:, : self.cells]
        for index, quarters in enumerate(parts):
            if index:
                begin = t + (index - 1) * h
                self.engine.dynamics.advance(self.engine.scheme, f, v, h, 1, begin)
            for quarter in quarters:
                moving *= decay
                moving += kicks[quarter]


class Means:
    """Running means and variances of readings and of their coarse-fine differences over runs."""

    def __init__(self) -> None:
        self.runs = 0
        self._mean: Array = np.zeros(())
        self._squares: Array = np.zeros(())

    def add(self, coarse: Array, fine: Array) -> None:
        """Add the readings of one run, computed with the coarse and with the fine step."""
        values = np.array([fine, coarse - fine])
        self.runs += 1
        before = values - self._mean
        self._mean = self._mean + before / self.runs
        self._squares = self._squares + before * (values - self._mean)

    @property
    def mean(self) -> Array:
        """Mean of each reading over the runs with the finer step."""
        return np.asarray(self._mean[0])

    @property
    def spread(self) -> Array:
        """Standard deviation of each reading over the runs with the finer step."""
        return np.asarray(np.sqrt(self._squares[0] / (self.runs - 1)))

    @property
    def by_chance(self) -> Array:
        """Half-width of each mean's confidence interval."""
        quantile = student.ppf(0.5 * (1.0 + QUANTILE_CONFIDENCE), self.runs - 1)
        return np.asarray(quantile * self.spread / math.sqrt(self.runs))

    @property
    def by_steps(self) -> Array:
        """Step-size error of the finer runs' means, for a scheme of order 2."""
        return np.asarray(np.abs(self._mean[1]) / 3.0)

    def asks_for_shorter_steps(self, allowed: float) -> bool:
        """Return whether the step-size error is significant and above half of ``allowed``."""
        chance = np.sqrt(self._squares[1] / (self.runs - 1) / self.runs)
        significant = np.abs(self._mean[1]) > SIGNIFICANT_ERRORS * chance
        return bool((significant & (self.by_steps > 0.5 * allowed)).any())


def record_means(
    scene: Scene, bench: Bench, chain: DrivenChain, progress: Progress, announce: Announce
) -> RunRecord:
    """Run the chain until each mean's confidence interval is within the tolerance.

    Raises ValueError for a diverging chain and if too many runs are needed, OverBudgetError if they
    would take too long.
    """
    loop, allowed = begin_loop("means of a bath"), scene.target.tolerance
    bath, means, target = Bath(scene, bench, chain), Means(), FIRST_RUNS
    assert allowed is not None
    if loop.memory is not None:
        bath.step, bath.steps, target = (loop.memory[name] for name in ("step", "steps", "wanted"))
        vars(means).update(loop.memory["means"])
    last = perf_counter()
    while True:
        while means.runs < target:
            last = perf_counter()
            pair = bath.pair_if_resolved(means.runs)
            if pair is None:
                means, target = Means(), FIRST_RUNS
                continue
            means.add(*pair)
            progress(means.runs / target)
            state = {"step": bath.step, "steps": bath.steps, "wanted": target, "means": vars(means)}
            loop.offer(state.copy)
        chance, steps = float(means.by_chance.max()), float(means.by_steps.max())
        if float((means.by_chance + means.by_steps).max()) <= allowed:
            break
        halved = means.asks_for_shorter_steps(allowed)
        needed = RUNS_SAFETY * (chance / (allowed - min(steps, 0.5 * allowed))) ** 2 * means.runs
        if needed > MOST_RUNS:
            raise ValueError(
                f"tolerance must be one that {MOST_RUNS} runs reach, got {allowed:g} (after "
                f"{means.runs} runs the means are known to {chance:.1g}; raise the tolerance)"
            )
        each = (perf_counter() - last) * (2.0 if halved else 1.0)
        remaining = ExpectedCost(seconds=each * max(needed - means.runs * (not halved), FIRST_RUNS))
        check_request(scene.name, remaining, "a larger tolerance, or end earlier")
        announce(remaining.seconds)
        if halved:
            bath.step, means, target = 0.5 * bath.step, Means(), FIRST_RUNS
        else:
            target = max(means.runs + 1, math.ceil(min(needed, 4.0 * means.runs)))
    return _means_record(bath, means, allowed, perf_counter() - loop.begun)


def _means_record(bath: Bath, means: Means, tolerance: float, seconds: float) -> RunRecord:
    """Return the record of the means, with confidence intervals and the spread over single runs."""
    error, spread = MEAN_SUFFIXES
    half = means.by_chance + means.by_steps
    prefix = f"half of the {CONFIDENCE:.0%} interval of the "
    variables = bath.readings.variables(means.mean, meaning="mean ")
    variables |= bath.readings.variables(half, error, f"{prefix}mean ")
    variables |= bath.readings.variables(means.spread, spread, "standard deviation, a run's, of ")
    record = bath.readings.record(variables, bath.steps, seconds)
    record.attrs |= {
        "tolerance": tolerance,
        "error_estimate": float(half.max()),
        "step_error": float(means.by_steps.max()),
        "runs": means.runs,
        "next_decade": 100.0,
        "planning_seconds": 0.0,
    }
    return record
