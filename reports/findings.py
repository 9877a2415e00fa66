"""The jobs of a report, and what they found: under (kind, subject), as the studies name them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import chain, groupby
from operator import attrgetter
from typing import Any

from longwave.reports.sections.other_lattices import model_jobs
from longwave.reports.studies.estimates import estimate_jobs
from longwave.reports.studies.evaluation_accuracy import Accuracy, accuracy_jobs, worst_of
from longwave.reports.studies.evaluation_cost import evaluation_cost_jobs
from longwave.reports.studies.hard_cases import hard_case_jobs
from longwave.reports.studies.lattice_cost import lattice_cost_jobs
from longwave.reports.studies.lattice_models import modulation_plane
from longwave.reports.studies.long_runs import LongRun, long_run_jobs, long_runs
from longwave.reports.studies.measured_rates import rate_jobs
from longwave.reports.studies.measured_runs import MeasuredRuns, scene_job
from longwave.reports.studies.proofs import proof_jobs
from longwave.reports.studies.published_verdicts import library_jobs
from longwave.reports.studies.scene_runs import scene_run_jobs
from longwave.scenes.scene import Scene
from longwave.solutions.catalogue import CATALOGUE, closed_form
from longwave.support.processes import Job, Key
from longwave.verify.evidence.mutations import MutationCount, count_mutants
from longwave.verify.evidence.residual import check_residual
from longwave.verify.verdict import Verdict


def all_jobs(scenes: Mapping[str, Scene], full: bool) -> dict[Key, Job]:
    """The jobs of a report under (kind, subject)."""
    jobs: dict[Key, Job] = {("run", name): scene_job(scene) for name, scene in scenes.items()}
    jobs |= {("residual", name): Job(_residual, (name,), 0.5) for name in CATALOGUE.names}
    paper = CATALOGUE.of("mKdV").names
    jobs |= {("mutants", name): Job(_mutants, (name,), 2.0) for name in paper}
    jobs["plane", "fput_strain"] = Job(modulation_plane, (), 0.5)
    jobs |= proof_jobs() | library_jobs() | accuracy_jobs(full)
    return jobs | model_jobs() | rate_jobs(full) | scene_run_jobs() | study_jobs(full)


def study_jobs(full: bool) -> dict[Key, Job]:
    """The jobs of the studies of cost and of hard cases; long runs and estimates if ``full``."""
    jobs = evaluation_cost_jobs() | lattice_cost_jobs(full) | hard_case_jobs(full)
    return jobs | long_run_jobs() | estimate_jobs() if full else jobs


def _residual(name: str) -> Verdict:
    return check_residual(closed_form(name))


def _mutants(name: str) -> MutationCount:
    return count_mutants(closed_form(name))


STANDS: Mapping[str, Callable[[Any], bool]] = {
    "run": lambda run: not run.attrs["blow_up"],
    "proof": lambda record: record.outcome.passed and record.accepted is not False,
    "mutants": lambda count: count.undecided == 0,
    "library": lambda verdicts: all(verdict.expected for verdict in verdicts),
    "scene": lambda scene: scene.kept,
    "rate": lambda rate: rate.reached,
    "hard": lambda case: case.passed,
    "estimate": lambda judged: judged.sound,
}
"""Whether what a job of a kind found stands; what else the jobs find is no more than shown."""


@dataclass(frozen=True)
class Findings:
    """What the jobs ``found``, and the ``scenes`` of its runs; of a kind without jobs nothing."""

    found: Mapping[Key, Any]
    scenes: Mapping[str, Scene]

    def of(self, kind: str) -> dict[Any, Any]:
        """What the jobs of a kind found, by their subjects."""
        return {subject: value for (part, subject), value in self.found.items() if part == kind}

    def all(self, kind: str) -> list[Any]:
        """What the jobs of a kind found, one after the other."""
        return list(self.of(kind).values())

    def rows(self, kind: str) -> list[Any]:
        """What the jobs of a kind found whose finding is a list."""
        return list(chain.from_iterable(self.all(kind)))

    @cached_property
    def runs(self) -> MeasuredRuns:
        """The runs of the paper's scenes."""
        return MeasuredRuns(self.of("run"), self.scenes)

    @cached_property
    def long_runs(self) -> dict[str, LongRun]:
        """The long runs with their judges."""
        return long_runs(self.found)

    @cached_property
    def accuracy(self) -> list[Accuracy]:
        """The worst errors of each wave."""
        cases = groupby(self.all("accuracy"), attrgetter("name"))
        return [worst_of(group) for _, group in cases]

    @property
    def sound(self) -> bool:
        """Whether every form and study stands and every run came to its end."""
        stands = (STANDS[kind](v) for (kind, _), v in self.found.items() if kind in STANDS)
        return all(stands) and all(long.kept for long in self.long_runs.values())
