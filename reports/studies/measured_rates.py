"""The rates at which lattices come near their long-wave limits, measured for a report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sympy import Expr, Rational, S

from longwave.derive import LATTICES
from longwave.derive.symbols import eps, ybar
from longwave.solutions import closed_form
from longwave.support.processes import Job, Key

if TYPE_CHECKING:
    from longwave.scenes.convergence import ConvergenceStudy
    from longwave.scenes.rate_cases import RateCase, Value

SECONDS = {"leading": 0.5, "slaved": 0.7, "corrected": 15.0}
"""About the processor time of a case by the order of its data."""

LONG = {"5c": 9.0, "5d": 9.0, "6e": 9.0, "4b, second rogue wave": 15.0}
LONG |= {"6a, second rogue wave": 20.0, "6a, rogue wave on cn": 10.0}
"""The same of cases that the full report alone has: computed waves, and those at small eps."""

WIDE, FINE = (0.1, 0.07, 0.05, 0.035), (0.07, 0.05, 0.035)
COARSE, SHORT = (0.14, 0.1, 0.07), (0.1, 0.07, 0.05)

ENVELOPES: Mapping[tuple[str, str], tuple[float, ...]] = {
    ("bright, strain", "slaved"): WIDE,
    ("bright, strain", "corrected"): WIDE,
    ("bright, displacement", "corrected"): WIDE,
    ("dark, strain", "leading"): WIDE,
    ("dark, strain", "corrected"): WIDE,
    ("dark, Klein-Gordon", "slaved"): WIDE,
    ("bright, Klein-Gordon", "leading"): WIDE,
    ("bright, Klein-Gordon", "corrected"): SHORT,
    ("Peregrine, strain", "leading"): FINE,
    ("Peregrine, strain", "corrected"): FINE,
    ("Peregrine, optical dimer", "leading"): COARSE,
    ("Peregrine, optical dimer", "corrected"): SHORT,
    ("Peregrine, granular dimer", "slaved"): FINE,
}
"""Case and order of the data -> the values of eps."""

SHORT_ENVELOPES = (("bright, strain", "slaved"),)
"""Those that the short report has as well."""

ENVELOPE_SECONDS = {"leading": 2.0, "slaved": 9.0, "corrected": 20.0}


@dataclass(frozen=True)
class MeasuredRate:
    """A case's errors over eps with data of one order, and the rate to expect.

    ``lattice`` and ``wave`` are titles, ``kind`` is the equation's name.  ``constants`` are the
    lattice's, with the mean strain where there is one; eps may be in their values.
    """

    case: str
    lattice: str
    constants: tuple[tuple[str, Expr], ...]
    kind: str
    wave: str
    order: str
    expected: int
    study: ConvergenceStudy

    @property
    def reached(self) -> bool:
        """Whether the measured rate's interval holds the expected one."""
        return self.study.rate.holds(self.expected)


def measured_rate(name: str, order: str) -> MeasuredRate:
    """Measure one of `RATE_CASES` with data of an order.

    >>> found = measured_rate("2", "leading")
    >>> found.kind, found.expected, found.reached
    ('KdV', 4, True)
    """
    from longwave.scenes.rate_cases import RATE_CASES

    case = RATE_CASES[name]
    return MeasuredRate(
        name,
        LATTICES[case.lattice].title + (f", along {case.steps}" if case.steps else ""),
        tuple((key, _exact(value)) for key, value in _numbers(case)),
        case.reduction.pde.kind,
        closed_form(case.wave).title if case.wave else "soliton, computed",
        order,
        case.rate(order),
        case.study(order),
    )


def measured_envelope(name: str, order: str) -> MeasuredRate:
    """Measure one of `ENVELOPES`."""
    from longwave.scenes.envelope_study import ENVELOPE_CASES, envelope_study
    from longwave.scenes.theory_rate import envelope_rate

    case = ENVELOPE_CASES[name]
    lattice = case.runs or LATTICES[case.lattice]
    used = {str(symbol) for symbol in lattice.constants}
    return MeasuredRate(
        name,
        f"{lattice.title}, {case.branch} branch" if case.branch else lattice.title,
        (*((key, S(v)) for key, v in case.constants.items() if key in used), ("k", case.k)),
        "NLS",
        closed_form(case.form).title,
        order,
        envelope_rate(case.envelope(), case.constants, order),
        envelope_study(case, order, ENVELOPES[name, order]),
    )


def _numbers(case: RateCase) -> Iterator[tuple[str, Value]]:
    yield from case.constants.items()
    mean = sum((value * eps**power for power, value in case.scaling.background), S.Zero)
    if mean:
        yield str(ybar), mean


def _exact(value: Value) -> Expr:
    return value if isinstance(value, Expr) else Rational(value)


def rate_jobs(full: bool) -> dict[Key, Job]:
    """The short cases with their simplest data; if ``full`` all cases, and with the next order.

    Data of leading and of slaved order are the same with one field in a cell.
    """
    from longwave.scenes.rate_cases import RATE_CASES

    envelopes = ENVELOPES if full else SHORT_ENVELOPES
    waves: dict[Key, Job] = {
        ("rate", (name, order)): Job(measured_rate, (name, order), LONG.get(name, SECONDS[order]))
        for name, case in RATE_CASES.items()
        for order in _orders(case, full)
    }
    carried: dict[Key, Job] = {
        ("rate", given): Job(measured_envelope, given, ENVELOPE_SECONDS[given[1]])
        for given in envelopes
    }
    return waves | carried


def _orders(case: RateCase, full: bool) -> list[str]:
    if not full:
        return [] if case.name in LONG else list(case.orders)[:1]
    left = {"slaved"} if "leading" in case.orders else set()
    return [order for order in case.orders if order not in left]
