"""An opponent of the estimates: it looks for the scene whose true error is most of its estimate.

A family is a wave on a lattice, with an engine; everything in its scene that is a number is what
differential evolution moves: parameters, eps, constants, the carrier, times, compared cells,
tolerance.  The lattices of the catalogue come in turn, each with an envelope, a long wave, an
envelope about k = pi and a growth rate.  The true error is the difference to the same wave with a
third of its step (the order is 6 or more, so that it errs by a seven-hundredth of it) on a ring
that is half as wide again, and odd where the run's is even; on the paper's chain to a causal
reference of another domain.  Refusals cost the opponent its turn.

    python -m searches.opponent [--kind all] [--families 40] [--turns 200] [--seed 0]
                                  [--workers 2] [--unmended]

Prints each family's largest ratio with its scene, and the largest of all.  The exit status is 1 if
an error exceeds its estimate.  ``--unmended`` asks of no step that its law was seen: ``--kind
known`` then finds the cases for which that is asked.
"""

from __future__ import annotations

import argparse
import json
import math
import random
import sys
import time
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from copy import copy
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import differential_evolution

import longwave.lattice.refine
import longwave.scenes.engines.domain_plan
from longwave.derive import LATTICES
from longwave.lattice import integrate
from longwave.lattice.refine import refine
from longwave.lattice.trial import StepSearch, Trial
from longwave.scenes.description.scene import Scene
from longwave.scenes.description.scene_checks import Pairs
from longwave.scenes.engines.lattice_run import domain_plan
from longwave.scenes.engines.run_record import RunRecord
from longwave.scenes.engines.sideband_growth import SidebandRuns, growth_plan
from longwave.scenes.engines.site_engine import SiteEngine
from longwave.support.processes import Job, LocalWorkers, OutOfTime, as_ended, time_limit
from searches.estimate_judge import judge_scene, warm_up
from searches.estimate_scenes import RandomScene, random_scene
from searches.random_chains import random_case
from searches.soak_scenes import soak_scene

Array = NDArray[np.float64]

FINER = 3.0
"""The reference's step is so many times shorter: with an order of 6 it errs by 1/729 of it."""

FASTER = 1.5
"""The reference's ring is wide enough for signals that are so many times faster."""

SECONDS = 2.0
"""Of the processor, for a run and its reference."""

FIRST = 10.0
"""Of the processor, for a family's first scene with its derivation."""

CHEAP = 0.15
"""Most seconds that a family's first scene may take."""

FLOOR = 1e-3
"""Of a refused scene, and the least ratio that is told apart."""

REDRAWN = 40
"""Scenes that are drawn before a family is given up."""

NEAR_PI = ("pi", "pi", 3.1, 3.0, 2.2, "pi/2")
"""Carriers, most of them short: near the zone's edge steps are next to the stability limit."""

SORTS = ("envelope", "long", "short", "growth")
"""What is on a lattice in turn: an envelope, a long wave, an envelope about k = pi, its growth."""


Judgement = tuple[float, float]
"""Estimate and true error."""


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


def ratio_of_search(engine: StepSearch, wider: StepSearch, tolerance: float) -> Judgement:
    """Estimate and true error of what `refine` finds with an engine; ``wider`` is the reference."""
    found = refine(engine, tolerance)
    trial: Trial = found.trial
    if trial.values is None or not math.isfinite(found.error):
        raise NeutralError
    finer = replace(trial.choices, step=trial.choices.step / FINER)
    reference = wider.run(finer, False, lambda _: None)
    if reference.values is None:  # perhaps beyond the run's own ring
        reference = engine.run(finer, False, lambda _: None)
    if reference.values is None:
        return found.error, math.inf
    difference = compared_values(reference) - compared_values(trial)
    return found.error, float(np.max(np.abs(difference))) - 4.0 * reference.rounding


def compared_values(trial: Trial) -> Array:
    """Return the compared values of a run, without the rates that are judged with it."""
    values = np.asarray(trial.values)
    return values[:, 0] if isinstance(trial.payload, RunRecord) else values


def of_lattice(scene: Scene) -> Judgement:
    """Return a scene on any lattice, or of a growth rate."""
    if scene.is_growth:
        growing = SidebandRuns(growth_plan(scene), scene).engine
        return ratio_of_search(growing, growing, scene.target.tolerance)
    timed, domains = domain_plan(scene)
    wider = copy(domains)
    wider.window = None
    wider.signals = [FASTER * speed + 1.0 / (timed.end - timed.t0) for speed in domains.signals]
    engines = SiteEngine(timed, domains), SiteEngine(timed, wider)
    return ratio_of_search(*engines, scene.target.tolerance)


def of_chain(scene: Scene) -> Judgement:
    """Return a scene of the paper's chain, judged by the causal reference."""
    judged = judge_scene(RandomScene(0, 0, scene, 0))
    if judged.verdict not in ("honest", "dishonest"):
        raise NeutralError
    return judged.estimate, judged.true - judged.own


def moved(value: float, gene: float, factor: float) -> float:
    """Return a number times a power of ``factor``, from -1 to 1 as the gene goes from 0 to 1."""
    return float(f"{value * factor ** (2.0 * gene - 1.0):.5g}")


@dataclass
class LatticeFamily:
    """Scenes on a lattice of the catalogue about the one of (seed, index)."""

    seed: int
    index: int
    base: Scene = field(init=False)

    def __post_init__(self) -> None:
        for redrawn in range(REDRAWN):
            try:
                scene = self._drawn(redrawn)
                with time_limit(FIRST):
                    of_lattice(scene)
                begun = time.process_time()
                with time_limit(SECONDS):
                    of_lattice(scene)
            except (ValueError, NeutralError, OutOfTime):
                continue
            if time.process_time() - begun <= CHEAP:
                self.base = scene
                return
        raise NeutralError

    @property
    def _sort(self) -> str:
        return SORTS[self.index // len(LATTICES) % len(SORTS)]

    def _drawn(self, redrawn: int) -> Scene:
        """Return a scene of the family's sort, its times in the lattice's own."""
        names, draw = list(LATTICES), random.Random(f"{self.seed}:{self.index}:{redrawn}")
        on = names[self.index % len(names)]
        scene = soak_scene(self.seed, self.index, redrawn, on, self._sort != "long")
        if scene.carrier and self._sort != "envelope":
            scene = scene.changed(carrier=draw.choice(NEAR_PI))
        plain = {
            "tolerance": 1e-3,
            "slow_times": (),
            "t0": None,
            "snapshots": None,
            "half_width": None,
        }
        if self._sort == "growth":
            perturbed = {"amplitude": draw.uniform(0.2, 1.5), "share": draw.uniform(0.3, 1.3)}
            order = draw.choice(["leading", "slaved"])
            changes = {"wave": "perturbed_plane", "parameters": tuple(perturbed.items())}
            return scene.changed(**plain, **changes, order=order, disorder=None)
        begin, span = draw.choice([0.0, 0.0, -20.0, -100.0]), draw.choice([20.0, 60.0, 200.0])
        compared = draw.choice([1, 1, 3, 12, 40])
        return scene.changed(**plain, times=(begin, begin + span), compared=compared)

    @property
    def name(self) -> str:
        """The family in a line."""
        disordered = "/disorder" if self.base.disorder else ""
        return f"{self.base.lattice}/{self._sort}/{self.base.wave}{disordered}"

    @property
    def genes(self) -> int:
        """Number of genes: every second time also the lattice's constants."""
        constants = len(self.base.constants) if self.index % 2 else 0
        return 6 + len(self.base.parameters) + constants

    def scene(self, genes: Array) -> Scene:
        """Return the scene of these numbers, each from 0 to 1."""
        base, own = self.base, 6 + len(self.base.parameters)
        changes: dict[str, Any] = {
            "parameters": moved_pairs(base.parameters, genes[6:own], 1.5),
            "eps": min(1.0, moved(base.eps, genes[0], 3.0)),
            "tolerance": moved(base.target.tolerance, genes[1], 30.0),
        }
        if genes.size > own:
            changes["constants"] = moved_pairs(base.constants, genes[own:], 1.4)
        if isinstance(base.carrier, float) and genes.size > own:
            changes["carrier"] = min(3.14159, moved(base.carrier, genes[5], 1.3))
        if not base.is_growth:
            begin, span = base.t0, moved(base.end - base.t0, genes[2], 3.0)
            begin = float(f"{begin + (genes[4] - 0.5) * span:.6g}")
            shares = (1.0,) if genes[3] < 0.6 else (genes[3], 1.0)
            changes["times"] = (begin, *(begin + share * span for share in shares))
            changes["compared"] = max(1, round(base.compared * (0.5 + genes[5])))
        return base.changed(**changes)

    def judge(self, genes: Array) -> tuple[float, float, str]:
        """Estimate, true error and the scene in text."""
        scene = self.scene(genes)
        return *of_lattice(scene), scene.toml()


def moved_pairs(pairs: Pairs, genes: Array, factor: float) -> Pairs:
    """Return names and values, those that are plain numbers moved."""

    def number(value: float | str) -> float | None:
        try:
            return float(Fraction(value))
        except ValueError:
            return None

    found = []
    for (name, value), gene in zip(pairs, genes, strict=True):
        plain = number(value)
        found.append((name, value if plain is None else moved(plain, gene, factor)))
    return tuple(found)


@dataclass
class KnownFamily(LatticeFamily):
    """The families of waves for which the law of the step is asked."""

    def _drawn(self, redrawn: int) -> Scene:
        return Scene.of(name="known", **KNOWN[self.index % len(KNOWN)], **SHORT)


SHORT = {"order": "slaved", "compared": 3, "tolerance": 1e-3}

KNOWN: tuple[dict[str, Any], ...] = (
    {
        "lattice": "klein_gordon",
        "constants": {"K2": 0.7, "g1": 1, "g2": 0, "g3": -1},
        "wave": "nls_plane",
        "parameters": {"A": 1.0},
        "eps": 0.25,
        "carrier": "pi",
        "times": [0, 200],
    },
    {
        "lattice": "fput",
        "constants": {"K2": 1, "K3": 0, "K4": -1},
        "wave": "nls_dark",
        "parameters": {"kappa": 0.7},
        "eps": 0.2,
        "carrier": "pi",
        "times": [0, 400],
    },
    {
        "lattice": "fput_strain",
        "constants": {"K2": 1, "K3": 0, "K4": 1},
        "wave": "nls_plane",
        "parameters": {"A": 1.2},
        "eps": 0.2,
        "carrier": 2.2,
        "times": [0, 200],
    },
)
"""Waves, each about a scene whose error was once above its estimate."""


@dataclass
class ChainFamily:
    """Scenes of the paper's chain about the one of (seed, index), with any engine."""

    seed: int
    index: int
    base: Scene = field(init=False)

    def __post_init__(self) -> None:
        scene = random_scene(self.seed, self.index, budget=CHEAP).scene
        self.base = scene.changed(compared=random.Random(self.index).choice([1, 3, 30]))

    @property
    def name(self) -> str:
        """The family in a line."""
        return f"chain/{self.base.wave_name}/{self.base.target.engine or 'chosen'}"

    @property
    def genes(self) -> int:
        """Number of genes."""
        return 5 + len(self.base.parameters)

    def scene(self, genes: Array) -> Scene:
        """Return the scene of these numbers, each from 0 to 1."""
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
            K4=moved(base.model.K4, genes[1], 3.0),
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
        summary = {"case": self.index, "size": size, "times": times, "tolerance": tolerance}
        return found.error_estimate, true, json.dumps(summary)


FAMILIES: Mapping[str, Callable[[int, int], Any]] = {
    "lattice": LatticeFamily,
    "chain": ChainFamily,
    "state": StateFamily,
    "known": KnownFamily,
}
COMMON = ("lattice", "lattice", "chain", "state")
"""Those that come in turn where all are asked for."""


def attack(kind: str, seed: int, index: int, turns: int) -> Found | None:
    """Return the worst scene of a family; None where no scene of it answers."""
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


def numbered(kind: str, families: int) -> Iterator[tuple[str, int]]:
    """Yield kinds with the numbers of their families."""
    counts: Counter[str] = Counter()
    for i in range(families):
        one = COMMON[i % len(COMMON)] if kind == "all" else kind
        yield one, counts[one]
        counts[one] += 1


def begin(unmended: bool) -> None:
    """Compile; if asked, treat every step as one whose law was seen."""
    warm_up()
    if unmended:
        search: Any = longwave.lattice.refine._Search
        search.is_lawful, search.lawful_change = lambda *_: True, lambda *_: 0.0
        longwave.scenes.engines.domain_plan.MAX_CARRIER_TURN = math.inf


def main() -> int:
    """Attack families of the kinds that are asked for; 1 if an error exceeds its estimate."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--kind", choices=["all", *FAMILIES], default="all")
    parser.add_argument("--families", type=int, default=40)
    parser.add_argument("--turns", type=int, default=200, help="scenes tried in a family")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--unmended", action="store_true", help="ask of no step its law")
    given = parser.parse_args()
    jobs = list(numbered(given.kind, given.families))
    begun, found = time.perf_counter(), []
    todo = (((kind, i), Job(attack, (kind, given.seed, i, given.turns))) for kind, i in jobs)
    for _, call in as_ended(todo, LocalWorkers(given.workers, partial(begin, given.unmended))):
        one = call.result()
        if one is None:
            continue
        found.append(one)
        line = f"{one.ratio:8.3g} {one.family} ({one.answered} of {one.turns} answered)"
        print(line, flush=True)
        if one.ratio > 1.0:
            print(f"  estimate {one.estimate:.3g}, true {one.true:.3g}\n{one.scene}", flush=True)
    turns, answered = (sum(getattr(one, key) for one in found) for key in ("turns", "answered"))
    largest = max((one.ratio for one in found), default=0.0)
    taken = time.perf_counter() - begun
    print(f"{turns} scenes, {answered} answered, largest ratio {largest:.3g}, {taken:.0f} s")
    return int(largest > 1.0)


if __name__ == "__main__":
    sys.exit(main())
