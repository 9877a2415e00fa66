"""How long work takes: told before it begins, and now and then how much time is left."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event, Thread

from longwave.support.request_limits import LONG, duration

EVERY = 30.0
"""Seconds after which a command that has not said a word says how far it is."""

LOOK = 0.1
"""Seconds between two looks at whether they have passed."""

LITTLE = 1e-3
"""Share of the work from which on its pace is known."""

Clock = Callable[[], float]

_notices = 0


def count_notice() -> None:
    """Count that the running command has said how long it takes, or shows how far it is."""
    global _notices
    _notices += 1


def give_notice(work: str, takes: str) -> None:
    """Say on stderr how long ``work`` takes."""
    count_notice()
    print(f"{work}: {takes} (Ctrl-C stops it)", file=sys.stderr, flush=True)


def announce(work: str, seconds: float) -> None:
    """Say on stderr, before it begins, how long ``work`` will take, if that is ``LONG`` or more.

    >>> announce("rational_9", 0.5)
    """
    if seconds >= LONG:
        give_notice(work, f"about {duration(seconds)}")


@dataclass
class TimeLeft:
    """How much time work has left, by what was foreseen and by the pace of what is done.

    >>> seconds = iter([0.0, 0.0, 10.0, 10.0]).__next__
    >>> work = TimeLeft(seconds)
    >>> work.share(0.0); work.share(0.5); work.words()
    '50 %, about 10 s left'
    """

    clock: Clock = time.monotonic
    begun: float = field(init=False)

    def __post_init__(self) -> None:
        self.begun = self.clock()
        self._end: float | None = None
        self._first: tuple[float, float] | None = None
        self._done, self._pace = 0.0, 0.0

    def foresee(self, seconds: float) -> None:
        """Take in that so many seconds are expected from now on."""
        self._end = self.clock() + seconds

    def share(self, done: float) -> None:
        """Take in which share is done; what was done before this process has no pace."""
        now = self.clock()
        self._first = self._first or (now, done)
        self._done = done
        if done > self._first[1] + LITTLE:
            self._pace = (now - self._first[0]) / (done - self._first[1])

    def words(self) -> str:
        """The share and the time left; how long it has been at work if nobody knows."""
        now = self.clock()
        by_pace = self._pace * (1.0 - self._done)
        foreseen = max(0.0, self._end - now) if self._end is not None else 0.0
        if not by_pace and not foreseen:
            return f"{duration(now - self.begun)} so far"
        if not (by_pace and foreseen):
            left = by_pace or foreseen
        else:
            left = foreseen ** (1.0 - self._done) * by_pace**self._done
        percent = f"{100.0 * self._done:.0f} %, " if self._done else ""
        return f"{percent}about {duration(left)} left"


@contextmanager
def time_told(work: str, clock: Clock = time.monotonic) -> Iterator[TimeLeft]:
    """Say of the ``work`` in the body how much time is left, where `EVERY` passes without a word.

    A thread looks at the ``clock``: what is slow may not come to tell its progress.
    """
    left, over = TimeLeft(clock), Event()

    def watch() -> None:
        seen, last = _notices, left.begun
        while not over.wait(LOOK):
            if _notices == seen and clock() >= last + EVERY:
                give_notice(work, left.words())
            if _notices != seen:
                seen, last = _notices, clock()

    Thread(target=watch, daemon=True).start()
    try:
        yield left
    finally:
        over.set()
