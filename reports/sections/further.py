"""What the full report has beyond the paper's scenes: all eps, the split wave, long times."""

from collections.abc import Iterable, Mapping

import numpy as np
import xarray as xr

from reports.environment import escape
from reports.figures.costs import CostPanel
from reports.figures.paper import snapshots
from reports.figures.snapshots import Snapshot
from reports.sections.evaluation import duration
from reports.tables import measured, scientific, table
from verify.comparison import load_scene, relative_sup_error
from verify.studies.long_runs import LongRun
from verify.studies.reduction import PeakError, peak_laws

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
            power = "--" if law is None else rf"$\epsilon^{{{law.exponent:.2f}}}$"
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


def peak_panels(points: Iterable[PeakError]) -> list[CostPanel]:
    """The resolved errors against eps, a curve an order, and eps squared through the last."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for point in points:
        if point.resolved:
            curves.setdefault(f"$Y_{point.order}$", []).append((point.eps, point.value))
    if curves:
        eps, value = min(next(iter(curves.values())))
        ends = (eps, max(x for curve in curves.values() for x, _ in curve))
        curves[r"$\propto\epsilon^2$"] = [(x, 0.7 * value * (x / eps) ** 2) for x in ends]
    return [CostPanel("", curves)]


def split_rows(runs: Mapping[str, xr.Dataset]) -> list[list[Snapshot]]:
    """The snapshots of the split wave's run, in rows of ``ACROSS``."""
    rows = []
    for name, run in runs.items():
        seen = list(snapshots(run, load_scene(name), SPLIT_HALF_WIDTH))
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
    errors = []
    for time in found.ring["time"].values:
        at = found.ring.sel(time=time)
        parts = (np.asarray(at[key]) for key in ("strain", "analytic", "background"))
        errors.append(f"{relative_sup_error(*parts):.4f}")
    attributes = found.ring.attrs
    judged = scientific(float(found.differences.max(skipna=False)))
    return [
        escape(name.split("_k_")[0].replace("_", " ")),
        *errors,
        scientific(float(attributes["error_estimate"])),
        judged if found.kept else f"{judged} (TOO LARGE)",
        scientific(found.own, 1),
        duration(float(attributes["seconds"] + attributes["planning_seconds"])),
        duration(float(found.fine.attrs["seconds"])),
    ]
