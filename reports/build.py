"""Building the report: the work as jobs in processes, figures, tables, LaTeX, PDF."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version
from itertools import chain, groupby
from operator import attrgetter
from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars

from longwave.reports.engine import CompileError, EngineMissingError, compile_pdf, ensure_engine
from longwave.reports.latex import render, write
from longwave.reports.lattice_chapter import (
    CHAPTER_TABLES,
    LatticeChapter,
    chapter_jobs,
    lattice_chapter,
    write_chapter_figures,
)
from longwave.reports.paper import SOURCES
from longwave.reports.pictures.drawing import cost_figure, save, snapshot_figure, styled
from longwave.reports.pictures.paper_figures import ERROR_FIGURES, SNAPSHOT_FIGURES, draw_all
from longwave.reports.sections import costs, literature, other_lattices, runs, theory
from longwave.reports.studies.claims import all_claims
from longwave.reports.studies.estimates import Judged, estimate_jobs, estimate_rows
from longwave.reports.studies.evaluation_accuracy import Accuracy, accuracy_jobs, worst_of
from longwave.reports.studies.evaluation_cost import EvaluationCost, evaluation_cost_jobs
from longwave.reports.studies.hard_cases import HardCaseResult, hard_case_jobs
from longwave.reports.studies.lattice_cost import (
    CostPoint,
    PeakError,
    ScalingPoint,
    lattice_cost_jobs,
)
from longwave.reports.studies.long_runs import LongRun, long_run_jobs, long_runs
from longwave.reports.studies.measured_runs import MeasuredRuns, report_scenes, scene_job
from longwave.reports.studies.proofs import ProofRecord, proof_jobs
from longwave.reports.studies.published_verdicts import PublishedVerdict, library_jobs
from longwave.scenes.scene import Scene
from longwave.solutions.catalogue import CATALOGUE, closed_form
from longwave.support.command_line import announce, fail, interrupted
from longwave.support.console import check_output, plain_console
from longwave.support.interruption import will_keep
from longwave.support.processes import Job, Key, Progress, run_jobs
from longwave.support.request_limits import ExpectedCost, check_request
from longwave.verify.evidence.mutations import MutationCount, count_mutants
from longwave.verify.evidence.residual import check_residual
from longwave.verify.verdict import Verdict


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
    library: Sequence[PublishedVerdict]
    chapter: LatticeChapter

    @property
    def sound(self) -> bool:
        """Whether every form and study stands and every run came to its end."""
        proved = all(record.outcome.passed for record in self.proofs)
        accepted = all(record.accepted is not False for record in self.proofs)
        refuted = all(count.undecided == 0 for count in self.mutations)
        ran = self.studies.sound and not self.evidence.blown_up
        decided = all(verdict.expected for verdict in self.library)
        return proved and accepted and refuted and decided and ran and self.chapter.sound


PROCESS_BYTES, WORKER_BYTES = 6e8, 4e8
"""What the command and each worker hold at most."""


def report_cost(jobs: Mapping[Key, Job], workers: int) -> ExpectedCost:
    """What a report of these jobs takes."""
    work = sum(job.weight for job in jobs.values())
    cores = min(workers, os.cpu_count() or 1)
    return ExpectedCost(work / cores, PROCESS_BYTES + WORKER_BYTES * workers)


def find(
    scenes: Mapping[str, Scene], jobs: Mapping[Key, Job], workers: int, progress: Progress
) -> Findings:
    """Do the work of a report in the pool; raises as `run_jobs` does."""
    found = run_jobs(jobs, workers, progress)
    accuracy = groupby(_of(found, "accuracy"), attrgetter("name"))
    return Findings(
        evidence=MeasuredRuns({name: found["run", name] for name in scenes}, scenes),
        proofs=_of(found, "proof"),
        residuals={verdict.name: verdict for verdict in _of(found, "residual")},
        mutations=_of(found, "mutants"),
        accuracy=[worst_of(group) for _, group in accuracy],
        studies=studies(found),
        library=_joined(found, "library"),
        chapter=lattice_chapter(found),
    )


def all_jobs(scenes: Mapping[str, Scene], full: bool) -> dict[Key, Job]:
    """The jobs of a report under (kind, subject)."""
    jobs: dict[Key, Job] = {("run", name): scene_job(scene) for name, scene in scenes.items()}
    evidence = proof_jobs() | library_jobs() | evidence_jobs() | accuracy_jobs(full)
    return jobs | evidence | chapter_jobs(full) | study_jobs(full)


def evidence_jobs() -> dict[Key, Job]:
    """The residual of the catalogue's forms, and the misprints of the paper's."""
    jobs: dict[Key, Job] = {}
    for name in CATALOGUE.names:
        jobs["residual", name] = Job(_residual, (name,), 0.5)
    for name in CATALOGUE.of("mKdV").names:
        jobs["mutants", name] = Job(_mutants, (name,), 2.0)
    return jobs


def _residual(name: str) -> Verdict:
    return check_residual(closed_form(name))


def _mutants(name: str) -> MutationCount:
    return count_mutants(closed_form(name))


def study_jobs(full: bool) -> dict[Key, Job]:
    """The jobs of the studies of cost and of hard cases; long runs and estimates if ``full``."""
    jobs = evaluation_cost_jobs() | lattice_cost_jobs(full) | hard_case_jobs(full)
    return jobs | long_run_jobs() | estimate_jobs() if full else jobs


SOURCE = "longwave.tex"

STUDY_FIGURES = 3
"""How many figures the studies have, at least."""

CHAPTER_FIGURES = 4
"""How many the chapter of other lattices has, at least."""

TABLES: Mapping[str, Callable[[Findings], str]] = {
    "solution_table": lambda _: theory.solution_table(),
    "proof_table": lambda found: theory.proof_table(_papers(found.proofs), found.residuals),
    "mutation_table": lambda found: theory.mutation_table(found.mutations),
    "survivor_table": lambda found: theory.survivor_table(found.mutations),
    "accuracy_table": lambda found: costs.accuracy_table(_papers(found.accuracy)),
    "run_table": lambda found: runs.run_table(found.evidence),
    "claim_table": lambda found: runs.claim_table(all_claims(found.evidence)),
    "library_counts": lambda found: literature.library_counts(found.library),
    "library_table": lambda found: literature.library_table(found.library),
    "library_conditions": lambda found: literature.library_conditions(found.library),
    "found_misprints": lambda found: literature.found_misprints(found.library),
    "form_table": lambda found: other_lattices.form_table(
        found.proofs, found.residuals, found.accuracy
    ),
}
"""The tables of proofs, waves, runs and published solutions under their templates' names."""

STUDY_TABLES: Mapping[str, Callable[[Studies], str]] = {
    "cost_table": lambda found: costs.cost_table(found.evaluation),
    "precision_table": lambda found: costs.precision_table(found.precision),
    "scaling_table": lambda found: costs.scaling_table(found.scaling),
    "rk4_table": lambda found: costs.rk4_table(found.rk4),
    "window_table": lambda found: costs.window_table(found.windows),
    "hard_case_table": lambda found: costs.hard_case_table(found.hard_cases),
    "message_table": lambda found: costs.message_table(found.hard_cases),
    "peak_table": lambda found: runs.peak_table(found.peaks) if found.peaks else "",
    "split_table": lambda found: runs.split_table(found.split),
    "long_table": lambda found: runs.long_table(found.long_runs),
    "estimate_table": lambda found: costs.estimate_table(estimate_rows(found.estimates)),
    "estimate_reasons": lambda found: costs.reason_table(found.estimates),
}
"""The tables of the studies."""


def _papers(records: Sequence[Any]) -> list[Any]:
    """The records of forms of the paper's equation; the others are in the chapter of lattices."""
    return [found for found in records if CATALOGUE.equation(found.name) == other_lattices.PAPERS]


def source(content: Mapping[str, str], scenes: Mapping[str, Scene], full: bool) -> str:
    """Return the report's LaTeX source; `content` holds the tables."""
    return render(
        "report.tex.j2",
        version=version("longwave"),
        full=full,
        alone=False,
        formulas=theory.formulas(),
        equations=theory.equations(),
        figures=runs.figure_entries(scenes),
        sources=sorted(SOURCES.items()),
        normal_equations=other_lattices.normal_equations(),
        **theory.derivation(),
        **content,
    )


def write_figures(found: Findings, folder: Path) -> Iterator[Path]:
    """Draw every figure below the folder, yielding each path when it is written."""
    yield from draw_all(found.evidence.runs, folder / "figures")
    yield from write_study_figures(found.studies, folder)
    yield from write_chapter_figures(found.chapter, found.evidence, folder)


def write_study_figures(found: Studies, folder: Path) -> Iterator[Path]:
    """Draw the figures of the studies, yielding each path when it is written."""
    with styled():
        for name, figure in study_figures(found).items():
            yield save(figure, folder / "figures" / f"{name}.pdf")


def study_figures(found: Studies) -> dict[str, Figure]:
    """The figures of the studies by their names."""
    error, eps, inverse = r"error of $y/\epsilon$", r"$\epsilon$", r"$1/\epsilon$"
    figures = {
        "evaluation_costs": cost_figure(
            costs.cost_panels(found.evaluation),
            "seconds a point",
            "digits",
            4,
            1.35,
            digits=(0, 30, 60, 90),
        ),
        "work_precision": cost_figure(
            costs.precision_panels(found.precision), "seconds", error, 2, 2.7
        ),
        "cost_scaling": cost_figure(
            costs.scaling_panels(found.scaling),
            inverse,
            "seconds",
            1,
            2.8,
            x_ticks=(10, 20, 40, 80, 160),
        ),
    }
    if found.peaks:
        panels = runs.peak_panels(found.peaks)
        figures["reduction_error"] = cost_figure(panels, eps, r"$L^\infty_\epsilon$", 1, 2.8)
    if found.split:
        figures["split"] = snapshot_figure(runs.split_rows(found.split))
    return figures


def write_tables(found: Findings, folder: Path) -> Iterator[tuple[str, str]]:
    """Write every table below the folder, yielding its name and LaTeX when it is written."""
    for name, make in TABLES.items():
        yield name, write_table(name, make(found), folder)
    yield from write_study_tables(found.studies, folder)
    for name, table in CHAPTER_TABLES.items():
        yield name, write_table(name, table(found.chapter), folder)


def write_study_tables(found: Studies, folder: Path) -> Iterator[tuple[str, str]]:
    """Write the studies' tables, yielding each one's name and LaTeX when it is written."""
    for name, make in STUDY_TABLES.items():
        yield name, write_table(name, make(found), folder)


def write_table(name: str, text: str, folder: Path) -> str:
    """Write one table; return its LaTeX."""
    write(folder / "tables" / f"{name}.tex", text)
    return text


def write_source(found: Findings, folder: Path, full: bool, wrote: Callable[[], None]) -> Path:
    """Write the tables and the LaTeX source below the folder; return the source's path."""
    content = {}
    for name, text in write_tables(found, folder):
        content[name] = text
        wrote()
    return write(folder / SOURCE, source(content, found.evidence.scenes, full))


def _check_folder(output: Path, force: bool) -> None:
    """Raise ValueError, before anything is computed, if no report can or may be written there."""
    if not force and (output / SOURCE).exists():
        raise ValueError(
            f"--output must name a folder without a report, got {output}, which has one "
            "(--force overwrites it)"
        )
    output.mkdir(parents=True, exist_ok=True)
    check_output(str(output / SOURCE), force=True)


def write_report(output: Path, program: str, *, force: bool, full: bool, workers: int) -> int:
    """Build the report in a folder, if ``full`` with long scenes; Ctrl-C is told by ``program``.

    Returns 0, 1 if a check, a run or LaTeX failed, 2 for bad input, 130 after Ctrl-C.
    """
    console = plain_console()
    try:
        if workers < 1:
            raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
        _check_folder(output, force)
        scenes = report_scenes()
        jobs = all_jobs(scenes, full)
        cost = report_cost(jobs, workers)
        check_request("the report", cost, "take fewer --workers or no --full")
        missing = _missing_engine(console)
        will_keep(f"what was written is in {shown(output)}")
        announce("the report", cost.seconds)
        tex, sound = build(output, scenes, jobs, console, full, workers)
        if missing:
            return 1
        pdf = compile_pdf(tex)
    except KeyboardInterrupt:
        return interrupted(program, f"what was written is in {shown(output)}")
    except (ValueError, OSError) as error:
        return fail(error)
    except CompileError as error:
        fail(error)
        return 1
    console.print(shown(pdf), soft_wrap=True)
    return 0 if sound else 1


def _missing_engine(console: Console) -> bool:
    """Whether there is no LaTeX engine, which is said: the source is then all that is written."""
    try:
        ensure_engine(console.print)
    except EngineMissingError as error:
        fail(f"{error}; the source alone is written")
        return True
    return False


def build(
    output: Path,
    scenes: Mapping[str, Scene],
    jobs: Mapping[Key, Job],
    console: Console,
    full: bool,
    workers: int,
) -> tuple[Path, bool]:
    """Do the jobs on the scenes; write figures, tables and source below the folder.

    Returns the source's path, and whether every form stands and every run came to its end.
    """
    figures = len(SNAPSHOT_FIGURES) + len(ERROR_FIGURES) + STUDY_FIGURES + CHAPTER_FIGURES
    with bars(console) as bar:
        working = bar.add_task("proving and running", total=1.0)
        found = find(scenes, jobs, workers, lambda share: bar.update(working, completed=share))
        drawing = bar.add_task("drawing", total=figures)
        for _ in write_figures(found, output):
            bar.advance(drawing)
        writing = bar.add_task(
            "writing", total=len(TABLES) + len(STUDY_TABLES) + len(CHAPTER_TABLES)
        )
        tex = write_source(found, output, full, partial(bar.advance, writing))
    return tex, found.sound


def shown(path: Path) -> str:
    """Return the path relative to the working directory where it lies below it."""
    with suppress(ValueError):
        return str(path.resolve().relative_to(Path.cwd()))
    return str(path)


def write_bench(output: Path, short: bool, program: str) -> int:
    """Run every study in a process of its own, nothing beside it; write its tables and figures.

    Returns 0, 1 if a study fails, 2 for bad input, 130 after Ctrl-C, which ``program`` tells.
    """
    console = plain_console()
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        return fail(f"--output must be a folder that can be written, got {output}: {error}")
    jobs = study_jobs(full=not short)
    announce("the studies", sum(job.weight for job in jobs.values()))
    try:
        with bars(console) as bar:
            task = bar.add_task("measuring", total=1.0)
            found = studies(run_jobs(jobs, 1, lambda share: bar.update(task, completed=share)))
            for name, text in write_study_tables(found, output):
                if text:
                    console.print(output / "tables" / f"{name}.tex", soft_wrap=True)
            for path in write_study_figures(found, output):
                console.print(path, soft_wrap=True)
    except KeyboardInterrupt:
        return interrupted(program, "nothing was written of unfinished studies")
    return 0 if found.sound else 1


def bars(console: Console) -> Bars:
    """Bars with their names and the time that has gone."""
    columns = TextColumn("{task.description:20}"), BarColumn(), TimeElapsedColumn()
    return Bars(*columns, console=console)
