"""The proofs: verdicts, certificates, times; and what became of the misprints."""

from collections.abc import Iterable, Mapping

from reports.environment import escape
from reports.tables import scientific, table
from verify.study.mutations import MutationCount
from verify.study.proofs import ProofRecord
from verify.verdict import Verdict

DASH = "--"


def proof_table(records: Iterable[ProofRecord], residuals: Mapping[str, Verdict]) -> str:
    """Solution, verdict, method, certificate, seconds to prove and to check, residual.

    The residual is that of mpmath, independent of the proof; a form without one has a dash.
    """
    rows = [
        [
            rf"\texttt{{{escape(record.name)}}}",
            escape(record.outcome.value),
            escape(record.method),
            _kilobytes(record.certificate_bytes),
            f"{record.prove_seconds:.2f}",
            DASH if record.check_seconds is None else f"{record.check_seconds:.2f}",
            _answer(record.accepted),
            _residual(residuals.get(record.name)),
        ]
        for record in records
    ]
    head = ["solution", "verdict", "method", "kB", "prove/s", "check/s", "checker", "residual"]
    return table("llL{30mm}rrrll", head, rows)


def mutation_table(counts: Iterable[MutationCount]) -> str:
    """How many misprints of each form are refuted, proved and undecided, and in how long."""
    found = list(counts)
    rows = [
        [
            rf"\texttt{{{escape(count.name)}}}",
            *map(str, (count.mutants, count.refuted, count.proved, count.undecided)),
            f"{count.seconds:.1f}",
        ]
        for count in found
    ]
    together = [
        str(sum(getattr(count, name) for count in found))
        for name in ("mutants", "refuted", "proved", "undecided")
    ]
    rows.append(["together", *together, f"{sum(count.seconds for count in found):.1f}"])
    head = ["solution", "misprints", "refuted", "proved", "undecided", "seconds"]
    return table("lrrrrr", head, rows)


def survivor_table(counts: Iterable[MutationCount]) -> str:
    """The misprints that are not refuted: which change, of which form, and why."""
    rows = [
        [
            rf"\texttt{{{escape(count.name)}}}",
            escape(survivor.outcome.value),
            rf"\texttt{{{_breakable(survivor.description)}}}",
            escape(survivor.reason),
        ]
        for count in counts
        for survivor in count.survivors
    ]
    return table("llL{71mm}L{33mm}", ["solution", "verdict", "change", "why"], rows)


def _breakable(text: str) -> str:
    """Return escaped code that may be broken after its operators."""
    shown = escape(text)
    for sign in ("*", "+", ",", ")", "/"):
        shown = shown.replace(sign, sign + r"\allowbreak{}")
    return shown


def _kilobytes(size: int | None) -> str:
    return DASH if size is None else f"{size / 1000:.1f}"


def _answer(accepted: bool | None) -> str:
    return DASH if accepted is None else "accepted" if accepted else "REJECTED"


def _residual(verdict: Verdict | None) -> str:
    return DASH if verdict is None or verdict.residual is None else scientific(verdict.residual)
