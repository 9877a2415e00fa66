"""The proofs: verdicts, certificates, times; and what became of the misprints."""

import re
from collections.abc import Iterable, Mapping

from reports.environment import escape
from reports.tables import block, scientific, table
from verify.study.mutations import MutationCount, Survivor
from verify.study.proofs import ProofRecord
from verify.verdict import Verdict

DASH = "--"

METHODS = {"differential algebra": "A", "exact at more points than the degree": "P"}
"""The letters by which the table calls the methods; the text above it says them."""

SHOWN = 20
"""Most characters of a misprinted part that are shown."""


def proof_table(records: Iterable[ProofRecord], residuals: Mapping[str, Verdict]) -> str:
    """Solution, verdict, method, certificate, seconds to prove and to check, residual.

    The residual is that of mpmath, independent of the proof; a form without one has a dash.
    """
    rows = [
        [
            rf"\texttt{{{escape(record.name)}}}",
            escape(record.outcome.value),
            METHODS.get(record.method, escape(record.method)),
            _kilobytes(record.certificate_bytes),
            f"{record.prove_seconds:.2f}",
            DASH if record.check_seconds is None else f"{record.check_seconds:.2f}",
            _answer(record.accepted),
            _residual(residuals.get(record.name)),
        ]
        for record in records
    ]
    head = ["solution", "verdict", "method", "kB", "prove/s", "check/s", "checker", "residual"]
    return block("lllrrrll", head, rows)


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
    return block("lrrrrr", head, rows)


def survivor_table(counts: Iterable[MutationCount]) -> str:
    """The misprints that are not refuted, the same change with the same reason in one row."""
    changes: dict[tuple[str, str, str], dict[str, list[str]]] = {}
    for count in counts:
        for survivor in count.survivors:
            place, change = _place(survivor.description)
            key = (place, _reason(survivor), survivor.outcome.value)
            changes.setdefault(key, {}).setdefault(count.name, []).append(change)
    merged: dict[tuple[str, ...], list[str]] = {}
    for (place, why, verdict), forms in changes.items():
        for name, what in forms.items():
            merged.setdefault((place, ", ".join(dict.fromkeys(what)), why, verdict), []).append(name)
    rows = [
        [place, change, why, verdict, ", ".join(rf"\texttt{{{escape(name)}}}" for name in names)]
        for (place, change, why, verdict), names in merged.items()
    ]
    head = ["of", "change", "why", "verdict", "solutions"]
    return table("L{24mm}L{32mm}L{26mm}L{16mm}L{50mm}", head, rows, gap="0.5ex")


def _place(description: str) -> tuple[str, str]:
    """Return which part a description says was changed, and how; wide parts by what they are."""
    words, _, change = description.rpartition(": ")
    kind, _, text = words.partition(" ")
    change = escape(change.replace("coefficient times 101/100", "1 % more"))
    if "..." not in text and len(text) <= SHOWN:
        return f"{kind} {_mathematics(text)}", change
    outer = re.sub(r"\((?:[^()]|\((?:[^()]|\([^()]*\))*\))*\)", "", text)
    return ("the fraction" if "/" in outer else "the product"), change


def _mathematics(text: str) -> str:
    """Return a short part's text as LaTeX."""
    text = re.sub(r"\b(tau|xi|alpha|kappa)\b", r"\\\1 ", text)
    return f"${text.replace('**', '^').replace('*', ' ')}$"


def _reason(survivor: Survivor) -> str:
    """Return why it is a solution, its symbols in mathematics."""
    signs = survivor.reason.replace("U to -U", "$U\\to-U$")
    return re.sub(r"another value of (\w+)", r"another value of $\1$", signs)


def _kilobytes(size: int | None) -> str:
    return DASH if size is None else f"{size / 1000:.1f}"


def _answer(accepted: bool | None) -> str:
    return DASH if accepted is None else "accepted" if accepted else "REJECTED"


def _residual(verdict: Verdict | None) -> str:
    return DASH if verdict is None or verdict.residual is None else scientific(verdict.residual)
