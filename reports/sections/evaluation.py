"""Evaluation: worst errors over the stated domains, and digits against seconds."""

import math
from collections.abc import Iterable, Sequence
from itertools import groupby
from operator import attrgetter

from reports.environment import escape
from reports.tables import scientific, table
from verify.study.cost_evaluation import ARITHMETICS, EvaluationCost
from verify.study.evaluation import Accuracy

TABULATED = (
    "double",
    "double-double",
    "balls, 40 digits",
    "mpmath, 15 digits",
    "mpmath, 60 digits",
)
"""The arithmetics of the table; the figure has them all."""

UNITS = ((1.0, "s"), (1e-3, "ms"), (1e-6, r"\textmu s"), (1e-9, "ns"))


def accuracy_table(results: Iterable[Accuracy]) -> str:
    """The worst errors of Y, Y_X, Y_T of each wave, and where the worst of all is."""
    rows = [
        [
            rf"\texttt{{{escape(result.name)}}}",
            ", ".join(result.precisions),
            str(result.points),
            *(scientific(error) for error in result.errors),
            escape(result.worst),
        ]
        for result in results
    ]
    head = ["wave", "arithmetic", "points", "$Y$", "$Y_X$", "$Y_T$", "worst at"]
    return table("lL{22mm}rlllL{42mm}", head, rows)


def cost_table(costs: Iterable[EvaluationCost]) -> str:
    """Digits and time of a point in each of the tabulated arithmetics, one row a wave."""
    rows = []
    for wave, group in groupby(costs, attrgetter("wave")):
        found = {cost.arithmetic: cost for cost in group}
        chosen = [found[name] for name in TABULATED]
        cells = [cell for cost in chosen for cell in (digits(cost.digits), duration(cost.seconds))]
        ratio = found["mpmath, 15 digits"].seconds / found["double"].seconds
        rows.append([rf"\texttt{{{escape(wave)}}}", *cells, f"{float(f'{ratio:.2g}'):.0f}"])
    head = ["wave", *(rf"\multicolumn{{2}}{{l}}{{{escape(name)}}}" for name in TABULATED), "ratio"]
    return rf"\footnotesize\setlength{{\tabcolsep}}{{3pt}}{table('l' + 'rr' * 5 + 'r', head, rows)}"


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


def families() -> Sequence[str]:
    """The families of arithmetics, each once, in the order of the study."""
    return list(dict.fromkeys(arithmetic.family for arithmetic in ARITHMETICS))
