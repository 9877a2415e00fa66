"""What the report prints of the runs: errors, the paper's statements, and the full report's more.

The full report has all eps, the split wave and long times.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from longwave.reports.latex import (
    PRINTED,
    Row,
    escape,
    mathematics,
    scientific,
    symbol_latex,
    table,
    uncertain,
)
from longwave.reports.paper import cited
from longwave.reports.pictures.drawing import CostPanels
from longwave.reports.pictures.paper_figures import ERROR_FIGURES, SNAPSHOT_FIGURES
from longwave.reports.pictures.run_data import snapshots
from longwave.reports.studies.lattice_cost import PeakError, peak_laws
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.support.labelled_arrays import LabelledArrays

if TYPE_CHECKING:
    from longwave.reports.studies.claims import Claim, Measurement
    from longwave.reports.studies.long_runs import LongRun
    from longwave.reports.studies.measured_runs import MeasuredRuns


def claim_table(claims: Iterable[Claim]) -> str:
    """Each statement with its verdict, and below it a row a number, with its own error."""
    rows: list[Row] = []
    for number, claim in enumerate(claims, 1):
        rows.append(
            rf"{number}. {mathematics(claim.statement)}: \textbf{{{claim.ruling.value}}}. "
            rf"\emph{{Rests on}} {mathematics(claim.depends_on)}."
        )
        rows += _measured(claim.measurements)
    head = ["quantity", "value", "own error"]
    caption = (
        "The paper's statements, each with its verdict and the numbers measured for it, which are "
        r"$L^\infty_\epsilon$ where no other quantity is named; a number without an own error is "
        "computed without a lattice."
    )
    return table("claims", caption, r"L{106mm}ll", head, rows)


def _measured(measurements: Iterable[Measurement]) -> list[list[str]]:
    """The measurements: equal ones of several cases in one row."""
    cases: dict[tuple[str, tuple[str, str]], list[str]] = {}
    for measurement in measurements:
        case, colon, what = measurement.of.partition(": ")
        shown = uncertain(measurement.value, measurement.error)
        key = (what, shown) if colon else (measurement.of, shown)
        cases.setdefault(key, []).append(case if colon else "")
    return [
        [mathematics(": ".join(filter(None, (", ".join(found), what)))), *shown]
        for (what, shown), found in cases.items()
    ]


def run_table(evidence: MeasuredRuns) -> str:
    """The runs: scheme, step, sites, and at each snapshot the errors and what they are made of."""
    rows = [row for name in evidence.runs for row in _run_rows(evidence, name)]
    head = [
        "$t$",
        r"$L^\infty_\epsilon$",
        "own error",
        "over far field",
        r"step$\,/\,\epsilon$",
        r"domain$\,/\,\epsilon$",
    ]
    caption = (
        r"Errors of the runs at each snapshot. Own error: of $L^\infty_\epsilon$, by step and "
        r"domain together; over far field: with the distance to the true far field as denominator."
    )
    return table("runs", caption, "rlllll", head, rows)


def _run_rows(evidence: MeasuredRuns, name: str) -> list[Row]:
    """Return the rows of one run, its description across the table first."""
    run = evidence.runs[name]
    columns = ("error_far_field", "time_step_error", "domain_error")
    rows: list[Row] = [_description(name, evidence.scenes[name])]
    for time in run["time"].values:
        at = run.sel(time=time)
        measures = [scientific(float(at[key])) if key in run else "--" for key in columns]
        error = uncertain(*evidence.relative_error(name, float(time)))
        rows.append([f"${time:g}$", *error, *measures])
    return rows


def _description(name: str, scene: Scene) -> str:
    """Return name, scheme, step and domain of a scene in words."""
    stated = scene.discretisation
    return (
        rf"\texttt{{{escape(name)}}}: {escape(PRINTED[stated.scheme])}, "
        rf"$\Delta t={stated.step:g}$, {escape(stated.domain)} of {stated.sites} sites, "
        f"{2 * scene.compared + 1} compared"
    )


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
        "own error",
        "engine",
        "time (s)",
        "law",
    ]
    caption = (
        "The error of the reduction at the peak, with the run's own error in the same units and "
        r"the power of $\epsilon$ fitted to the three smallest."
    )
    return table("peaks", caption, "lrL{34mm}llrl", head, rows)


def _peak(point: PeakError) -> list[str]:
    """Value, its own error, engine and time; in the value's place why there is none."""
    time = scientific(point.seconds) if np.isfinite(point.seconds) else "--"
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


def split_rows(runs: Mapping[str, xr.Dataset]) -> list[list[LabelledArrays]]:
    """The snapshots of the split wave's run, in rows of ``ACROSS``."""
    rows = []
    for run in runs.values():
        seen = snapshots(run, SPLIT_HALF_WIDTH)
        rows += [seen[i : i + ACROSS] for i in range(0, len(seen) - ACROSS + 1, ACROSS)]
    return rows


def split_table(runs: Mapping[str, xr.Dataset]) -> str:
    """Lowest and highest strain of lattice and wave, and the error, at each snapshot."""
    rows = [row for name, run in runs.items() for row in _split_rows(run, load_scene(name).eps)]
    head = [
        *("$t$", "lowest: lattice", "wave", "highest: lattice", "wave", "own error"),
        *(r"$L^\infty_\epsilon$", "own error"),
    ]
    caption = r"The split wave: lowest and highest strain in units of $\epsilon$, and the error."
    return table("split", caption, "rrrrrlll", head, rows)


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
        own = float(run.attrs["error_estimate"])
        strain, error = scientific(own), uncertain(float(at["error"]), own / height)
        rows.append([f"${time:g}$", *ends, strain, *error])
    return rows


def long_table(runs: Mapping[str, LongRun]) -> str:
    """One row a long run: its errors in time, its estimate, the other engine's word, the times."""
    times = _times(runs)
    rows = [_long_row(name, found) for name, found in runs.items()]
    head = [
        r"$L^\infty_\epsilon$ at $t=$",
        *(f"${time:g}$" for time in times),
        "own error",
        "difference",
        "its step",
        "ring (s)",
        "stencil (s)",
    ]
    caption = (
        r"Long runs: $L^\infty_\epsilon$ at each time; the ring's own error of $y/\epsilon$, its "
        "difference to the stencil, and what the stencil's step changes; the time of each."
    )
    return table("long", caption, "l" + "r" * (len(times) + 5), head, rows)


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
        scientific(float(attributes["seconds"] + attributes["planning_seconds"])),
        scientific(float(found.fine.attrs["seconds"])),
    ]
