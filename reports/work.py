"""The work behind a report, as jobs in several processes, and what it finds."""

import multiprocessing as mp
from collections.abc import Callable, Hashable, Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, Future, ProcessPoolExecutor, wait
from ctypes import c_double
from dataclasses import dataclass, field
from itertools import chain
from typing import Any, TypeVar

import xarray as xr

from derive.command_line import announce
from solutions import CATALOGUE, closed_form
from verify.comparison import Scene, load_scene, run
from verify.comparison.scene_catalogue import EPS, ORDERS
from verify.evidence.mutations import MutationCount, count_mutants
from verify.evidence.residual import check_residual
from verify.processes import ignore_interrupt, stopping
from verify.proof.catalogue_proofs import NAMES
from verify.studies.estimates import Judged, judge
from verify.studies.evaluation_accuracy import (
    Accuracy,
    WaveCase,
    all_cases,
    measure_accuracy,
    wave_names,
    worst_of,
)
from verify.studies.evaluation_cost import EvaluationCost, evaluation_costs
from verify.studies.hard_cases import HARD_CASES, HardCaseResult, hard_case
from verify.studies.lattice_cost import (
    PROBLEMS,
    CostPoint,
    PeakError,
    ScalingPoint,
    at_eps,
    peak_error,
    rk4_share,
    window_error,
    work_precision,
)
from verify.studies.long_runs import LONG_SCENES, SHARES, LongRun, by_ring, by_sites
from verify.studies.measured_runs import MeasuredRuns
from verify.studies.proofs import ProofRecord, proof_record
from verify.verdict import Verdict

Subject = TypeVar("Subject", bound=Hashable)
Progress = Callable[[float], None]

POLL = 0.2
"""Seconds between two looks at the progress."""

_shares: Any = None


@dataclass(frozen=True)
class Job:
    """A call to make in a worker process, and about how many seconds it takes.

    With ``tells``, the function is called with a further argument: a function to be told the
    share of the work that is done, 0 .. 1. All parts must be picklable.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    weight: float
    tells: bool = False

    def run(self, progress: Progress) -> Any:
        """Make the call and return what it returns."""
        told = (progress,) if self.tells else ()
        found = self.function(*self.arguments, *told)
        progress(1.0)
        return found


def run_jobs(jobs: Mapping[Subject, Job], workers: int, progress: Progress) -> dict[Subject, Any]:
    """Do all jobs in `workers` processes, the longest first; return the results under their keys.

    `progress` is called from time to time with the share of the work done, 0 .. 1. The first
    failing job's exception is raised here and the jobs not yet begun are dropped.

    Raises ValueError unless workers >= 1.
    """
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
    context = mp.get_context("spawn")
    ordered = sorted(jobs, key=lambda key: jobs[key].weight, reverse=True)
    weights = [jobs[key].weight for key in ordered]
    shares: Any = context.Array(c_double, len(jobs), lock=False)

    def report() -> None:
        done = sum(weight * share for weight, share in zip(weights, shares, strict=True))
        progress(min(1.0, done / sum(weights)))

    with ProcessPoolExecutor(workers, context, _begin, (shares,)) as pool, stopping(pool):
        found = {key: pool.submit(_do, i, jobs[key]) for i, key in enumerate(ordered)}
        _watch(set(found.values()), report)
    progress(1.0)
    return {key: found[key].result() for key in jobs}


def _watch(pending: set[Future[Any]], report: Callable[[], None]) -> None:
    """Wait for the jobs, reporting meanwhile; cancel the rest and raise when one fails."""
    while pending:
        done, pending = wait(pending, POLL, FIRST_EXCEPTION)
        report()
        for job in done:
            if job.exception() is not None:
                for other in pending:
                    other.cancel()
                job.result()


def _begin(shares: Any) -> None:
    """Keep the array of progress shares in this worker process; leave Ctrl-C to the parent."""
    global _shares
    _shares = shares
    ignore_interrupt()


def _do(place: int, job: Job) -> Any:
    """Do one job in a worker process, writing its progress at its place."""

    def progress(share: float) -> None:
        _shares[place] = share

    return job.run(progress)


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


def _hard_case(name: str) -> HardCaseResult:
    return hard_case(name).run()


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

    def of(kind: str) -> list[Any]:
        return [value for (part, _), value in found.items() if part == kind]

    measured = {name: [found[key] for key in _accuracy_keys(name, full)] for name in wave_names()}
    return Findings(
        evidence=MeasuredRuns({name: found["run", name] for name in scenes}, scenes),
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


def _accuracy_keys(name: str, full: bool) -> list[tuple[str, WaveCase]]:
    """All cases of a wave, or for the short report the first, the middle and the last."""
    cases = list(all_cases(name))
    if not full and len(cases) > SHORT_CASES:
        cases = [cases[0], cases[len(cases) // 2], cases[-1]]
    return [("accuracy", case) for case in cases]


def _accuracy_job(case: WaveCase, full: bool) -> Job:
    if not full:
        return Job(_quick_accuracy, (case,), 0.5)
    return Job(measure_accuracy, (case,), ACCURACY_SECONDS[case.form.period is not None])


def _quick_accuracy(case: WaveCase) -> Accuracy:
    return measure_accuracy(case, times=case.times[::3], per_time=SHORT_POINTS, grid=SHORT_GRID)


def _residual(name: str) -> Verdict:
    return check_residual(closed_form(name))


def _mutants(name: str) -> MutationCount:
    return count_mutants(closed_form(name))
