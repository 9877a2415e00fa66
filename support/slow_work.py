"""The notice that work takes long: before it where its seconds are known, else while it runs."""

import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from longwave.support.request_limits import LONG, duration

SILENT = 4.0
"""Seconds that a command may work without a word."""

LOOK = 0.1
"""Seconds between two looks at whether they have passed."""

_notices = 0


def count_notice() -> None:
    """Count that the running command has said that it takes long, or shows how far it is."""
    global _notices
    _notices += 1


def give_notice(work: str, takes: str = "takes more than some seconds") -> None:
    """Say on stderr how long ``work`` takes; that nobody knows, unless told."""
    count_notice()
    print(f"{work}: {takes} (Ctrl-C stops it)", file=sys.stderr, flush=True)


def announce(work: str, seconds: float) -> None:
    """Say on stderr, before it begins, how long ``work`` will take, if that is ``LONG`` or more.

    >>> announce("rational_9", 0.5)
    """
    if seconds >= LONG:
        give_notice(work, f"about {duration(seconds)}")


@contextmanager
def notice_when_silent(
    work: str, after: float, clock: Callable[[], float] = time.monotonic
) -> Iterator[None]:
    """Say of the ``work`` in the body that it goes on, if ``after`` seconds pass without a notice.

    A thread looks at the ``clock``: what is slow may not come to tell its progress.
    """
    before, end, over = _notices, clock() + after, threading.Event()

    def watch() -> None:
        while not over.wait(LOOK) and _notices == before:
            if clock() > end:
                give_notice(work)

    threading.Thread(target=watch, daemon=True).start()
    try:
        yield
    finally:
        over.set()
