"""The search for wrong verdicts at length: random statements of known truth, on all cores.

Prints every finding (wrong, error, slow) with a script to paste, and a table by kind.  The exit
status is 1 if a verdict is wrong, an error escaped, or nothing came back in time.

    python -m searches.verdicts [--count 100000] [--minutes 600] [--seed 0] [--workers 2]
                                  [--kind all] [--undecided]

With ``--kind all`` the kinds take turns: one real unknown, then systems,
complex fields, compositions and shifts of lattice sites.
"""

from __future__ import annotations

import argparse
import sys
import time
from itertools import takewhile

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from longwave.support.processes import Job, LocalWorkers, LostProcess, OutOfTime, as_ended
from searches.text_search import (
    HEADINGS,
    SEARCH_KINDS,
    Judgement,
    Mark,
    any_statement,
    digest,
    judged,
    kind_of,
    tallies,
)

COUNT = 100_000
PATIENCE = 60.0
"""Seconds after which a worker that says nothing is killed; its statement counts as slow."""

WIDTH = 160
"""Of the tables, in a file too."""

FINDINGS = (Mark.WRONG, Mark.ERROR, Mark.SLOW)

Kinds = tuple[str, ...]


def placed(kinds: Kinds, number: int) -> tuple[str, int]:
    """Return the kind and the index of the statement of this number: the kinds take turns."""
    return kinds[number % len(kinds)], number // len(kinds)


def judged_at(kinds: Kinds, seed: int, number: int) -> Judgement:
    """Return the judgement on the statement of this number."""
    kind, index = placed(kinds, number)
    return judged(kind, seed, index)


def search(
    kinds: Kinds, seed: int, count: int, workers: int, minutes: float, report: Progress
) -> list[Judgement]:
    """Return all judgements, from ``workers`` processes.

    That a process died at a statement, or said nothing for `PATIENCE`, is a judgement too. After
    ``minutes`` it ends with those that it has.
    """
    task = report.add_task("statements", total=count)
    found: list[Judgement] = []
    end = time.monotonic() + 60 * minutes
    jobs = (Job(judged_at, (kinds, seed, place), seconds=PATIENCE) for place in range(count))
    before_the_end = takewhile(lambda _: time.monotonic() < end, enumerate(jobs))
    for number, call in as_ended(before_the_end, LocalWorkers(workers)):
        if isinstance(call.error, OutOfTime):
            found.append(_abandoned(kinds, seed, number, f"nothing came back in {PATIENCE:g} s"))
        elif isinstance(call.error, LostProcess):
            found.append(_abandoned(kinds, seed, number, "the process died"))
        else:
            found.append(call.result())
        report.advance(task)
        if found[-1].mark in FINDINGS:
            report.console.print(_text(found[-1]), markup=False, highlight=False)
    return found


def _abandoned(kinds: Kinds, seed: int, number: int, words: str) -> Judgement:
    kind, index = placed(kinds, number)
    given = any_statement(kind, seed, index)
    return Judgement(given.kind, given.truth, seed, index, Mark.SLOW, words, PATIENCE)


def _text(judgement: Judgement) -> str:
    script = any_statement(kind_of(judgement), judgement.seed, judgement.index).script()
    return f"{judgement.mark.upper()}: {judgement.words}\n{script}\n"


def _within(judgement: Judgement) -> str:
    """Return two levels of the kind: "real: branch" and not which of them."""
    return ":".join(judgement.kind.split(":")[:2])


def table(found: list[Judgement], kind: str, seconds: float) -> Table:
    """Return the tallies by kind, or by what there is within one kind."""
    grid = Table(title=f"{len(found)} statements in {seconds / 60:.1f} min")
    for place, heading in enumerate(HEADINGS):
        grid.add_column(heading, justify="right" if place else "left")
    for tally in tallies(found, kind_of if kind == "all" else _within):
        grid.add_row(*tally.cells())
    return grid


def reasons(found: list[Judgement]) -> Table:
    """Return the reasons of undecided verdicts, the most frequent first."""
    counts: dict[tuple[str, str], list[int]] = {}
    for judgement in found:
        if judgement.mark is Mark.UNDECIDED:
            last = judgement.words.rpartition("; then: ")[2]
            counts.setdefault((judgement.kind, last[:100]), []).append(judgement.index)
    grid = Table("count", "kind", "reason", "first", title="Undecided")
    for (kind, words), own in sorted(counts.items(), key=lambda item: -len(item[1]))[:40]:
        grid.add_row(str(len(own)), kind, words, str(min(own)))
    return grid


def main() -> int:
    """Read the options, search, print; 1 if there is a finding."""
    parser = argparse.ArgumentParser(description="The search for wrong verdicts.")
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--minutes", type=float, default=600.0, help="where it stops, done or not")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--kind", choices=(*SEARCH_KINDS, "all"), default="all")
    parser.add_argument("--undecided", action="store_true", help="why so many were undecided")
    options = parser.parse_args()
    console, start = Console(width=WIDTH), time.monotonic()
    with Progress(console=console) as report:
        kinds = SEARCH_KINDS if options.kind == "all" else (options.kind,)
        found = search(kinds, options.seed, options.count, options.workers, options.minutes, report)
    console.print(table(found, options.kind, time.monotonic() - start))
    console.print(f"digest {digest(found)}")
    if options.undecided:
        console.print(reasons(found))
    return int(any(judgement.mark in FINDINGS for judgement in found))


if __name__ == "__main__":
    sys.exit(main())
