"""What the subcommands share: tables, progress, and Ctrl-C between two items."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeVar

from rich.console import Console
from rich.progress import track

PIPE_WIDTH = 120
"""Columns of a table where stdout is no terminal."""

T = TypeVar("T")


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
