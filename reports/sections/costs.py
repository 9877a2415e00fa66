"""What accuracy costs on the lattice, and the hard cases."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from operator import attrgetter
from textwrap import shorten

import numpy as np
import xarray as xr

from reports.environment import escape
from reports.figures.costs import CostPanel
from reports.sections.evaluation import duration
from reports.tables import scientific, table
from verify.lattice import relative_sup_error
from verify.study.cost_precision import CostPoint
from verify.study.cost_scaling import Law, ScalingPoint, fit_law
from verify.study.hard_case import HardCase

WANTED = (1e-2, 1e-4, 1e-6)
"""Errors for which the cheapest run of each series is tabulated."""

DETAIL = 150
"""Most characters shown of a hard case's detail."""

FITTED = 3
"""Points at the small-eps end through which a law is fitted."""


def precision_table(points: Sequence[CostPoint]) -> str:
    """The seconds of each series' cheapest run within each of the wanted errors."""
    rows = []
    for (problem, series), group in groupby(points, attrgetter("problem", "series")):
        found = list(group)
        cells = [_cheapest(found, error) for error in WANTED]
        rows.append([escape(problem), rf"\texttt{{{escape(series)}}}", *cells])
    head = ["problem", "method", *(rf"error $\le$ {scientific(e, 1)}" for e in WANTED)]
    return table("llrrr", head, rows)


def _cheapest(points: Iterable[CostPoint], error: float) -> str:
    seconds = [point.seconds for point in points if point.error <= error]
    return duration(min(seconds)) if seconds else "--"


def precision_panels(points: Iterable[CostPoint]) -> list[CostPanel]:
    """One panel a problem: error against seconds for each series."""
    panels: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for point in points:
        curves = panels.setdefault(point.problem, {})
        curves.setdefault(point.series.replace("_", " "), []).append((point.seconds, point.error))
    return [CostPanel(problem, curves) for problem, curves in panels.items()]


def laws(points: Iterable[ScalingPoint]) -> list[Law]:
    """The law of each series, fitted where eps is smallest."""
    series: dict[str, list[ScalingPoint]] = {}
    for point in points:
        series.setdefault(point.series, []).append(point)
    return [
        fit_law(sorted(found, key=lambda point: max(point.x, 1 / point.x))[-FITTED:])
        for found in series.values()
    ]


def scaling_table(points: Sequence[ScalingPoint]) -> str:
    """Each series against eps, with its fitted exponent."""
    found = {law.series: law for law in laws(points)}
    epsilons = sorted({_eps(point) for point in points}, reverse=True)
    rows = []
    for series, law in found.items():
        mine = {_eps(point): point for point in points if point.series == series}
        cells = [_scaled(mine[eps]) for eps in epsilons]
        variable = r"\epsilon" if "error" in series else r"1/\epsilon"
        rows.append([escape(series), *cells, f"$({variable})^{{{law.exponent:.2f}}}$"])
    head = ["", *(rf"$\epsilon={eps:g}$" for eps in epsilons), "law"]
    return table("l" + "r" * len(epsilons) + "l", head, rows)


def _eps(point: ScalingPoint) -> float:
    return round(min(point.x, 1 / point.x), 9)


def _scaled(point: ScalingPoint) -> str:
    if "error" in point.series:
        return f"{point.value:.4f}"
    return f"{'(' if point.scaled else ''}{duration(point.value)}{')' if point.scaled else ''}"


def scaling_panels(points: Iterable[ScalingPoint]) -> list[CostPanel]:
    """Seconds against 1/eps for each way."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for point in points:
        if "error" not in point.series:
            curves.setdefault(point.series, []).append((point.x, point.value))
    return [CostPanel("", curves)]


def rk4_table(points: Iterable[ScalingPoint]) -> str:
    """The error figure by RK4's step, and how much of it is the step's."""
    found = {point.x: point.value for point in points}
    exact = found[0.0]
    rows = [
        [
            f"${step:g}$" if step else "exact flow",
            f"{value:.5f}",
            rf"{100 * (value - exact) / value:.1f}\,\%",
        ]
        for step, value in found.items()
    ]
    head = [r"$\Delta t$", r"$L^\infty_\epsilon$ at $t=0$", "of it the step's"]
    return table("lrr", head, rows)


def window_table(points: Sequence[ScalingPoint]) -> str:
    """The window's error by its number of sites, with the fitted exponent."""
    rows = [[f"{point.x:.0f}", scientific(point.value)] for point in points]
    rows.append(["law", rf"$N^{{{fit_law(points).exponent:.1f}}}$"])
    return table("rl", ["sites $N$", r"error of $y/\epsilon$"], rows)


def hard_case_table(cases: Iterable[HardCase]) -> str:
    """What each hard case measured against its bound."""
    rows = [
        [
            escape(case.what),
            scientific(case.measured),
            scientific(case.bound),
            "holds" if case.passed else "FAILS",
            escape(shorten(case.detail, DETAIL, placeholder=" ...")),
        ]
        for case in cases
    ]
    head = ["case and measure", "measured", "bound", "", "detail"]
    return table("L{50mm}llL{10mm}L{45mm}", head, rows, gap="0.5ex")


def long_table(runs: Mapping[str, xr.Dataset]) -> str:
    """The long runs: relative sup error at each snapshot, estimate and seconds."""
    rows = []
    for name, run in runs.items():
        seconds = duration(float(run.attrs["seconds"] + run.attrs["planning_seconds"]))
        estimate = scientific(float(run.attrs["error_estimate"]))
        rows.append([rf"\texttt{{{escape(name)}}}", "", "", estimate, seconds])
        for time in run["time"].values:
            parts = run.sel(time=time)
            arrays = (np.asarray(parts[key]) for key in ("strain", "analytic", "background"))
            rows.append(["", f"${time:g}$", f"{relative_sup_error(*arrays):.4f}", "", ""])
    head = ["scene", "$t$", r"$L^\infty_\epsilon$", "estimate", "time"]
    return table("lrrrr", head, rows)
