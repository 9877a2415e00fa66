"""Build of the report: jobs in worker processes, then figures, tables, LaTeX and PDF."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure
from rich.console import Console
from rich.progress import BarColumn, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars

from longwave.reports.engine import CompileError, EngineMissingError, compile_pdf, ensure_engine
from longwave.reports.latex import render, write
from longwave.reports.paper import SOURCES
from longwave.reports.pictures.drawing import cost_figure, snapshot_panels
from longwave.reports.pictures.lattice_figures import modulation_figure
from longwave.reports.pictures.paper_figures import paper_figures
from longwave.reports.pictures.style import TEXT_WIDTH, save, styled
from longwave.reports.sections import (
    benches,
    costs,
    lattice_runs,
    literature,
    other_lattices,
    runs,
    theory,
)
from longwave.reports.sections.headlines import Findings, headline_table
from longwave.reports.sections.other_lattices import model_jobs
from longwave.reports.studies.bench_laws import bench_law_jobs
from longwave.reports.studies.effects import effect_jobs
from longwave.reports.studies.estimates import estimate_rows, judged_findings
from longwave.reports.studies.evaluation_accuracy import accuracy_jobs
from longwave.reports.studies.evaluation_cost import evaluation_cost_jobs
from longwave.reports.studies.hard_cases import hard_case_jobs
from longwave.reports.studies.lattice_cost import MEDIANS, lattice_cost_jobs
from longwave.reports.studies.lattice_models import modulation_plane
from longwave.reports.studies.lattice_runs import rate_jobs, scene_run_jobs
from longwave.reports.studies.long_runs import long_run_jobs
from longwave.reports.studies.measured_runs import SPLIT, report_scenes, scene_job
from longwave.reports.studies.proofs import library_jobs, proof_jobs
from longwave.scenes.description.scene import Scene
from longwave.solutions.catalogue import CATALOGUE, closed_form
from longwave.support.command_line import fail
from longwave.support.console import check_output, plain_console
from longwave.support.interruption import interrupted, note_saved
from longwave.support.processes import Job, Key, run_jobs
from longwave.support.request_limits import ExpectedCost, check_request
from longwave.support.slow_work import announce
from longwave.verify.evidence.mutations import MutationCount, count_mutants
from longwave.verify.evidence.residual import check_residual
from longwave.verify.verdict import Verdict


def all_jobs(scenes: Mapping[str, Scene], full: bool) -> dict[Key, Job]:
    """Return the jobs of a report, keyed by (kind, subject)."""
    jobs: dict[Key, Job] = {("run", name): scene_job(scene) for name, scene in scenes.items()}
    jobs |= {("residual", name): Job(_residual, (name,), 0.5) for name in CATALOGUE.names}
    paper = CATALOGUE.of("mKdV").names
    jobs |= {("mutants", name): Job(_mutants, (name,), 2.0) for name in paper}
    jobs["plane", "fput_strain"] = Job(modulation_plane, (), 0.5)
    jobs |= proof_jobs() | library_jobs() | accuracy_jobs(full)
    jobs |= model_jobs() | rate_jobs(full) | scene_run_jobs() | bench_law_jobs()
    return jobs | study_jobs(full)


def study_jobs(full: bool) -> dict[Key, Job]:
    """Return the jobs of the studies of cost and hard cases and, if ``full``, of long runs."""
    jobs = evaluation_cost_jobs() | lattice_cost_jobs(full) | hard_case_jobs(full) | effect_jobs()
    return jobs | long_run_jobs() if full else jobs


def _residual(name: str) -> Verdict:
    return check_residual(closed_form(name))


def _mutants(name: str) -> MutationCount:
    return count_mutants(closed_form(name))


PROCESS_BYTES, WORKER_BYTES = 6e8, 4e8
"""Bytes of memory that the main process needs at most, and that each worker needs."""


def report_cost(jobs: Mapping[Key, Job], workers: int) -> ExpectedCost:
    """Return the expected time and memory of a report with these jobs."""
    work = sum(job.weight for job in jobs.values())
    cores = min(workers, os.cpu_count() or 1)
    return ExpectedCost(work / cores, PROCESS_BYTES + WORKER_BYTES * workers)


SOURCE = "longwave.tex"
"""File name of the report's LaTeX source."""

MIN_FIGURES = 14
"""Least number of figures in a report, for the progress bar."""

STUDY_TABLES: Mapping[str, Callable[[Findings], str]] = {
    "cost_table": lambda found: costs.cost_table(found.rows("cost")),
    "precision_table": lambda found: costs.precision_table(found.rows("precision")),
    "scaling_table": lambda found: costs.scaling_table(found.rows("scaling")),
    "extrapolated_table": lambda found: costs.extrapolated_table(found.rows("scaling")),
    "rk4_table": lambda found: costs.rk4_table(found.rows("rk4")),
    "window_table": lambda found: costs.window_table(found.rows("windows")),
    "hard_case_table": lambda found: costs.hard_case_table(found.all("hard")),
    "message_table": lambda found: costs.message_table(found.all("hard")),
    "peak_table": lambda found: runs.peak_table(found.all("peak")),
    "effect_table": lambda found: benches.effect_table(found.of("effect")),
    "split_table": lambda found: runs.split_table(found.of("split")),
    "long_table": lambda found: runs.long_table(found.long_runs),
}
"""Table name -> function that builds it, for the studies of cost, hard cases and long runs."""

TABLES: Mapping[str, Callable[[Findings], str]] = {
    **STUDY_TABLES,
    "headline_table": lambda found: headline_table(found.headlines.values()),
    "estimate_table": lambda found: costs.estimate_table(estimate_rows(found.all("estimate"))),
    "estimate_reasons": lambda found: costs.reason_table(found.all("estimate")),
    "solution_table": lambda _: theory.solution_table(),
    "proof_table": lambda found: theory.proof_table(
        _of_paper(found.all("proof")), found.of("residual")
    ),
    "mutation_table": lambda found: theory.mutation_table(found.all("mutants")),
    "survivor_table": lambda found: theory.survivor_table(found.all("mutants")),
    "accuracy_table": lambda found: costs.accuracy_table(_of_paper(found.accuracy)),
    "run_table": lambda found: runs.run_table(found.runs),
    "claim_table": lambda found: runs.claim_table(found.claims),
    "library_counts": lambda found: literature.library_counts(found.rows("library")),
    "library_equations": lambda found: literature.library_equations(found.rows("library")),
    "library_formulas": lambda found: literature.library_formulas(found.rows("library")),
    "library_conditions": lambda found: literature.library_conditions(found.rows("library")),
    "found_misprints": lambda found: literature.found_misprints(found.rows("library")),
    "form_table": lambda found: other_lattices.form_table(
        found.all("proof"), found.of("residual"), found.accuracy
    ),
    "model_table": lambda found: other_lattices.model_table(found.rows("model")),
    "envelope_table": lambda found: other_lattices.envelope_table(found.all("envelope")),
    "scene_table": lambda found: lattice_runs.scene_table(found.of("scene")),
    "scene_maps": lambda found: lattice_runs.scene_maps(found.of("scene")),
    "bench_table": lambda found: benches.bench_table(found.of("bench")),
    "balance_table": lambda found: benches.balance_table(found.of("bench")),
    "bench_pictures": lambda found: benches.bench_pictures(found.of("bench")),
    "bench_laws": lambda found: benches.bench_laws(found.of("bench"), found.all("struck")),
    "loss_pictures": lambda found: benches.bench_pictures(_lossy(found)),
    "rate_table": lambda found: lattice_runs.rate_table(found.all("rate")),
    "rate_errors": lambda found: lattice_runs.rate_errors(found.all("rate")),
}
"""Name of each table in the templates -> function that builds its LaTeX."""


def _lossy(findings: Findings) -> dict[str, Any]:
    """Return the scenes on lattices with losses, with their runs, by name."""
    return {name: run for name, run in findings.of("scene").items() if run.scene.losses}


def _of_paper(records: Sequence[Any]) -> list[Any]:
    """Return the records whose closed form solves the paper's equation (mKdV)."""
    equation = other_lattices.PAPER_EQUATION
    return [record for record in records if CATALOGUE.equation(record.name) == equation]


def source(content: Mapping[str, str], findings: Findings, full: bool) -> str:
    """Return the report's LaTeX source; ``content`` maps the template's names to LaTeX tables."""
    return render(
        "report.tex.j2",
        version=version("longwave"),
        date=today(),
        full=full,
        headlines=findings.headlines,
        formulas=theory.formulas(),
        equations=theory.equations(),
        figures=runs.figure_entries(findings.runs.scenes),
        sources=sorted(SOURCES.items()),
        normal_equations=other_lattices.normal_equations(),
        **theory.derivation(),
        **content,
    )


def today() -> str:
    """Return the report's date, in UTC; SOURCE_DATE_EPOCH overrides the clock, in seconds."""
    seconds = float(os.environ.get("SOURCE_DATE_EPOCH") or time.time())
    return time.strftime("%d %B %Y", time.gmtime(seconds)).lstrip("0")


def report_figures(findings: Findings) -> Iterator[tuple[str, Figure]]:
    """Yield the name and figure of each figure in the report."""
    yield from paper_figures(findings.runs.runs)
    yield from study_figures(findings)
    papers, (plane,) = findings.runs.runs[SPLIT], findings.all("plane")
    yield from lattice_runs.lattice_figures(findings.of("scene"), papers, findings.all("rate"))
    yield from benches.bench_figures(findings.of("bench") | _lossy(findings))
    yield "modulation", modulation_figure(*plane)


def study_figures(findings: Findings) -> Iterator[tuple[str, Figure]]:
    """Yield the name and figure of each figure of the studies."""
    panels, digits = costs.cost_panels(findings.rows("cost")), (0, 30, 60, 90)
    figure = cost_figure(panels, "seconds a point", "digits", 4, 1.35, digits=digits)
    yield "evaluation_costs", figure
    panels, error = costs.precision_panels(findings.rows("precision")), r"error of $y/\epsilon$"
    yield "work_precision", cost_figure(panels, "seconds", error, 2, 2.7, cheapest=MEDIANS)
    panels, ticks = costs.scaling_panels(findings.rows("scaling")), (10, 20, 40, 80, 160)
    yield "cost_scaling", cost_figure(panels, r"$1/\epsilon$", "seconds", 1, 2.8, x_ticks=ticks)
    if peaks := findings.all("peak"):
        panels, error = runs.peak_panels(peaks), r"$L^\infty_\epsilon$"
        yield "reduction_error", cost_figure(panels, r"$\epsilon$", error, 1, 2.8)
    if split := findings.of("split"):
        yield "split", snapshot_panels(runs.split_rows(split)).figure()


def write_figures(figures: Iterable[tuple[str, Figure]], folder: Path) -> Iterator[Path]:
    """Draw the figures below the folder, yielding each path when it is written."""
    with styled(TEXT_WIDTH, "tex"):
        for name, figure in figures:
            yield save(figure, folder / "figures" / f"{name}.pdf")


def write_tables(
    tables: Mapping[str, Callable[[Findings], str]], findings: Findings, folder: Path
) -> Iterator[tuple[str, str]]:
    """Write the tables below the folder, yielding each one's name and LaTeX when it is written."""
    for name, table in tables.items():
        text = table(findings)
        write(folder / "tables" / f"{name}.tex", text)
        yield name, text


def write_source(
    findings: Findings, folder: Path, full: bool, on_table_written: Callable[[], None]
) -> Path:
    """Write the tables and the LaTeX source below the folder; return the source's path."""
    content = {}
    for name, text in write_tables(TABLES, findings, folder):
        content[name] = text
        on_table_written()
    return write(folder / SOURCE, source(content, findings, full))


def _check_folder(output: Path, force: bool) -> None:
    """Raise ValueError, before the jobs run, if no report can or may be written to ``output``."""
    if not force and (output / SOURCE).exists():
        got = f"{output}, which has one (--force overwrites it)"
        raise ValueError(f"--output must name a folder without a report, got {got}")
    output.mkdir(parents=True, exist_ok=True)
    check_output(str(output / SOURCE), force=True)


def write_report(
    output: Path,
    program: str,
    *,
    force: bool,
    full: bool,
    workers: int,
    estimates: Path | None = None,
) -> int:
    """Build the report in a folder and return the exit status; ``program`` names the command.

    ``full`` adds the long scenes and full studies, ``estimates`` the table of a file that
    `searches.estimates` wrote.

    Returns 0, 1 if a check, a run or LaTeX failed, 2 for bad input, 130 after Ctrl-C.
    """
    console = plain_console()
    try:
        if workers < 1:
            raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
        _check_folder(output, force)
        estimate_findings = judged_findings(estimates)
        scenes = report_scenes()
        jobs = all_jobs(scenes, full)
        cost = report_cost(jobs, workers)
        check_request("the report", cost, "take fewer --workers or no --full")
        missing = _missing_engine()
        note_saved(f"what was written is in {relative_path(output)}")
        announce("the report", cost.seconds)
        tex, sound = build(output, scenes, jobs, estimate_findings, console, full, workers)
        if missing:
            return 1
        pdf = compile_pdf(tex)
    except KeyboardInterrupt:
        return interrupted(program, f"what was written is in {relative_path(output)}")
    except (ValueError, OSError) as error:
        return fail(error)
    except CompileError as error:
        fail(error)
        return 1
    console.print(relative_path(pdf), soft_wrap=True)
    return 0 if sound else 1


def _missing_engine() -> bool:
    """Return whether the LaTeX engine is missing; if so, print that only the source is written."""
    try:
        ensure_engine()
    except EngineMissingError as error:
        fail(f"{error}; only the source is written")
        return True
    return False


def build(
    output: Path,
    scenes: Mapping[str, Scene],
    jobs: Mapping[Key, Job],
    estimate_findings: Mapping[Key, Any],
    console: Console,
    full: bool,
    workers: int,
) -> tuple[Path, bool]:
    """Run the jobs, then write figures, tables and source below the folder.

    ``estimate_findings`` are added to the results of the jobs.

    Returns the source's path, and whether all results are as they should be (`Findings.sound`).
    """
    with bars(console) as progress:
        run_task = progress.add_task("proving and running", total=1.0)
        results = run_jobs(jobs, workers, lambda done: progress.update(run_task, completed=done))
        findings = Findings({**results, **estimate_findings}, scenes)
        draw_task = progress.add_task("drawing", total=MIN_FIGURES)
        for _ in write_figures(report_figures(findings), output):
            progress.advance(draw_task)
        write_task = progress.add_task("writing", total=len(TABLES))
        tex = write_source(findings, output, full, partial(progress.advance, write_task))
    return tex, findings.sound


def relative_path(path: Path) -> str:
    """Return the path relative to the working directory if it lies below it, else unchanged."""
    with suppress(ValueError):
        return str(path.resolve().relative_to(Path.cwd()))
    return str(path)


def bars(console: Console) -> Bars:
    """Return progress bars with a label and the elapsed time."""
    label = TextColumn("{task.description:20}")
    return Bars(label, BarColumn(), TimeElapsedColumn(), console=console)
