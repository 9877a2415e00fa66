"""Error estimation by an engine whose errors and blow-ups are known.

Catches: a lattice reported to blow up where shorter steps cure it, a refusal that reports what was
not measured, redundant runs, an error attributed to the wrong choice.
"""

import math
from collections.abc import Collection
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from longwave.derive import LATTICES
from longwave.lattice import State, driven_chain, integrate
from longwave.lattice.numeric_lattice import numeric_lattice
from longwave.lattice.refine import refine
from longwave.lattice.trial import (
    STEP_RATIO,
    Choices,
    Engine,
    Kind,
    Progress,
    StepSearch,
    Trial,
    lawful_step,
)


class Breaking:
    """Engine whose value has the error step^2.

    None if the step is longer than ``longest``, or ``among``.
    """

    kinds: tuple[Kind, ...] = ("step",)
    threads, order, decay, safety, unstable, amplifies_rounding = 1, 2, 1.0, 2.0, 1, False
    most_work = math.inf

    def __init__(self, longest: float, among: tuple[float, float] = (0.0, 0.0)) -> None:
        self.longest, self.among = longest, among

    def first(self) -> Choices:
        return Choices(1.0, 10.0, causal=True)

    def coarse_engine(self) -> Engine:
        return self

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        low, high = self.among
        breaks = choices.step > self.longest or low < choices.step < high
        values = None if breaks else np.array([choices.step**2])
        return Trial(choices, values, 1.0, 0.0, 0.0, None, shown)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        return replace(choices, step=choices.step * STEP_RATIO) if "step" in kinds else choices

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        return replace(choices, step=lawful_step(choices.step, self.order, excess))

    def taken(self, choices: Choices) -> float:
        return choices.step

    def work(self, choices: Choices) -> float:
        return 1.0 / choices.step


@pytest.mark.parametrize(
    ("longest", "own"), [(2.0, False), (0.3, False), (0.05, False), (0.02, True), (0.0, True)]
)
def test_a_blow_up_in_three_pairs_of_runs_is_physical(longest: float, own: bool) -> None:
    """Their steps are 1, 0.2 and 0.04; those of the control runs 0.7 of that."""
    found = refine(Breaking(longest), 1e-2)
    assert math.isinf(found.error) is own
    assert (found.trial.values is None) is own
    assert own or abs(found.trial.values[0]) <= found.error <= 1e-2  # type: ignore[index]


def test_blow_ups_with_a_good_run_between_them_are_numerical() -> None:
    """The steps are 1, 0.2, 0.04 and about 0.01; only the third run completes."""
    found = refine(Breaking(0.05, among=(0.003, 0.025)), 1e-4)
    assert found.error <= 1e-4


def test_the_actual_steps_are_shortened() -> None:
    """Catches: a shorter step that gives the same actual steps, and so repeats the run."""
    for gaps in ([1.0], [1.0] * 5, [0.3, 1.0, 0.7], [2.0, 0.01]):
        stops = np.concatenate([[0.0], np.cumsum(gaps)])
        for order, step, excess in product((2, 6, 8), (0.2, 0.53, 0.9, 1.5, 4.0), (1.01, 1.4, 9)):
            engine = StepSearch(order, step, stops)
            choices = engine.first()
            shorter = engine.improved(choices, "step", excess)
            share = (engine.taken(shorter) / engine.taken(choices)) ** order
            assert share <= max(1.0 / excess, 0.22**order) * (1.0 + 1e-9)


def test_a_mild_chain_runs_at_every_tolerance() -> None:
    """Catches: three equal runs between two stops, interpreted as errors that no step reduces."""
    lattice = numeric_lattice(LATTICES["alpha_fput"], {"K2": 0.5, "K3": 0.5})
    f, v = 0.1 * np.random.default_rng(31).standard_normal((2, 1, 12))
    chain = driven_chain(lattice, 12, left="fixed", right="fixed")
    for tolerance in np.geomspace(1e-7, 1e-3, 25):
        times = 3.1138 * np.arange(1.0, 6.0)
        assert integrate(chain, State(0.0, f, v), times, tolerance).error_estimate <= tolerance


class Blunt(StepSearch):
    """Engine with an error that no step reduces, or one that falls too slowly."""

    def __init__(self, slowly: bool) -> None:
        super().__init__(2, 1.0, np.array([0.0, 100.0]))
        self.slowly, self.steps = slowly, list[float]()

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        if choices.step not in self.steps:
            self.steps.append(choices.step)
        count = self.steps.index(choices.step)
        value = (-1.0) ** count * (0.6**count if self.slowly else 1.0)
        return Trial(choices, np.array([value]), 1.0, 0.0, 0.0, None, shown)


def test_a_refusal_reports_what_was_measured() -> None:
    with pytest.raises(ValueError, match="no longer help, and rounding is only"):
        refine(Blunt(slowly=False), 1e-9)
    with pytest.raises(ValueError, match=r"got 1e-90 \(after 12 control runs"):
        refine(Blunt(slowly=True), 1e-90)


class Windowed(StepSearch):
    """Engine with errors ``of_step`` step^6 and ``of_size`` size^-5; all runs are recorded.

    If it ``is_scouted``, a scout sees the step's error ``blunted``.
    """

    kinds: tuple[Kind, ...] = ("step", "domain")
    decay, safety = 5.0, 3.0

    def __init__(self, of_step: float, of_size: float, blunted: float = 1.0) -> None:
        super().__init__(6, 1.0, np.array([0.0, 1000.0]))
        self.of_step, self.of_size, self.blunted = of_step, of_size, blunted
        self.runs: list[Choices] = []

    def coarse_engine(self) -> Engine:
        is_blunted = self.blunted < 1.0
        return Windowed(self.blunted * self.of_step, 0.0) if is_blunted else self

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        self.runs.append(choices)
        value = self.of_step * choices.step**6 + self.of_size * choices.size**-5.0
        return Trial(choices, np.array([value]), 1.0, 0.0, 0.0, None, shown)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        found = super().control(choices, kinds) if "step" in kinds else choices
        return replace(found, size=1.3 * found.size) if "domain" in kinds else found

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        if kind == "step":
            return super().improved(choices, kind, excess)
        return replace(choices, size=choices.size * max(1.2, excess**0.2))


def test_the_control_run_of_a_window_confirms_the_steps_law() -> None:
    """Catches: a run with a shorter step alone, although one in a wider window shows the same."""
    engine = Windowed(1e-4, 1e-5)
    found = refine(engine, 1e-3)
    assert abs(float(found.trial.values[0])) <= found.error <= 1e-3  # type: ignore[index]
    assert [(one.step, one.size) for one in engine.runs[:2]] == [(1.0, 1.0), (0.7, 1.0)]
    assert [one.size for one in engine.runs[2:]] == [1.3]


@pytest.mark.parametrize("of_size", [0.01, 0.1, 10.0])
def test_a_window_is_widened_without_further_runs(of_size: float) -> None:
    """Catches: step and window varied separately although the step's change is known."""
    engine = Windowed(1e-4, of_size)
    found = refine(engine, 1e-3)
    assert abs(float(found.trial.values[0])) <= found.error <= 1e-3  # type: ignore[index]
    first, last = (one.size for one in engine.runs if one.size > 1.3)
    assert last == pytest.approx(1.3 * first)


@pytest.mark.parametrize("blunted", [1e-1, 1e-3])
def test_an_error_that_no_window_reduces_is_the_steps(blunted: float) -> None:
    """Catches: a window widened in vain where a scout saw almost nothing of the step's error."""
    engine = Windowed(0.1, 1e-6, blunted)
    found = refine(engine, 1e-3)
    assert abs(float(found.trial.values[0])) <= found.error <= 1e-3  # type: ignore[index]


def test_a_law_hidden_by_the_window_gets_its_own_run() -> None:
    """Catches: a law counted as confirmed although the window changed the values."""
    engine = Windowed(1e-4, 2e-3)
    refine(engine, 1e-3)
    assert [one.size for one in engine.runs].count(1.0) == 3
