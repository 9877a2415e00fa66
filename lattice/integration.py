"""A lattice with numbers from a state through given times, to a stated tolerance.

The run is judged by `lattice.refine`: done again with a shorter step, and with the last digits of
its data changed where the lattice may amplify rounding.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.driving import DrivenChain
from longwave.lattice.dynamics import WIDER, Dynamics
from longwave.lattice.energy_balance import EnergyBalance
from longwave.lattice.force_features import GAPS, TRAVEL, find_feature, finite_range
from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.refine import refine
from longwave.lattice.run_times import check_positive, checked_times
from longwave.lattice.schemes import (
    REDUCED_PHASE_6,
    SCHEMES,
    Scheme,
    check_order,
    check_step,
    stability_limit,
)
from longwave.lattice.state import State
from longwave.lattice.stepper import CHUNK, FixedDomain, Stepper
from longwave.lattice.trial import (
    LEAST_FACTOR,
    Choices,
    Kind,
    Progress,
    StepSearch,
    Trial,
    difference,
    nudged,
    rounding_error,
    step_between,
)
from longwave.support.checkpoint import Memory, begin_loop
from longwave.support.request_limits import OverBudgetError

Array = NDArray[np.float64]
Judged = Callable[[Array, Array, float], ArrayLike]
"""What is judged, from positions, velocities and the time."""

Look = Callable[[State, EnergyBalance | None], NDArray[Any]]
"""The same from a state, and the balance of energy where it is followed."""


@dataclass(frozen=True)
class StateComparison:
    """What runs are compared by: what a ``look`` at each of the times gives, taken ``together``.

    It is in so many ``unit`` of the fields.
    """

    look: Look
    together: Callable[[NDArray[Any]], Array] = lambda looks: looks
    unit: float = 1.0


LIMIT_SHARE = 0.9
"""Longest step tried, in units of the stability limit at the largest strain."""

SLOW = 1e6
"""Waves that take so many times the run's duration do not bound the step."""

LARGE = 2**20
"""Numbers of a state from which on one run is made at a time, on both cores: two would take twice
the memory."""

RUNAWAY, LEAST_RUNAWAY = 4e4, 1e5
"""Steps, in units of the longest one's and at least, that a run takes only where strains run away:
with an order of 2 a tolerance of 1e-9 takes 3e4 times the longest one's."""

RAN_AWAY = 100.0
"""Strains run away if those met ask for steps so many times shorter than those at first."""

ORDER_AT_OPENINGS = 2
"""With which errors fall at least where contacts open and close, or where a drive has a corner."""

KEPT_AT_OPENINGS = 0.5
"""The most of a step that is kept where it was too long and contacts open: what a step changes
falls by jumps there, and from little shorter ones it was taken not to fall."""

FINE = 1e-9
"""Tolerance for which features of drives and forces are followed where none is given."""

NEAR = 2.0
"""Room beside the stretches that were met, in units of their range, where features are sought."""

NEAR_GAPS = round(GAPS * (1.0 + 2.0 * NEAR))
"""Gaps between samples of slopes there: as long as those between samples of what was met."""

UNFOLLOWED = 3
"""Runs, with shorter and shorter steps, that must meet a feature that is too narrow before it is
refused."""

STILL = 0.1
"""Time between stops, in units of the inverse highest frequency at rest, that shows all that
stretches pass."""

PATIENT, MOST_FOLLOWED = 12, 2e6
"""Steps tried until one follows the features of forces, and the most that one run may take."""

NUDGED = 4
"""Times, with the start, at which a run's last digits are changed."""

RING_SAFETY = 6.0
"""Factor on the difference of two runs. With 2, one estimate in 2000 was too small, by 1.6, and
with 4 one in 2500, by 1.2, where strains begin to run away (the random cases of
`tests/lattice/test_lattice_integration.py`)."""


@dataclass(frozen=True)
class Cost:
    """Steps and force evaluations a site of the run that is returned, and its seconds.

    ``all_seconds`` are those of all runs, with the ones that only judge it.
    """

    steps: int
    force_evaluations: int
    seconds: float
    all_seconds: float


@dataclass(frozen=True)
class Trajectory:
    """Fields ``f`` and velocities ``v`` of a ring at all ``times``: (time, field, *cells).

    ``error_estimate`` is what the largest error of what is judged, of the stretches of all bonds
    if nothing else was asked for, is at most estimated to be, over all cells and times; nan if it
    was not asked for. ``step`` is the longest step.
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
    scheme: Scheme = REDUCED_PHASE_6,
    step: float | None = None,
    measure_error: bool = True,
) -> Trajectory:
    """The lattice from ``state``, on its ring of cells, at all ``times``.

    With a ``tolerance`` the step is found: the error of the stretches of all bonds, over all cells
    and times, is at most that. Of a ring of displacements their sum, the drift of the whole ring,
    is not judged then. ``judged(f, v, t)`` is an array of what is judged in place of them, in the
    fields' unit: ``lambda f, v, t: f`` judges the fields themselves. With a ``step`` it is taken as
    it is (at most: each of the times is hit), and the error is measured with a shorter one unless
    ``measure_error`` is False. ``times`` increase and do not lie before ``state.t``. The state is
    left alone.

    Raises ValueError for what cannot be run, for a lattice that blows up before the last time, and
    for a tolerance below what rounding leaves.

    >>> from longwave.lattice import Model
    >>> wave = 0.1 * np.cos(np.pi * np.arange(64) / 32)
    >>> state = State(0.0, wave[np.newaxis], np.zeros((1, 64)))
    >>> run = integrate(Model(1.0, 0.0, 0.0).lattice, state, [0.0, 10.0], tolerance=1e-6)
    >>> exact = wave * np.cos(2.0 * np.sin(np.pi / 64) * 10.0)
    >>> bool(np.abs(run.f[1] - exact).max() <= run.error_estimate <= 1e-6)
    True
    """
    held = _checked(lattice, state)
    moments = checked_times(times, held.t)
    if scheme not in SCHEMES:
        check_order(scheme)
    if (tolerance is None) == (step is None):
        raise ValueError(
            f"either tolerance or step must be given, got tolerance {tolerance} and step {step} "
            "(a tolerance finds the step)"
        )
    begun = perf_counter()
    compared = None if judged is None else _of_cells(judged, lattice.cell_count)
    search = CellEngine(lattice, held, moments, scheme, compared, tolerance=tolerance or FINE)
    if tolerance is not None:
        trial, error = _found(search, tolerance, moments)
    else:
        assert step is not None
        trial, error = _stated(search, step, measure_error)
    return _outcome(trial, error, moments, begun, search)


def _of_cells(judged: Judged, cells: int | None) -> StateComparison:
    """What is judged of the lattice's own cells, walls left out."""

    def looked(state: State, _: EnergyBalance | None) -> Array:
        return np.asarray(judged(state.f[:, :cells], state.v[:, :cells], state.t))

    return StateComparison(looked)


def _checked(lattice: NumericLattice, state: State) -> State:
    """The state with arrays of doubles; ValueError for what is no state of the lattice."""
    for name, value, kind, remedy in (
        ("lattice", lattice, NumericLattice, "numeric_lattice or Model(...).lattice makes one"),
        ("state", state, State, "State(t, f, v), with f and v of the shape (fields, *cells)"),
    ):
        if not isinstance(value, kind):
            raise ValueError(
                f"{name} must be a {kind.__name__}, got a {type(value).__name__} ({remedy})"
            )
    return lattice.held(Dynamics(lattice).checked(state))


def _found(engine: CellEngine, tolerance: float, times: Array) -> tuple[Trial, float]:
    """A run to the tolerance, and its error."""
    remedy = "it is the error that is accepted, in the unit of what is judged"
    check_positive("tolerance", tolerance, remedy)
    try:
        found = refine(engine, tolerance)
    except OverBudgetError as dear:
        raise ValueError(engine.told_dear(dear.work, tolerance)) from None
    return found.trial, found.error


def _stated(engine: CellEngine, step: float, measure_error: bool) -> tuple[Trial, float]:
    """A run with that step, its error measured with a shorter one."""
    check_positive("step", step, "it goes forward in time")
    check_step(step, engine.scheme, engine.first_frequency)
    choices = replace(engine.first(), step=step)
    trial, error = engine.run(choices, True), math.nan
    if measure_error:
        control = engine.run(engine.control(choices, engine.kinds), True)
        error = RING_SAFETY * difference(trial, control) + max(trial.rounding, control.rounding)
    return trial, error


def _outcome(
    trial: Trial, error: float, times: Array, begun: float, engine: CellEngine
) -> Trajectory:
    blow_up, steps, *held = trial.payload
    f, v = (values[:, :, : engine.lattice.cell_count] for values in held)
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
            f"times must end while runs that are compared go on, got {times[-1]:g} (one of two "
            f"broke down, with steps down to {trial.choices.step:.2g}; end earlier or take smaller "
            "strains)"
        )
    cost = Cost(
        steps,
        steps * engine.scheme.stages,
        trial.seconds,
        perf_counter() - begun,
    )
    return Trajectory(times, f, v, error, engine.scheme.name, trial.choices.step, cost)


class CellEngine(StepSearch):
    """Runs of a ring of sites from a state, for `refine` to judge: only the step varies.

    ``first_frequency`` is the highest of any wave about the state. Positions and velocities are
    ``kept`` at all of the times, or at those given; without ``compared`` stretches and their rates
    are, at all of them. With ``cuts`` of a driven chain, however few, its `EnergyBalance` is there
    when it is looked at. No step tried is longer than ``longest``. Last digits are changed by
    ``amplified`` times what one rounding does.
    """

    safety = RING_SAFETY

    def __init__(
        self,
        lattice: NumericLattice,
        state: State,
        times: Array,
        scheme: Scheme,
        compared: StateComparison | None = None,
        kept: Array | None = None,
        cuts: Sequence[int] | None = None,
        tolerance: float = FINE,
        longest: float = math.inf,
        amplified: float = 1.0,
    ) -> None:
        self._amplified = amplified
        self.lattice, self.scheme, self.state = lattice, scheme, state
        self._cuts = cuts
        self.dynamics = Dynamics(lattice)
        self.amplifies_rounding = not lattice.is_linear
        self.threads = self.dynamics.threads(scheme) if state.size < LARGE else 1
        self._times, self._kept = times, times if kept is None else kept
        self._curious = [at for at, one in enumerate(lattice.bonds) if not one.force.is_smooth]
        self._has_features, self._unfollowed = False, 0
        self._told_by, self._by_feature = math.inf, False
        ranges = self.dynamics.ranges(state)
        self.first_frequency = self.dynamics.highest_frequency(ranges)
        self._duration = float(times[-1] - state.t) or 1.0
        self._admitted = self._admitted_first = self._longest_step(ranges)
        if not self._admitted > 0.0:
            raise ValueError(
                "state must leave the slopes of all forces finite, got a stretch of "
                f"{float(np.max(np.abs(ranges[: len(lattice.bonds)]))):g} (take other units)"
            )
        self._highest_at_rest = self._frequency_at_rest(ranges)
        self._largest = self._sizes(ranges)
        self._compared = compared or StateComparison(self._stretches_and_rates)
        stops = np.concatenate([[state.t], times])
        begin, end = float(stops[0]), float(stops[-1])
        opens = any(bond.force.opening is not None for bond in lattice.bonds)
        admitted = LIMIT_SHARE * self._admitted
        self._push = tolerance / max(1.0, self._highest_at_rest) / max(1.0, self._duration)
        driven = lattice.drive_steps(begin, end, admitted, scheme, self._push)
        opens = opens or driven.turns
        order = min(scheme.order, ORDER_AT_OPENINGS) if opens else scheme.order
        self._most_kept = KEPT_AT_OPENINGS if opens else 1.0
        self._missed = driven.missed * tolerance / self._push
        if driven.stops.size:
            stops = np.append(stops[0], np.union1d(stops[1:], driven.stops))
        super().__init__(order, min(driven.step, longest), stops, state.size)
        self.most_work = max(RUNAWAY * self.work(self.first()), LEAST_RUNAWAY)

    @property
    def stops(self) -> Array:
        """Times at which steps end: those that are judged, and those that follow drives."""
        return self._stops[1:]

    def _frequency_at_rest(self, ranges: Array) -> float:
        """The highest frequency at rest, that of the start if there is none."""
        frequency = self.dynamics.highest_frequency(0.0 * ranges)
        return frequency if 0.0 < frequency < math.inf else self.first_frequency or 1.0

    def _stretches_and_rates(self, state: State, _: EnergyBalance | None) -> Array:
        """Both in the unit of stretches: rates in units of the highest frequency at rest."""
        stretches = self.dynamics.stretches
        return np.array([stretches(state.f), stretches(state.v) / self._highest_at_rest])

    def run(self, choices: Choices, shown: bool, progress: Progress = lambda _: None) -> Trial:
        """A run; its payload is what stopped it, its steps, positions and velocities."""
        start = self._start(choices.nudged)
        balance = self.balance(start)
        ring, chunk = FixedDomain(start), self._chunk(choices)
        stepper = Stepper(start, self.scheme, self.lattice, ring, choices.step, None, chunk)
        f, v = np.empty((2, self._kept.size, *self.state.arrays[0].shape))
        rows = {t: row for row, t in enumerate(self._kept.tolist())}
        met = self._rates(stepper.state)
        times, judged = self.stops.tolist(), []
        moments, end = set(self._times.tolist()), times[-1]
        kind = f"{choices.nudged}{', features' if self._has_features else ''}"
        loop = begin_loop(f"{self.scheme.name}, step {choices.step!r}, {kind}")
        if loop.memory is not None:
            stepper.recall(loop.memory)
            f, v, judged, met = (loop.memory[name] for name in ("f", "v", "judged", "met"))
            if balance is not None:
                balance.recall(loop.memory["balance"])
            times = [t for t in times if t > stepper.state.t]

        def remember(arrays: bool = True) -> Memory:
            told = {} if balance is None else {"balance": balance.memory()}
            return stepper.memory(arrays) | {"f": f, "v": v, "judged": judged, "met": met} | told

        before = stepper.state.t
        for state in stepper.stops(times) if times else ():
            met = np.fmax(met, self._rates(state))
            if balance is not None:
                balance.follow(state)
            if state.t in rows:
                f[rows[state.t]], v[rows[state.t]] = state.at(state.sites)
            if state.t in moments:
                if balance is not None:
                    balance.settle()
                with np.errstate(all="ignore"):  # where the step is too long
                    judged.append(self._compared.look(state, balance))
            if choices.nudged:
                self._nudge_again(state, before)
            before = state.t
            progress((state.t - self._stops[0]) / (self._stops[-1] - self._stops[0] or 1.0))
            if state.t < end:
                loop.offer(remember)
        if times and stepper.blow_up is None:
            loop.end(lambda: remember(arrays=False))
        if self._finds_features(stepper.ranges, met):
            return self.run(choices, shown, progress)
        return Trial(
            choices,
            self._values(stepper, choices, judged, met),
            float(stepper.steps),
            perf_counter() - loop.begun,
            self._rounding(stepper),
            (stepper.blow_up, stepper.steps, f, v),
            common_error=self._missed,
            shown=self._kept.size == 0,  # no more is kept than what is looked at
        )

    def _values(
        self, stepper: Stepper, choices: Choices, judged: list[Array], rates: Array
    ) -> Array | None:
        """What was judged; None after a blow-up or with a step that does not follow the run.

        Then what strains and fields became is not the motion's.
        """
        longest, taken = self._longest_step(stepper.ranges), self._taken(choices.step)
        followed = math.inf
        if stepper.blow_up is None and taken <= longest:
            followed = self._followed_step(stepper.ranges, rates, choices)
        self._note_admitted(choices.step, longest, followed)
        longest = min(longest, followed)
        if stepper.blow_up is not None or taken > longest:
            return None
        self._largest = np.fmax(self._largest, self._sizes(stepper.ranges))
        looks = np.array(judged) if len(judged) > 1 else judged[0][np.newaxis]
        return self._compared.together(looks)

    def _rounding(self, stepper: Stepper) -> float:
        """What rounding is taken to have done to what is compared."""
        largest = self.dynamics.largest(stepper.ranges) / self._compared.unit
        return rounding_error(largest, stepper.steps * self.scheme.stages)

    def _note_admitted(self, step: float, stable: float, followed: float) -> None:
        """Keep the longest step that the strains and features admit which a run has met.

        What the run with the shortest step met counts: a longer one may have shown no motion.
        """
        if step < self._told_by:
            self._admitted, self._told_by = math.inf, step
        if step == self._told_by and min(stable, followed) < self._admitted:
            self._admitted, self._by_feature = min(stable, followed), followed < stable

    def _chunk(self, choices: Choices) -> int | None:
        """Most steps between two stops: few enough for nudges between them."""
        if self._cuts is not None:
            return 1
        steps = self.work(choices) / (2 * NUDGED) if choices.nudged else math.inf
        if self._has_features:
            steps = min(steps, self._still(choices) / choices.step)
        return max(1, math.ceil(steps)) if steps < CHUNK else None

    def _still(self, choices: Choices) -> float:
        """The time between two stops in which stretches and their rates change little."""
        return max(choices.step, STILL / self._highest_at_rest)

    def _rates(self, state: State) -> Array:
        """The largest rate of each stretch whose force may have features."""
        if not self._curious:
            return np.zeros(0)
        bonds = [self.lattice.bonds[place] for place in self._curious]
        rates = [bond.stretched(state.v) - bond.offset for bond in bonds]
        return np.array([float(np.max(np.abs(rate))) for rate in rates])

    def _finds_features(self, ranges: Array, rates: Array) -> bool:
        """Whether forces have features near what was met, of which nothing was known before."""
        if self._has_features or not self._curious or not np.isfinite(ranges).all():
            return False
        for place, rate in zip(self._curious, rates.tolist(), strict=True):
            force, (least, most) = self.lattice.bonds[place].force, ranges[place].tolist()
            room = NEAR * (most - least + rate / self._highest_at_rest)
            ends = finite_range(force, least, most, room)
            feature = find_feature(force, *ends, self._push * max(rate, room), NEAR_GAPS)
            if feature.width < math.inf or feature.turns:
                self._has_features, self.unstable = True, PATIENT
                self.most_work = max(self.most_work, 4.0 * MOST_FOLLOWED)
        return self._has_features

    def _followed_step(self, ranges: Array, rates: Array, choices: Choices) -> float:
        """The longest step that sees all features of forces; ValueError if it is far too short."""
        longest = math.inf
        if not self._has_features or not np.isfinite(ranges).all():
            return longest
        for place, rate in zip(self._curious, rates.tolist(), strict=True):
            force, (least, most) = self.lattice.bonds[place].force, ranges[place].tolist()
            room = WIDER * (most - least) + rate * self._still(choices)
            ends = finite_range(force, least, most, room)
            feature = find_feature(force, *ends, self._push * rate)
            if feature.turns:
                self.order, self._most_kept = ORDER_AT_OPENINGS, KEPT_AT_OPENINGS
            if rate > 0.0:
                longest = min(longest, TRAVEL * feature.width / rate)
            if self._duration > MOST_FOLLOWED * longest:
                self._unfollowed += 1
                if self._unfollowed < UNFOLLOWED:  # with shorter steps the range may be another
                    return self._duration / MOST_FOLLOWED
                raise ValueError(
                    f"force of bond {place + 1} of {self.lattice.name} must change slowly enough "
                    f"to be followed, got one that changes within {feature.width:.2g} where "
                    f"stretches move at {rate:.2g} (that takes {self._duration / longest:.1g} "
                    "steps; widen it or end earlier)"
                )
        return longest

    def balance(self, start: State) -> EnergyBalance | None:
        """What follows the energy of a run from there, where it is asked for."""
        if self._cuts is None:
            return None
        assert isinstance(self.lattice, DrivenChain)
        return EnergyBalance(self.lattice, self._cuts, start)

    def _taken(self, step: float) -> float:
        """The longest step that is taken where the stops shorten it."""
        gaps = np.diff(self._stops)
        return float(np.max(gaps / np.maximum(np.ceil(gaps / step), 1.0)))

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """A step that follows the strains that were met, or by the law of the order."""
        step = step_between(self._stops, choices.step)
        if math.isinf(excess) and 0.0 < self._admitted < self._taken(choices.step):
            least = LEAST_FACTOR**3 if self._has_features else LEAST_FACTOR
            return replace(choices, step=max(LIMIT_SHARE * self._admitted, least * step))
        found = super().improved(choices, kind, excess)
        return replace(found, step=min(found.step, self._most_kept * step))

    def check_followed(self, trial: Trial) -> None:
        """Raise ValueError if it broke down where a force changes fast, and not as waves grew."""
        if trial.values is None and trial.payload[0] is None and self._by_feature:
            raise ValueError(
                f"forces of {self.lattice.name} must change slowly enough to be followed, got one "
                f"that steps down to {trial.choices.step:.2g} do not follow (widen what changes "
                "fast, or end earlier)"
            )

    def told_dear(self, work: float, tolerance: float | None) -> str:
        """Why runs of so many steps are refused: strains that grew, or the tolerance."""
        times = self._admitted_first / self._admitted if self._admitted else math.inf
        if times > RAN_AWAY and self._by_feature:
            return (
                f"forces of {self.lattice.name} must change slowly enough to be followed, got one "
                f"that asks for steps {times:.1g} times shorter than strains do ({work:.1g} in "
                "all; widen it or end earlier)"
            )
        if times > RAN_AWAY:
            return (
                f"times must end before strains run away, got {self._times[-1]:g} (those met ask "
                f"for steps {times:.1g} times shorter than at first, {work:.1g} in all; end "
                "earlier or take smaller strains)"
            )
        return (
            f"tolerance must be one that {self.most_work:.1g} steps reach, got {tolerance:g} (the "
            f"next runs would take {work:.1g}; raise it or end earlier)"
        )

    def _longest_step(self, ranges: Array) -> float:
        """The longest step that is stable about what was met; 0 if there is no such step.

        A run with a longer one shows neither waves nor what runs away: two such runs may agree.
        """
        highest = self.dynamics.highest_frequency(ranges)
        limit = stability_limit(self.scheme)
        return limit / highest if limit < SLOW * highest * self._duration else self._duration

    def _start(self, changed: bool) -> State:
        """A copy of the state; ``changed`` with the last digits of both its arrays changed.

        Cells at rest have none: they are moved by as much of what fields become in the run.
        """
        start = self.state.copy()
        if changed:
            resting = (start.f == 0.0) & (start.v == 0.0)
            for values, others in zip(
                start.arrays, nudged(*start.arrays, times=self._amplified), strict=True
            ):
                values[:] = others
            start.f += np.where(resting, self._nudges(start.f), 0.0)
        return start

    def _nudge_again(self, state: State, before: float) -> None:
        """Change last digits of what fields become, where the run has passed a mark."""
        begin, end = float(self._stops[0]), float(self._stops[-1])
        marks = begin + np.arange(1, NUDGED) * (end - begin) / NUDGED
        if state.t < end and np.any((before < marks) & (marks <= state.t)):
            state.f += self._nudges(state.f)

    def _nudges(self, f: Array) -> Array:
        """Such changes, of cells that move."""
        ones = np.zeros_like(f)
        ones[:, : self.lattice.cell_count] = 1.0
        [signs] = nudged(ones, times=self._amplified)
        return (signs - ones) * self._largest.reshape(-1, *(1,) * (f.ndim - 1))

    def _sizes(self, ranges: Array) -> Array:
        """The largest size of each field."""
        found = np.abs(ranges[len(self.lattice.bonds) :]).max(axis=1)
        return np.where(np.isfinite(found), found, 0.0)
