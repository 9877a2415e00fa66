"""What the report prints of evaluation, costs on the lattice, hard cases and estimates."""

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
from longwave.reports.studies.lattice_cost import (
    REDUCTION,
    SPECTRAL,
    STEPS,
    TRUE_ERROR,
    CostPoint,
    ScalingPoint,
    fit_power,
    scaling_laws,
)
from longwave.solutions import closed_form

if TYPE_CHECKING:
    from longwave.reports.studies.estimates import EstimateRow, Judged
    from longwave.reports.studies.evaluation_accuracy import Accuracy
    from longwave.reports.studies.evaluation_cost import EvaluationCost
    from longwave.reports.studies.hard_cases import HardCase

TABULATED = ("double-double", "balls, 40 digits", "mpmath, 15 digits", "mpmath, 60 digits")
"""The arithmetics of the table; the figure has them all."""

ERROR_UNIT = 1e-16
"""The table of accuracy gives errors in this unit."""


def accuracy_table(results: Iterable[Accuracy]) -> str:
    """The worst errors of Y, Y_X, Y_T of each wave, and where the worst of all is."""
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
    """Return the parameters, the site and the time of a point as LaTeX."""
    found = dict(re.findall(r"(\w+) = ((?:1 - )?[^\s,]+)", text))
    site, time = (_value(found.pop(name)) if name in found else "" for name in ("n", "t"))
    parameters = ", ".join(f"${symbol_latex(name)}={_value(v)[1:-1]}$" for name, v in found.items())
    return parameters or DASH, site, time


def _value(text: str) -> str:
    r"""Return a value with three digits; one near 1 by its distance from it.

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
    """Digits and time of a point in each of the tabulated arithmetics, one row a wave."""
    rows = []
    for wave, group in groupby(costs, attrgetter("wave")):
        found = {cost.arithmetic: cost for cost in group}
        chosen = [found[name] for name in TABULATED]
        cells = [
            cell
            for cost in chosen
            for cell in (digits(cost.digits), scientific(1e6 * cost.seconds))
        ]
        ratio = found["mpmath, 15 digits"].seconds / found["double-double"].seconds
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
"""Heads of the columns of digits."""


def digits(value: float) -> str:
    """Return a number of digits with one decimal; an exact value has no end of them.

    >>> digits(15.62), digits(float("inf"))
    ('15.6', 'exact')
    """
    return "exact" if math.isinf(value) else f"{value:.1f}"


def panels(points: Iterable[tuple[str, str, tuple[float, float]]]) -> CostPanels:
    """Points as curves in panels: by the title of a panel, and the label of a curve in it.

    >>> panels([("smooth", "RK4", (1.0, 0.1)), ("smooth", "RK4", (2.0, 0.01))])
    {'smooth': {'RK4': [(1.0, 0.1), (2.0, 0.01)]}}
    """
    found: dict[str, dict[str, list[tuple[float, float]]]] = {}
    for title, label, point in points:
        found.setdefault(title, {}).setdefault(label, []).append(point)
    return found


def cost_panels(costs: Iterable[EvaluationCost]) -> CostPanels:
    """One panel a wave: digits against seconds for each family of arithmetics."""
    return panels(
        (c.wave.replace("_", " "), c.arithmetic.partition(",")[0], (c.seconds, c.digits))
        for c in costs
    )


WANTED = (1e-2, 1e-4, 1e-6)
"""Errors for which the cheapest run of each series is tabulated."""


def precision_table(points: Sequence[CostPoint]) -> str:
    """The seconds of each series' cheapest run within each of the wanted errors.

    The ring has a second row, in which making its data counts.
    """
    rows: list[Row] = []
    for problem, mine in groupby(points, attrgetter("problem")):
        rows.append(escape(problem))
        for series, group in groupby(mine, attrgetter("series")):
            found = list(group)
            rows.append(_precision_row(PRINTED[series], found))
            if series == SPECTRAL:
                whole = [replace(p, seconds=p.seconds + p.data_seconds) for p in found]
                rows.append(_precision_row(f"{PRINTED[series]}, with its data", whole))
    head = ["problem and method", *(rf"error $\le$ {_power(e)} (s)" for e in WANTED)]
    caption = r"Measured time in s of each method's cheapest run within an error of $y/\epsilon$."
    return table("precision", caption, "lrrr", head, rows)


def _precision_row(name: str, points: Sequence[CostPoint]) -> list[str]:
    return [escape(name), *(_cheapest(points, error) for error in WANTED)]


def _power(value: float) -> str:
    return f"$10^{{{round(math.log10(value))}}}$"


def _cheapest(points: Iterable[CostPoint], error: float) -> str:
    seconds = [point.seconds for point in points if point.error <= error]
    return scientific(min(seconds)) if seconds else "--"


def precision_panels(points: Iterable[CostPoint]) -> CostPanels:
    """One panel a problem: error against seconds for each series."""
    return panels((p.problem, PRINTED[p.series], (p.seconds, p.error)) for p in points)


def scaling_table(points: Sequence[ScalingPoint]) -> str:
    """What was measured of each series against eps, with its fitted exponent."""
    caption = (
        r"Measured to the peak of $Y_2$: time of the whole run in s, its error, and the exponent "
        "fitted."
    )
    return _scaling("scaling", caption, [point for point in points if not point.scaled])


def extrapolated_table(points: Sequence[ScalingPoint]) -> str:
    """The seconds of those series of which a part was run, with the exponent fitted to them."""
    caption = (
        rf"Extrapolated to the peak of $Y_2$: time in s, scaled from {STEPS} steps to the whole "
        "run, and the exponent fitted to these numbers."
    )
    return _scaling("extrapolated", caption, [point for point in points if point.scaled])


def _scaling(name: str, caption: str, points: Sequence[ScalingPoint]) -> str:
    found = scaling_laws(points)
    epsilons = sorted({_eps(point) for point in points}, reverse=True)
    rows = []
    for series in dict.fromkeys(point.series for point in points):
        mine = {_eps(point): point for point in points if point.series == series}
        unit = "" if series in (REDUCTION, TRUE_ERROR) else " (s)"
        rows.append([escape(series) + unit, *(scientific(mine[eps].value) for eps in epsilons)])
        variable = r"\epsilon" if series == REDUCTION else r"1/\epsilon"
        law = found.get(series)
        rows[-1].append(DASH if law is None else f"$({variable})^{{{law:.2f}}}$")
        if any(point.own for point in mine.values()):
            rows.append(["its own error", *(scientific(mine[eps].own) for eps in epsilons), DASH])
    head = ["", *(rf"$\epsilon={eps:g}$" for eps in epsilons), "law"]
    return table(name, caption, "l" + "r" * len(epsilons) + "l", head, rows)


def _eps(point: ScalingPoint) -> float:
    return round(min(point.x, 1 / point.x), 9)


def scaling_panels(points: Iterable[ScalingPoint]) -> CostPanels:
    """Seconds against 1/eps for each way; a way of which a part was timed says so."""
    ways = (p for p in points if p.series not in (REDUCTION, TRUE_ERROR))
    return panels(("", p.series + " (scaled)" * p.scaled, (p.x, p.value)) for p in ways)


def rk4_table(points: Iterable[ScalingPoint]) -> str:
    """The error figure by RK4's step, and how much of it is the step's."""
    found = {point.x: point.value for point in points}
    exact = found[0.0]
    rows = [
        [
            f"${step:g}$" if step else "exact flow",
            f"{value:.5f}",
            scientific(abs(value - exact)) if step else "--",
            f"{100 * (value - exact) / value:.1f}",
        ]
        for step, value in found.items()
    ]
    head = [r"$\Delta t$", r"$L^\infty_\epsilon$ at $t=0$", "error by the step", r"share (\%)"]
    caption = "The paper's error figure by the time step of RK4, and how much of it is the step's."
    return table("rk4", caption, "lrrr", head, rows)


def window_table(points: Sequence[ScalingPoint]) -> str:
    """The window's error by its number of sites, with the fitted exponent."""
    rows = [[f"{point.x:.0f}", scientific(point.value)] for point in points]
    rows.append(["law", rf"$N^{{{fit_power((p.x, p.value) for p in points):.1f}}}$"])
    head = ["sites $N$", r"error of $y/\epsilon$"]
    return table("window", "Error by the size of the co-moving window.", "rl", head, rows)


def hard_case_table(cases: Iterable[HardCase]) -> str:
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
    head = ["case", "quantity", "measured", "bound", "verdict"]
    return table("hard", "Hard cases.", "L{50mm}L{46mm}lll", head, rows, gap="0.5ex")


def message_table(cases: Iterable[HardCase]) -> str:
    """What the program says where a case must be refused or stopped."""
    rows = [[mathematics(case.what), escape(case.message)] for case in cases if case.message]
    caption = "Messages of the program where it must refuse or stop."
    return table("messages", caption, "L{56mm}L{88mm}", ["case", "message"], rows, gap="0.5ex")


def estimate_table(rows: Sequence[EstimateRow]) -> str:
    """Counts of verdicts and quantiles of true/estimate by wave and engine; "" without rows."""
    if not rows:
        return ""
    names = {0.5: "median", 1.0: "largest"}
    shares = [names.get(share, f"{share:.0%}") for share in rows[0].quantiles]
    head = ["", "scenes", *rows[0].verdicts, *map(escape, shares), "time (s)"]
    columns = "l" + "r" * (len(head) - 1)
    caption = "Random scenes by verdict, and quantiles of true error over estimate."
    return table("estimates", caption, columns, head, map(_row, rows))


def _row(found: EstimateRow) -> list[str]:
    quantiles = ["--" if q != q else scientific(q) for q in found.quantiles.values()]
    counts = [str(count) if count else "--" for count in found.verdicts.values()]
    return [escape(found.name), str(found.count), *counts, *quantiles, scientific(found.seconds)]


def reason_table(judged: Sequence[Judged]) -> str:
    """The reasons for which scenes were refused, without their numbers, and how often."""
    counts = Counter(found.kind for found in judged if found.reason)
    cells = [[str(count), escape(kind)] for kind, count in counts.most_common()]
    return table("reasons", "Reasons of refusals.", "rL{120mm}", ["scenes", "reason"], cells)
