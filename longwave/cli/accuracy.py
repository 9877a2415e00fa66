"""``longwave verify accuracy``: worst evaluation errors per wave and derivative, as a table.

Exit status: 0 if every error is within the promised bound, 1 if one is not, 2 for bad input.
"""

import os
import sys
from collections.abc import Iterator, Sequence
from itertools import islice

from rich.table import Table

from longwave.reports.studies.evaluation_accuracy import (
    DRAWN,
    PROMISED_ERROR,
    Accuracy,
    all_cases,
    measure_accuracy,
    wave_names,
    worst_of,
)
from longwave.support.command_line import check_and_announce
from longwave.support.console import finished, print_results, table_console
from longwave.support.known_names import one_of
from longwave.support.processes import Job, LocalWorkers, in_order
from longwave.support.user_files import shown

CASE_SECONDS = 0.3
"""About the time that one case takes in a process."""

MOST_JOBS, MOST_DRAWN = 1000, 100_000
"""Beyond them a request is a slip of the pen."""

WORKER_SECONDS, WORKER_BYTES = 3.0, 3e8
"""For a process to begin, and what it holds."""


def print_accuracy(
    only: Sequence[str], jobs: int | None, drawn: int | None, json_wanted: bool, program: str
) -> int:
    """Measure the waves (all if none is named) and print the table; return the exit status.

    By default on all cores, with ``DRAWN`` random cases a wave. Raises ValueError for bad options.
    """
    jobs = os.cpu_count() or 1 if jobs is None else jobs
    drawn = DRAWN if drawn is None else drawn
    unknown = sorted(set(only) - set(wave_names()))
    if unknown:
        known = one_of(unknown[0], wave_names())
        raise ValueError(f"--only must be a wave, got {unknown[0]} ({known})")
    for name, least, given, most, usual in (
        ("--jobs", 1, jobs, MOST_JOBS, 2),
        ("--drawn", 0, drawn, MOST_DRAWN, DRAWN),
    ):
        if not least <= given <= most:
            got = f"{shown(given)} ({usual} is usual)"
            raise ValueError(f"{name} must satisfy {least} <= {name} <= {most}, got {got}")
    chosen = only or wave_names()
    cases = sum(len(list(all_cases(name, 0))) + drawn for name in chosen)
    cores = min(jobs, os.cpu_count() or 1)
    check_and_announce(
        f"{len(chosen)} waves to be measured",
        CASE_SECONDS * cases / cores + WORKER_SECONDS * jobs / cores,
        WORKER_BYTES * jobs,
        "take fewer waves, --drawn or --jobs",
    )
    results, complete = finished(_measured(chosen, jobs, drawn))
    asked = f"{len(chosen)} waves"
    status = print_results(results, complete, _print, json_wanted, program, asked)
    return status or int(not all(result.passed for result in results))


def _measured(names: Sequence[str], jobs: int, drawn: int) -> Iterator[Accuracy]:
    """Each wave's worst errors; its cases run in ``jobs`` fresh processes."""
    cases = {name: list(all_cases(name, drawn)) for name in names}
    every = (Job(measure_accuracy, (case,)) for name in names for case in cases[name])
    found = in_order(every, LocalWorkers(jobs))
    for name in names:
        print(f"measuring {name}", file=sys.stderr)
        yield worst_of(islice(found, len(cases[name])))


def _print(results: Sequence[Accuracy]) -> None:
    table = Table(title=f"worst errors / max(1, |value|); promised: {PROMISED_ERROR:.0e}")
    for heading in ("wave", "points", "Y", "Y_X", "Y_T", "worst at"):
        table.add_column(heading, justify="left" if heading in ("wave", "worst at") else "right")
    for result in results:
        errors = [f"{error:.1e}" for error in result.errors]
        table.add_row(result.name, str(result.points), *errors, result.worst)
    table_console().print(table)
