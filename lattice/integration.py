"""A numeric model from a state through given times, to a stated tolerance of the strain.

The run is judged by `lattice.refine`: done again with a shorter step, and with the last digits of
its data changed where the lattice may amplify rounding.
"""

import math
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lattice.kernels import blocked
from lattice.model import Model, State
from lattice.refine import refine
from lattice.run_times import check_positive, checked_times
from lattice.scheme_order import check_order
from lattice.schemes import REDUCED_PHASE_6, SCHEMES, Scheme, check_step, stability_limit
from lattice.stepper import Stepper, StillRing
from lattice.trial import (
    LEAST_FACTOR,
    NUDGE,
    Choices,
    Kind,
    Progress,
    StepSearch,
    Trial,
    difference,
    rounding_error,
)

Array = NDArray[np.float64]

LIMIT_SHARE = 0.9
"""Longest step tried, in units of the stability limit at the largest strain."""

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
    """A ring of sites at all ``times``: ``strain`` and ``velocity`` of shape (time, site).

    ``error_estimate`` is what the largest error of the strain, over all sites and times, is at
    most estimated to be; nan if it was not asked for. ``step`` is the longest step.
    """

    times: Array
    strain: Array
    velocity: Array
    error_estimate: float
    scheme: str
    step: float
    cost: Cost


def integrate(
    model: Model,
    state: State,
    times: ArrayLike,
    tolerance: float | None = None,
    *,
    scheme: Scheme = REDUCED_PHASE_6,
    step: float | None = None,
    measure_error: bool = True,
) -> Trajectory:
    """The lattice y_n'' = D V'(y)_n from ``state``, on its ring of sites, at all ``times``.

    With a ``tolerance`` the step is found: the error of the strain, over all sites and times, is at
    most that. With a ``step`` it is taken as it is (at most: each of the times is hit), and the
    error is measured with a shorter one unless ``measure_error`` is False. ``times`` increase and
    do not lie before ``state.t``. The state is left alone.

    Raises ValueError for what cannot be run, for a lattice that blows up before the last time, and
    for a tolerance below what rounding leaves.

    >>> n = np.arange(64)
    >>> state = State(0.0, 0, 0.1 * np.cos(np.pi * n / 32), np.zeros(64))
    >>> run = integrate(Model(1.0, 0.0, 0.0), state, [0.0, 10.0], tolerance=1e-6)
    >>> exact = 0.1 * np.cos(np.pi * n / 32) * np.cos(2.0 * np.sin(np.pi / 64) * 10.0)
    >>> bool(np.abs(run.strain[1] - exact).max() <= run.error_estimate <= 1e-6)
    True
    """
    state = _checked_state(state)
    wanted = checked_times(times, state.t)
    if scheme not in SCHEMES:
        check_order(scheme)
    if (tolerance is None) == (step is None):
        raise ValueError(
            f"either tolerance or step must be given, got tolerance {tolerance} and step {step} "
            "(a tolerance finds the step)"
        )
    begun = perf_counter()
    if tolerance is not None:
        remedy = "it is the error of the strain that is accepted, in the strain's unit"
        check_positive("tolerance", tolerance, remedy)
        found = refine(RingSearch(model, state, wanted, scheme), tolerance)
        return _trajectory(found.trial, found.error, begun, scheme)
    assert step is not None
    return _stated(RingSearch(model, state, wanted, scheme), step, measure_error, begun)


def _checked_state(state: State) -> State:
    """The state with arrays of doubles."""
    found = replace(state, y=np.asarray(state.y, np.float64), s=np.asarray(state.s, np.float64))
    for name, values in (("y", found.y), ("s", found.s)):
        if values.shape != (found.size,) or found.size < 3:
            raise ValueError(
                f"state.{name} must hold one number for each of at least 3 sites, got the shape "
                f"{values.shape} (strain and velocity are arrays of one length)"
            )
        broken = ~np.isfinite(values)
        if np.any(broken):
            place = int(np.argmax(broken))
            raise ValueError(
                f"state.{name} must be finite, got {values[place]} at place {place} "
                "(look at where the state comes from)"
            )
    return found


def _stated(engine: "RingSearch", step: float, measure_error: bool, begun: float) -> Trajectory:
    """A run with that step, its error measured with a shorter one."""
    check_positive("step", step, "it goes forward in time")
    check_step(step, engine.scheme, engine.model, engine.state.y)
    choices = replace(engine.first(), step=step)
    trial, error = engine.run(choices, True), math.nan
    if measure_error:
        control = engine.run(engine.varied(choices, engine.kinds), True)
        error = RING_SAFETY * difference(trial, control) + max(trial.rounding, control.rounding)
    return _trajectory(trial, error, begun, engine.scheme)


def _trajectory(trial: Trial, error: float, begun: float, scheme: Scheme) -> Trajectory:
    stepper, times, strain, velocity = trial.payload
    if stepper.blow_up is not None:
        raise ValueError(
            f"times must end before the lattice blows up, got {times[-1]:g} ({stepper.blow_up}, "
            "whatever the step; end earlier or take smaller strains)"
        )
    if trial.values is None and math.isinf(error):
        raise ValueError(
            f"times must end before strains run away, got {times[-1]:g} (no step follows them; end "
            "earlier or take smaller strains)"
        )
    cost = Cost(
        stepper.steps,
        stepper.steps * scheme.stages,
        trial.seconds,
        perf_counter() - begun,
    )
    return Trajectory(times, strain, velocity, error, scheme.name, trial.choices.step, cost)


class RingSearch(StepSearch):
    """Runs of a ring of sites from a state, for `refine` to judge: only the step varies."""

    safety = RING_SAFETY

    def __init__(self, model: Model, state: State, times: Array, scheme: Scheme) -> None:
        self.model, self.state, self.scheme = model, state, scheme
        self.fragile = model.kernel[1:] != (None, None)
        self.threads = 2 if blocked.fits(state.size, scheme.stages) else 1
        self._times = times
        self._admitted = self._longest_step(state.y)
        if not self._admitted > 0.0:
            raise ValueError(
                "state.y must leave K2 + 2 K3 y + 3 K4 y^2 finite, got a strain of "
                f"{float(np.max(np.abs(state.y))):g} (take other units)"
            )
        stops = np.concatenate([[state.t], times])
        super().__init__(scheme.order, LIMIT_SHARE * self._admitted, stops, state.size)

    def run(self, choices: Choices, shown: bool, progress: Progress = lambda _: None) -> Trial:
        """A run; its payload is the stepper, the times, strains and velocities."""
        begun = perf_counter()
        stepper = Stepper(
            state := self._start(choices.nudged),
            self.scheme,
            self.model,
            StillRing(state),
            choices.step,
            None,
        )
        wanted, rows = set(self._times.tolist()), {}
        for state in stepper.through(self._times.tolist()):
            if state.t in wanted:
                rows[state.t] = state.strain(state.sites), state.velocity(state.sites)
            progress((state.t - self._stops[0]) / (self._stops[-1] - self._stops[0] or 1.0))
        strain, velocity = np.array([*rows.values()]).reshape(-1, 2, state.size).swapaxes(0, 1)
        values, longest = None, self._longest_step(np.array(stepper.strain))
        self._admitted = min(self._admitted, longest)
        if stepper.blow_up is None and self._taken(choices.step) <= longest:
            values = np.array([strain, velocity / (2.0 * math.sqrt(self.model.K2))])
        return Trial(
            choices,
            values,
            float(stepper.steps),
            perf_counter() - begun,
            rounding_error(max(map(abs, stepper.strain)), stepper.steps * self.scheme.stages),
            (stepper, self._times, strain, velocity),
        )

    def _taken(self, step: float) -> float:
        """The longest step that is taken where the stops shorten it."""
        gaps = np.diff(self._stops)
        return float(np.max(gaps / np.maximum(np.ceil(gaps / step), 1.0)))

    def better(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """A step that follows the strains that were met, or by the law of the order."""
        if math.isinf(excess) and 0.0 < self._admitted < choices.step:
            step = max(LIMIT_SHARE * self._admitted, LEAST_FACTOR * choices.step)
            return replace(choices, step=step)
        return super().better(choices, kind, excess)

    def _longest_step(self, strains: Array) -> float:
        """The longest step that is stable about the strains; 0 if they are no numbers.

        A run with a longer one shows neither waves nor what runs away: two such runs may agree.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            stiffest = max(float(np.max(np.abs(self.model.stiffness(strains)))), self.model.K2)
        limit = stability_limit(self.scheme) / (2.0 * math.sqrt(stiffest))
        return limit if math.isfinite(stiffest) else 0.0

    def _start(self, nudged: bool) -> State:
        """A copy of the state; ``nudged`` with the last digits of both its arrays changed."""
        start = replace(self.state, y=self.state.y.copy(), s=self.state.s.copy())
        if nudged:
            signs = np.random.default_rng(0).choice([-NUDGE, NUDGE], (2, start.size))
            start.y *= 1.0 + signs[0]
            start.s *= 1.0 + signs[1]
        return start
