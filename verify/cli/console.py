"""What the subcommands share: options, tables, progress, and how long a request will take.

The laws of the rational family were measured in processor seconds on one core of a 3 GHz server:
orders 7 to 12 for proofs, 4 to 8 for stable forms, 4 to 7 for the rest.  Beyond, they are orders
of magnitude.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

from rich.console import Console
from rich.progress import track

from derive.command_line import OneLineParser, fail
from solutions.catalogue import CATALOGUE
from verify.proof.catalogue_proofs import higher_order

__all__ = [
    "OneLineParser",
    "add_only",
    "fail",
    "finished",
    "print_lines",
    "table_console",
    "tracked",
]

PIPE_WIDTH = 120
"""Columns of a table where stdout is no terminal."""

T = TypeVar("T")


def add_only(parser: OneLineParser) -> None:
    """Add ``--only NAME``, which may be repeated."""
    parser.add_argument(
        "--only", action="append", metavar="NAME", help="take this form; may be repeated"
    )


def table_console() -> Console:
    """The console for tables: as wide as the terminal, and wide enough for one row in a pipe."""
    console = Console()
    return console if console.is_terminal else Console(width=PIPE_WIDTH)


def tracked(items: Iterable[T], count: int, words: str) -> Iterator[T]:
    """``items`` as they come, with a progress bar on stderr if that is a terminal."""
    console = Console(stderr=True)
    off = not console.is_terminal
    yield from track(items, words, count, console=console, transient=True, disable=off)


def finished(items: Iterable[T]) -> tuple[list[T], bool]:
    """The items that came until the end or until Ctrl-C, and whether it was the end."""
    found: list[T] = []
    try:
        for item in items:
            found.append(item)
    except KeyboardInterrupt:
        return found, False
    return found, True


def print_lines(console: Console, lines: Sequence[str]) -> None:
    """Print lines as they are, without markup and without breaking them."""
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)


@dataclass(frozen=True)
class TimeLaw:
    """``seconds`` for a form of the catalogue; ``rational`` at order 7, which grows as a power."""

    seconds: float
    rational: float
    exponent: float

    def total(self, names: Iterable[str]) -> float:
        """Seconds for all the forms; raises ValueError for a name that is none.

        >>> round(PROOF.total(["rational_2", "rational_14"]))
        19
        """
        return sum(self._one(higher_order(name)) for name in names)

    def _one(self, order: int | None) -> float:
        if order is None:
            return self.seconds
        return self.rational * (order / 7) ** self.exponent


PROOF = TimeLaw(0.2, 0.15, 7.0)
STABLE = TimeLaw(0.3, 1.5, 3.3)
RESIDUAL = TimeLaw(0.3, 1.0, 4.0)
MUTANTS = TimeLaw(35.0 / len(CATALOGUE), 29.0, 6.5)
