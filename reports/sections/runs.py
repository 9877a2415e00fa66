"""What the report prints of the runs: errors, the paper's statements, and the full report's more.

The full report has all eps, the split wave and long times.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from longwave.reports.latex import (
    duration,
    escape,
    mathematics,
    measured,
    scientific,
    symbol_latex,
    table,
)
from longwave.reports.paper import cited
from longwave.reports.pictures.drawing import CostPanels
from longwave.reports.pictures.paper_figures import ERROR_FIGURES, SNAPSHOT_FIGURES
from longwave.reports.pictures.run_data import snapshots
from longwave.reports.studies.lattice_cost import PeakError, peak_laws
from longwave.scenes.named_scenes import load_scene
from longwave.scenes.scene import Scene

if TYPE_CHECKING:
    from longwave.reports.studies.claims import Claim, Measurement
    from longwave.reports.studies.long_runs import LongRun
    from longwave.reports.studies.measured_runs import MeasuredRuns

SHORT = 16
"""Measurements whose texts are shorter than this stand in one line."""


def claim_table(claims: Iterable[Claim]) -> str:
    """One row a statement."""
    rows = [
        [
            mathematics(claim.statement),
            _measured(claim.measurements),
            claim.ruling.value,
            mathematics(claim.depends_on),
        ]
        for claim in claims
    ]
    head = ["the paper says", "measured here", "verdict", "depends on"]
    return table("L{35mm}L{69mm}L{16mm}L{33mm}", head, rows, gap="1ex")


def _measured(measurements: Iterable[Measurement]) -> str:
    """Return the measurements in lines: equal ones of several cases in one, short ones joined."""
    cases: dict[tuple[str, str], list[str]] = {}
    for measurement in measurements:
        case, colon, what = measurement.of.partition(": ")
        key = (what, _number(measurement)) if colon else (measurement.of, _number(measurement))
        cases.setdefault(key, []).append(case if colon else "")
    lines = [
        f"{mathematics(': '.join(filter(None, (', '.join(found), what))))}: {number}"
        for (what, number), found in cases.items()
    ]
    return (", " if all(len(line) < SHORT for line in lines) else r"\newline ").join(lines)


def _number(measurement: Measurement) -> str:
    """Return the number; one without error is exact."""
    value, error = measurement.value, measurement.error
    return f"${value:.4g}$" if error == 0 else measured(value, error)


def run_table(evidence: MeasuredRuns) -> str:
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


def _run_rows(evidence: MeasuredRuns, name: str) -> list[list[str]]:
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
    constants = {"K2": scene.model.K2, "K4": scene.model.K4, "eps": scene.eps, "t_0": scene.t0}
    values = ", ".join(
        f"${symbol_latex(name)}={escape(value) if isinstance(value, str) else f'{value:g}'}$"
        for name, value in [*scene.parameters, *constants.items()]
    )
    title = scene.form.title
    return f"{escape(title[0].upper() + title[1:])} ({values})"


SPLIT_HALF_WIDTH = 150
"""Sites shown of the split wave to either side of c t."""

ACROSS = 3
"""Snapshots of the split wave in a row."""


def peak_table(points: Iterable[PeakError]) -> str:
    """The reduction's error by order and eps, its law, and what each point took."""
    found = list(points)
    laws = peak_laws(found)
    rows = []
    for order, law in laws.items():
        mine = sorted((p for p in found if p.order == order), key=lambda p: -p.eps)
        for place, point in enumerate(mine):
            name = f"$Y_{order}$" if place == 0 else ""
            power = "--" if law is None else rf"$\epsilon^{{{law:.2f}}}$"
            rows.append([name, f"${point.eps:g}$", *_peak(point), "" if place else power])
    head = [
        "",
        r"$\epsilon$",
        r"$L^\infty_\epsilon$ at $T=0$",
        "of it discretisation",
        "engine",
        "time",
        "law",
    ]
    return table("lrL{34mm}llrl", head, rows)


def _peak(point: PeakError) -> list[str]:
    """Value, its own error, engine and time; in the value's place why there is none."""
    time = duration(point.seconds) if np.isfinite(point.seconds) else "--"
    if point.fault:
        return [f"did not run: {escape(point.fault)}", "--", point.engine or "--", time]
    value = scientific(point.value, 4) + ("" if point.resolved else " (not resolved)")
    return [value, rf"$\le$ {scientific(point.own)}", point.engine, time]


def peak_panels(points: Iterable[PeakError]) -> CostPanels:
    """The resolved errors against eps, a curve an order, and eps squared through the last."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for point in points:
        if point.resolved:
            curves.setdefault(f"$Y_{point.order}$", []).append((point.eps, point.value))
    if curves:
        eps, value = min(next(iter(curves.values())))
        ends = (eps, max(x for curve in curves.values() for x, _ in curve))
        curves[r"$\propto\epsilon^2$"] = [(x, 0.7 * value * (x / eps) ** 2) for x in ends]
    return {"": curves}


def split_rows(runs: Mapping[str, xr.Dataset]) -> list[list[xr.Dataset]]:
    """The snapshots of the split wave's run, in rows of ``ACROSS``."""
    rows = []
    for run in runs.values():
        seen = snapshots(run, SPLIT_HALF_WIDTH)
        rows += [seen[i : i + ACROSS] for i in range(0, len(seen) - ACROSS + 1, ACROSS)]
    return rows


def split_table(runs: Mapping[str, xr.Dataset]) -> str:
    """Lowest and highest strain of lattice and wave, and the error, at each snapshot."""
    rows = [row for name, run in runs.items() for row in _split_rows(run, load_scene(name).eps)]
    head = ["$t$", "lowest: lattice", "wave", "highest: lattice", "wave", r"$L^\infty_\epsilon$"]
    return table("rrrrrl", head, rows) if rows else ""


def _split_rows(run: xr.Dataset, eps: float) -> list[list[str]]:
    rows = []
    for time in run["time"].values:
        at = run.sel(time=time)
        ends = [
            f"${float(end(at[part])) / eps:.3f}$"
            for end in (np.min, np.max)
            for part in ("strain", "analytic")
        ]
        height = float(np.max(np.abs(at["analytic"] - at["background"]))) / eps
        own = float(run.attrs["error_estimate"]) / height
        rows.append([f"${time:g}$", *ends, measured(float(at["error"]), own)])
    return rows


def long_table(runs: Mapping[str, LongRun]) -> str:
    """One row a long run: its errors in time, its estimate, the other engine's word, the times."""
    times = _times(runs)
    rows = [_long_row(name, found) for name, found in runs.items()]
    head = [
        r"$L^\infty_\epsilon$ at $t=$",
        *(f"${time:g}$" for time in times),
        "estimate",
        "difference",
        "its step",
        "ring",
        "stencil",
    ]
    return table("l" + "r" * (len(times) + 5), head, rows) if rows else ""


def _times(runs: Mapping[str, LongRun]) -> list[float]:
    """The times of the first run; all have the same."""
    return [float(t) for found in list(runs.values())[:1] for t in found.ring["time"].values]


def _long_row(name: str, found: LongRun) -> list[str]:
    attributes = found.ring.attrs
    judged = scientific(float(found.differences.max(skipna=False)))
    return [
        escape(name.split("_k_")[0].replace("_", " ")),
        *(f"{error:.4f}" for error in found.ring["error"].values),
        scientific(float(attributes["error_estimate"])),
        judged if found.kept else f"{judged} (TOO LARGE)",
        scientific(found.own, 1),
        duration(float(attributes["seconds"] + attributes["planning_seconds"])),
        duration(float(found.fine.attrs["seconds"])),
    ]
