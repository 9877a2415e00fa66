"""Building the report: the work as jobs in processes, figures, tables, LaTeX, PDF."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, partial
from importlib.metadata import version
from itertools import chain, groupby
from operator import attrgetter
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
from longwave.reports.sections.headlines import Headline, headline_table, headlines
from longwave.reports.sections.other_lattices import model_jobs
from longwave.reports.studies.bench_laws import bench_law_jobs
from longwave.reports.studies.claims import Claim, all_claims
from longwave.reports.studies.effects import effect_jobs
from longwave.reports.studies.estimates import estimate_rows, judged_findings
from longwave.reports.studies.evaluation_accuracy import Accuracy, accuracy_jobs, worst_of
from longwave.reports.studies.evaluation_cost import evaluation_cost_jobs
from longwave.reports.studies.hard_cases import hard_case_jobs
from longwave.reports.studies.lattice_cost import MEDIANS, lattice_cost_jobs
from longwave.reports.studies.lattice_models import modulation_plane
from longwave.reports.studies.lattice_runs import rate_jobs, scene_run_jobs
from longwave.reports.studies.long_runs import LongRun, long_run_jobs, long_runs
from longwave.reports.studies.measured_runs import SPLIT, MeasuredRuns, report_scenes, scene_job
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
    """The jobs of a report under (kind, subject)."""
    jobs: dict[Key, Job] = {("run", name): scene_job(scene) for name, scene in scenes.items()}
    jobs |= {("residual", name): Job(_residual, (name,), 0.5) for name in CATALOGUE.names}
    paper = CATALOGUE.of("mKdV").names
    jobs |= {("mutants", name): Job(_mutants, (name,), 2.0) for name in paper}
    jobs["plane", "fput_strain"] = Job(modulation_plane, (), 0.5)
    jobs |= proof_jobs() | library_jobs() | accuracy_jobs(full)
    jobs |= model_jobs() | rate_jobs(full) | scene_run_jobs() | bench_law_jobs()
    return jobs | study_jobs(full)


def study_jobs(full: bool) -> dict[Key, Job]:
    """The jobs of the studies of cost and of hard cases; long runs if ``full``."""
    jobs = evaluation_cost_jobs() | lattice_cost_jobs(full) | hard_case_jobs(full) | effect_jobs()
    return jobs | long_run_jobs() if full else jobs


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

    @cached_property
    def claims(self) -> list[Claim]:
        """The paper's statements with their verdicts."""
        return all_claims(self.runs)

    @cached_property
    def headlines(self) -> dict[str, Headline]:
        """The main results."""
        return headlines(self)

    @property
    def sound(self) -> bool:
        """Whether every form and study stands and every run came to its end."""
        stands = (STANDS[kind](v) for (kind, _), v in self.found.items() if kind in STANDS)
        return all(stands) and all(long.kept for long in self.long_runs.values())


PROCESS_BYTES, WORKER_BYTES = 6e8, 4e8
"""What the command and each worker hold at most."""


def report_cost(jobs: Mapping[Key, Job], workers: int) -> ExpectedCost:
    """What a report of these jobs takes."""
    work = sum(job.weight for job in jobs.values())
    cores = min(workers, os.cpu_count() or 1)
    return ExpectedCost(work / cores, PROCESS_BYTES + WORKER_BYTES * workers)


SOURCE = "longwave.tex"

FIGURES = 14
"""How many figures a report has, at least."""

STUDY_TABLES: Mapping[str, Callable[[Findings], str]] = {
    "cost_table": lambda found: costs.cost_table(found.rows("cost")),
    "precision_table": lambda found: costs.precision_table(found.rows("precision")),
    "scaling_table": lambda found: costs.scaling_table(found.rows("scaling")),
    "extrapolated_table": lambda found: costs.extrapolated_table(found.rows("scaling")),
    "rk4_table": lambda found: costs.rk4_table(found.rows("rk4")),
    "window_table": lambda found: costs.window_table(found.rows("windows")),
    "hard_case_table": lambda found: costs.hard_case_table(found.all("hard")),
    "message_table": lambda found: costs.message_table(found.all("hard")),
    "peak_table": lambda found: runs.peak_table(peaks) if (peaks := found.all("peak")) else "",
    "effect_table": lambda found: benches.effect_table(found.of("effect")),
    "split_table": lambda found: runs.split_table(found.of("split")),
    "long_table": lambda found: runs.long_table(found.long_runs),
}
"""The tables of the studies of cost, hard cases and long runs."""

TABLES: Mapping[str, Callable[[Findings], str]] = {
    **STUDY_TABLES,
    "headline_table": lambda found: headline_table(found.headlines.values()),
    "estimate_table": lambda found: costs.estimate_table(estimate_rows(found.all("estimate"))),
    "estimate_reasons": lambda found: costs.reason_table(found.all("estimate")),
    "solution_table": lambda _: theory.solution_table(),
    "proof_table": lambda found: theory.proof_table(
        _papers(found.all("proof")), found.of("residual")
    ),
    "mutation_table": lambda found: theory.mutation_table(found.all("mutants")),
    "survivor_table": lambda found: theory.survivor_table(found.all("mutants")),
    "accuracy_table": lambda found: costs.accuracy_table(_papers(found.accuracy)),
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
"""All tables under their templates' names."""


def _lossy(found: Findings) -> dict[str, Any]:
    """The runs of waves on lattices with losses."""
    return {name: run for name, run in found.of("scene").items() if run.scene.losses}


def _papers(records: Sequence[Any]) -> list[Any]:
    """The records of forms of the paper's equation; the others are in the chapter of lattices."""
    return [found for found in records if CATALOGUE.equation(found.name) == other_lattices.PAPERS]


def source(content: Mapping[str, str], found: Findings, full: bool) -> str:
    """Return the report's LaTeX source; `content` holds the tables."""
    return render(
        "report.tex.j2",
        version=version("longwave"),
        date=today(),
        full=full,
        headlines=found.headlines,
        formulas=theory.formulas(),
        equations=theory.equations(),
        figures=runs.figure_entries(found.runs.scenes),
        sources=sorted(SOURCES.items()),
        normal_equations=other_lattices.normal_equations(),
        **theory.derivation(),
        **content,
    )


def today() -> str:
    """The date of a report, in UTC; SOURCE_DATE_EPOCH names another one, in seconds."""
    seconds = float(os.environ.get("SOURCE_DATE_EPOCH") or time.time())
    return time.strftime("%d %B %Y", time.gmtime(seconds)).lstrip("0")


def report_figures(found: Findings) -> Iterator[tuple[str, Figure]]:
    """Each figure under its name."""
    yield from paper_figures(found.runs.runs)
    yield from study_figures(found)
    papers, (plane,) = found.runs.runs[SPLIT], found.all("plane")
    yield from lattice_runs.lattice_figures(found.of("scene"), papers, found.all("rate"))
    yield from benches.bench_figures(found.of("bench") | _lossy(found))
    yield "modulation", modulation_figure(*plane)


def study_figures(found: Findings) -> Iterator[tuple[str, Figure]]:
    """The figures of the studies under their names."""
    yield (
        "evaluation_costs",
        cost_figure(
            costs.cost_panels(found.rows("cost")),
            *("seconds a point", "digits", 4, 1.35),
            digits=(0, 30, 60, 90),
        ),
    )
    precision, error = costs.precision_panels(found.rows("precision")), r"error of $y/\epsilon$"
    yield "work_precision", cost_figure(precision, "seconds", error, 2, 2.7, cheapest=MEDIANS)
    scaling, ticks = costs.scaling_panels(found.rows("scaling")), (10, 20, 40, 80, 160)
    yield "cost_scaling", cost_figure(scaling, r"$1/\epsilon$", "seconds", 1, 2.8, x_ticks=ticks)
    if peaks := found.all("peak"):
        panels = runs.peak_panels(peaks)
        figure = cost_figure(panels, r"$\epsilon$", r"$L^\infty_\epsilon$", 1, 2.8)
        yield "reduction_error", figure
    if split := found.of("split"):
        yield "split", snapshot_panels(runs.split_rows(split)).figure()


def write_figures(figures: Iterable[tuple[str, Figure]], folder: Path) -> Iterator[Path]:
    """Draw the figures below the folder, yielding each path when it is written."""
    with styled(TEXT_WIDTH, "tex"):
        for name, figure in figures:
            yield save(figure, folder / "figures" / f"{name}.pdf")


def write_tables(
    tables: Mapping[str, Callable[[Findings], str]], found: Findings, folder: Path
) -> Iterator[tuple[str, str]]:
    """Write the tables below the folder, yielding each one's name and LaTeX when it is written."""
    for name, table in tables.items():
        text = table(found)
        write(folder / "tables" / f"{name}.tex", text)
        yield name, text


def write_source(found: Findings, folder: Path, full: bool, wrote: Callable[[], None]) -> Path:
    """Write the tables and the LaTeX source below the folder; return the source's path."""
    content = {}
    for name, text in write_tables(TABLES, found, folder):
        content[name] = text
        wrote()
    return write(folder / SOURCE, source(content, found, full))


def _check_folder(output: Path, force: bool) -> None:
    """Raise ValueError, before anything is computed, if no report can or may be written there."""
    if not force and (output / SOURCE).exists():
        raise ValueError(
            f"--output must name a folder without a report, got {output}, which has one "
            "(--force overwrites it)"
        )
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
    """Build the report in a folder, if ``full`` with long scenes; Ctrl-C is told by ``program``.

    ``estimates`` is a file of `searches.estimates`, whose table the report then has as well.

    Returns 0, 1 if a check, a run or LaTeX failed, 2 for bad input, 130 after Ctrl-C.
    """
    console = plain_console()
    try:
        if workers < 1:
            raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
        _check_folder(output, force)
        judged = judged_findings(estimates)
        scenes = report_scenes()
        jobs = all_jobs(scenes, full)
        cost = report_cost(jobs, workers)
        check_request("the report", cost, "take fewer --workers or no --full")
        missing = _missing_engine(console)
        note_saved(f"what was written is in {shown(output)}")
        announce("the report", cost.seconds)
        tex, sound = build(output, scenes, jobs, judged, console, full, workers)
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
        ensure_engine()
    except EngineMissingError as error:
        fail(f"{error}; the source alone is written")
        return True
    return False


def build(
    output: Path,
    scenes: Mapping[str, Scene],
    jobs: Mapping[Key, Job],
    judged: Mapping[Key, Any],
    console: Console,
    full: bool,
    workers: int,
) -> tuple[Path, bool]:
    """Do the jobs on the scenes; write figures, tables and source below the folder.

    ``judged`` is what was found before.

    Returns the source's path, and whether every form stands and every run came to its end.
    """
    with bars(console) as bar:
        working = bar.add_task("proving and running", total=1.0)
        done = run_jobs(jobs, workers, lambda share: bar.update(working, completed=share))
        found, drawing = (
            Findings({**done, **judged}, scenes),
            bar.add_task("drawing", total=FIGURES),
        )
        for _ in write_figures(report_figures(found), output):
            bar.advance(drawing)
        writing = bar.add_task("writing", total=len(TABLES))
        tex = write_source(found, output, full, partial(bar.advance, writing))
    return tex, found.sound


def shown(path: Path) -> str:
    """Return the path relative to the working directory where it lies below it."""
    with suppress(ValueError):
        return str(path.resolve().relative_to(Path.cwd()))
    return str(path)


def bars(console: Console) -> Bars:
    """Bars with their names and the time that has gone."""
    columns = TextColumn("{task.description:20}"), BarColumn(), TimeElapsedColumn()
    return Bars(*columns, console=console)
