"""Verdicts as a table and in words, for the terminal."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

from rich.table import Table

from verify.decay import scientific
from verify.verdict import Outcome, ProofVerdict, Verdict

STYLES = {
    Outcome.PROVED: "green",
    Outcome.CHECKED: "cyan",
    Outcome.REFUTED: "bold red",
    Outcome.UNDECIDED: "yellow",
}

MEANINGS = {
    Outcome.PROVED: "proved exactly",
    Outcome.CHECKED: "checked to the digits shown, which is no proof",
    Outcome.REFUTED: "refuted",
    Outcome.UNDECIDED: "undecided",
}


def verdict_table(verdicts: Sequence[Verdict]) -> Table:
    """One row a closed form: solution, equation, method, verdict, evidence, seconds.

    The evidence is the certificate's size if there is one, else the largest relative residual at
    the highest precision; an exact 0 is a proof.
    """
    table = Table(title="Closed forms against their equations")
    for heading in ("solution", "equation", "method", "verdict"):
        table.add_column(heading, no_wrap=heading != "method")
    for heading in ("evidence", "seconds"):
        table.add_column(heading, justify="right", no_wrap=True)
    for verdict in verdicts:
        outcome = f"[{STYLES[verdict.outcome]}]{verdict.outcome.value}[/]"
        cells = (verdict.name, verdict.equation, verdict.method, outcome)
        table.add_row(*cells, evidence_text(verdict), f"{verdict.seconds:.2f}")
    return table


def evidence_text(verdict: Verdict) -> str:
    """The size of the certificate, else the residual with two digits; a dash without either."""
    if isinstance(verdict, ProofVerdict) and verdict.certificate_bytes is not None:
        return f"{verdict.certificate_bytes} bytes"
    if verdict.residual is None:
        return "-"
    return scientific(math.log10(verdict.residual) if verdict.residual else -math.inf)


def failure_lines(verdicts: Sequence[Verdict]) -> list[str]:
    """One line for each form that does not stand, with its witness or reason."""
    return [_failure(verdict) for verdict in verdicts if not verdict.passed]


def _failure(verdict: Verdict) -> str:
    place = ", ".join(f"{name} = {value}" for name, value in (verdict.witness or {}).items())
    at = f" (witness: {place})" if place else ""
    return f"{verdict.name}: {verdict.outcome.value}: {verdict.detail}{at}"


def summary(verdicts: Sequence[Verdict], noun: str = "closed form") -> str:
    """How many forms (or whatever ``noun`` says) came to which verdict, and the time together.

    >>> proof = Verdict("kink", "defocusing mKdV", "by hand", Outcome.PROVED, "", 0.0)
    >>> summary([proof])
    '1 closed form in 0.0 s: 1 proved exactly'
    """
    counts = Counter(verdict.outcome for verdict in verdicts)
    parts = "; ".join(
        f"{counts[outcome]} {MEANINGS[outcome]}" for outcome in Outcome if counts[outcome]
    )
    seconds = sum(verdict.seconds for verdict in verdicts)
    plural = "" if len(verdicts) == 1 else "s"
    return f"{len(verdicts)} {noun}{plural} in {seconds:.1f} s: {parts}"
