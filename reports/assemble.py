"""Putting the report together: findings, figures, tables, LaTeX source."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

from reports.figures.drawing import CostAxes, cost_figure, save, snapshot_figure, styled
from reports.figures.paper_figures import draw_all
from reports.latex import render, write
from reports.paper import SOURCES
from reports.sections import costs, runs, theory
from verify.comparison import Scene
from verify.studies.claims import all_claims
from verify.studies.estimates import estimate_rows

if TYPE_CHECKING:
    from reports.work import Findings, Studies

SOURCE = "longwave.tex"

STUDY_FIGURES = 3
"""How many figures the studies have, at least."""

TABLES: Mapping[str, Callable[[Findings], str]] = {
    "solution_table": lambda _: theory.solution_table(),
    "proof_table": lambda found: theory.proof_table(found.proofs, found.residuals),
    "mutation_table": lambda found: theory.mutation_table(found.mutations),
    "survivor_table": lambda found: theory.survivor_table(found.mutations),
    "accuracy_table": lambda found: costs.accuracy_table(found.accuracy),
    "run_table": lambda found: runs.run_table(found.evidence),
    "claim_table": lambda found: runs.claim_table(all_claims(found.evidence)),
}
"""The tables of proofs, waves and runs under the names that the templates give them."""

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
        **theory.derivation(),
        **content,
    )


def write_figures(found: Findings, folder: Path) -> Iterator[Path]:
    """Draw every figure below the folder, yielding each path when it is written."""
    yield from draw_all(found.evidence.runs, found.evidence.scenes, folder / "figures")
    yield from write_study_figures(found.studies, folder)


def write_study_figures(found: Studies, folder: Path) -> Iterator[Path]:
    """Draw the figures of the studies, yielding each path when it is written."""
    digits = CostAxes("seconds a point", "digits", digits=(0, 30, 60, 90))
    error = CostAxes("seconds", r"error of $y/\epsilon$")
    scaling = CostAxes(r"$1/\epsilon$", "seconds", x_ticks=(10, 20, 40, 80, 160))
    figures = {
        "evaluation_costs": (costs.cost_panels(found.evaluation), digits, 4, 1.35),
        "work_precision": (costs.precision_panels(found.precision), error, 2, 2.7),
        "cost_scaling": (costs.scaling_panels(found.scaling), scaling, 1, 2.8),
    }
    if found.peaks:
        peaks = runs.peak_panels(found.peaks)
        reduction = CostAxes(r"$\epsilon$", r"$L^\infty_\epsilon$")
        figures["reduction_error"] = (peaks, reduction, 1, 2.8)
    with styled():
        for name, (panels, axes, across, height) in figures.items():
            figure = cost_figure(panels, axes, across, height)
            yield save(figure, folder / "figures" / f"{name}.pdf")
        if found.split:
            rows = runs.split_rows(found.split)
            yield save(snapshot_figure(rows), folder / "figures" / "split.pdf")


def write_tables(found: Findings, folder: Path) -> Iterator[tuple[str, str]]:
    """Write every table below the folder, yielding its name and LaTeX when it is written."""
    for name, make in TABLES.items():
        yield name, write_table(name, make(found), folder)
    yield from write_study_tables(found.studies, folder)


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
