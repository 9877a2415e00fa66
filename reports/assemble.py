"""Putting the report together: runs, figures, tables, LaTeX source."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

from reports import sections
from reports.environment import render
from reports.evidence import Evidence
from reports.figures.paper import draw_all
from reports.tables import write
from verify.lattice import Scene
from verify.verdict import Verdict

SOURCE = "longwave.tex"


def tables(evidence: Evidence, verdicts: list[Verdict]) -> dict[str, str]:
    """Return the LaTeX of every table under its name."""
    return {
        "solution_table": sections.solution_table(),
        "residual_table": sections.residual_table(verdicts),
        "run_table": sections.run_table(evidence),
        "claim_table": sections.claim_table(evidence),
    }


def source(content: Mapping[str, str], scenes: Mapping[str, Scene]) -> str:
    """Return the report's LaTeX source; `content` holds the tables."""
    return render(
        "report.tex.j2",
        version=sections.package_version(),
        formulas=sections.formulas(),
        equations=sections.equations(),
        figures=sections.figure_entries(scenes),
        **sections.derivation(),
        **content,
    )


def write_figures(evidence: Evidence, folder: Path) -> Iterator[Path]:
    """Draw every figure below the folder, yielding each path when it is written."""
    yield from draw_all(evidence.runs, evidence.scenes, folder / "figures")


def write_source(
    evidence: Evidence, verdicts: list[Verdict], folder: Path, wrote: Callable[[], None]
) -> Path:
    """Write the tables and the LaTeX source below the folder; return the source's path."""
    content = tables(evidence, verdicts)
    for name, text in content.items():
        write(folder / "tables" / f"{name}.tex", text)
        wrote()
    return write(folder / SOURCE, source(content, evidence.scenes))
