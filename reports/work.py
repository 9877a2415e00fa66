"""The work behind a report, as jobs in several processes, and what it finds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, groupby
from operator import attrgetter
from typing import Any

import xarray as xr

from derive.command_line import announce
from solutions.catalogue import CATALOGUE, closed_form
from verify.comparison import Scene
from verify.evidence.mutations import MutationCount, count_mutants
from verify.evidence.residual import check_residual
from verify.processes import Job, Key, Progress, run_jobs
from verify.studies.estimates import Judged, estimate_jobs
from verify.studies.evaluation_accuracy import Accuracy, accuracy_jobs, worst_of
from verify.studies.evaluation_cost import EvaluationCost, evaluation_cost_jobs
from verify.studies.hard_cases import HardCaseResult, hard_case_jobs
from verify.studies.lattice_cost import CostPoint, PeakError, ScalingPoint, lattice_cost_jobs
from verify.studies.long_runs import LongRun, long_run_jobs, long_runs
from verify.studies.measured_runs import MeasuredRuns, scene_job
from verify.studies.proofs import ProofRecord, proof_jobs
from verify.verdict import Verdict


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
    hard_cases: list[HardCaseResult]
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


def studies(found: Mapping[Key, Any]) -> Studies:
    """The results of the jobs, gathered."""

    return Studies(
        evaluation=_joined(found, "cost"),
        precision=_joined(found, "precision"),
        scaling=_joined(found, "scaling"),
        rk4=_joined(found, "rk4"),
        windows=_joined(found, "windows"),
        hard_cases=_of(found, "hard"),
        peaks=_of(found, "peak"),
        split={str(name): value for (part, name), value in found.items() if part == "split"},
        long_runs=long_runs(found),
        estimates=_of(found, "estimate"),
    )


def _of(found: Mapping[Key, Any], kind: str) -> list[Any]:
    return [value for (part, _), value in found.items() if part == kind]


def _joined(found: Mapping[Key, Any], kind: str) -> list[Any]:
    return list(chain.from_iterable(_of(found, kind)))


@dataclass(frozen=True)
class Findings:
    """Everything that a report shows and that had to be computed."""

    evidence: MeasuredRuns
    proofs: Sequence[ProofRecord]
    residuals: Mapping[str, Verdict]
    mutations: Sequence[MutationCount]
    accuracy: Sequence[Accuracy]
    studies: Studies

    @property
    def sound(self) -> bool:
        """Whether every form and study stands and every run came to its end."""
        proved = all(record.outcome.passed for record in self.proofs)
        accepted = all(record.accepted is not False for record in self.proofs)
        refuted = all(count.undecided == 0 for count in self.mutations)
        ran = self.studies.sound and not self.evidence.blown_up
        return proved and accepted and refuted and ran


def find(scenes: Mapping[str, Scene], full: bool, workers: int, progress: Progress) -> Findings:
    """Do the work of a report in the pool; raises as `run_jobs` does."""
    jobs = all_jobs(scenes, full)
    if workers >= 1:
        announce("the report", sum(job.weight for job in jobs.values()) / workers)
    found = run_jobs(jobs, workers, progress)
    accuracy = groupby(_of(found, "accuracy"), attrgetter("name"))
    return Findings(
        evidence=MeasuredRuns({name: found["run", name] for name in scenes}, scenes),
        proofs=_of(found, "proof"),
        residuals={verdict.name: verdict for verdict in _of(found, "residual")},
        mutations=_of(found, "mutants"),
        accuracy=[worst_of(group) for _, group in accuracy],
        studies=studies(found),
    )


def all_jobs(scenes: Mapping[str, Scene], full: bool) -> dict[Key, Job]:
    """The jobs of a report under (kind, subject)."""
    jobs: dict[Key, Job] = {("run", name): scene_job(scene) for name, scene in scenes.items()}
    return jobs | proof_jobs() | evidence_jobs() | accuracy_jobs(full) | study_jobs(full)


def evidence_jobs() -> dict[Key, Job]:
    """The residual and the misprints of the catalogue's forms."""
    jobs: dict[Key, Job] = {}
    for form in CATALOGUE:
        jobs["residual", form.name] = Job(_residual, (form.name,), 0.5)
        jobs["mutants", form.name] = Job(_mutants, (form.name,), 2.0)
    return jobs


def _residual(name: str) -> Verdict:
    return check_residual(closed_form(name))


def _mutants(name: str) -> MutationCount:
    return count_mutants(closed_form(name))


def study_jobs(full: bool) -> dict[Key, Job]:
    """The jobs of the studies of cost and of hard cases; long runs and estimates if ``full``."""
    jobs = evaluation_cost_jobs() | lattice_cost_jobs(full) | hard_case_jobs(full)
    return jobs | long_run_jobs() | estimate_jobs() if full else jobs
