"""Tables and figures of evaluation accuracy, costs, hard cases and error estimates."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import groupby
from operator import attrgetter
from typing import TYPE_CHECKING

from longwave.reports.latex import (
    DASH,
    PRINTED,
    Row,
    escape,
    mathematics,
    scientific,
    symbol_latex,
    table,
)
from longwave.reports.pictures.drawing import CostPanels
from longwave.reports.studies import lattice_cost
from longwave.solutions import closed_form

if TYPE_CHECKING:
    from longwave.reports.studies.estimates import EstimateRow, Judged
    from longwave.reports.studies.evaluation_accuracy import Accuracy
    from longwave.reports.studies.evaluation_cost import EvaluationCost
    from longwave.reports.studies.hard_cases import HardCase

TABULATED = ("double-double", "balls, 40 digits", "mpmath, 15 digits", "mpmath, 60 digits")
"""Arithmetics that have columns in the cost table; the figure shows all arithmetics."""

ERROR_UNIT = 1e-16
"""Unit of the errors in the accuracy table."""


def accuracy_table(results: Iterable[Accuracy]) -> str:
    """Return the table of each wave's worst errors of Y, Y_X, Y_T, and the point of the largest."""
    rows = [
        [
            escape(closed_form(result.name).title),
            str(result.points),
            *(f"{float(f'{error / ERROR_UNIT:.2g}'):g}" for error in result.errors),
            *_where(result.worst),
        ]
        for result in results
    ]
    head = ["wave", "points", "$Y$", "$Y_X$", "$Y_T$", "at parameters", "$n$", "$t$"]
    caption = (
        r"Worst errors of the evaluation of each wave, in units of "
        r"$10^{-16}\max(1,|\mbox{value}|)$, and the point of the largest of the three."
    )
    return table("accuracy", caption, "L{34mm}rrrrL{42mm}rr", head, rows)


def _where(text: str) -> tuple[str, str, str]:
    """Split a description such as "k = 0.5, n = 3, t = 1" into LaTeX: parameters, site and time."""
    fields = dict(re.findall(r"(\w+) = ((?:1 - )?[^\s,]+)", text))
    site, time = (_value(fields.pop(name)) if name in fields else "" for name in ("n", "t"))
    parameters = ", ".join(
        f"${symbol_latex(name)}={_value(v)[1:-1]}$" for name, v in fields.items()
    )
    return parameters or DASH, site, time


def _value(text: str) -> str:
    r"""Format a number with three digits; a number written as "1 - d" keeps that form.

    >>> _value("160149996.8"), _value("1 - 1e-12"), _value("-9.2")
    ('$1.6\\times 10^{8}$', '$1-10^{-12}$', '$-9.2$')
    """
    if text.startswith("1 - "):
        return f"$1-{_value(text[4:])[1:-1]}$"
    mantissa, _, exponent = f"{float(text):.3g}".partition("e")
    if not exponent:
        return f"${mantissa}$"
    power = f"10^{{{int(exponent)}}}"
    return f"${power}$" if mantissa == "1" else rf"${float(mantissa):g}\times {power}$"


def cost_table(costs: Iterable[EvaluationCost]) -> str:
    """Return the table of digits and microseconds per point, by wave (rows) and arithmetic."""
    rows = []
    for wave, group in groupby(costs, attrgetter("wave")):
        by_arithmetic = {cost.arithmetic: cost for cost in group}
        cells = []
        for cost in (by_arithmetic[name] for name in TABULATED):
            cells += [digits(cost.digits), scientific(1e6 * cost.seconds)]
        ratio = by_arithmetic["mpmath, 15 digits"].seconds / by_arithmetic["double-double"].seconds
        title = escape(closed_form(wave).title)
        rows.append([title, *cells, f"{float(f'{ratio:.2g}'):.0f}"])
    head = ["wave", *(cell for name in SHORT_NAMES for cell in (name, r"\textmu s")), "ratio"]
    caption = (
        r"Correct digits and time in \textmu s of one point with both derivatives: in "
        "double-double (dd), in balls of 40 digits, in mpmath at 15 and 60 digits; ratio of "
        "mpmath at 15 digits to double-double."
    )
    return table("evaluation_costs", caption, "L{34mm}" + "rr" * len(TABULATED) + "r", head, rows)


SHORT_NAMES = ("dd", "balls", "mp 15", "mp 60")
"""Column heads for the arithmetics in `TABULATED`, in the same order."""


def digits(value: float) -> str:
    """Format a number of correct digits with one decimal; infinity is printed as "exact".

    >>> digits(15.62), digits(float("inf"))
    ('15.6', 'exact')
    """
    return "exact" if math.isinf(value) else f"{value:.1f}"


def panels(points: Iterable[tuple[str, str, tuple[float, float]]]) -> CostPanels:
    """Group (panel title, curve label, point) triples into panels of curves.

    >>> panels([("smooth", "RK4", (1.0, 0.1)), ("smooth", "RK4", (2.0, 0.01))])
    {'smooth': {'RK4': [(1.0, 0.1), (2.0, 0.01)]}}
    """
    grouped: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for title, label, point in points:
        grouped.setdefault(title, {}).setdefault(label, []).append(point)
    return grouped


def cost_panels(costs: Iterable[EvaluationCost]) -> CostPanels:
    """Return a panel per wave: correct digits against seconds for each family of arithmetics."""
    points = ((c.wave, c.arithmetic.partition(",")[0], (c.seconds, c.digits)) for c in costs)
    return panels((wave.replace("_", " "), family, point) for wave, family, point in points)


ERROR_LEVELS = (1e-2, 1e-4, 1e-6)
"""Bounds on errors of y/eps; the precision table has each series' fastest run within each."""


def precision_table(points: Sequence[lattice_cost.CostPoint]) -> str:
    """Return the table of seconds of each series' fastest run within each of `ERROR_LEVELS`.

    The spectral ring has a second row that includes the time to compute its initial data.
    """
    rows: list[Row] = []
    for problem, of_problem in groupby(points, attrgetter("problem")):
        rows.append(escape(problem))
        for series, group in groupby(of_problem, attrgetter("series")):
            runs = list(group)
            rows.append(_precision_row(PRINTED[series], runs))
            if series == lattice_cost.SPECTRAL:
                whole = [replace(p, seconds=p.seconds + p.data_seconds) for p in runs]
                rows.append(_precision_row(f"{PRINTED[series]}, with its data", whole))
    head = ["problem and method", *(rf"error $\le$ {_power(e)} (s)" for e in ERROR_LEVELS)]
    caption = r"Measured time in s of each method's cheapest run within an error of $y/\epsilon$."
    return table("precision", caption, "lrrr", head, rows)


def _precision_row(name: str, points: Sequence[lattice_cost.CostPoint]) -> list[str]:
    """Return a row with the seconds of the fastest run within each error level."""
    fast = [[p.seconds for p in points if p.error <= error] for error in ERROR_LEVELS]
    return [escape(name), *(scientific(min(seconds)) if seconds else DASH for seconds in fast)]


def _power(value: float) -> str:
    return f"$10^{{{round(math.log10(value))}}}$"


def precision_panels(points: Iterable[lattice_cost.CostPoint]) -> CostPanels:
    """Return one panel for each problem: error against seconds, with a curve for each series."""
    return panels((p.problem, PRINTED[p.series], (p.seconds, p.error)) for p in points)


def scaling_table(points: Sequence[lattice_cost.ScalingPoint]) -> str:
    """Return the table of fully timed series against eps, with fitted exponents."""
    caption = (
        r"Measured to the peak of $Y_2$: time of the whole run in s, its error, and the exponent "
        "fitted."
    )
    return _scaling("scaling", caption, [point for point in points if not point.scaled])


def extrapolated_table(points: Sequence[lattice_cost.ScalingPoint]) -> str:
    """Return the table of series extrapolated from part of a run, with fitted exponents."""
    caption = (
        rf"Extrapolated to the peak of $Y_2$: time in s, scaled from {lattice_cost.STEPS} steps "
        "to the whole run, and the exponent fitted to these numbers."
    )
    return _scaling("extrapolated", caption, [point for point in points if point.scaled])


def _scaling(name: str, caption: str, points: Sequence[lattice_cost.ScalingPoint]) -> str:
    laws = lattice_cost.scaling_laws(points)
    epsilons = sorted({_eps(point) for point in points}, reverse=True)
    rows = []
    for series in dict.fromkeys(point.series for point in points):
        by_eps = {_eps(point): point for point in points if point.series == series}
        unit = "" if series in (lattice_cost.REDUCTION, lattice_cost.TRUE_ERROR) else " (s)"
        rows.append([escape(series) + unit, *(scientific(by_eps[eps].value) for eps in epsilons)])
        variable = r"\epsilon" if series == lattice_cost.REDUCTION else r"1/\epsilon"
        law = laws.get(series)
        rows[-1].append(DASH if law is None else f"$({variable})^{{{law:.2f}}}$")
        if any(point.own for point in by_eps.values()):
            rows.append(["its own error", *(scientific(by_eps[eps].own) for eps in epsilons), DASH])
    head = ["", *(rf"$\epsilon={eps:g}$" for eps in epsilons), "law"]
    return table(name, caption, "l" + "r" * len(epsilons) + "l", head, rows)


def _eps(point: lattice_cost.ScalingPoint) -> float:
    return round(min(point.x, 1 / point.x), 9)


def scaling_panels(points: Iterable[lattice_cost.ScalingPoint]) -> CostPanels:
    """Return seconds against 1/eps for each method; extrapolated ones are labelled "(scaled)"."""
    ways = (p for p in points if p.series not in (lattice_cost.REDUCTION, lattice_cost.TRUE_ERROR))
    return panels(("", p.series + " (scaled)" * p.scaled, (p.x, p.value)) for p in ways)


def rk4_table(points: Iterable[lattice_cost.ScalingPoint]) -> str:
    """Return the table of the rational wave Y_2's error at t = 0 and RK4's part in it, by step."""
    errors = {point.x: point.value for point in points}
    exact, rows = errors[0.0], []
    for step, value in errors.items():
        name = f"${step:g}$" if step else "exact flow"
        part = scientific(abs(value - exact)) if step else DASH
        rows.append([name, f"{value:.5f}", part, f"{100 * (value - exact) / value:.1f}"])
    head = [r"$\Delta t$", r"$L^\infty_\epsilon$ at $t=0$", "error by the step", r"share (\%)"]
    caption = "The paper's error figure by the time step of RK4, and the share due to the step."
    return table("rk4", caption, "lrrr", head, rows)


def window_table(points: Sequence[lattice_cost.ScalingPoint]) -> str:
    """Return the table of errors due to the window by its number of sites, and their power law."""
    rows = [[f"{point.x:.0f}", scientific(point.value)] for point in points]
    rows.append(["law", rf"$N^{{{lattice_cost.fit_power((p.x, p.value) for p in points):.1f}}}$"])
    head = ["sites $N$", r"error of $y/\epsilon$"]
    return table("window", "Error by the size of the co-moving window.", "rl", head, rows)


def hard_case_table(cases: Iterable[HardCase]) -> str:
    """Return the table of hard cases: measured value, bound and verdict."""
    rows = []
    for case in cases:
        verdict = "holds" if case.passed else r"\textbf{FAILS}"
        texts = map(mathematics, (case.setup, case.criterion))
        rows.append([*texts, *map(scientific, (case.measured, case.bound)), verdict])
    head = ["case", "quantity", "measured", "bound", "verdict"]
    return table("hard", "Hard cases.", "L{50mm}L{46mm}lll", head, rows, gap="0.5ex")


def message_table(cases: Iterable[HardCase]) -> str:
    """Return the table of messages printed when a request is refused or a run is stopped."""
    rows = [[mathematics(case.setup), escape(case.message)] for case in cases if case.message]
    caption = "Messages of the program where it must refuse or stop."
    return table("messages", caption, "L{56mm}L{88mm}", ["case", "message"], rows, gap="0.5ex")


def estimate_table(rows: Sequence[EstimateRow]) -> str:
    """Return the table of verdict counts and quantiles of true error over estimate; "" if empty."""
    if not rows:
        return ""
    names = {0.5: "median", 1.0: "largest"}
    shares = [names.get(share, f"{share:.0%}") for share in rows[0].quantiles]
    head = ["", "scenes", *rows[0].verdicts, *map(escape, shares), "time (s)"]
    columns = "l" + "r" * (len(head) - 1)
    caption = "Random scenes by verdict, and quantiles of true error over estimate."
    return table("estimates", caption, columns, head, map(_row, rows))


def _row(row: EstimateRow) -> list[str]:
    quantiles = ["--" if q != q else scientific(q) for q in row.quantiles.values()]
    counts = [str(count) if count else "--" for count in row.verdicts.values()]
    return [escape(row.name), str(row.count), *counts, *quantiles, scientific(row.seconds)]


def reason_table(judged: Sequence[Judged]) -> str:
    """Return the table of the reasons for refusal (numbers in them removed) and their counts."""
    counts = Counter(scene.kind for scene in judged if scene.reason)
    cells = [[str(count), escape(kind)] for kind, count in counts.most_common()]
    return table("reasons", "Reasons of refusals.", "rL{120mm}", ["scenes", "reason"], cells)
