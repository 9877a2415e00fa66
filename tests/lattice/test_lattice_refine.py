"""The judge of a run's error, by an engine whose errors and blow-ups are known.

Catches: a lattice said to blow up by itself where shorter steps cure it.
"""

import math
from collections.abc import Collection
from dataclasses import replace

import numpy as np
import pytest

from longwave.lattice.refine import refine
from longwave.lattice.trial import (
    STEP_RATIO,
    Choices,
    Engine,
    Kind,
    Progress,
    Trial,
    lawful_step,
)


class Breaking:
    """A value that is off by step^2; none if the step is longer than ``longest``, or ``among``."""

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
def test_a_blow_up_that_outlives_three_pairs_of_runs_is_the_lattice_s_own(
    longest: float, own: bool
) -> None:
    """Their steps are 1, 0.2 and 0.04, the control runs' 0.7 of that."""
    found = refine(Breaking(longest), 1e-2)
    assert math.isinf(found.error) is own
    assert (found.trial.values is None) is own
    assert own or abs(found.trial.values[0]) <= found.error <= 1e-2  # type: ignore[index]


def test_blow_ups_with_a_run_between_them_are_not_the_lattice_s_own() -> None:
    """Its steps are 1, 0.2, 0.04, about 0.01, of which the third alone comes to an end."""
    found = refine(Breaking(0.05, among=(0.003, 0.025)), 1e-4)
    assert found.error <= 1e-4
