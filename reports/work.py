"""The work behind a report, as jobs for the pool, and what it finds."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from derive.command_line import announce
from reports.jobs import Job, Progress, run_jobs
from reports.studies import Key, Studies, studies, study_jobs
from solutions import CATALOGUE, closed_form
from verify.comparison import Scene, run
from verify.proof.catalogue_proofs import NAMES
from verify.residual import check_residual
from verify.studies.claims_evidence import Evidence
from verify.studies.evaluation import Accuracy, measure, worst_of
from verify.studies.evaluation_cases import Case, all_cases, wave_names
from verify.studies.mutations import MutationCount, count_mutants
from verify.studies.proofs import ProofRecord, proof_record
from verify.verdict import Verdict

SITE_SECONDS = 4e-10
"""About the time of one force evaluation on one site, with what is seen of the run."""

START_SECONDS = 0.5
"""About the time that any run takes."""

ACCURACY_SECONDS = {False: 0.2, True: 2.0}
"""About the time of a case of the evaluation study, by whether the wave's background is periodic:
its reference values are elliptic functions then."""

SHORT_GRID = 401
SHORT_POINTS, SHORT_CASES = 4, 3


@dataclass(frozen=True)
class Findings:
    """Everything that a report shows and that had to be computed."""

    evidence: Evidence
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

    def of(kind: str) -> list[Any]:
        return [value for (part, _), value in found.items() if part == kind]

    measured = {name: [found[key] for key in _accuracy_keys(name, full)] for name in wave_names()}
    return Findings(
        evidence=Evidence({name: found["run", name] for name in scenes}, scenes),
        proofs=of("proof"),
        residuals={verdict.name: verdict for verdict in of("residual")},
        mutations=of("mutants"),
        accuracy=[worst_of(results) for results in measured.values()],
        studies=studies(found),
    )


def all_jobs(scenes: Mapping[str, Scene], full: bool) -> dict[Key, Job]:
    """The jobs of a report under (kind, subject)."""
    jobs: dict[Key, Job] = {("run", name): scene_job(scene) for name, scene in scenes.items()}
    jobs |= {("proof", name): Job(proof_record, (name,), 0.5) for name in NAMES}
    for form in CATALOGUE:
        jobs["residual", form.name] = Job(_residual, (form.name,), 0.5)
        jobs["mutants", form.name] = Job(_mutants, (form.name,), 2.0)
    for name in wave_names():
        for key in _accuracy_keys(name, full):
            jobs[key] = _accuracy_job(key[1], full)
    return jobs | study_jobs(full)


def scene_job(scene: Scene) -> Job:
    """The run of a scene; its weight counts force evaluations."""
    steps = (scene.end - scene.t0) / scene.step
    evaluations = steps * scene.scheme_table.stages * scene.sites
    refined = 1 + 2 * sum(name.endswith("_error") for name in scene.observables)
    weight = START_SECONDS + evaluations * refined * SITE_SECONDS
    return Job(run, (scene,), weight, tells=True)


def _accuracy_keys(name: str, full: bool) -> list[tuple[str, Case]]:
    """All cases of a wave, or for the short report the first, the middle and the last."""
    cases = list(all_cases(name))
    if not full and len(cases) > SHORT_CASES:
        cases = [cases[0], cases[len(cases) // 2], cases[-1]]
    return [("accuracy", case) for case in cases]


def _accuracy_job(case: Case, full: bool) -> Job:
    if not full:
        return Job(_quick_accuracy, (case,), 0.5)
    return Job(measure, (case,), ACCURACY_SECONDS[case.form.period is not None])


def _quick_accuracy(case: Case) -> Accuracy:
    return measure(case, times=case.times[::3], per_time=SHORT_POINTS, grid=SHORT_GRID)


def _residual(name: str) -> Verdict:
    return check_residual(closed_form(name))


def _mutants(name: str) -> MutationCount:
    return count_mutants(closed_form(name))
