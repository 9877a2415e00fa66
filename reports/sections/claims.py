"""The paper's statements with measured numbers, verdicts and what they depend on."""

import re
from collections.abc import Iterable

from reports.environment import escape
from reports.tables import measured, table
from verify.study.claims_record import Claim, Measurement

COMMANDS = {
    "eps": r"\epsilon ",
    "alpha": r"\alpha ",
    "tau": r"\tau ",
    "dt": r"\Delta t",
    "<=": r"\le ",
}
"""Names in the records' mathematics that LaTeX calls otherwise."""


def claim_table(claims: Iterable[Claim]) -> str:
    """One row a statement."""
    rows = [
        [
            mathematics(claim.statement),
            r"\newline ".join(map(_line, claim.measurements)),
            claim.ruling.value,
            mathematics(claim.depends_on),
        ]
        for claim in claims
    ]
    head = ["the paper says", "measured here", "verdict", "depends on"]
    return table("L{40mm}L{60mm}L{17mm}L{32mm}", head, rows, gap="1ex")


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


def _line(measurement: Measurement) -> str:
    """Return one measurement; a whole number without error is exact."""
    value, error = measurement.value, measurement.error
    exact = error == 0
    number = f"${value:.6g}$" if exact else measured(value, error)
    return f"{mathematics(measurement.of)}: {number}"
