"""The studies of cost and of hard cases, as jobs for the pool, and what they find."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import chain
from typing import Any

import xarray as xr

from reports.jobs import Job
from solutions import CATALOGUE
from verify.lattice import load_scene, run
from verify.study.cost_evaluation import EvaluationCost, evaluation_costs
from verify.study.cost_precision import PROBLEMS, CostPoint, work_precision
from verify.study.cost_scaling import ScalingPoint, at_eps, rk4_share, window_error
from verify.study.hard_case import HardCase
from verify.study.hard_cases import HARD_CASES, hard_case

Key = tuple[str, object]

EPSILONS, MORE_EPSILONS = (0.1, 0.05, 0.025, 0.0125), (0.00625,)
RK4_STEPS, MORE_RK4_STEPS = (0.4, 0.25, 0.125), (0.0625,)
WINDOWS, MORE_WINDOWS = (2048, 4096, 8192), (16384, 32768)
LONG_SCENES = ("breather_sn_k_0.7_long", "rogue_cn_k_0.5_long", "soliton_dn_k_0.7_long")


@dataclass(frozen=True)
class Studies:
    """What the studies found; ``long_runs`` is empty in the short report."""

    evaluation: list[EvaluationCost]
    precision: list[CostPoint]
    scaling: list[ScalingPoint]
    rk4: list[ScalingPoint]
    windows: list[ScalingPoint]
    hard_cases: list[HardCase]
    long_runs: Mapping[str, xr.Dataset]


def study_jobs(full: bool) -> dict[Key, Job]:
    """The jobs of the studies under (kind, subject)."""
    jobs: dict[Key, Job] = {}
    for form in CATALOGUE:
        jobs["cost", form.name] = Job(evaluation_costs, (form.name,), 1.0)
    for problem in PROBLEMS:
        jobs["precision", problem] = Job(work_precision, (problem,), 8.0)
    for eps in EPSILONS + MORE_EPSILONS * full:
        jobs["scaling", eps] = Job(at_eps, (eps,), 2.0)
    jobs["rk4", ""] = Job(rk4_share, (RK4_STEPS + MORE_RK4_STEPS * full,), 10.0)
    jobs["windows", ""] = Job(window_error, (WINDOWS + MORE_WINDOWS * full,), 10.0)
    for case in HARD_CASES:
        if full or not case.slow:
            jobs["hard", case.name] = Job(_hard_case, (case.name,), 30.0 if case.slow else 2.0)
    if full:
        for name in LONG_SCENES:
            jobs["long", name] = Job(run, (load_scene(name),), 60.0, tells=True)
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
        long_runs={str(name): value for (part, name), value in found.items() if part == "long"},
    )


def _hard_case(name: str) -> HardCase:
    return hard_case(name).run()
