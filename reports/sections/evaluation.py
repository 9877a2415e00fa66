"""Evaluation: worst errors over the stated domains, and digits against seconds."""

import math
import re
from collections.abc import Iterable
from itertools import groupby
from operator import attrgetter

from reports.environment import escape
from reports.figures.costs import CostPanel
from reports.tables import block
from verify.studies.cost_evaluation import ARITHMETICS, EvaluationCost
from verify.studies.evaluation import Accuracy

TABULATED = (
    "double-double",
    "balls, 40 digits",
    "mpmath, 15 digits",
    "mpmath, 60 digits",
)
"""The arithmetics of the table; the figure has them all."""

ERROR_UNIT = 1e-16
"""The table of accuracy gives errors in this unit."""

GREEK = ("alpha", "kappa", "tau")
LATTICE = {"K2": "K_2", "K4": "K_4", "eps": r"\epsilon"}
DASH = "--"

UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, r"\textmu s"), (1e-9, "ns"))


def accuracy_table(results: Iterable[Accuracy]) -> str:
    """The worst errors of Y, Y_X, Y_T of each wave, and where the worst of all is."""
    rows = [
        [
            rf"\texttt{{{escape(result.name)}}}",
            str(result.points),
            *(f"{float(f'{error / ERROR_UNIT:.2g}'):g}" for error in result.errors),
            *_where(result.worst),
        ]
        for result in results
    ]
    head = ["wave", "points", "$Y$", "$Y_X$", "$Y_T$", "at parameters", "$n$", "$t$"]
    return block("lrrrrp{52mm}rr", head, rows)


def _where(text: str) -> tuple[str, str, str]:
    """Return the parameters, the site and the time of a point as LaTeX."""
    found = dict(re.findall(r"(\w+) = ((?:1 - )?[^\s,]+)", text))
    site, time = (_value(found.pop(name)) if name in found else "" for name in ("n", "t"))
    parameters = ", ".join(f"${_symbol(name)}={_value(v)[1:-1]}$" for name, v in found.items())
    return parameters or DASH, site, time


def _symbol(name: str) -> str:
    letter, _, index = name.partition("_")
    if name in LATTICE:
        return LATTICE[name]
    greek = rf"\{letter}" if letter in GREEK else letter
    return f"{greek}_{{{index}}}" if index else greek


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
        cells = [cell for cost in chosen for cell in (digits(cost.digits), duration(cost.seconds))]
        ratio = found["mpmath, 15 digits"].seconds / found["double-double"].seconds
        rows.append([rf"\texttt{{{escape(wave)}}}", *cells, f"{float(f'{ratio:.2g}'):.0f}"])
    head = ["wave", *map(_two_columns, TABULATED), "ratio"]
    return block("l" + "rr" * len(TABULATED) + "r", head, rows)


def _two_columns(name: str) -> str:
    """Return a heading over two columns, in two lines where it has a comma."""
    lines = r"\\".join(part.strip() for part in escape(name).split(","))
    return rf"\multicolumn{{2}}{{r}}{{\begin{{tabular}}[b]{{@{{}}r@{{}}}}{lines}\end{{tabular}}}}"


def digits(value: float) -> str:
    """Return a number of digits with one decimal; an exact value has no end of them.

    >>> digits(15.62), digits(float("inf"))
    ('15.6', 'exact')
    """
    return "exact" if math.isinf(value) else f"{value:.1f}"


def duration(seconds: float) -> str:
    r"""Return a time with two significant digits in a unit that fits.

    >>> duration(4.4e-08), duration(0.0123), duration(120.0)
    ('44 ns', '12 ms', '120 s')
    """
    scale, unit = next((pair for pair in UNITS if seconds >= pair[0]), UNITS[-1])
    value = seconds / scale
    return f"{value:.1f} {unit}" if value < 10 else f"{float(f'{value:.2g}'):.0f} {unit}"


def cost_panels(costs: Iterable[EvaluationCost]) -> list[CostPanel]:
    """One panel a wave: digits against seconds for each family of arithmetics."""
    family = {arithmetic.name: arithmetic.family for arithmetic in ARITHMETICS}
    panels = []
    for wave, group in groupby(costs, attrgetter("wave")):
        curves: dict[str, list[tuple[float, float]]] = {}
        for cost in group:
            curves.setdefault(family[cost.arithmetic], []).append((cost.seconds, cost.digits))
        panels.append(CostPanel(wave.replace("_", " "), curves))
    return panels
