"""Work of which nobody knows how long it takes says that it goes on: no screen stays silent."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

SILENT = 4.0
"""Seconds that a command may work without a word."""

_spoken = threading.Event()


def spoke() -> None:
    """Say that the running command has told that it takes long, or shows how far it is."""
    _spoken.set()


def say_open_end(work: str) -> None:
    """Say on stderr that nobody knows how long ``work`` will take."""
    spoke()
    print(f"{work}: takes more than some seconds (Ctrl-C stops it)", file=sys.stderr, flush=True)


@contextmanager
def speaking_up(called: str) -> Iterator[None]:
    """Say it of a command, by what it is called by, that was silent in the body for so long."""
    _spoken.clear()
    threading.Thread(target=_listen, args=(called,), daemon=True).start()
    try:
        yield
    finally:
        spoke()


def _listen(called: str) -> None:
    if not _spoken.wait(SILENT):
        say_open_end(called)
