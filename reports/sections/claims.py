"""The paper's statements with measured numbers, verdicts and what they depend on."""

import re
from collections.abc import Iterable

from reports.environment import escape
from reports.tables import measured, table
from verify.studies.claims_record import Claim, Measurement

COMMANDS = {
    "eps": r"\epsilon ",
    "alpha": r"\alpha ",
    "tau": r"\tau ",
    "dt": r"\Delta t",
    "<=": r"\le ",
}
"""Names in the records' mathematics that LaTeX calls otherwise."""


SHORT = 16
"""Measurements whose texts are shorter than this stand in one line."""


def claim_table(claims: Iterable[Claim]) -> str:
    """One row a statement."""
    rows = [
        [
            mathematics(claim.statement),
            _measured(claim.measurements),
            claim.ruling.value,
            mathematics(claim.depends_on),
        ]
        for claim in claims
    ]
    head = ["the paper says", "measured here", "verdict", "depends on"]
    return table("L{35mm}L{69mm}L{16mm}L{33mm}", head, rows, gap="1ex")


def mathematics(text: str) -> str:
    r"""Return a record's text as LaTeX: escaped outside the dollars, commands inside.

    >>> mathematics("below 20 % at $eps = 0.05$")
    'below 20 \\% at $\\epsilon  = 0.05$'
    """
    parts = text.split("$")
    parts[::2] = [escape(part) for part in parts[::2]]
    parts[1::2] = [_commands(part) for part in parts[1::2]]
    return "$".join(parts)


def _commands(text: str) -> str:
    return re.sub(r"[a-z]+|<=", lambda found: COMMANDS.get(found[0], found[0]), text)


def _measured(measurements: Iterable[Measurement]) -> str:
    """Return the measurements in lines: equal ones of several cases in one, short ones joined."""
    cases: dict[tuple[str, str], list[str]] = {}
    for measurement in measurements:
        case, colon, what = measurement.of.partition(": ")
        key = (what, _number(measurement)) if colon else (measurement.of, _number(measurement))
        cases.setdefault(key, []).append(case if colon else "")
    lines = [
        f"{mathematics(': '.join(filter(None, (', '.join(found), what))))}: {number}"
        for (what, number), found in cases.items()
    ]
    return (", " if all(len(line) < SHORT for line in lines) else r"\newline ").join(lines)


def _number(measurement: Measurement) -> str:
    """Return the number; one without error is exact."""
    value, error = measurement.value, measurement.error
    return f"${value:.4g}$" if error == 0 else measured(value, error)
