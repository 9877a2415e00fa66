"""Putting the report together: findings, figures, tables, LaTeX source."""

from collections.abc import Callable, Iterator, Mapping
from importlib.metadata import version
from itertools import groupby
from operator import attrgetter
from pathlib import Path

from reports.environment import render
from reports.figures.costs import CostPanel, cost_figure
from reports.figures.paper import draw_all
from reports.figures.style import save, styled
from reports.sections import claims, derivation, evaluation, proofs, runs, solutions
from reports.tables import write
from reports.work import Findings
from verify.lattice import Scene
from verify.study.claims import all_claims
from verify.study.cost_evaluation import ARITHMETICS

SOURCE = "longwave.tex"

TABLES: Mapping[str, Callable[[Findings], str]] = {
    "solution_table": lambda _: solutions.solution_table(),
    "proof_table": lambda found: proofs.proof_table(found.proofs, found.residuals),
    "mutation_table": lambda found: proofs.mutation_table(found.mutations),
    "survivor_table": lambda found: proofs.survivor_table(found.mutations),
    "accuracy_table": lambda found: evaluation.accuracy_table(found.accuracy),
    "cost_table": lambda found: evaluation.cost_table(found.costs),
    "run_table": lambda found: runs.run_table(found.evidence),
    "claim_table": lambda found: claims.claim_table(all_claims(found.evidence)),
}
"""Every table of the report under the name that the templates give it."""


def source(content: Mapping[str, str], scenes: Mapping[str, Scene], full: bool) -> str:
    """Return the report's LaTeX source; `content` holds the tables."""
    return render(
        "report.tex.j2",
        version=version("longwave"),
        full=full,
        formulas=solutions.formulas(),
        equations=solutions.equations(),
        figures=runs.figure_entries(scenes),
        **derivation.derivation(),
        **content,
    )


def write_figures(found: Findings, folder: Path) -> Iterator[Path]:
    """Draw every figure below the folder, yielding each path when it is written."""
    yield from draw_all(found.evidence.runs, found.evidence.scenes, folder / "figures")
    with styled():
        figure = cost_figure(evaluation_panels(found), "seconds", "digits", across=4)
        yield save(figure, folder / "figures" / "evaluation_costs.pdf")


def evaluation_panels(found: Findings) -> list[CostPanel]:
    """One panel a wave: digits against seconds for each family of arithmetics."""
    family = {arithmetic.name: arithmetic.family for arithmetic in ARITHMETICS}
    panels = []
    for wave, costs in groupby(found.costs, attrgetter("wave")):
        curves: dict[str, list[tuple[float, float]]] = {}
        for cost in costs:
            curves.setdefault(family[cost.arithmetic], []).append((cost.seconds, cost.digits))
        panels.append(CostPanel(wave.replace("_", " "), curves))
    return panels


def write_source(found: Findings, folder: Path, full: bool, wrote: Callable[[], None]) -> Path:
    """Write the tables and the LaTeX source below the folder; return the source's path."""
    content = {}
    for name, make in TABLES.items():
        content[name] = make(found)
        write(folder / "tables" / f"{name}.tex", content[name])
        wrote()
    return write(folder / SOURCE, source(content, found.evidence.scenes, full))
