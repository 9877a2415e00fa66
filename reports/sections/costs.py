"""What accuracy costs on the lattice, and the hard cases."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import groupby
from operator import attrgetter

from reports.environment import escape
from reports.figures.costs import CostPanel
from reports.sections.claims import mathematics
from reports.sections.evaluation import duration
from reports.tables import scientific, table
from verify.studies.cost_precision import SPECTRAL, CostPoint
from verify.studies.cost_scaling import REDUCTION, TRUE_ERROR, PowerLaw, ScalingPoint, fit_law
from verify.studies.hard_case import HardCaseResult

WANTED = (1e-2, 1e-4, 1e-6)
"""Errors for which the cheapest run of each series is tabulated."""

PRINTED = {
    "rk4": "RK4",
    "stoermer_verlet": "Störmer-Verlet (2)",
    "mclachlan_4": "McLachlan (4)",
    "blanes_moan_6": "Blanes-Moan (6)",
    "reduced_phase_6": "reduced phase lag (6)",
    "suzuki_umeno_8": "Suzuki-Umeno (8)",
    "kahan_li_8": "Kahan-Li (8)",
    SPECTRAL: "spectral ring",
}
"""Names of the methods as they are printed, with the orders of the splittings."""

LONG = 1e4
"""Seconds from which on they are shown as a power of ten."""

FITTED = 3
"""Points at the small-eps end through which a law is fitted."""


def precision_table(points: Sequence[CostPoint]) -> str:
    """The seconds of each series' cheapest run within each of the wanted errors.

    The ring has a second row, in which making its data counts.
    """
    rows = []
    for (problem, series), group in groupby(points, attrgetter("problem", "series")):
        found = list(group)
        rows.append(_precision_row(problem, PRINTED[series], found))
        if series == SPECTRAL:
            whole = [replace(p, seconds=p.seconds + p.data_seconds) for p in found]
            rows.append(_precision_row(problem, f"{PRINTED[series]}, with its data", whole))
    head = ["problem", "method", *(rf"error $\le$ {_power(e)}" for e in WANTED)]
    return table("llrrr", head, rows)


def _precision_row(problem: str, name: str, points: Iterable[CostPoint]) -> list[str]:
    found = list(points)
    return [escape(problem), escape(name), *(_cheapest(found, error) for error in WANTED)]


def _power(value: float) -> str:
    return f"$10^{{{round(math.log10(value))}}}$"


def _cheapest(points: Iterable[CostPoint], error: float) -> str:
    seconds = [point.seconds for point in points if point.error <= error]
    return duration(min(seconds)) if seconds else "--"


def precision_panels(points: Iterable[CostPoint]) -> list[CostPanel]:
    """One panel a problem: error against seconds for each series."""
    panels: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for point in points:
        curves = panels.setdefault(point.problem, {})
        curves.setdefault(PRINTED[point.series], []).append((point.seconds, point.error))
    return [CostPanel(problem, curves) for problem, curves in panels.items()]


def laws(points: Iterable[ScalingPoint]) -> list[PowerLaw]:
    """The law of each series, fitted where eps is smallest; what a tolerance sets has none."""
    series: dict[str, list[ScalingPoint]] = {}
    for point in points:
        if point.series != TRUE_ERROR:
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
    for series in dict.fromkeys(point.series for point in points):
        mine = {_eps(point): point for point in points if point.series == series}
        rows.append([escape(series), *(_scaled(mine[eps]) for eps in epsilons)])
        variable = r"\epsilon" if series == REDUCTION else r"1/\epsilon"
        law = found.get(series)
        rows[-1].append("--" if law is None else f"$({variable})^{{{law.exponent:.2f}}}$")
    head = ["", *(rf"$\epsilon={eps:g}$" for eps in epsilons), "law"]
    return table("l" + "r" * len(epsilons) + "l", head, rows)


def _eps(point: ScalingPoint) -> float:
    return round(min(point.x, 1 / point.x), 9)


def _scaled(point: ScalingPoint) -> str:
    if point.series in (REDUCTION, TRUE_ERROR):
        return scientific(point.value)
    seconds = duration(point.value) if point.value < LONG else f"{scientific(point.value)} s"
    return f"({seconds})" if point.scaled else seconds


def scaling_panels(points: Iterable[ScalingPoint]) -> list[CostPanel]:
    """Seconds against 1/eps for each way; a way of which a part was timed says so."""
    curves: dict[str, list[tuple[float, float]]] = {}
    for point in points:
        if point.series not in (REDUCTION, TRUE_ERROR):
            label = f"{point.series}{' (scaled)' if point.scaled else ''}"
            curves.setdefault(label, []).append((point.x, point.value))
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


def hard_case_table(cases: Iterable[HardCaseResult]) -> str:
    """What each hard case measured against its bound."""
    rows = [
        [
            mathematics(case.what),
            mathematics(case.criterion),
            scientific(case.measured),
            scientific(case.bound),
            "holds" if case.passed else r"\textbf{FAILS}",
        ]
        for case in cases
    ]
    head = ["case", "the number", "measured", "bound", "verdict"]
    return table("L{50mm}L{46mm}lll", head, rows, gap="0.5ex")


def message_table(cases: Iterable[HardCaseResult]) -> str:
    """What the program says where a case must be refused or stopped."""
    rows = [[mathematics(case.what), escape(case.message)] for case in cases if case.message]
    return table("L{56mm}L{88mm}", ["case", "the program says"], rows, gap="0.5ex")
