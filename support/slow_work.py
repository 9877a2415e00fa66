"""Reports about slow work: its duration before it begins, and the time left now and then."""

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from threading import Event, Thread

from longwave.support.request_limits import LONG, duration

EVERY = 30.0
"""Seconds of silence after which a command reports its progress."""

CHECK_INTERVAL = 0.1
"""Seconds between two checks whether the command has been silent."""

MIN_PACE_FRACTION = 1e-3
"""Least fraction of the work that must be done before the pace is estimated."""

Clock = Callable[[], float]

_notices = 0


def count_notice() -> None:
    """Record that the running command has reported its duration or progress."""
    global _notices
    _notices += 1


def give_notice(work: str, takes: str) -> None:
    """Print on stderr how long ``work`` takes, given as the text ``takes``."""
    count_notice()
    print(f"{work}: {takes} (Ctrl-C stops it)", file=sys.stderr, flush=True)


def announce(work: str, seconds: float) -> None:
    """Print on stderr how long ``work`` will take, if that is ``LONG`` or more.

    >>> announce("rational_9", 0.5)
    """
    if seconds >= LONG:
        give_notice(work, f"about {duration(seconds)}")


@dataclass
class TimeLeft:
    """Estimate of the time left, from the expected duration and the pace so far.

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
        """Set the seconds that the work is expected to take from now on."""
        self._end = self.clock() + seconds

    def share(self, done: float) -> None:
        """Set the fraction done; the pace is measured from the first call on."""
        now = self.clock()
        self._first = self._first or (now, done)
        self._done = done
        if done > self._first[1] + MIN_PACE_FRACTION:
            self._pace = (now - self._first[0]) / (done - self._first[1])

    def words(self) -> str:
        """Return as text the fraction done and the time left, or else the time so far."""
        now = self.clock()
        by_pace = self._pace * (1.0 - self._done)
        foreseen = max(0.0, self._end - now) if self._end is not None else 0.0
        if not by_pace and not foreseen:
            return f"{duration(now - self.begun)} so far"
        if not (by_pace and foreseen):
            seconds_left = by_pace or foreseen
        else:
            seconds_left = foreseen ** (1.0 - self._done) * by_pace**self._done
        percent = f"{100.0 * self._done:.0f} %, " if self._done else ""
        return f"{percent}about {duration(seconds_left)} left"


@contextmanager
def report_time_left(work: str, clock: Clock = time.monotonic) -> Iterator[TimeLeft]:
    """Report the time left, in the block, after each `EVERY` seconds of silence."""
    left, over = TimeLeft(clock), Event()

    def watch() -> None:
        counted, last = _notices, left.begun
        while not over.wait(CHECK_INTERVAL):
            if _notices == counted and clock() >= last + EVERY:
                give_notice(work, left.words())
            if _notices != counted:
                counted, last = _notices, clock()

    Thread(target=watch, daemon=True).start()
    try:
        yield left
    finally:
        over.set()
