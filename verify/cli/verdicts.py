"""``python -m verify``: the table of verdicts on the closed forms."""

from __future__ import annotations

import argparse
import json
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.table import Table

from derive.command_line import announce, interrupted
from verify.cli.console import (
    PROOF,
    RESIDUAL,
    STABLE,
    OneLineParser,
    TimeLaw,
    add_only,
    fail,
    finished,
    print_lines,
    table_console,
    tracked,
)
from verify.evidence.residual import DIGITS, POINTS, Sampling, check_residual, scientific
from verify.proof import ProofVerdict, prove_stable
from verify.proof.catalogue_proofs import NAMES, named_form, prove_all
from verify.verdict import Outcome, Verdict

RESIDUAL_OPTIONS = ("digits", "points", "seed")
PROOF_OPTIONS = ("certificate", "stable")


@dataclass
class Options:
    """What is to be decided, and how; None where nothing is said.

    ``only`` are names of forms (all if empty), ``digits`` and the rest the residual's sampling.
    """

    only: Sequence[str] | None = None
    json: bool = False
    certificate: Path | None = None
    stable: bool = False
    method: str | None = None
    digits: tuple[int, ...] | None = None
    points: int | None = None
    seed: int | None = None


def verdicts_command(argv: list[str]) -> int:
    """Decide the closed forms and print the verdicts; 1 if any form does not stand."""
    parser = _parser()
    return print_verdicts(parser.parse_args(argv, Options()), parser.prog)


def print_verdicts(options: Options, program: str) -> int:
    """Decide the closed forms and print the verdicts; the exit status.

    0, 1 if any form does not stand, 2 for bad options, 130 after Ctrl-C, which ``program`` tells.
    """
    names = options.only or NAMES
    try:
        _settle_method(options)
        work = _verdicts(names, options)
        announce(f"{_noun(len(names))} to be checked", _law(options).total(names))
        if options.certificate is not None:
            options.certificate.touch()
        found, complete = finished(tracked(work, len(names), "checking"))
        if options.certificate is not None:
            _write_certificates(options.certificate, found)
    except (ValueError, OSError) as error:
        return fail(error)
    _print(found, options)
    if not complete:
        return interrupted(program, f"after {len(found)} of {_noun(len(names))}")
    return 0 if all(verdict.passed for verdict in found) else 1


def _noun(count: int) -> str:
    return "1 form" if count == 1 else f"{count} forms"


def _law(options: Options) -> TimeLaw:
    """What a form costs with the method and the options chosen."""
    if options.stable:
        return STABLE
    if options.method == "residual":
        return RESIDUAL
    return PROOF


def _parser() -> OneLineParser:
    parser = OneLineParser(
        prog="python -m verify",
        description="Prove the closed forms exactly, for all parameters and lattice constants.",
        epilog="subcommands (each has --help): check-certificate FILE repeats proofs; mutations "
        "refutes every misprint; run SCENE.toml integrates a scene on the lattice",
    )
    add_only(parser)
    parser.add_argument("--json", action="store_true", help="print the verdicts as JSON")
    exact = parser.add_argument_group("proof (the default method)")
    exact.add_argument(
        "--certificate", type=Path, metavar="FILE", help="write the proofs' certificates as JSON"
    )
    exact.add_argument(
        "--stable",
        action="store_true",
        help="prove instead that each evaluation form is the canonical form",
    )
    sampled = parser.add_argument_group("high-precision residual (evidence, no proof)")
    sampled.add_argument("--method", choices=("proof", "residual"))
    sampled.add_argument(
        "--digits",
        type=_digits,
        metavar="D1,D2,...",
        help=f"increasing precisions (default {','.join(map(str, DIGITS))})",
    )
    sampled.add_argument("--points", type=int, help=f"random points a form (default {POINTS})")
    sampled.add_argument("--seed", type=int, help="seed of the points (default 0)")
    return parser


def _digits(text: str) -> tuple[int, ...]:
    try:
        return digits_in(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def digits_in(text: str) -> tuple[int, ...]:
    """The precisions in a text; raises ValueError if it is no list of integers.

    >>> digits_in("30,50")
    (30, 50)
    """
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise ValueError(
            f"digits must be integers with commas between, got {text!r} (30,50,100 is usual)"
        ) from None


def _settle_method(options: Options) -> None:
    """Residual if an option of it is given; raises ValueError for options of both methods."""
    sampled = [name for name in RESIDUAL_OPTIONS if getattr(options, name) is not None]
    exact = [name for name in PROOF_OPTIONS if getattr(options, name)]
    options.method = options.method or ("residual" if sampled else "proof")
    wrong = exact if options.method == "residual" else sampled
    if wrong:
        raise ValueError(
            f"--{wrong[0]} must not be given with the method {options.method}, got it (leave it)"
        )


def _verdicts(names: Sequence[str], options: Options) -> Iterator[Verdict]:
    if options.stable:
        return (prove_stable(named_form(name)) for name in names)
    if options.method == "proof":
        return prove_all(names)
    given = {name: getattr(options, name) for name in RESIDUAL_OPTIONS}
    sampling = Sampling(**{name: value for name, value in given.items() if value is not None})
    return (check_residual(named_form(name), sampling) for name in names)


def _write_certificates(path: Path, verdicts: Sequence[Verdict]) -> None:
    proofs = [verdict for verdict in verdicts if isinstance(verdict, ProofVerdict)]
    texts = [text for proof in proofs if (text := proof.certificate_text()) is not None]
    path.write_text("[" + ",\n".join(texts) + "]\n", encoding="utf-8")


def _print(verdicts: Sequence[Verdict], options: Options) -> None:
    if options.json:
        print(json.dumps([verdict.json() for verdict in verdicts], indent=2))
        return
    noun = "stable form" if options.stable else "closed form"
    console = table_console()
    console.print(verdict_table(verdicts))
    print_lines(console, [*failure_lines(verdicts), summary(verdicts, noun)])


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
