"""``python -m verify``: the table of verdicts on the closed forms."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from derive.command_line import announce, interrupted
from verify.cli.costs import PROOF, RESIDUAL, STABLE, Law
from verify.cli.parser import (
    OneLineParser,
    add_only,
    fail,
    finished,
    print_lines,
    table_console,
    tracked,
)
from verify.proof import ProofVerdict, prove_stable
from verify.proof.catalogue_proofs import NAMES, named_form, prove_all
from verify.residual import DIGITS, POINTS, Sampling, check_residual
from verify.table import failure_lines, summary, verdict_table
from verify.verdict import Verdict

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


def _law(options: Options) -> Law:
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
