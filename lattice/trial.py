"""Runs whose error is to be judged: what was chosen, what they gave, and the engines that do them.

Values and errors are of y in the unit of the tolerance, sup over the compared sites.
"""

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NUDGE = 2.0**-51
"""Relative change of the data's last digits."""


def nudged(*arrays: Array, times: float = 1.0) -> tuple[Array, ...]:
    """The arrays with the last digits of all numbers changed, the same way each time.

    They change by so many ``times`` the least that is usual.
    """
    random, size = np.random.default_rng(0), times * NUDGE
    return tuple(values * (1.0 + random.choice([-size, size], values.shape)) for values in arrays)


@dataclass(frozen=True)
class Choices:
    """All numerical choices of a run.

    ``step`` in time; ``size`` of the domain in sites; ``causal`` if no signal from its ends reaches
    a compared site in time; ``density`` in points per site, or more if the spectrum calls for more,
    and of either ``finer`` times as many; ``shift`` of the domain's middle, in its sizes;
    ``absorber`` is the strength of one at the seam, 0 if there is none; ``start`` the
    step at first, until what the data send to the left has left the wave, 0 if there is none.
    ``nudged`` if the last digits of the data are changed, by ``NUDGE``.
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
    """A finished run: ``values`` of y/eps on the compared sites at all times that are looked at.

    They are None after a blow-up. ``rounding`` estimates what rounding has done to them,
    ``common_error`` bounds what a run with a shorter step would not show, for it does the same.
    ``payload`` is the engine's own. ``shown`` if the observables can be asked for. An unfinished
    run holds the times before it was stopped. ``around`` are values on more sites, if there are
    any: what rounding has grown to on a few of them may be little by chance.
    """

    choices: Choices
    values: Array | None
    work: float
    seconds: float
    rounding: float
    payload: Any
    shown: bool = True
    common_error: float = 0.0
    around: Array | None = None


class StoppedTrial(KeyboardInterrupt):
    """Ctrl-C during a run: what there is of it."""

    def __init__(self, trial: Trial) -> None:
        super().__init__("interrupted")
        self.trial = trial


def difference(one: Trial, other: Trial) -> float:
    """Largest difference of y/eps between two runs; infinite if either blew up."""
    return _apart(one.values, other.values)


def difference_around(one: Trial, other: Trial) -> float:
    """The same, or that on more sites if it is larger."""
    found = difference(one, other)
    return found if one.around is None else max(found, _apart(one.around, other.around))


def _apart(one: Array | None, other: Array | None) -> float:
    if one is None or other is None:
        return math.inf
    with np.errstate(invalid="ignore", over="ignore"):
        found = float(np.max(np.abs(one - other)))
    return found if math.isfinite(found) else math.inf


ROUNDING = 4.0 * 2.0**-53
"""What one evaluation adds to a unit strain: a few roundings, of signs that vary."""

STEADY = 2.0**-53
"""The part whose sign does not vary (measured: 0.4 of it, on a kink's far field at t = 2e8)."""


def rounding_error(largest: float, evaluations: int) -> float:
    """What rounding is taken to do to strains of that size in so many force evaluations a site.

    Where nothing moves, it is the same every time and adds up.

    >>> rounding_error(5.0, 10_000) < 1e-11
    True
    """
    return largest * (ROUNDING * math.sqrt(1.0 + evaluations) + STEADY * evaluations)


def clock_error(values: NDArray[np.float64], c: float, times: tuple[float, float]) -> float:
    """What two roundings of the time do to ``values``, of neighbouring sites, which move at c.

    Far from t = 0 a time stands for its unit in the last place, in which the wave goes on.

    >>> f"{clock_error(np.array([[0.0, 1.0]]), 1.0, (2.0**28, 2.0**28 + 1)):.2g}"
    '1.2e-07'
    """
    slope = float(np.max(np.abs(np.diff(values, axis=-1)), initial=0.0))
    return 2.0 * float(np.spacing(max(map(abs, times)))) * c * slope


Kind = Literal["step", "sampling", "domain"]
Progress = Callable[[float], None]
"""Called with the share of the work that is done, 0 .. 1."""

SAFETY = 2.0
"""Factor on the difference of the last two runs: their error may fall as slowly as 1/size."""


class Engine(Protocol):
    """What is to be known of an engine: its runs, and how its errors depend on its choices."""

    kinds: tuple[Kind, ...]
    """What can be varied."""
    threads: int
    """Runs that may be done at once."""
    order: int
    """The time step's error falls like step^order."""
    decay: float
    """A domain's error falls at least like size^-decay."""
    safety: float
    """Factor on the difference of two runs, ``SAFETY`` or more."""
    unstable: int
    """Steps tried, each shorter, until one is stable."""
    amplifies_rounding: bool
    """Whether perturbations may grow, so that what becomes of rounding is measured."""
    most_work: float
    """The most that the next runs may take, in the unit of `work`."""

    def first(self) -> Choices:
        """Where the search begins."""

    def coarse_engine(self) -> "Engine":
        """An engine that finds the step on fewer sites; itself, if there is none."""

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        """A run; ``shown`` if its observables may be asked for afterwards.

        Raises StoppedTrial on Ctrl-C.
        """

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """Finer, wider or elsewhere in each of the kinds, and not in the others."""

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """Choices with which that kind's error is smaller by the factor ``excess`` > 1."""

    def taken(self, choices: Choices) -> float:
        """The step that makes the error of a run, where stops shorten the one that was chosen."""

    def work(self, choices: Choices) -> float:
        """What a run costs, in any unit, as `Trial` counts it."""


DRIVEN_SHARE = 0.5
"""Longest step tried, in units of the time in which a force from outside changes by all that it
does: two runs with longer steps may agree on what neither has seen."""

LEAST_FACTOR = 0.2
"""Least factor from one step to the next one tried."""

MARGIN = 0.95
"""What a step is shorter by than its law asks for."""

STEP_RATIO = 0.7
"""Step of a control run of a `StepSearch`, in units of the one before it."""


def lawful_step(step: float, order: int, excess: float) -> float:
    """The step with which an error that falls like step^order is smaller by ``excess``.

    >>> round(lawful_step(1.0, 6, 64.0), 3)
    0.475
    """
    return step * max(LEAST_FACTOR, MARGIN * excess ** (-1.0 / order))


def mean_step(stops: Array, step: float, order: int) -> float:
    """The step that would make the same error if the stops did not shorten it.

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
    """The step, or the longest gap between two stops where that is shorter.

    >>> step_between(np.array([0.0, 1.0, 1.5]), 3.0)
    1.0
    """
    return min(step, float(np.max(np.diff(stops))) or step)


def shorter_step(stops: Array, step: float, order: int, ratio: float) -> float:
    """A step whose error falls as that of ``ratio`` times the step, whatever the stops."""
    return step_taken(stops, ratio * step, order, ratio * mean_step(stops, step, order))


def step_taken(stops: Array, step: float, order: int, most: float) -> float:
    """The step, or a shorter one whose error is at most that of steps ``most``, whatever the stops.

    >>> round(step_taken(np.array([0.0, 1.0]), 0.9, 6, 0.4), 2)
    0.49
    """
    while mean_step(stops, step, order) > most:
        step *= 0.97
    return step


class StepSearch:
    """An engine of which only the time step is to be found; `run` is its user's.

    ``first_step`` is the longest one tried; ``stops`` are times that are hit exactly, from the
    beginning to the end: between them the steps are equal.
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
        """The longest step."""
        return self._first

    def coarse_engine(self) -> Engine:
        """Itself: there are no sites to spare."""
        return self

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        """A run with that step."""
        raise NotImplementedError

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        """A shorter step."""
        step = shorter_step(self._stops, choices.step, self.order, STEP_RATIO)
        return replace(choices, step=step)

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        """By the law of the order, of the step that is taken where stops shorten it."""
        step, order = step_between(self._stops, choices.step), self.order
        wanted = max(LEAST_FACTOR / MARGIN, excess ** (-1.0 / order)) * self.taken(choices)
        found = lawful_step(step, order, excess)
        return replace(choices, step=step_taken(self._stops, found, order, wanted))

    def taken(self, choices: Choices) -> float:
        """The mean of the steps between the stops."""
        return mean_step(self._stops, choices.step, self.order)

    def work(self, choices: Choices) -> float:
        """Steps."""
        return float(self._stops[-1] - self._stops[0]) / choices.step
