"""``longwave verify accuracy``: table of the worst evaluation errors of each wave and derivative.

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
"""Approximate seconds that one worker process takes for one case of a wave."""

MAX_JOBS, MAX_DRAWN = 1000, 100_000
"""Largest accepted values of --jobs and --drawn; larger ones are refused as typing errors."""

WORKER_SECONDS, WORKER_BYTES = 3.0, 3e8
"""Seconds to start a worker process, and the bytes of memory that it uses."""


def print_accuracy(
    only: Sequence[str], jobs: int | None, drawn: int | None, json_wanted: bool, program: str
) -> int:
    """Measure the waves (all if none is named) and print the table; return the exit status.

    By default this uses all cores and ``DRAWN`` random cases for each wave. Raises ValueError for
    bad options.
    """
    jobs = os.cpu_count() or 1 if jobs is None else jobs
    drawn = DRAWN if drawn is None else drawn
    for name in sorted(set(only) - set(wave_names())):
        raise ValueError(f"--only must be a wave, got {name} ({one_of(name, wave_names())})")
    job_option, drawn_option = ("--jobs", 1, jobs, MAX_JOBS, 2), ("--drawn", 0, drawn, MAX_DRAWN)
    for name, least, value, most, usual in (job_option, (*drawn_option, DRAWN)):
        if not least <= value <= most:
            got = f"{shown(value)} ({usual} is usual)"
            raise ValueError(f"{name} must satisfy {least} <= {name} <= {most}, got {got}")
    names = only or wave_names()
    cases = sum(len(list(all_cases(name, 0))) + drawn for name in names)
    cores = min(jobs, os.cpu_count() or 1)
    check_and_announce(
        f"{len(names)} waves to be measured",
        CASE_SECONDS * cases / cores + WORKER_SECONDS * jobs / cores,
        WORKER_BYTES * jobs,
        "take fewer waves, --drawn or --jobs",
    )
    results, complete = finished(_measure_all(names, jobs, drawn))
    requested = f"{len(names)} waves"
    status = print_results(results, complete, _print_table, json_wanted, program, requested)
    return status or int(not all(result.passed for result in results))


def _measure_all(names: Sequence[str], processes: int, drawn: int) -> Iterator[Accuracy]:
    """Yield the worst errors of each wave; its cases run in fresh worker processes."""
    cases = {name: list(all_cases(name, drawn)) for name in names}
    jobs = (Job(measure_accuracy, (case,)) for name in names for case in cases[name])
    measured = in_order(jobs, LocalWorkers(processes))
    for name in names:
        print(f"measuring {name}", file=sys.stderr)
        yield worst_of(islice(measured, len(cases[name])))


def _print_table(results: Sequence[Accuracy]) -> None:
    table = Table(title=f"worst errors / max(1, |value|); promised: {PROMISED_ERROR:.0e}")
    for heading in ("wave", "points", "Y", "Y_X", "Y_T", "worst at"):
        table.add_column(heading, justify="left" if heading in ("wave", "worst at") else "right")
    for result in results:
        errors = [f"{error:.1e}" for error in result.errors]
        table.add_row(result.name, str(result.points), *errors, result.worst)
    table_console().print(table)
