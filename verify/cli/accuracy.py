"""``python -m verify accuracy``: worst evaluation errors per wave and derivative, as a table.

Exit status: 0 if every error is within the promised bound, 1 if one is not, 2 for bad input.
"""

import json
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

from rich.console import Console
from rich.table import Table

from derive.command_line import OneLineParser, announce, fail, interrupted
from verify.cli.console import finished
from verify.processes import ignore_interrupt, stopping
from verify.studies.evaluation_accuracy import (
    DRAWN,
    PROMISED_ERROR,
    Accuracy,
    all_cases,
    measure_accuracy,
    wave_names,
    worst_of,
)

__all__ = ["accuracy_command"]

PIPE_WIDTH = 120

CASE_SECONDS = 0.3
"""About the time that one case takes in a process."""


def accuracy_command(argv: list[str]) -> int:
    """Measure, print, and say by the exit status whether every error is within the bound."""
    parser = OneLineParser(
        prog="python -m verify accuracy",
        description="Measure the evaluation of every wave against mpmath at 60 digits.",
    )
    parser.add_argument("--only", action="append", metavar="NAME", help="this wave; repeatable")
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes (default all)")
    parser.add_argument("--json", action="store_true", help="print the table as JSON")
    parser.add_argument(
        "--drawn", type=int, default=DRAWN, help=f"random cases a wave (default {DRAWN})"
    )
    options = parser.parse_args(argv)
    unknown = sorted(set(options.only or ()) - set(wave_names()))
    if unknown:
        names = ", ".join(wave_names())
        return fail(f"--only must be a wave, got {unknown[0]} (one of {names})")
    if options.jobs < 1:
        return fail(f"--jobs must satisfy --jobs >= 1, got {options.jobs} (2 is usual)")
    if options.drawn < 0:
        return fail(f"--drawn must satisfy --drawn >= 0, got {options.drawn} ({DRAWN} is usual)")
    chosen = options.only or wave_names()
    cases = sum(len(list(all_cases(name, options.drawn))) for name in chosen)
    announce(f"{len(chosen)} waves to be measured", CASE_SECONDS * cases / options.jobs)
    results, complete = finished(_measured(chosen, options.jobs, options.drawn))
    if options.json:
        print(json.dumps([result.json() for result in results], indent=2))
    else:
        _print(results)
    if not complete:
        return interrupted(parser.prog, f"after {len(results)} of {len(chosen)} waves")
    return 0 if all(result.passed for result in results) else 1


def _measured(names: Sequence[str], jobs: int, drawn: int) -> Iterator[Accuracy]:
    """Each wave's worst errors; its cases run in ``jobs`` fresh processes."""
    context = get_context("spawn")
    with ProcessPoolExecutor(jobs, context, ignore_interrupt) as pool, stopping(pool):
        pending = [
            (name, [pool.submit(measure_accuracy, case) for case in all_cases(name, drawn)])
            for name in names
        ]
        for name, cases in pending:
            print(f"measuring {name}", file=sys.stderr)
            yield worst_of(case.result() for case in cases)


def _print(results: Sequence[Accuracy]) -> None:
    table = Table(title=f"worst errors / max(1, |value|); promised: {PROMISED_ERROR:.0e}")
    for heading in ("wave", "points", "Y", "Y_X", "Y_T", "worst at"):
        table.add_column(heading, justify="left" if heading in ("wave", "worst at") else "right")
    for result in results:
        errors = [f"{error:.1e}" for error in result.errors]
        table.add_row(result.name, str(result.points), *errors, result.worst)
    Console(width=None if sys.stdout.isatty() else PIPE_WIDTH).print(table)
