"""``python -m verify mutations``: every misprint of every closed form, refuted or explained."""

from __future__ import annotations

import json
from collections.abc import Sequence

from rich.table import Table

from derive.command_line import announce, interrupted
from solutions.catalogue import CATALOGUE
from verify.cli.console import (
    MUTANTS,
    OneLineParser,
    add_only,
    fail,
    finished,
    print_lines,
    table_console,
    tracked,
)
from verify.evidence.mutations import MutationCount, count_mutants
from verify.proof.catalogue_proofs import named_form

COLUMNS = ("mutants", "refuted", "proved", "undecided")


def mutations_command(argv: list[str]) -> int:
    """Decide all mutants and print the counts; 1 if any is undecided."""
    parser = OneLineParser(
        prog="python -m verify mutations",
        description="Change each closed form in every single place: a coefficient, a sign, a term "
        "left out, k for k**2. Refute the wrong ones; list those that still solve the equation.",
    )
    add_only(parser)
    parser.add_argument("--json", action="store_true", help="print the counts as JSON")
    options = parser.parse_args(argv)
    return print_mutations(options.only, options.json, parser.prog)


def print_mutations(only: Sequence[str] | None, json_wanted: bool, program: str) -> int:
    """Decide all mutants of the forms (all if none is named) and print the counts.

    Returns 0, 1 if any is undecided, 2 for a name that is none, 130 after Ctrl-C.
    """
    names = only or list(CATALOGUE.names)
    try:
        announce(f"the misprints of {', '.join(only or ['all forms'])}", MUTANTS.total(names))
    except ValueError as error:
        return fail(error)
    work = (count_mutants(named_form(name)) for name in names)
    counts, complete = finished(tracked(work, len(names), "refuting"))
    if json_wanted:
        print(json.dumps([count.json() for count in counts], indent=2))
    else:
        _print(counts)
    if not complete:
        return interrupted(program, f"after {len(counts)} of {len(names)} forms")
    return 1 if any(count.undecided for count in counts) else 0


def _print(counts: Sequence[MutationCount]) -> None:
    console = table_console()
    console.print(counts_table(counts))
    print_lines(console, survivor_lines(counts))


def counts_table(counts: Sequence[MutationCount]) -> Table:
    """One row a form, and the totals."""
    table = Table(title="Misprints of the closed forms", show_footer=True)
    table.add_column("solution", "total", no_wrap=True)
    for column in COLUMNS:
        total = sum(getattr(count, column) for count in counts)
        table.add_column(column, str(total), justify="right")
    table.add_column("seconds", f"{sum(c.seconds for c in counts):.1f}", justify="right")
    for count in counts:
        cells = (str(getattr(count, column)) for column in COLUMNS)
        table.add_row(count.name, *cells, f"{count.seconds:.1f}")
    return table


def survivor_lines(counts: Sequence[MutationCount]) -> list[str]:
    """One line for each mutant that is not refuted."""
    return [
        f"{count.name}: {survivor.outcome.value} ({survivor.reason}): {survivor.description}"
        for count in counts
        for survivor in count.survivors
    ]
