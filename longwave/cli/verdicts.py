"""``longwave verify``: tables of the verdicts on the closed forms and on their misprints.

A misprint changes a single place: a coefficient, a sign, a missing term, k for k**2.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from rich.table import Table

from longwave.cli.certificates import ProofFile
from longwave.solutions.catalogue import CATALOGUE
from longwave.support.command_line import check_and_announce, listed
from longwave.support.console import finished, print_lines, print_results, table_console, tracked
from longwave.verify.evidence.mutations import MutationCount, count_mutants
from longwave.verify.evidence.residual import Sampling, check_residual, scientific
from longwave.verify.proof import ProofVerdict, prove_stable
from longwave.verify.proof.catalogue_proofs import NAMES, higher_order, named_form, prove_all
from longwave.verify.verdict import Outcome, Verdict

MUTATION_COLUMNS = ("mutants", "refuted", "proved", "undecided")


@dataclass(frozen=True)
class TimeLaw:
    """Expected time in seconds to process closed forms.

    ``seconds`` is the time for one form of the catalogue, ``rational`` the time for order 7 of the
    rational family; the time for other orders is that times (order / 7) ** ``exponent``.
    """

    seconds: float
    rational: float
    exponent: float

    def total(self, names: Iterable[str]) -> float:
        """Return the seconds for all forms; raise ValueError for an unknown name.

        >>> round(PROOF_LAW.total(["rational_2", "rational_14"]))
        19
        """
        return sum(
            self.seconds if order is None else self.rational * (order / 7) ** self.exponent
            for order in map(higher_order, names)
        )


PROOF_LAW = TimeLaw(0.2, 0.15, 7.0)
STABLE_LAW = TimeLaw(0.3, 1.5, 3.3)
RESIDUAL_LAW = TimeLaw(0.3, 1.0, 4.0)
MUTANT_LAW = TimeLaw(35.0 / len(CATALOGUE), 29.0, 6.5)
"""Time laws of four kinds: proofs that a form is a solution, proofs that its evaluation form equals
its canonical form (--stable), numerical residuals, decisions of mutants (misprints).

The laws of the rational family were measured in processor seconds on one core of a 3 GHz server:
orders 7 to 12 for proofs, 4 to 8 for --stable, 4 to 7 for the others. Beyond these orders only
the order of magnitude is right.
"""


def print_verdicts(
    program: str,
    *,
    only: Sequence[str] = (),
    json_wanted: bool = False,
    output: str | None = None,
    system: str | None = None,
    force: bool = False,
    stable: bool = False,
    method: str | None = None,
    **sampled: Any,
) -> int:
    """Decide the closed forms (all if none is named), print the verdicts, return the exit status.

    ``sampled`` may have ``digits`` (precisions, separated by commas), ``points`` and ``seed`` of
    the residual. Proofs are written as by `ProofFile`. The status is 0, 1 if a form does not pass,
    130 after Ctrl-C. Raises ValueError for bad options, and OSError if writing fails.
    """
    names = tuple(dict.fromkeys(only)) or NAMES
    proof_options = {"--output": output, "--export": system, "--stable": stable}
    proofs = ProofFile(output, system, force)
    sampling = sampling_of(
        method, [name for name in proof_options if proof_options[name]], **sampled
    )
    law = STABLE_LAW if stable else PROOF_LAW if sampling is None else RESIDUAL_LAW
    expected = law.total(names) * (1.0 if sampling is None else _relative_effort(sampling))
    cheaper = "take a lower order, fewer forms or another method"
    proofs.check()
    check_and_announce(f"{_form_count(len(names))} to be checked", expected, cheaper=cheaper)
    pending = _verdicts(names, stable, sampling)
    verdicts, complete = finished(tracked(pending, len(names), "checking"))
    proved = (verdict for verdict in verdicts if isinstance(verdict, ProofVerdict))
    proofs.write([proof.certificate for proof in proved if proof.certificate is not None])
    noun = "stable form" if stable else "closed form"
    show, requested = partial(_print_table, noun=noun), _form_count(len(names))
    status = print_results(verdicts, complete, show, json_wanted, program, requested)
    return status or int(not all(verdict.passed for verdict in verdicts))


def _form_count(count: int) -> str:
    return "1 form" if count == 1 else f"{count} forms"


def _relative_effort(sampling: Sampling) -> float:
    """Return the work of a sampling relative to the default one: points times digits squared."""
    default = Sampling()
    digit_work = sum(max(number, 30) ** 2 for number in sampling.digits)
    default_work = sum(number**2 for number in default.digits)
    return sampling.points / default.points * digit_work / default_work


def sampling_of(
    method: str | None, proof_options: Sequence[str], **options: Any
) -> Sampling | None:
    """Return the sampling of the residual, or None for the method of proof.

    The method defaults to the residual if one of its options is given. Raises ValueError for
    options of the other method; ``proof_options`` lists those given for proofs.
    """
    sampled = {name: value for name, value in options.items() if value is not None}
    method = method or ("residual" if sampled else "proof")
    conflicting = proof_options if method == "residual" else [f"--{name}" for name in sampled]
    if conflicting:
        raise ValueError(
            f"{conflicting[0]} must not be given with the method {method}, got it (leave it out)"
        )
    if "digits" in sampled:
        example = "30,50,100 is usual"
        sampled["digits"] = listed("digits", sampled["digits"], int, "integers", example)
    return None if method == "proof" else Sampling(**sampled)


def _verdicts(names: Sequence[str], stable: bool, sampling: Sampling | None) -> Iterator[Verdict]:
    if stable:
        return (prove_stable(named_form(name)) for name in names)
    if sampling is None:
        return prove_all(names)
    return (check_residual(named_form(name), sampling) for name in names)


STYLES = {
    Outcome.PROVED: "green",
    Outcome.CHECKED: "cyan",
    Outcome.REFUTED: "bold red",
    Outcome.UNDECIDED: "yellow",
    Outcome.UNREADABLE: "magenta",
}
"""Style of each outcome in a terminal."""

MEANINGS = {outcome: outcome.value.lower() for outcome in STYLES} | {
    Outcome.PROVED: "proved exactly",
    Outcome.CHECKED: "checked to the digits shown, which is no proof",
}
"""Words for each outcome in a summary."""


def _print_table(verdicts: Sequence[Verdict], noun: str) -> None:
    """Print one row for each form, a line for each that does not pass, and a summary.

    The evidence is the size of the certificate if there is one, else the largest relative residual
    at the highest precision; an exact 0 is a proof.
    """
    table = Table(title="Closed forms against their equations")
    for heading in ("solution", "equation", "method", "verdict"):
        table.add_column(heading, no_wrap=heading != "method")
    for heading in ("evidence", "seconds"):
        table.add_column(heading, justify="right", no_wrap=True)
    for verdict in verdicts:
        outcome = f"[{STYLES[verdict.outcome]}]{verdict.outcome.value}[/]"
        cells = (verdict.name, verdict.equation, verdict.method, outcome)
        table.add_row(*cells, _evidence(verdict), f"{verdict.seconds:.2f}")
    console = table_console()
    console.print(table)
    failures = [_failure_line(verdict) for verdict in verdicts if not verdict.passed]
    print_lines(console, [*failures, summary(verdicts, noun)])


def _evidence(verdict: Verdict) -> str:
    """Return the table entry for the evidence: certificate size, else the residual, else a dash."""
    if isinstance(verdict, ProofVerdict) and verdict.certificate_bytes is not None:
        return f"{verdict.certificate_bytes} bytes"
    if verdict.residual is None:
        return "-"
    return scientific(math.log10(verdict.residual) if verdict.residual else -math.inf)


def _failure_line(verdict: Verdict) -> str:
    """Return the line on a form that does not pass, with its witness or reason."""
    witness = f" (witness: {verdict.point})" if verdict.witness else ""
    return f"{verdict.name}: {verdict.outcome.value}: {verdict.detail}{witness}"


def summary(verdicts: Sequence[Verdict], noun: str = "closed form") -> str:
    """Return a line with the number of verdicts of each kind and the total time.

    >>> proof = Verdict("kink", "defocusing mKdV", "by hand", Outcome.PROVED, "", 0.0)
    >>> summary([proof])
    '1 closed form in 0.0 s: 1 proved exactly'
    """
    counts = Counter(verdict.outcome for verdict in verdicts)
    parts = (f"{counts[outcome]} {MEANINGS[outcome]}" for outcome in Outcome if counts[outcome])
    seconds = sum(verdict.seconds for verdict in verdicts)
    plural = "" if len(verdicts) == 1 else "s"
    return f"{len(verdicts)} {noun}{plural} in {seconds:.1f} s: {'; '.join(parts)}"


def print_mutations(only: Sequence[str], json_wanted: bool, program: str) -> int:
    """Decide all mutants of the forms (all if none is named) and print the counts.

    Returns the exit status: 0, 1 if any mutant is undecided, 130 after Ctrl-C. Raises ValueError
    for an unknown name.
    """
    names = only or list(CATALOGUE.names)
    label = f"the misprints of {', '.join(only or ['all forms'])}"
    check_and_announce(label, MUTANT_LAW.total(names), cheaper="take fewer forms, of lower order")
    pending = (count_mutants(named_form(name)) for name in names)
    counts, complete = finished(tracked(pending, len(names), "refuting"))
    requested = f"{len(names)} forms"
    status = print_results(counts, complete, _print_counts, json_wanted, program, requested)
    return status or int(any(count.undecided for count in counts))


def _print_counts(counts: Sequence[MutationCount]) -> None:
    """Print one row for each form, the totals, and a line for each mutant that is not refuted."""
    table = Table(title="Misprints of the closed forms", show_footer=True)
    table.add_column("solution", "total", no_wrap=True)
    for column in MUTATION_COLUMNS:
        total = sum(getattr(count, column) for count in counts)
        table.add_column(column, str(total), justify="right")
    table.add_column("seconds", f"{sum(c.seconds for c in counts):.1f}", justify="right")
    for count in counts:
        cells = (str(getattr(count, column)) for column in MUTATION_COLUMNS)
        table.add_row(count.name, *cells, f"{count.seconds:.1f}")
    console = table_console()
    console.print(table)
    survivors = [
        f"{count.name}: {survivor.outcome.value} ({survivor.reason}): {survivor.description}"
        for count in counts
        for survivor in count.survivors
    ]
    print_lines(console, survivors)
