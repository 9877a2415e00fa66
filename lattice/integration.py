"""Time integration of a numerical lattice from a state through given times, to a tolerance.

`lattice.refine` estimates the error: the run is repeated with a shorter step, and with the last
digits of its data changed where the lattice may amplify rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import longwave.lattice.schemes as schemes
import longwave.lattice.trial as trials
from longwave.lattice.driving import DrivenChain
from longwave.lattice.dynamics import RANGE_MARGIN, Dynamics
from longwave.lattice.energy_balance import EnergyBalance
from longwave.lattice.force_features import INITIAL_GAPS, STEP_FRACTION, find_feature, finite_range
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.refine import refine
from longwave.lattice.run_times import check_positive, checked_times
from longwave.lattice.state import State
from longwave.lattice.stepper import CHUNK, FixedDomain, Stepper
from longwave.support.checkpoint import Memory, begin_loop
from longwave.support.real_arrays import Array
from longwave.support.request_limits import OverBudgetError

Judged = Callable[[Array, Array, float], ArrayLike]
"""Function of positions, velocities and time that returns the quantity whose error is estimated."""

Observe = Callable[[State, EnergyBalance | None], NDArray[Any]]
"""Function that returns the compared values of a state and of its energy balance, if any."""


@dataclass(frozen=True)
class StateComparison:
    """Compared quantity: ``combine`` of all ``observe`` results, in ``unit`` of the fields."""

    observe: Observe
    combine: Callable[[NDArray[Any]], Array] = lambda observed: observed
    unit: float = 1.0


LIMIT_SHARE = 0.9
"""Longest step tried, as a fraction of the stability limit at the largest strain."""

SLOW_RATIO = 1e6
"""Number of run durations: a wave whose period is longer does not limit the step."""

LARGE_STATE = 2**20
"""Number of values in a state from which on runs are made one at a time, to save memory."""

RUNAWAY_STEP_RATIO, MIN_RUNAWAY_STEPS = 4e4, 1e5
"""Number of steps beyond which strains must be running away: as a multiple of the number with the
longest step, and its minimum. At order 2, a tolerance of 1e-9 takes 3e4 times as many steps."""

RUNAWAY_LIMIT_RATIO = 100.0
"""Strains count as running away if they require steps this many times shorter than at the start."""

ORDER_AT_OPENINGS = 2
"""Highest order assumed where contacts open and close, or where a drive has a corner."""

RATIO_AT_OPENINGS = 0.5
"""Largest ratio of a step to the step before, which was too long, if contacts open. Errors fall in
jumps there, and with a ratio close to 1 they seemed not to fall."""

DEFAULT_TOLERANCE = 1e-9
"""Tolerance used for resolving drives and forces if none is given."""

FEATURE_MARGIN = 2.0
"""Margin searched for features on either side of the stretches visited, in units of their range."""

FEATURE_GAPS = round(INITIAL_GAPS * (1.0 + 2.0 * FEATURE_MARGIN))
"""Number of gaps between sampled slopes on the range with its margins; they have the same length as
`INITIAL_GAPS` gaps on the range alone."""

MAX_UNRESOLVED_RUNS = 3
"""Number of runs, each with a shorter step, that must find a feature too narrow to resolve before
the lattice is refused."""

QUIET_TIME = 0.1
"""Longest time between two stops, times the highest frequency at rest, in which stretches change so
little that their values at the stops show their range."""

MAX_RESOLVING_RUNS, MAX_RESOLVING_STEPS = 12, 2e6
"""Largest number of step sizes tried until one resolves the features of forces, and largest number
of steps of a run with such a step."""

NUDGES = 4
"""Number of times in a run, its start included, at which the last digits of the state are
changed."""

RING_SAFETY = 6.0
"""Factor on the difference of two runs, which gives the error estimate. With 2, one estimate in
2000 was too small, by 1.6, and with 4 one in 2500, by 1.2, where strains begin to run away (the
random cases of `tests/lattice/test_lattice_integration.py`)."""


@dataclass(frozen=True)
class Cost:
    """Steps, force evaluations per site and seconds of a run; ``all_seconds`` adds control runs."""

    steps: int
    force_evaluations: int
    seconds: float
    all_seconds: float


@dataclass(frozen=True)
class Trajectory:
    """Fields ``f`` and velocities ``v`` of a ring at all ``times``: (time, field, *cells).

    ``error_estimate`` is an upper estimate of the largest error, over all cells and times, of the
    judged quantity (the stretches of all bonds by default); nan if it was not measured. ``step`` is
    the longest step.
    """

    times: Array
    f: Array
    v: Array
    error_estimate: float
    scheme: str
    step: float
    cost: Cost


def integrate(
    lattice: NumericLattice,
    state: State,
    times: ArrayLike,
    tolerance: float | None = None,
    *,
    judged: Judged | None = None,
    scheme: schemes.Scheme = schemes.REDUCED_PHASE_6,
    step: float | None = None,
    measure_error: bool = True,
) -> Trajectory:
    """Integrate the lattice from ``state``, on its ring of cells, through all ``times``.

    With a ``tolerance`` the step is chosen so that the error of the stretches of all bonds, over
    all cells and times, is at most the tolerance. The drift of a whole ring of displacements
    changes no stretch and is not judged. ``judged(f, v, t)`` returns other quantities to judge, in
    the fields' unit: ``lambda f, v, t: f`` judges the fields themselves. A given ``step`` is used
    as it is, or shortened to hit each time; the error is measured with a shorter one unless
    ``measure_error`` is False. ``times`` increase from ``state.t`` on. The state is not changed.

    Raises ValueError for invalid arguments, for a lattice that blows up before the last time, and
    for a tolerance that rounding errors exceed.

    >>> from longwave.lattice import Model
    >>> wave = 0.1 * np.cos(np.pi * np.arange(64) / 32)
    >>> state = State(0.0, wave[np.newaxis], np.zeros((1, 64)))
    >>> run = integrate(Model(1.0, 0.0, 0.0).lattice, state, [0.0, 10.0], tolerance=1e-6)
    >>> exact = wave * np.cos(2.0 * np.sin(np.pi / 64) * 10.0)
    >>> bool(np.abs(run.f[1] - exact).max() <= run.error_estimate <= 1e-6)
    True
    """
    start = _checked(lattice, state)
    moments = checked_times(times, start.t)
    if scheme not in schemes.SCHEMES:
        schemes.check_order(scheme)
    if (tolerance is None) == (step is None):
        raise ValueError(
            f"either tolerance or step must be given, got tolerance {tolerance} and step {step} "
            "(with a tolerance the step is chosen for you)"
        )
    started = perf_counter()
    comparison = None
    if judged is not None:
        cells = slice(lattice.cell_count)  # without those of walls
        comparison = StateComparison(
            lambda state, _: np.asarray(judged(state.f[:, cells], state.v[:, cells], state.t))
        )
    allowed = tolerance or DEFAULT_TOLERANCE
    search = CellEngine(lattice, start, moments, scheme, comparison, tolerance=allowed)
    if tolerance is not None:
        trial, error = _to_tolerance(search, tolerance, moments)
    else:
        assert step is not None
        trial, error = _with_step(search, step, measure_error)
    return _trajectory(trial, error, moments, started, search)


def _checked(lattice: NumericLattice, state: State) -> State:
    """Return the state as double arrays, with walls. Raises ValueError if it does not fit."""
    for name, value, kind, remedy in (
        ("lattice", lattice, NumericLattice, "numeric_lattice or Model(...).lattice builds one"),
        ("state", state, State, "State(t, f, v), with f and v of the shape (fields, *cells)"),
    ):
        if not isinstance(value, kind):
            raise ValueError(
                f"{name} must be a {kind.__name__}, got a {type(value).__name__} ({remedy})"
            )
    return lattice.with_walls(Dynamics(lattice).checked(state))


def _to_tolerance(engine: CellEngine, tolerance: float, times: Array) -> tuple[trials.Trial, float]:
    """Return a run whose estimated error is within the tolerance, and that estimate."""
    remedy = "it is the largest accepted error, in the unit of the judged quantity"
    check_positive("tolerance", tolerance, remedy)
    try:
        refined = refine(engine, tolerance)
    except OverBudgetError as over_budget:
        raise ValueError(engine.budget_message(over_budget.work, tolerance)) from None
    return refined.trial, refined.error


def _with_step(engine: CellEngine, step: float, measure_error: bool) -> tuple[trials.Trial, float]:
    """Return a run with the given step, and its error measured with a shorter one."""
    check_positive("step", step, "it goes forward in time")
    schemes.check_step(step, engine.scheme, engine.first_frequency)
    choices = replace(engine.first(), step=step)
    trial, error = engine.run(choices, True), math.nan
    if measure_error:
        control = engine.run(engine.control(choices, engine.kinds), True)
        rounding = max(trial.rounding, control.rounding)
        error = RING_SAFETY * trials.difference(trial, control) + rounding
    return trial, error


def _trajectory(
    trial: trials.Trial, error: float, times: Array, started: float, engine: CellEngine
) -> Trajectory:
    """Return a finished run as a `Trajectory`. Raises ValueError if it blew up or broke down."""
    blow_up, steps, *stored = trial.payload
    f, v = (values[:, :, : engine.lattice.cell_count] for values in stored)
    if blow_up is not None:
        raise ValueError(
            f"times must end before the lattice blows up, got {times[-1]:g} ({blow_up}, with "
            f"steps down to {trial.choices.step:.2g}; end earlier or take smaller strains)"
        )
    engine.check_followed(trial)
    if trial.values is None and math.isinf(error):
        raise ValueError(
            f"times must end before strains run away, got {times[-1]:g} (steps down to "
            f"{trial.choices.step:.2g} do not follow them; end earlier or take smaller strains)"
        )
    if math.isinf(error):
        raise ValueError(
            f"times must end before a run breaks down, got {times[-1]:g} (one of the two runs that "
            f"are compared did, with steps down to {trial.choices.step:.2g}; end earlier or take "
            "smaller strains)"
        )
    cost = Cost(steps, steps * engine.scheme.stages, trial.seconds, perf_counter() - started)
    return Trajectory(times, f, v, error, engine.scheme.name, trial.choices.step, cost)


class CellEngine(trials.StepSearch):
    """Runs of a ring of cells from a state, for `refine`; only the time step is varied.

    ``first_frequency`` is an upper bound for all waves about the initial state. Positions and
    velocities are stored at ``stored_times``, by default all. Runs are compared by ``compared``, by
    default the stretches and their rates. If ``cuts`` of a driven chain are given, even an empty
    list, an `EnergyBalance` is followed. No step tried is longer than ``longest``. Changes of last
    digits are ``amplified`` times as large as one rounding.
    """

    safety = RING_SAFETY

    def __init__(
        self,
        lattice: NumericLattice,
        state: State,
        times: Array,
        scheme: schemes.Scheme,
        compared: StateComparison | None = None,
        stored_times: Array | None = None,
        cuts: Sequence[int] | None = None,
        tolerance: float = DEFAULT_TOLERANCE,
        longest: float = math.inf,
        amplified: float = 1.0,
    ) -> None:
        self._amplified = amplified
        self.lattice, self.scheme, self.state = lattice, scheme, state
        self._cuts = cuts
        self.dynamics = Dynamics(lattice)
        self.amplifies_rounding = not lattice.is_linear
        self.threads = self.dynamics.threads(scheme) if state.size < LARGE_STATE else 1
        self._times, self._stored_times = times, times if stored_times is None else stored_times
        smooth = [bond.force.is_smooth for bond in lattice.bonds]
        self._featured_bonds = [index for index, is_smooth in enumerate(smooth) if not is_smooth]
        self._has_features, self._refusals = False, 0
        self._limit_step, self._is_limited_by_feature = math.inf, False
        ranges = self.dynamics.ranges(state)
        self.first_frequency = self.dynamics.highest_frequency(ranges)
        self._duration = float(times[-1] - state.t) or 1.0
        self._step_limit = self._first_limit = self._longest_step(ranges)
        if not self._step_limit > 0.0:
            raise ValueError(
                "state must have stretches where all slopes of forces are finite, got a stretch of "
                f"{float(np.max(np.abs(ranges[: len(lattice.bonds)]))):g} (take other units)"
            )
        self._highest_at_rest = self._frequency_at_rest(ranges)
        self._largest = self._field_sizes(ranges)
        self._comparison = compared or StateComparison(self._stretches_and_rates)
        stops = np.concatenate([[state.t], times])
        begin, end = float(stops[0]), float(stops[-1])
        opens = any(bond.force.opening is not None for bond in lattice.bonds)
        admitted = LIMIT_SHARE * self._step_limit
        self._allowed_push = tolerance / max(1.0, self._highest_at_rest) / max(1.0, self._duration)
        driven = lattice.drive_steps(begin, end, admitted, scheme, self._allowed_push)
        opens = opens or driven.turns
        order = min(scheme.order, ORDER_AT_OPENINGS) if opens else scheme.order
        self._largest_ratio = RATIO_AT_OPENINGS if opens else 1.0
        self._drive_error = driven.missed * tolerance / self._allowed_push
        if driven.stops.size:
            stops = np.append(stops[0], np.union1d(stops[1:], driven.stops))
        super().__init__(order, min(driven.step, longest), stops, state.size)
        self.most_work = max(RUNAWAY_STEP_RATIO * self.work(self.first()), MIN_RUNAWAY_STEPS)

    @property
    def stops(self) -> Array:
        """Times at which steps end: the judged times, and those added to resolve drives."""
        return self._stops[1:]

    def _frequency_at_rest(self, ranges: Array) -> float:
        """Return the highest frequency at rest, or at the start if it is 0 or infinite at rest."""
        frequency = self.dynamics.highest_frequency(0.0 * ranges)
        return frequency if 0.0 < frequency < math.inf else self.first_frequency or 1.0

    def _stretches_and_rates(self, state: State, _: EnergyBalance | None) -> Array:
        """Return stretches, and their rates in units of the highest frequency at rest."""
        stretches, rates = (np.array(self.lattice.stretches(values)) for values in state.arrays)
        return np.array([stretches, rates / self._highest_at_rest])

    def run(
        self, choices: trials.Choices, shown: bool, progress: trials.Progress = lambda _: None
    ) -> trials.Trial:
        """Make or resume a run; its payload is (blow-up, steps, positions, velocities)."""
        start = self._start(choices.nudged)
        balance = self.balance(start)
        ring, chunk = FixedDomain(start), self._chunk(choices)
        stepper = Stepper(start, self.scheme, self.lattice, ring, choices.step, None, chunk)
        f, v = np.empty((2, self._stored_times.size, *self.state.arrays[0].shape))
        rows = {t: row for row, t in enumerate(self._stored_times.tolist())}
        rates = self._stretch_rates(stepper.state)
        times, observed = self.stops.tolist(), []
        judged_times, end = set(self._times.tolist()), times[-1]
        kind = f"{choices.nudged}{', features' if self._has_features else ''}"
        loop = begin_loop(f"{self.scheme.name}, step {choices.step!r}, {kind}")
        if loop.memory is not None:
            stepper.recall(loop.memory)
            f, v, observed, rates = (loop.memory[name] for name in ("f", "v", "judged", "met"))
            if balance is not None:
                balance.recall(loop.memory["balance"])
            times = [t for t in times if t > stepper.state.t]

        def remember(arrays: bool = True) -> Memory:
            flow = {} if balance is None else {"balance": balance.memory()}
            data = {"f": f, "v": v, "judged": observed, "met": rates}
            return stepper.memory(arrays) | data | flow

        before = stepper.state.t
        for state in stepper.stops(times) if times else ():
            rates = np.fmax(rates, self._stretch_rates(state))
            if balance is not None:
                balance.follow(state)
            if state.t in rows:
                f[rows[state.t]], v[rows[state.t]] = state.at(state.sites)
            if state.t in judged_times:
                if balance is not None:
                    balance.settle()
                with np.errstate(all="ignore"):  # where the step is too long
                    observed.append(self._comparison.observe(state, balance))
            if choices.nudged:
                self._nudge_again(state, before)
            before = state.t
            progress((state.t - self._stops[0]) / (self._stops[-1] - self._stops[0] or 1.0))
            if state.t < end:
                loop.offer(remember)
        if times and stepper.blow_up is None:
            loop.end(lambda: remember(arrays=False))
        if self._finds_new_features(stepper.ranges, rates):
            return self.run(choices, shown, progress)
        return trials.Trial(
            choices,
            self._values(stepper, choices, observed, rates),
            float(stepper.steps),
            perf_counter() - loop.begun,
            self._rounding(stepper),
            (stepper.blow_up, stepper.steps, f, v),
            common_error=self._drive_error,
            has_observables=self._stored_times.size == 0,  # nothing is stored but what is compared
        )

    def _values(
        self, stepper: Stepper, choices: trials.Choices, observed: list[Array], rates: Array
    ) -> Array | None:
        """Return the compared values; None after a blow-up or if the step was too long."""
        longest = self._longest_step(stepper.ranges)
        longest_taken = self._longest_taken(choices.step)
        feature_limit = math.inf
        if stepper.blow_up is None and longest_taken <= longest:
            feature_limit = self._resolving_step(stepper.ranges, rates, choices)
        self._note_limit(choices.step, longest, feature_limit)
        longest = min(longest, feature_limit)
        if stepper.blow_up is not None or longest_taken > longest:
            return None
        self._largest = np.fmax(self._largest, self._field_sizes(stepper.ranges))
        stacked = np.array(observed) if len(observed) > 1 else observed[0][np.newaxis]
        return self._comparison.combine(stacked)

    def _rounding(self, stepper: Stepper) -> float:
        """Return the estimated rounding error of the compared values."""
        largest = self.dynamics.largest(stepper.ranges) / self._comparison.unit
        return trials.rounding_error(largest, stepper.steps * self.scheme.stages)

    def _note_limit(self, step: float, stable: float, resolving: float) -> None:
        """Record the smaller of two step limits, unless a run with a shorter step has set it."""
        if step < self._limit_step:
            self._step_limit, self._limit_step = math.inf, step
        limit = min(stable, resolving)
        if step == self._limit_step and limit < self._step_limit:
            self._step_limit, self._is_limited_by_feature = limit, resolving < stable

    def _chunk(self, choices: trials.Choices) -> int | None:
        """Return the largest number of steps between two stops; None for the default."""
        if self._cuts is not None:
            return 1
        steps = self.work(choices) / (2 * NUDGES) if choices.nudged else math.inf
        if self._has_features:
            steps = min(steps, self._quiet_time(choices) / choices.step)
        return max(1, math.ceil(steps)) if steps < CHUNK else None

    def _quiet_time(self, choices: trials.Choices) -> float:
        """Return a time in which stretches and their rates change little."""
        return max(choices.step, QUIET_TIME / self._highest_at_rest)

    def _stretch_rates(self, state: State) -> Array:
        """Return the largest rate of each stretch whose force may have narrow features."""
        if not self._featured_bonds:
            return np.zeros(0)
        bonds = [self.lattice.bonds[index] for index in self._featured_bonds]
        rates = [bond.stretched(state.v) - bond.offset for bond in bonds]
        return np.array([float(np.max(np.abs(rate))) for rate in rates])

    def _finds_new_features(self, ranges: Array, rates: Array) -> bool:
        """Return True when narrow features of forces are first found near the stretches."""
        if self._has_features or not self._featured_bonds or not np.isfinite(ranges).all():
            return False
        for index, rate in zip(self._featured_bonds, rates.tolist(), strict=True):
            force, (least, most) = self.lattice.bonds[index].force, ranges[index].tolist()
            pad = FEATURE_MARGIN * (most - least + rate / self._highest_at_rest)
            ends = finite_range(force, least, most, pad)
            feature = find_feature(force, *ends, self._allowed_push * max(rate, pad), FEATURE_GAPS)
            if feature.width < math.inf or feature.turns:
                self._has_features, self.unstable = True, MAX_RESOLVING_RUNS
                self.most_work = max(self.most_work, 4.0 * MAX_RESOLVING_STEPS)
        return self._has_features

    def _resolving_step(self, ranges: Array, rates: Array, choices: trials.Choices) -> float:
        """Return the longest step that resolves all features; raise ValueError if too short."""
        longest = math.inf
        if not self._has_features or not np.isfinite(ranges).all():
            return longest
        for index, rate in zip(self._featured_bonds, rates.tolist(), strict=True):
            force, (least, most) = self.lattice.bonds[index].force, ranges[index].tolist()
            pad = RANGE_MARGIN * (most - least) + rate * self._quiet_time(choices)
            ends = finite_range(force, least, most, pad)
            feature = find_feature(force, *ends, self._allowed_push * rate)
            if feature.turns:
                self.order, self._largest_ratio = ORDER_AT_OPENINGS, RATIO_AT_OPENINGS
            if rate > 0.0:
                longest = min(longest, STEP_FRACTION * feature.width / rate)
            if self._duration > MAX_RESOLVING_STEPS * longest:
                self._refusals += 1
                if self._refusals < MAX_UNRESOLVED_RUNS:  # shorter steps may change the range
                    return self._duration / MAX_RESOLVING_STEPS
                raise ValueError(
                    f"force of bond {index + 1} of {self.lattice.name} must change slowly enough "
                    f"to be resolved, got one that changes within {feature.width:.2g} where "
                    f"stretches move at {rate:.2g} (that takes {self._duration / longest:.1g} "
                    "steps; widen it or end earlier)"
                )
        return longest

    def balance(self, start: State) -> EnergyBalance | None:
        """Return the energy balance of a run from ``start``, or None if it is not followed."""
        if self._cuts is None:
            return None
        assert isinstance(self.lattice, DrivenChain)
        return EnergyBalance(self.lattice, self._cuts, start)

    def _longest_taken(self, step: float) -> float:
        """Return the longest step taken if ``step`` is requested; stops make steps shorter."""
        gaps = np.diff(self._stops)
        return float(np.max(gaps / np.maximum(np.ceil(gaps / step), 1.0)))

    def improved(self, choices: trials.Choices, kind: trials.Kind, excess: float) -> trials.Choices:
        """Return choices with a shorter step: the last run's limit, or as step^order predicts."""
        step = trials.step_between(self._stops, choices.step)
        if math.isinf(excess) and 0.0 < self._step_limit < self._longest_taken(choices.step):
            least = trials.LEAST_FACTOR**3 if self._has_features else trials.LEAST_FACTOR
            return replace(choices, step=max(LIMIT_SHARE * self._step_limit, least * step))
        choices_by_law = super().improved(choices, kind, excess)
        return replace(choices_by_law, step=min(choices_by_law.step, self._largest_ratio * step))

    def check_followed(self, trial: trials.Trial) -> None:
        """Raise ValueError if the run broke down because a force changes too fast."""
        if trial.values is None and trial.payload[0] is None and self._is_limited_by_feature:
            raise ValueError(
                f"forces of {self.lattice.name} must change slowly enough to be resolved, got one "
                f"that steps down to {trial.choices.step:.2g} do not resolve (widen what changes "
                "fast, or end earlier)"
            )

    def budget_message(self, work: float, tolerance: float | None) -> str:
        """Return why so many steps are refused: fast strains, fast forces, or the tolerance."""
        ratio = self._first_limit / self._step_limit if self._step_limit else math.inf
        if ratio > RUNAWAY_LIMIT_RATIO and self._is_limited_by_feature:
            return (
                f"forces of {self.lattice.name} must change slowly enough to be resolved, got one "
                f"that needs steps {ratio:.1g} times shorter than strains do ({work:.1g} in "
                "all; widen it or end earlier)"
            )
        if ratio > RUNAWAY_LIMIT_RATIO:
            return (
                f"times must end before strains run away, got {self._times[-1]:g} (they need "
                f"steps {ratio:.1g} times shorter than at first, {work:.1g} in all; end "
                "earlier or take smaller strains)"
            )
        return (
            f"tolerance must be reachable with {self.most_work:.1g} steps, got {tolerance:g} (the "
            f"next runs would take {work:.1g}; raise it or end earlier)"
        )

    def _longest_step(self, ranges: Array) -> float:
        """Return the longest step that is stable for stretches in these ranges; 0 if none is."""
        highest = self.dynamics.highest_frequency(ranges)
        limit = schemes.stability_limit(self.scheme)
        return limit / highest if limit < SLOW_RATIO * highest * self._duration else self._duration

    def _start(self, changed: bool) -> State:
        """Return a copy of the initial state, with other last digits if ``changed``.

        Cells at rest have no last digits; their changes are relative to the fields' sizes in the
        run.
        """
        start = self.state.copy()
        if changed:
            resting = (start.f == 0.0) & (start.v == 0.0)
            start.f[:], start.v[:] = trials.nudged(*start.arrays, times=self._amplified)
            start.f += np.where(resting, self._digit_changes(start.f), 0.0)
        return start

    def _nudge_again(self, state: State, before: float) -> None:
        """Change last digits of ``state``, in place, if a set time has passed since ``before``."""
        begin, end = float(self._stops[0]), float(self._stops[-1])
        marks = begin + np.arange(1, NUDGES) * (end - begin) / NUDGES
        if state.t < end and np.any((before < marks) & (marks <= state.t)):
            state.f += self._digit_changes(state.f)

    def _digit_changes(self, f: Array) -> Array:
        """Return random changes of last digits, scaled to each field's largest value."""
        ones = np.zeros_like(f)
        ones[:, : self.lattice.cell_count] = 1.0
        [factors] = trials.nudged(ones, times=self._amplified)
        return (factors - ones) * self._largest.reshape(-1, *(1,) * (f.ndim - 1))

    def _field_sizes(self, ranges: Array) -> Array:
        """Return the largest abs(value) of each field, 0 where it is not finite."""
        sizes = np.abs(ranges[len(self.lattice.bonds) :]).max(axis=1)
        return np.where(np.isfinite(sizes), sizes, 0.0)
