"""The studies of cost and of hard cases, as jobs for the pool, and what they find."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

import xarray as xr

from reports.jobs import Job
from solutions import CATALOGUE
from verify.comparison import load_scene, run
from verify.comparison.scene_catalogue import EPS, ORDERS
from verify.studies.cost_evaluation import EvaluationCost, evaluation_costs
from verify.studies.cost_precision import PROBLEMS, CostPoint, work_precision
from verify.studies.cost_scaling import ScalingPoint, at_eps, rk4_share, window_error
from verify.studies.estimates import Judged, judge
from verify.studies.hard_case import HardCase
from verify.studies.hard_cases import HARD_CASES, hard_case
from verify.studies.long_runs import LONG_SCENES, SHARES, LongRun, by_ring, by_sites
from verify.studies.reduction import PeakError, peak_error

Key = tuple[str, object]

EPSILONS, MORE_EPSILONS = (0.1, 0.05, 0.025, 0.0125), (0.00625,)
RK4_STEPS, MORE_RK4_STEPS = (0.4, 0.25, 0.125), (0.0625,)
WINDOWS, MORE_WINDOWS = (2048, 4096, 8192), (16384, 32768)
SPLIT_SCENE = "split_rational_3"
ESTIMATES, ESTIMATE_SEED = 240, 3
"""Random scenes whose estimates are judged; other ones than those of the tests."""

PEAK_SECONDS, WIDE_PEAK_SECONDS = {2: 5.0, 3: 20.0, 4: 45.0, 5: 75.0}, 3.0
"""About what a member of the family takes: by its order below ``NARROW``, and from there on."""

NARROW = 0.02


@dataclass(frozen=True)
class Studies:
    """What the studies found; what the short report leaves out is empty there.

    ``split`` holds the run of the split wave under its scene's name.
    """

    evaluation: list[EvaluationCost]
    precision: list[CostPoint]
    scaling: list[ScalingPoint]
    rk4: list[ScalingPoint]
    windows: list[ScalingPoint]
    hard_cases: list[HardCase]
    peaks: list[PeakError]
    split: Mapping[str, xr.Dataset]
    long_runs: Mapping[str, LongRun]
    estimates: list[Judged] = field(default_factory=list)

    @property
    def sound(self) -> bool:
        """Whether hard cases hold, long runs keep their tolerance and estimates are honest."""
        cases = all(case.passed for case in self.hard_cases)
        long = all(found.kept for found in self.long_runs.values())
        return cases and long and all(found.sound for found in self.estimates)


def study_jobs(full: bool) -> dict[Key, Job]:
    """The jobs of the studies under (kind, subject)."""
    jobs: dict[Key, Job] = {}
    for form in CATALOGUE:
        jobs["cost", form.name] = Job(evaluation_costs, (form.name,), 1.0)
    for problem in PROBLEMS:
        jobs["precision", problem] = Job(work_precision, (problem,), 5.0)
    for eps in EPSILONS + MORE_EPSILONS * full:
        jobs["scaling", eps] = Job(at_eps, (eps, full), 3.0)
    jobs["rk4", ""] = Job(rk4_share, (RK4_STEPS + MORE_RK4_STEPS * full,), 10.0)
    jobs["windows", ""] = Job(window_error, (WINDOWS + MORE_WINDOWS * full,), 7.0)
    for case in HARD_CASES:
        if full or not case.slow:
            jobs["hard", case.name] = Job(_hard_case, (case.name,), 2.0 if case.slow else 1.0)
    return jobs | _further_jobs() if full else jobs


def _further_jobs() -> dict[Key, Job]:
    """The jobs of the full report alone."""
    jobs: dict[Key, Job] = {}
    for order in ORDERS:
        for eps in EPS:
            seconds = PEAK_SECONDS[order] if eps < NARROW else WIDE_PEAK_SECONDS
            jobs["peak", (order, eps)] = Job(peak_error, (order, eps), seconds)
    jobs["split", SPLIT_SCENE] = Job(run, (load_scene(SPLIT_SCENE),), 4.0, tells=True)
    for name in LONG_SCENES:
        jobs["ring", name] = Job(by_ring, (name,), 5.0, tells=True)
        for share in SHARES:
            jobs["sites", (name, share)] = Job(by_sites, (name, share), 1.5 / share, tells=True)
    for index in range(ESTIMATES):
        jobs["estimate", index] = Job(judge, (ESTIMATE_SEED, index), 0.8)
    return jobs


def studies(found: Mapping[Key, Any]) -> Studies:
    """The results of the jobs, gathered."""

    def of(kind: str) -> list[Any]:
        return [value for (part, _), value in found.items() if part == kind]

    def joined(kind: str) -> list[Any]:
        return list(chain.from_iterable(of(kind)))

    return Studies(
        evaluation=joined("cost"),
        precision=joined("precision"),
        scaling=joined("scaling"),
        rk4=joined("rk4"),
        windows=joined("windows"),
        hard_cases=of("hard"),
        peaks=of("peak"),
        split={str(name): value for (part, name), value in found.items() if part == "split"},
        long_runs={
            name: LongRun(found["ring", name], *(found["sites", (name, share)] for share in SHARES))
            for name in LONG_SCENES
            if ("ring", name) in found
        },
        estimates=of("estimate"),
    )


def _hard_case(name: str) -> HardCase:
    return hard_case(name).run()
