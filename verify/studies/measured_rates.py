"""The rates at which lattices come near their long-wave limits, measured for a report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from sympy import Expr, Rational, S

from derive import LATTICES
from derive.symbols import eps, ybar
from solutions import closed_form
from verify.processes import Job, Key

if TYPE_CHECKING:
    from verify.lattices.convergence import ConvergenceStudy
    from verify.lattices.rate_cases import RateCase, Value

SECONDS = {"leading": 0.5, "slaved": 0.7, "corrected": 15.0}
"""About the processor time of a case by the order of its data."""

LONG = {"5c": 9.0, "5d": 9.0, "6e": 9.0, "4b, second rogue wave": 15.0}
LONG |= {"6a, second rogue wave": 20.0, "6a, rogue wave on cn": 10.0}
"""The same of cases that the full report alone has: computed waves, and those at small eps."""

WIDE, FINE = (0.1, 0.07, 0.05, 0.035), (0.07, 0.05, 0.035)
COARSE, SHORT = (0.14, 0.1, 0.07), (0.1, 0.07, 0.05)

ENVELOPES: Mapping[tuple[str, str], tuple[float, tuple[float, ...]]] = {
    ("bright, strain", "slaved"): (2.0, WIDE),
    ("bright, strain", "corrected"): (3.0, WIDE),
    ("bright, displacement", "corrected"): (3.0, WIDE),
    ("dark, strain", "leading"): (2.0, WIDE),
    ("dark, strain", "corrected"): (3.0, WIDE),
    ("dark, Klein-Gordon", "slaved"): (2.0, WIDE),
    ("bright, Klein-Gordon", "leading"): (2.0, WIDE),
    ("bright, Klein-Gordon", "corrected"): (3.0, SHORT),
    ("Peregrine, strain", "leading"): (2.0, FINE),
    ("Peregrine, strain", "corrected"): (3.0, FINE),
    ("Peregrine, optical dimer", "leading"): (2.0, COARSE),
    ("Peregrine, optical dimer", "corrected"): (3.0, SHORT),
    ("Peregrine, granular dimer", "slaved"): (3.0, FINE),
}
"""Case and order of the data -> the rate to expect and the values of eps: 2 for the NLS equation, 3
with its next order, and where that vanishes, at k = pi."""

SHORT_ENVELOPES = (("bright, strain", "slaved"),)
"""Those that the short report has as well."""

ENVELOPE_SECONDS = {"leading": 2.0, "slaved": 9.0, "corrected": 20.0}

REACHED = 0.2
"""How far from what is expected a measured rate may be, beside its own uncertainty."""


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
    expected: float
    study: ConvergenceStudy

    @property
    def reached(self) -> bool:
        """Whether the expected rate is within the measured one's uncertainty, or close to it."""
        return abs(self.study.rate - self.expected) <= max(REACHED, self.study.uncertainty)


def measured_rate(name: str, order: str) -> MeasuredRate:
    """Measure one of `RATE_CASES` with data of an order.

    >>> found = measured_rate("2", "leading")
    >>> found.kind, found.expected, found.reached
    ('KdV', 4.0, True)
    """
    from verify.lattices.rate_cases import RATE_CASES

    case = RATE_CASES[name]
    return MeasuredRate(
        name,
        LATTICES[case.lattice].title + (f", along {case.steps}" if case.steps else ""),
        tuple((key, _exact(value)) for key, value in _numbers(case)),
        case.reduction.pde.kind,
        closed_form(case.wave).title if case.wave else "soliton, computed",
        order,
        case.rates[order],
        case.study(order),
    )


def measured_envelope(name: str, order: str) -> MeasuredRate:
    """Measure one of `ENVELOPES`."""
    from verify.lattices.envelope_study import ENVELOPE_CASES, envelope_study

    case, (expected, eps_values) = ENVELOPE_CASES[name], ENVELOPES[name, order]
    lattice = case.runs or LATTICES[case.lattice]
    used = {str(symbol) for symbol in lattice.constants}
    return MeasuredRate(
        name,
        f"{lattice.title}, {case.branch} branch" if case.branch else lattice.title,
        (*((key, S(v)) for key, v in case.constants.items() if key in used), ("k", case.k)),
        "NLS",
        closed_form(case.form).title,
        order,
        expected,
        envelope_study(case, order, eps_values),
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
    from verify.lattices.rate_cases import RATE_CASES

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
        return [] if case.name in LONG else list(case.rates)[:1]
    left = {"slaved"} if "leading" in case.rates else set()
    return [order for order in case.rates if order not in left]
