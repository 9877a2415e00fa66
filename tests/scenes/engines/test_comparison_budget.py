"""Catches: a search that goes round in circles, and one that takes all memory, before it gives up.

Scenes without an answer were: a lattice that amplifies rounding to the size of the wave, where
every step that a search tries is as wrong as the one before; and a ring in which short waves come
round, however wide it is.
"""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from longwave.lattice.refine import refine
from longwave.lattice.trial import Choices, Engine, Kind, Progress, Trial
from longwave.scenes import run
from longwave.scenes.description.scene import Scene
from longwave.support.request_limits import OverBudgetError, request_limits
from searches.estimate_scenes import random_scene


@dataclass
class Toy:
    """Its error is ``error(choices)``; what the last digits change is ``rounding``."""

    rounding: float = 0.0
    plateau: float = 0.0
    amplifies_rounding: bool = False
    most_work: float = np.inf
    runs: list[Choices] = field(default_factory=list)
    kinds: tuple[Kind, ...] = ("step",)
    threads: int = 1
    order: int = 4
    decay: float = np.inf
    safety: float = 2.0
    unstable: int = 1

    def first(self) -> Choices:
        return Choices(1.0, 100.0)

    def coarse_engine(self) -> Engine:
        return self

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        self.runs.append(choices)
        sign = (-1.0) ** len(self.runs)
        value = choices.step**4 + sign * self.plateau + self.rounding * choices.nudged
        return Trial(choices, np.array([[value]]), self.work(choices), 0.0, 0.0, None)

    def control(self, choices: Choices, kinds: Collection[Kind]) -> Choices:
        return replace(choices, step=0.6 * choices.step)

    def improved(self, choices: Choices, kind: Kind, excess: float) -> Choices:
        return replace(choices, step=max(0.2, 0.9 * excess**-0.25) * choices.step)

    def taken(self, choices: Choices) -> float:
        return choices.step

    def work(self, choices: Choices) -> float:
        return 1.0 / choices.step


def test_a_law_that_holds_needs_a_run_and_its_control_for_each_step_tried() -> None:
    toy = Toy()
    assert refine(toy, 1e-6).error <= 1e-6
    assert not any(choices.nudged for choices in toy.runs)
    assert len(toy.runs) <= 8


@dataclass
class Misleading(Toy):
    """An error that hardly varies at long steps, and obeys the law below the step ``lawful``."""

    wrong: float = 0.02
    lawful: float = 0.5

    def run(self, choices: Choices, shown: bool, progress: Progress) -> Trial:
        self.runs.append(choices)
        error = self.wrong * (1.0 + 1e-5 * choices.step)
        if choices.step < self.lawful:
            error = self.wrong * (choices.step / self.lawful) ** self.order
        return Trial(choices, np.array([[error]]), self.work(choices), 0.0, 0.0, None)


@pytest.mark.parametrize("lawful", [0.9, 0.7, 0.5])
def test_runs_that_agree_and_are_both_wrong_are_not_believed(lawful: float) -> None:
    """Catches: a pair of runs judged near the longest stable step, where errors obey no law."""
    found = refine(Misleading(lawful=lawful), 1e-3)
    assert found.trial.values is not None
    true = float(np.max(np.abs(found.trial.values)))
    assert true <= found.error <= 1e-3


def test_a_plateau_ends_before_steps_become_dear() -> None:
    toy = Toy(plateau=1e-2)
    with pytest.raises(ValueError, match="finer steps no longer help, and rounding is only"):
        refine(toy, 1e-6)
    assert len(toy.runs) <= 14
    assert sum(map(toy.work, toy.runs)) < 5000


def test_a_plateau_of_rounding_is_told_at_once() -> None:
    toy = Toy(plateau=1e-2, rounding=1e-2)
    with pytest.raises(ValueError, match="neighbouring states of the lattice part so fast"):
        refine(toy, 1e-6)
    assert len(toy.runs) <= 8


def test_what_becomes_of_rounding_is_part_of_the_error() -> None:
    toy = Toy(rounding=3e-7, amplifies_rounding=True)
    found = refine(toy, 1e-6)
    assert 6e-7 <= found.rounding <= found.error <= 1e-6


def test_an_engine_gives_up_where_it_is_too_dear() -> None:
    with pytest.raises(OverBudgetError):
        refine(Toy(plateau=1e-2, most_work=1e2), 1e-6)


def _scene(name: str, eps: float, **fields: Any) -> Scene:
    return Scene.of(name=name, wave=name, eps=eps, observables=("strain",), **fields)


GROWING = _scene(
    "wave_sn",
    0.01804,
    K2=0.1585,
    K4=-64.76,
    t0=-8480.7,
    snapshots=(1315.0,),
    compared=245,
    tolerance=8.886e-3,
    engine="stencil",
    parameters=(("k", 0.6668),),
)
BARELY = _scene(
    "wave_sn",
    0.07091,
    K2=0.02244,
    K4=-0.4608,
    t0=-93502.06236350919,
    snapshots=(-76624.00278564543,),
    compared=108,
    tolerance=5.094e-7,
    parameters=(("k", 0.867),),
)


@pytest.mark.parametrize("scene", [GROWING, pytest.param(BARELY, marks=pytest.mark.slow)])
def test_a_lattice_that_amplifies_rounding_is_refused(scene: Scene) -> None:
    """The second was given an estimate of 4e-7, where rounding alone came to 6e-7."""
    with pytest.raises(ValueError, match=r"rounding (comes|has grown) to"):
        run(scene)


def test_the_tolerance_that_a_refusal_names_is_kept() -> None:
    found = run(BARELY.changed(tolerance=2e-6))
    assert found.attrs["error_estimate"] <= 2e-6
    assert found.attrs["rounding_estimate"] > 1e-7


@pytest.mark.parametrize("fields", [{"snapshots": (1e6,)}, {"compared": 2**20}])
def test_more_sites_than_memory_holds_are_refused(fields: dict[str, Any]) -> None:
    base: dict[str, Any] = {"K2": 1.0, "K4": 1.0, "t0": 0.0, "snapshots": (10.0,), "compared": 60}
    scene = _scene("wave_cn", 0.02, **(base | fields), tolerance=1e-3, parameters=(("k", 0.5),))
    with request_limits(memory="500M"), pytest.raises(ValueError, match=r"must fit 500 MB, got"):
        run(scene.changed(engine="stencil"))


@pytest.mark.slow
def test_a_ring_by_name_that_never_ends_is_refused() -> None:
    """A steep soliton at tolerance 1.6e-8: each wider ring improved a little more slowly."""
    with pytest.raises(ValueError, match=r"the next rings alone would take \d+ s, site by site"):
        run(random_scene(2, 13).scene)
