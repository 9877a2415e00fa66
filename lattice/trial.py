"""Runs whose error is to be estimated: their choices, their values, and the engines that make them.

Values and errors are of y in the unit of the tolerance, sup over the compared sites.
"""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

import numpy as np

from longwave.support.real_arrays import Array

NUDGE = 2.0**-51
"""Relative change of the last digits of a run's data."""


def nudged(*arrays: Array, times: float = 1.0) -> tuple[Array, ...]:
    """Return the arrays times 1 +- ``times`` `NUDGE`, with the same random signs in every call."""
    random, change = np.random.default_rng(0), times * NUDGE
    return tuple(
        values * (1.0 + random.choice([-change, change], values.shape)) for values in arrays
    )


@dataclass(frozen=True)
class Choices:
    """All numerical choices of a run.

    ``step`` in time; ``size`` of the domain in sites; ``causal`` if no signal from its ends reaches
    a compared site in time; ``density`` in points per site, or more if the spectrum needs more, and
    ``finer``, a factor on the density; ``shift`` of the domain's middle, in its sizes;
    ``absorber``, the absorber's strength at the seam, 0 for none; ``start``, the initial step,
    until the waves sent to the left have left the wave, 0 for none. ``nudged`` if the last digits
    of the data are changed, by ``NUDGE``.
    """

    step: float
    size: float
    causal: bool = False
    density: float = 1.0
    finer: float = 1.0
    shift: float = 0.0
    absorber: float = 0.0
    start: float = 0.0
    nudged: bool = False


@dataclass(frozen=True)
class Trial:
    """A finished run: ``values``, such as y/eps on the compared sites, at all observed times.

    ``values`` is None after a blow-up. ``rounding`` estimates the rounding error of the values;
    ``common_error`` bounds the error that a run with a shorter step shares. ``payload`` is the
    engine's own data. ``has_observables`` if observables can be computed from it. An unfinished run
    has the times before it was stopped. ``around`` are values on more sites, if any: on a few sites
    the effect of rounding may be small by chance.
    """

    choices: Choices
    values: Array | None
    work: float
    seconds: float
    rounding: float
    payload: Any
    has_observables: bool = True
    common_error: float = 0.0
    around: Array | None = None


class StoppedTrial(KeyboardInterrupt):
    """Raised on Ctrl-C during a run; holds the unfinished run."""

    def __init__(self, trial: Trial) -> None:
        super().__init__("interrupted")
        self.trial = trial


def difference(first: Trial, second: Trial) -> float:
    """Return the largest difference of the values of two runs; infinite if either blew up."""
    return _largest_difference(first.values, second.values)


def difference_around(first: Trial, second: Trial) -> float:
    """Return the `difference` of two runs, or that on more sites (``around``) if it is larger."""
    around = 0.0 if first.around is None else _largest_difference(first.around, second.around)
    return max(difference(first, second), around)


def _largest_difference(first: Array | None, second: Array | None) -> float:
    """Return the largest difference of two arrays; inf if one is None or not finite."""
    if first is None or second is None:
        return math.inf
    with np.errstate(invalid="ignore", over="ignore"):
        largest = float(np.max(np.abs(first - second)))
    return largest if math.isfinite(largest) else math.inf


FORCE_ROUNDING = 4.0 * 2.0**-53
"""Rounding error of one force evaluation at unit strain: a few roundings of either sign."""

STEADY_ROUNDING = 2.0**-53
"""Part of `FORCE_ROUNDING` that always has the same sign (0.4 of it on a kink's far field at t =
2e8)."""


def rounding_error(largest: float, evaluations: int) -> float:
    """Return the estimated rounding error of strains after some evaluations per site.

    ``largest`` is the size of the strains. In a field at rest each rounding is the same, and the
    roundings add up.

    >>> rounding_error(5.0, 10_000) < 1e-11
    True
    """
    return largest * (FORCE_ROUNDING * math.sqrt(1.0 + evaluations) + STEADY_ROUNDING * evaluations)


def clock_error(values: Array, c: float, times: tuple[float, float]) -> float:
    """Return the effect that rounding the time twice has on ``values`` of neighbouring sites.

    The wave moves at speed ``c``. Far from t = 0 a time is accurate to its last digit only.

    >>> f"{clock_error(np.array([[0.0, 1.0]]), 1.0, (2.0**28, 2.0**28 + 1)):.2g}"
    '1.2e-07'
    """
    slope = float(np.max(np.abs(np.diff(values, axis=-1)), initial=0.0))
    return 2.0 * float(np.spacing(max(map(abs, times)))) * c * slope


Kind = Literal["step", "sampling", "domain"]
Progress = Callable[[float], None]
"""Callback with the fraction of the work that is done, 0 .. 1."""

SAFETY = 2.0
"""Factor on the difference of the last two runs: their errors may fall as slowly as 1/size."""


class Engine(Protocol):
    """Protocol of an engine: its runs, and how their errors depend on the choices."""

    kinds: tuple[Kind, ...]
    """Discretisation parameters that the engine can refine, such as its step and its domain."""
    threads: int
    """Number of runs that may be made concurrently."""
    order: int
    """Order of the time step's error, step^order."""
    decay: float
    """Least exponent in the law size^-decay of a domain's error."""
    safety: float
    """Factor on the difference of two runs in the error estimate, ``SAFETY`` or more."""
    unstable: int
    """Largest number of steps tried, each shorter than the one before, until one is stable."""
    amplifies_rounding: bool
    """Whether perturbations may grow, so that the effect of rounding is measured."""
    most_work: float
    """Largest work accepted for the next runs, in the unit of `work`."""

    def first(self) -> Choices:
        """Return the choices with which the search begins."""

    def coarse_engine(self) -> "Engine":
        """Return an engine that finds the step on fewer sites, by default the engine itself."""
        return self

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        """Make a run; if ``shown``, its observables are needed afterwards.

        Raises StoppedTrial on Ctrl-C.
        """

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """Return choices refined in the given kinds only: finer, wider, or moved elsewhere."""

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """Return choices whose error of this ``kind`` is smaller by the factor ``excess`` > 1."""

    def taken(self, choices: Choices) -> float:
        """Return the effective step of a run: stops make it shorter than the chosen step."""

    def work(self, choices: Choices) -> float:
        """Return the expected work of a run, in the unit of `Trial.work`."""


DRIVEN_SHARE = 0.5
"""Longest step tried, in units of the time scale of an external force: two runs with longer steps
may agree on a force that neither resolves."""

LEAST_FACTOR = 0.2
"""Least ratio of a step to the step tried before."""

MARGIN = 0.95
"""Safety factor on the step predicted by the law step^order."""

STEP_RATIO = 0.7
"""Step of a control run of a `StepSearch`, as a fraction of the step of the run before it."""


def lawful_step(step: float, order: int, excess: float) -> float:
    """Return the step that reduces an error ~ step^order by the factor ``excess``.

    >>> round(lawful_step(1.0, 6, 64.0), 3)
    0.475
    """
    return step * max(LEAST_FACTOR, MARGIN * excess ** (-1.0 / order))


def mean_step(stops: Array, step: float, order: int) -> float:
    """Return the step with the same error as the actual steps, which stops make shorter.

    Between two stops the steps are equal and at most ``step``.

    >>> mean_step(np.array([0.0, 1.0, 2.0]), 0.9, 6)
    0.5
    """
    gaps = np.diff(stops)
    gaps = gaps[gaps > 0]
    if gaps.size == 0:
        return step
    taken = gaps / np.ceil(gaps / step * (1.0 - 1e-12))
    return float(np.average((taken / step) ** order, weights=gaps) ** (1.0 / order) * step)


def step_between(stops: Array, step: float) -> float:
    """Return ``step``, or the longest gap between two stops if that gap is shorter.

    >>> step_between(np.array([0.0, 1.0, 1.5]), 3.0)
    1.0
    """
    return min(step, float(np.max(np.diff(stops))) or step)


def shorter_step(stops: Array, step: float, order: int, ratio: float) -> float:
    """Return a step with the error of ``ratio`` times the mean step, whatever the stops."""
    return step_taken(stops, ratio * step, order, ratio * mean_step(stops, step, order))


def step_taken(stops: Array, step: float, order: int, target: float) -> float:
    """Return ``step``, shortened until its error is at most that of the step ``target``.

    Errors are those of the actual steps, which the stops shorten.

    >>> round(step_taken(np.array([0.0, 1.0]), 0.9, 6, 0.4), 2)
    0.49
    """
    while mean_step(stops, step, order) > target:
        step *= 0.97
    return step


class StepSearch(Engine):
    """Base of engines for which only the time step is chosen; subclasses define `run`.

    ``first_step`` is the longest step tried; ``stops`` are times that are hit exactly, from the
    beginning to the end. Between two stops the steps are equal.
    """

    kinds: tuple[Kind, ...] = ("step",)
    threads = 1
    decay = math.inf
    safety = SAFETY
    unstable = 4
    amplifies_rounding = False
    most_work = math.inf

    def __init__(self, order: int, first_step: float, stops: Array, size: float = 1.0) -> None:
        self.order = order
        self._first, self._stops = Choices(first_step, size), stops

    def first(self) -> Choices:
        """Return the choices with the longest step."""
        return self._first

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """Return choices with a shorter step."""
        step = shorter_step(self._stops, choices.step, self.order, STEP_RATIO)
        return replace(choices, step=step)

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """Return choices with a shorter step, whose error ~ step^order is smaller by ``excess``."""
        step, order = step_between(self._stops, choices.step), self.order
        target = max(LEAST_FACTOR / MARGIN, excess ** (-1.0 / order)) * self.taken(choices)
        shorter = lawful_step(step, order, excess)
        return replace(choices, step=step_taken(self._stops, shorter, order, target))

    def taken(self, choices: Choices) -> float:
        """Return the effective step (`mean_step`): stops make it shorter than the chosen step."""
        return mean_step(self._stops, choices.step, self.order)

    def work(self, choices: Choices) -> float:
        """Return the number of steps."""
        return float(self._stops[-1] - self._stops[0]) / choices.step
