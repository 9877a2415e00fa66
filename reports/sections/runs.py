"""Tables and figures of the runs: errors, the paper's statements, split wave and long runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from longwave.reports import latex
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
    """Return the table of the paper's statements: verdict, then a row for each measured number."""
    rows: list[latex.Row] = []
    for number, claim in enumerate(claims, 1):
        rows.append(
            rf"{number}. {latex.mathematics(claim.statement)}: \textbf{{{claim.ruling.value}}}. "
            rf"\emph{{Rests on}} {latex.mathematics(claim.depends_on)}."
        )
        rows += _measured(claim.measurements)
    head = ["quantity", "value", "own error"]
    caption = (
        "The paper's statements, each with its verdict and the numbers measured for it, which are "
        r"$L^\infty_\epsilon$ where no other quantity is named; a number without an own error is "
        "computed without a lattice."
    )
    return latex.table("claims", caption, r"L{106mm}ll", head, rows)


def _measured(measurements: Iterable[Measurement]) -> list[list[str]]:
    """Return table rows of measurements; cases "CASE: quantity" with equal values share a row."""
    cases: dict[tuple[str, tuple[str, str]], list[str]] = {}
    for measurement in measurements:
        case, colon, what = measurement.of.partition(": ")
        number = latex.uncertain(measurement.value, measurement.error)
        key = (what, number) if colon else (measurement.of, number)
        cases.setdefault(key, []).append(case if colon else "")
    return [
        [latex.mathematics(": ".join(filter(None, (", ".join(names), what)))), *number]
        for (what, number), names in cases.items()
    ]


def run_table(evidence: MeasuredRuns) -> str:
    """Return the table of runs: under each description the error and its parts by snapshot."""
    rows = [row for name in evidence.runs for row in _run_rows(evidence, name)]
    head = ["$t$", r"$L^\infty_\epsilon$", "own error", "over far field"]
    head += [r"step$\,/\,\epsilon$", r"domain$\,/\,\epsilon$"]
    caption = (
        r"Errors of the runs at each snapshot. Own error: of $L^\infty_\epsilon$, by step and "
        r"domain together; over far field: with the distance to the true far field as denominator."
    )
    return latex.table("runs", caption, "rlllll", head, rows)


def _run_rows(evidence: MeasuredRuns, name: str) -> list[latex.Row]:
    """Return the rows of one run, its description across the table first."""
    run = evidence.runs[name]
    columns = ("error_far_field", "time_step_error", "domain_error")
    rows: list[latex.Row] = [_description(name, evidence.scenes[name])]
    for time in run["time"].values:
        snapshot = run.sel(time=time)
        measures = [
            latex.scientific(float(snapshot[key])) if key in run else "--" for key in columns
        ]
        error = latex.uncertain(*evidence.relative_error(name, float(time)))
        rows.append([f"${time:g}$", *error, *measures])
    return rows


def _description(name: str, scene: Scene) -> str:
    """Return name, scheme, step and domain of a scene in words."""
    stated = scene.discretisation
    return (
        rf"\texttt{{{latex.escape(name)}}}: {latex.escape(latex.PRINTED[stated.scheme])}, "
        rf"$\Delta t={stated.step:g}$, {latex.escape(stated.domain)} of {stated.sites} sites, "
        f"{2 * scene.compared + 1} compared"
    )


def figure_entries(scenes: Mapping[str, Scene]) -> list[dict[str, Any]]:
    """Return the data of the figures for the template: file name, label in the paper, captions."""
    parts_of = {f: [caption_part(scenes[name]) for name in f.scenes] for f in SNAPSHOT_FIGURES}
    captions: dict[Any, list[str]] = {**parts_of, **{figure: [] for figure in ERROR_FIGURES}}
    return [
        {"name": figure.name, "paper": cited(figure.label), "scenes": parts}
        for figure, parts in captions.items()
    ]


def caption_part(scene: Scene) -> str:
    """Return a scene's wave with its parameters, constants and start time as LaTeX."""
    constants = {"K2": scene.model.K2, "K4": scene.model.K4, "eps": scene.eps, "t_0": scene.t0}
    numbers = {
        name: latex.escape(value) if isinstance(value, str) else f"{value:g}"
        for name, value in [*scene.parameters, *constants.items()]
    }
    values = ", ".join(f"${latex.symbol_latex(name)}={text}$" for name, text in numbers.items())
    title = scene.form.title
    return f"{latex.escape(title[0].upper() + title[1:])} ({values})"


SPLIT_HALF_WIDTH = 150
"""Number of sites on either side of c t in the snapshots of the split wave."""

SNAPSHOTS_PER_ROW = 3
"""Number of snapshots of the split wave in one row of its figure."""


def peak_table(points: Iterable[PeakError]) -> str:
    """Return the table of the reduction's error by order and eps, with the fitted power of eps."""
    all_points = list(points)
    laws = peak_laws(all_points)
    rows = []
    for order, law in laws.items():
        of_order = sorted((p for p in all_points if p.order == order), key=lambda p: -p.eps)
        for index, point in enumerate(of_order):
            name = f"$Y_{order}$" if index == 0 else ""
            power = "--" if law is None else rf"$\epsilon^{{{law:.2f}}}$"
            rows.append([name, f"${point.eps:g}$", *_peak(point), "" if index else power])
    value = r"$L^\infty_\epsilon$ at $T=0$"
    head = ["", r"$\epsilon$", value, "own error", "engine", "time (s)", "law"]
    caption = (
        "The error of the reduction at the peak, with the run's own error in the same units and "
        r"the power of $\epsilon$ fitted to the three smallest."
    )
    return latex.table("peaks", caption, "lrL{34mm}llrl", head, rows)


def _peak(point: PeakError) -> list[str]:
    """Return the table cells of a run: value, error, engine, time; or why the run failed."""
    time = latex.scientific(point.seconds) if np.isfinite(point.seconds) else "--"
    if point.fault:
        return [f"did not run: {latex.escape(point.fault)}", "--", point.engine or "--", time]
    value = latex.scientific(point.value, 4) + ("" if point.resolved else " (not resolved)")
    return [value, rf"$\le$ {latex.scientific(point.own)}", point.engine, time]


def peak_panels(points: Iterable[PeakError]) -> CostPanels:
    """Return the resolved errors against eps, one curve per order, and a line of slope eps**2."""
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
    """Return snapshots of the split wave's run in rows of ``SNAPSHOTS_PER_ROW``."""
    rows, across = [], SNAPSHOTS_PER_ROW
    for run in runs.values():
        frames = snapshots(run, SPLIT_HALF_WIDTH)
        rows += [frames[i : i + across] for i in range(0, len(frames) - across + 1, across)]
    return rows


def split_table(runs: Mapping[str, xr.Dataset]) -> str:
    """Return the table of the split wave's extreme strains and its error at each snapshot."""
    rows = [row for name, run in runs.items() for row in _split_rows(run, load_scene(name).eps)]
    head = [
        *("$t$", "lowest: lattice", "wave", "highest: lattice", "wave", "own error"),
        *(r"$L^\infty_\epsilon$", "own error"),
    ]
    caption = r"The split wave: lowest and highest strain in units of $\epsilon$, and the error."
    return latex.table("split", caption, "rrrrrlll", head, rows)


def _split_rows(run: xr.Dataset, eps: float) -> list[list[str]]:
    rows = []
    for time in run["time"].values:
        snapshot = run.sel(time=time)
        ends = [
            f"${float(end(snapshot[part])) / eps:.3f}$"
            for end in (np.min, np.max)
            for part in ("strain", "analytic")
        ]
        height = float(np.max(np.abs(snapshot["analytic"] - snapshot["background"]))) / eps
        own = float(run.attrs["error_estimate"])
        strain, error = (
            latex.scientific(own),
            latex.uncertain(float(snapshot["error"]), own / height),
        )
        rows.append([f"${time:g}$", *ends, strain, *error])
    return rows


def long_table(runs: Mapping[str, LongRun]) -> str:
    """Return the table of long runs: errors, numerical error, difference between engines, times."""
    times = _times(runs)
    rows = [_long_row(name, long_run) for name, long_run in runs.items()]
    head = [r"$L^\infty_\epsilon$ at $t=$", *(f"${time:g}$" for time in times)]
    head += ["own error", "difference", "its step", "ring (s)", "stencil (s)"]
    caption = (
        r"Long runs: $L^\infty_\epsilon$ at each time; the ring's own error of $y/\epsilon$, its "
        "difference to the stencil, and what the stencil's step changes; the time of each."
    )
    return latex.table("long", caption, "l" + "r" * (len(times) + 5), head, rows)


def _times(runs: Mapping[str, LongRun]) -> list[float]:
    """Return the snapshot times of the first run, which are those of all runs."""
    return [float(t) for long_run in list(runs.values())[:1] for t in long_run.ring["time"].values]


def _long_row(name: str, long_run: LongRun) -> list[str]:
    attributes = long_run.ring.attrs
    difference = latex.scientific(float(long_run.differences.max(skipna=False)))
    return [
        latex.escape(name.split("_k_")[0].replace("_", " ")),
        *(f"{error:.4f}" for error in long_run.ring["error"].values),
        latex.scientific(float(attributes["error_estimate"])),
        difference if long_run.within_tolerance else f"{difference} (TOO LARGE)",
        latex.scientific(long_run.own, 1),
        latex.scientific(float(attributes["seconds"] + attributes["planning_seconds"])),
        latex.scientific(float(long_run.fine.attrs["seconds"])),
    ]
