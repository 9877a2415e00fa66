"""``python -m verify``: check the closed forms, or run a scene on the lattice.

Exit status: 0 if every form stands, 1 if one does not, 2 for bad input (one line on stderr).
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NoReturn

if TYPE_CHECKING:
    from solutions.closed_form import ClosedForm
    from verify.residual import Sampling
    from verify.verdict import Verdict

PIPE_WIDTH = 120
"""Columns of the table where stdout is no terminal."""


class OneLineParser(argparse.ArgumentParser):
    """An argument parser whose errors are one line on stderr and exit status 2."""

    def error(self, message: str) -> NoReturn:
        """Print ``message`` and stop."""
        self.exit(2, f"{self.prog}: {message} (see {self.prog} --help)\n")


def main(argv: Sequence[str] | None = None) -> int:
    """Dispatch to a subcommand, or to the table of verdicts; return the exit status."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    command = COMMANDS.get(arguments[0]) if arguments else None
    try:
        return command(arguments[1:]) if command else table_command(arguments)
    except KeyboardInterrupt:
        print("python -m verify: interrupted", file=sys.stderr)
        return 130


def run_command(argv: list[str]) -> int:
    """Run a scene; numba and xarray are imported here and not for the table."""
    from verify.lattice.cli import run_command as run_scene

    return run_scene(argv)


def accuracy_command(argv: list[str]) -> int:
    """Print the worst evaluation errors per wave; numba is imported here and not for the table."""
    from verify.study.evaluation_cli import accuracy_command as measure

    return measure(argv)


COMMANDS: dict[str, Callable[[list[str]], int]] = {
    "accuracy": accuracy_command,
    "run": run_command,
}


def table_command(argv: list[str]) -> int:
    """Check the closed forms and print the verdicts; 1 if any form does not stand."""
    from verify.residual import Sampling

    parser = _parser()
    options = parser.parse_args(argv)
    try:
        forms = _chosen(options.only)
        sampling = Sampling(options.digits, options.points, options.seed)
    except ValueError as error:
        parser.error(str(error))
    verdicts = _checked(forms, sampling)
    if options.json:
        print(json.dumps([verdict.json() for verdict in verdicts], indent=2))
    else:
        _print_table(verdicts)
    return 0 if all(verdict.passed for verdict in verdicts) else 1


def _parser() -> OneLineParser:
    from verify.residual import DIGITS, POINTS

    parser = OneLineParser(
        prog="python -m verify",
        description="Check the closed forms against their equations.",
        epilog="subcommands: run SCENE.toml integrates a scene on the lattice (run --help); "
        "accuracy measures the evaluation of every wave (accuracy --help)",
    )
    parser.add_argument(
        "--digits",
        type=_digits,
        default=DIGITS,
        metavar="D1,D2,...",
        help=f"increasing precisions of the residual (default {','.join(map(str, DIGITS))})",
    )
    parser.add_argument(
        "--only", action="append", metavar="NAME", help="check this form; may be repeated"
    )
    parser.add_argument(
        "--points", type=int, default=POINTS, help=f"random points a form (default {POINTS})"
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of the points (default 0)")
    parser.add_argument("--json", action="store_true", help="print the verdicts as JSON")
    return parser


def _digits(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"digits must be integers with commas between, got {text!r} (30,50,100 is usual)"
        ) from None


def _chosen(names: Sequence[str] | None) -> list[ClosedForm]:
    from solutions.catalogue import CATALOGUE, closed_form

    return [closed_form(name) for name in names] if names else list(CATALOGUE)


def _checked(forms: Sequence[ClosedForm], sampling: Sampling) -> list[Verdict]:
    """The verdicts, with a progress bar on stderr if that is a terminal."""
    from rich.console import Console
    from rich.progress import track

    from verify.check import check

    console = Console(stderr=True)
    bar = track(forms, "checking", console=console, transient=True, disable=not console.is_terminal)
    return [check(form, sampling) for form in bar]


def _print_table(verdicts: Sequence[Verdict]) -> None:
    from rich.console import Console

    from verify.table import failure_lines, summary, verdict_table

    console = Console(width=None if sys.stdout.isatty() else PIPE_WIDTH)
    console.print(verdict_table(verdicts))
    for line in (*failure_lines(verdicts), summary(verdicts)):
        console.print(line, markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    sys.exit(main())
