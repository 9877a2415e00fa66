"""The runs: errors and what they are made of, and the figures' captions."""

from collections.abc import Mapping, Sequence
from typing import Any

from reports.environment import escape
from reports.figures.paper import ERROR_FIGURES, SNAPSHOT_FIGURES
from reports.paper import cited
from reports.tables import measured, scientific, table
from verify.comparison import Scene
from verify.comparison.initial_data import scene_form
from verify.studies.claims_evidence import Evidence


def run_table(evidence: Evidence) -> str:
    """The runs: scheme, step, sites, and at each snapshot the errors and what they are made of."""
    rows = [row for name in evidence.runs for row in _run_rows(evidence, name)]
    head = [
        "$t$",
        r"$L^\infty_\epsilon$",
        "over far field",
        r"step$\,/\,\epsilon$",
        r"domain$\,/\,\epsilon$",
    ]
    return table("rllll", head, rows)


def _run_rows(evidence: Evidence, name: str) -> list[list[str]]:
    """Return the rows of one run, its description across the table first."""
    run = evidence.runs[name]
    columns = ("error_far_field", "time_step_error", "domain_error")
    rows = [[rf"\multicolumn{{5}}{{l}}{{{_description(name, evidence.scenes[name])}}}"]]
    for time in run["time"].values:
        at = run.sel(time=time)
        measures = [scientific(float(at[key])) if key in run else "--" for key in columns]
        error = measured(*evidence.relative_error(name, float(time)))
        rows.append([rf"\nopagebreak ${time:g}$", error, *measures])
    return rows


def _description(name: str, scene: Scene) -> str:
    """Return name, scheme, step and domain of a scene in words."""
    stated = scene.discretisation
    words = (
        f"{stated.scheme}, dt = {stated.step:g}, {stated.domain} of {stated.sites} sites, "
        f"{2 * scene.compared + 1} compared"
    )
    return rf"\rule{{0pt}}{{3ex}}\texttt{{{escape(name)}}}: {escape(words)}"


def figure_entries(scenes: Mapping[str, Scene]) -> list[dict[str, Any]]:
    """The figures: file, caption from the scenes, label in the paper."""
    snapshots = [
        {
            "name": figure.name,
            "paper": cited(figure.label),
            "scenes": [caption_part(scenes[name]) for name in figure.scenes],
        }
        for figure in SNAPSHOT_FIGURES
    ]
    errors: Sequence[dict[str, Any]] = [
        {"name": figure.name, "paper": cited(figure.label), "scenes": []}
        for figure in ERROR_FIGURES
    ]
    return [*snapshots, *errors]


def caption_part(scene: Scene) -> str:
    """Return the scene's wave, parameters and constants as LaTeX, and the time it starts from."""
    given = [("K_2", scene.K2), ("K_4", scene.K4), (r"\epsilon", scene.eps), ("t_0", scene.t0)]
    named = {"alpha": r"\alpha"}
    parameters = [(named.get(name, name), value) for name, value in scene.parameters]
    values = ", ".join(
        f"${name}={escape(value) if isinstance(value, str) else f'{value:g}'}$"
        for name, value in [*parameters, *given]
    )
    title = scene_form(scene).title
    return f"{escape(title[0].upper() + title[1:])} ({values})"
