"""An opponent of the estimates: it looks for the scene whose true error is most of its estimate.

A family is a wave on a lattice, with an engine; everything in its scene that is a number is what
differential evolution moves: parameters, eps, constants, times, compared cells, tolerance.  The
true error is the difference to the same run with a third of its step (the order is 6 or more, so
that it errs by a seven-hundredth of it), on the paper's chain to a causal reference of another
domain.  Refusals cost the opponent its turn.

    python benchmarks/opponent.py [--kind all] [--families 40] [--turns 200] [--seed 0]
                                  [--workers 2]

Prints each family's largest ratio with its scene, and the largest of all.  The exit status is 1 if
an error exceeds its estimate.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import random
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

from lattice import integrate
from lattice.refine import refine
from lattice.trial import StepSearch, Trial
from verify.comparison.scene import Scene
from verify.lattices.lattice_derivation import lattice_wave
from verify.lattices.lattice_run import compared_cells, lattice_times
from verify.lattices.lattice_scene import LatticeScene
from verify.lattices.ring_runs import RingRuns
from verify.lattices.sideband_growth import SidebandRuns, growth_plan
from verify.processes import OutOfTime, time_limit
from verify.studies.estimate_scenes import RandomScene, random_scene
from verify.studies.estimates import judge_scene, warm_up
from verify.studies.random_chains import random_case
from verify.studies.soak_scenes import soak_scene

Array = NDArray[np.float64]

FINER = 3.0
"""The reference's step is so many times shorter: with an order of 6 it errs by 1/729 of it."""

SECONDS = 4.0
"""Of the processor, for a run and its reference."""

FLOOR = 1e-3
"""Of a refused scene, and the least ratio that is told apart."""

REDRAWN = 60
"""Scenes that are drawn before a family is given up."""

NEAR_PI = ("pi", "pi", "3.1", "3", "2.2", "pi/2")
"""Carriers, most of them short: near the zone's edge steps are next to the stability limit."""


class NeutralError(Exception):
    """No estimate came of the scene."""


@dataclass(frozen=True)
class Found:
    """The most that the opponent made of a family: true error over estimate, and its scene."""

    family: str
    ratio: float
    estimate: float
    true: float
    scene: str
    turns: int
    answered: int


def ratio_of_search(engine: StepSearch, tolerance: float) -> tuple[float, float]:
    """Estimate and true error of what `refine` finds with an engine."""
    found = refine(engine, tolerance)
    trial: Trial = found.trial
    if trial.values is None or not math.isfinite(found.error):
        raise NeutralError
    step = trial.choices.step / FINER
    reference = engine.run(replace(trial.choices, step=step), False, lambda _: None)
    if reference.values is None:
        return found.error, math.inf
    own = 4.0 * reference.rounding
    return found.error, float(np.max(np.abs(reference.values - trial.values))) - own


def of_lattice(scene: LatticeScene) -> tuple[float, float]:
    """A scene on any lattice, or of a growth rate."""
    if scene.is_growth:
        return ratio_of_search(SidebandRuns(growth_plan(scene), scene), scene.tolerance)
    wave = lattice_wave(scene)
    times = lattice_times(scene, wave.slow)
    wave.start(times[0])
    return ratio_of_search(RingRuns(wave, compared_cells(scene, wave), times), scene.tolerance)


def of_chain(scene: Scene) -> tuple[float, float]:
    """A scene of the paper's chain, judged by the causal reference."""
    judged = judge_scene(RandomScene(0, 0, scene, 0))
    if judged.verdict not in ("honest", "dishonest"):
        raise NeutralError
    return judged.estimate, judged.true - judged.own


def moved(value: float, gene: float, factor: float) -> float:
    """A number times a power of ``factor``, from -1 to 1 as the gene goes from 0 to 1."""
    return float(f"{value * factor ** (2.0 * gene - 1.0):.5g}")


@dataclass
class LatticeFamily:
    """Scenes on a lattice about the one of (seed, index), carriers near the zone's edge."""

    seed: int
    index: int
    base: LatticeScene = field(init=False)

    def __post_init__(self) -> None:
        draw = random.Random(f"{self.seed}:{self.index}")
        for redrawn in range(REDRAWN):
            scene = soak_scene(self.seed, self.index, redrawn).changed(disorder=())
            if scene.carrier:
                scene = scene.changed(carrier=draw.choice(NEAR_PI))
            scene = scene.changed(tolerance=1e-3)
            if not scene.is_growth:
                span = draw.choice([20.0, 60.0, 200.0])
                scene = scene.changed(
                    slow_times=(),
                    times=(0.0, span),
                    half_width=None,
                    compared=draw.choice([1, 3, 12]),
                )
            try:
                with time_limit(SECONDS):
                    of_lattice(scene)
            except (ValueError, NeutralError, OutOfTime):
                continue
            self.base = scene
            return
        raise NeutralError

    @property
    def name(self) -> str:
        """The family in a line."""
        return f"{self.base.lattice}/{self.base.wave}"

    @property
    def genes(self) -> int:
        """How many numbers are moved."""
        return 4 + len(self.base.parameters)

    def scene(self, genes: Array) -> LatticeScene:
        """The scene of these numbers, each from 0 to 1."""
        base = self.base
        values = [
            (name, moved(value, gene, 1.5) if isinstance(value, float) else value)
            for (name, value), gene in zip(base.parameters, genes[4:], strict=True)
        ]
        changes: dict[str, Any] = {
            "parameters": tuple(values),
            "eps": moved(base.eps, genes[0], 3.0),
            "tolerance": moved(base.tolerance, genes[1], 10.0),
        }
        if base.times:
            begin, span = base.times[0], base.times[-1] - base.times[0]
            middle = begin + moved(span, genes[2], 3.0)
            changes["times"] = (begin, middle) if genes[3] < 0.7 else (begin, middle, 1.3 * middle)
        return base.changed(**changes)

    def judge(self, genes: Array) -> tuple[float, float, str]:
        """Estimate, true error and the scene in text."""
        scene = self.scene(genes)
        return *of_lattice(scene), scene.toml()


@dataclass
class ChainFamily:
    """Scenes of the paper's chain about the one of (seed, index), with any engine."""

    seed: int
    index: int
    base: Scene = field(init=False)

    def __post_init__(self) -> None:
        scene = random_scene(self.seed, self.index, budget=1.0).scene
        self.base = scene.changed(compared=random.Random(self.index).choice([1, 3, 30]))

    @property
    def name(self) -> str:
        """The family in a line."""
        return f"chain/{self.base.wave_name}/{self.base.target.engine or 'chosen'}"

    @property
    def genes(self) -> int:
        """How many numbers are moved."""
        return 5 + len(self.base.parameters)

    def scene(self, genes: Array) -> Scene:
        """The scene of these numbers, each from 0 to 1."""
        base = self.base
        values = [
            (name, moved(float(value), gene, 1.3))
            for (name, value), gene in zip(base.parameters, genes[5:], strict=True)
        ]
        span = moved(base.end - base.t0, genes[3], 3.0)
        t0 = float(f"{base.t0 + (genes[4] - 0.5) * span:.6g}")
        return base.changed(
            parameters=tuple(values),
            eps=moved(base.eps, genes[0], 3.0),
            K4=moved(base.constants.K4, genes[1], 3.0),
            tolerance=moved(1e-3, genes[2], 10.0),
            t0=t0,
            snapshots=(t0 + span,),
        )

    def judge(self, genes: Array) -> tuple[float, float, str]:
        """Estimate, true error and the scene in text."""
        scene = self.scene(genes)
        return *of_chain(scene), scene.toml()


@dataclass
class StateFamily:
    """`lattice.integrate` on random chains from random states: times, sizes and tolerance move."""

    seed: int
    index: int
    genes: int = 3

    def __post_init__(self) -> None:
        self.case = random_case(self.seed * 10_000 + self.index)

    @property
    def name(self) -> str:
        """The family in a line."""
        return f"integrate/{self.case.lattice.name}"

    def judge(self, genes: Array) -> tuple[float, float, str]:
        """Estimate, true error and the scene in text."""
        case = self.case
        size = 4.0 ** (2.0 * genes[0] - 1.0)
        state = replace(case.state, f=size * case.state.f, v=size * case.state.v)
        times = [state.t + moved(float(case.times[-1] - state.t), genes[1], 4.0)]
        tolerance = moved(case.tolerance, genes[2], 30.0)
        found = integrate(case.lattice, state, times, tolerance)
        fine = integrate(case.lattice, state, times, step=found.step / FINER, measure_error=False)
        gap = case.lattice.stretches(found.f[-1])
        other = case.lattice.stretches(fine.f[-1])
        true = max(float(np.max(np.abs(a - b))) for a, b in zip(gap, other, strict=True))
        told = {"case": self.index, "size": size, "times": times, "tolerance": tolerance}
        return found.error_estimate, true, json.dumps(told)


FAMILIES: Mapping[str, Callable[[int, int], Any]] = {
    "lattice": LatticeFamily,
    "chain": ChainFamily,
    "state": StateFamily,
}


def attack(kind: str, seed: int, index: int, turns: int) -> Found | None:
    """The worst scene of a family; None where no scene of it answers."""
    warnings.simplefilter("ignore")
    try:
        family = FAMILIES[kind](seed, index)
    except (NeutralError, ValueError):
        return None
    worst = Found(family.name, FLOOR, math.nan, math.nan, "", 0, 0)
    counts: Counter[str] = Counter()

    def cost(genes: Array) -> float:
        nonlocal worst
        counts["turns"] += 1
        try:
            with time_limit(SECONDS), np.errstate(all="ignore"):
                estimate, true, text = family.judge(genes)
        except (ValueError, NeutralError, OutOfTime, ArithmeticError):
            return -math.log(FLOOR)
        counts["answered"] += 1
        ratio = max(FLOOR, true / estimate) if estimate > 0.0 else FLOOR
        if ratio > worst.ratio:
            worst = Found(family.name, ratio, estimate, true, text, 0, 0)
        return -math.log(ratio)

    members = 2 * family.genes + 4
    differential_evolution(
        cost,
        [(0.0, 1.0)] * family.genes,
        maxiter=max(1, turns // members - 1),
        popsize=1,
        init=np.random.default_rng([seed, index]).random((members, family.genes)),
        rng=np.random.default_rng([seed, index, 1]),
        mutation=(0.4, 0.9),
        polish=False,
        tol=0.0,
    )
    return replace(worst, turns=counts["turns"], answered=counts["answered"])


def main() -> int:
    """Attack families of the kinds that are asked for; 1 if an error exceeds its estimate."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kind", choices=["all", *FAMILIES], default="all")
    parser.add_argument("--families", type=int, default=40)
    parser.add_argument("--turns", type=int, default=200, help="scenes tried in a family")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    kinds = list(FAMILIES) if given.kind == "all" else [given.kind]
    jobs = [(kinds[i % len(kinds)], given.seed, i, given.turns) for i in range(given.families)]
    begun, found = time.perf_counter(), []
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(given.workers, context, warm_up) as pool:
        for done in as_completed([pool.submit(attack, *job) for job in jobs]):
            one = done.result()
            if one is None:
                continue
            found.append(one)
            told = f"{one.ratio:8.3g} {one.family} ({one.answered} of {one.turns} answered)"
            print(told, flush=True)
            if one.ratio > 1.0:
                print(
                    f"  estimate {one.estimate:.3g}, true {one.true:.3g}\n{one.scene}", flush=True
                )
    turns, answered = (sum(getattr(one, key) for one in found) for key in ("turns", "answered"))
    largest = max((one.ratio for one in found), default=0.0)
    taken = time.perf_counter() - begun
    print(f"{turns} scenes, {answered} answered, largest ratio {largest:.3g}, {taken:.0f} s")
    return int(largest > 1.0)


if __name__ == "__main__":
    sys.exit(main())
