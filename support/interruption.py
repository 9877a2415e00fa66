"""Ctrl-C ends a command in one line within two seconds, whatever the command is doing.

The first Ctrl-C is a KeyboardInterrupt, from which a command unwinds and tells what it keeps. One
that is in compiled code, waits for workers or has lost the interrupt in a finalizer is ended by a
watching thread, which the signal wakes without Python's help. A second Ctrl-C ends it at once.

SIGTERM, by which schedulers of clusters end their jobs, does the same to a command's process, and
so does SIGALRM, when the time of `ended_after` is over. A command that states limits is watched
from another process as well (`supervision`), which is told here what there is to say of it.
"""

from __future__ import annotations

import atexit
import math
import os
import signal
import sys
import threading
import time
from collections import namedtuple
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import NoReturn

from longwave.support.supervision import OVERDUE, TOO_LARGE, supervised, tell
from longwave.support.user_files import on_one_line

ENDING = signal.SIGINT, signal.SIGTERM, signal.SIGALRM, TOO_LARGE
"""What Ctrl-C sends, what a scheduler does, what a timer does, and what a full memory does."""

SIGNALLED = 128
"""Exit status after a signal, less its number."""

INTERRUPTED = SIGNALLED + signal.SIGINT
"""That after Ctrl-C."""

LONGEST_TIMER = 1e7
"""Seconds from which on no timer is set."""

PATIENCE = 1.5
"""Seconds in which a command may end by itself."""

KEEPING = 15.0
"""Seconds more in which it may write what is finished, where it does."""

SAME_PRESS = 0.3
"""Seconds in which a second signal is taken for the first: some programs pass on what a terminal
has sent already."""

LOOK = 0.05
"""Seconds between two looks at whether the time is over."""

SHOW_CURSOR = "\x1b[?25h"


class _Watch:
    """A running command: what it is called by, what it keeps, and since when it is to end."""

    def __init__(self, called: str) -> None:
        self.called, self.kept, self.limit, self.memory_limit = called, "", "", ""
        self.since: float | None = None
        self.status = INTERRUPTED
        self.patience = PATIENCE
        self.told = self.over = self.left = False

    def press(self, number: int, *_: object) -> None:
        """The handler of a signal: interrupt the main thread, or end if that was done before."""
        now = time.monotonic()
        if self.over or (self.since is not None and now > self.since + SAME_PRESS):
            self.end()
        if self.since is None:
            overdue = number in (signal.SIGALRM, TOO_LARGE)
            self.since, self.status = now, OVERDUE if overdue else SIGNALLED + number
            self.limit = self.memory_limit if number == TOO_LARGE else self.limit
            raise KeyboardInterrupt

    def watch(self, reading: int) -> None:
        """In a thread: end the command a while after the signal's number has come."""
        byte = os.read(reading, 1)
        while byte and byte[0] not in ENDING:  # of another handler
            byte = os.read(reading, 1)
        begun = time.monotonic()
        while byte and not self.left:
            if time.monotonic() > begun + self.patience:
                self.end()
            time.sleep(LOOK)
        os.close(reading)

    def tell(self, kept: str) -> None:
        """Say in one line that the command was interrupted, once."""
        if not self.told:
            self.told = True
            tell(said=True)
            print(self._line(kept), file=sys.stderr, flush=True)

    def _line(self, kept: str) -> str:
        """Return the line that says why the command ended, with what is ``kept``."""
        if self.status == OVERDUE:
            return f"error: {self.called} {self.limit}{kept}"
        return f"{self.called}: interrupted{kept}"

    def end(self) -> NoReturn:
        """End the process here and now, its workers too."""
        with suppress(Exception):
            processes = sys.modules.get("multiprocessing")
            for child in processes.active_children() if processes else ():
                child.kill()
        if self.told:
            time.sleep(LOOK)  # the line may be on its way
        else:
            shown = SHOW_CURSOR if os.isatty(2) else ""
            kept = f" ({self.kept})" if self.kept else ""
            tell(said=True)
            os.write(2, f"{shown}{self._line(kept)}\n".encode())
        os._exit(self.status)


_watch: _Watch | None = None


def interruptible(called: str, work: Callable[[], int], whole_process: bool) -> int:
    """What ``work`` returns, an exit status; 130 after Ctrl-C, 143 after SIGTERM, told in one line.

    ``called`` is what the command is called by. With ``whole_process`` there is nothing but the
    command, and the signals stay in these hands until the process has ended. Inside another one
    SIGTERM is left to that; where a signal is ignored, this only tells.
    """
    if whole_process and _watch is None:
        return supervised(sys.argv[1:], lambda: _interruptible(called, work, whole_process))
    return _interruptible(called, work, whole_process)


def _interruptible(called: str, work: Callable[[], int], whole_process: bool) -> int:
    main = threading.current_thread() is threading.main_thread()
    numbers = [
        number
        for number in ENDING[: len(ENDING) if whole_process else 1]
        if signal.getsignal(number) not in (signal.SIG_IGN, None)
    ]
    if _watch is not None or not main or not numbers:
        return _told(called, work)

    def watched() -> int:
        with _watched(_Watch(called), whole_process, numbers):
            return _told(called, work)

    return _told(called, watched)


def _told(called: str, work: Callable[[], int]) -> int:
    try:
        return work()
    except BaseException as error:
        if not (isinstance(error, KeyboardInterrupt) or was_interrupted()):
            raise  # an interrupted import raises whatever it likes
        return interrupted(called)
    finally:
        # CPython remembers that a source it ran, as `python -c` does, was interrupted, and ends by
        # the signal and not with the status, until it has run another: namedtuple runs one.
        namedtuple("Forget", ())


@contextmanager
def _watched(watch: _Watch, whole_process: bool, numbers: Sequence[int]) -> Iterator[None]:
    global _watch
    handlers = {number: signal.signal(number, watch.press) for number in numbers}
    reading, writing = os.pipe()
    os.set_blocking(writing, False)
    threading.Thread(target=watch.watch, args=(reading,), daemon=True).start()
    if whole_process:
        atexit.register(_ignore_from_here)
    _watch, hook = watch, sys.unraisablehook
    sys.unraisablehook = lambda lost: None if watch.since else hook(lost)
    woken = signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    try:
        yield
    finally:
        watch.over = whole_process
        if not whole_process:
            signal.set_wakeup_fd(woken)
            for number, handler in handlers.items():
                signal.signal(number, handler)
            _watch, sys.unraisablehook, watch.left = None, hook, True
            os.close(writing)


def owns_process() -> bool:
    """Whether the process is a command's own, as `interruptible` was told."""
    return _watch is not None and signal.getsignal(signal.SIGALRM) == _watch.press


@contextmanager
def ended_after(seconds: float, limit: str) -> Iterator[None]:
    """End the command as Ctrl-C does if the body takes longer; its line tells the ``limit``.

    Only where the command `owns_process`.
    """
    if _watch is None or not owns_process() or seconds > LONGEST_TIMER:
        yield
        return
    _watch.limit = limit
    signal.setitimer(signal.ITIMER_REAL, seconds)
    tell(end=time.monotonic() + seconds, time_limit=limit)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        if _watch.since is None:
            tell(end=math.inf)


@contextmanager
def ended_beyond(size: float, limit: str) -> Iterator[None]:
    """End the command where it has more than ``size`` bytes, all its processes together.

    Only where the command `owns_process`, and is watched from another one.
    """
    if _watch is None or not owns_process() or math.isinf(size):
        yield
        return
    _watch.memory_limit = limit
    tell(memory=size, memory_limit=limit)
    try:
        yield
    finally:
        if _watch.since is None:
            tell(memory=math.inf)


def stated_memory() -> str:
    """What the line says of a command beyond the memory that is stated; "" if none is."""
    return _watch.memory_limit if _watch is not None else ""


def _ignore_from_here() -> None:
    """The last step of a process that has done its work: it ends with its own status.

    Python forgets handlers as it ends, and the signal would kill it; one to ignore it leaves.
    """
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)


def _leave_to_parent() -> None:
    """In a forked process: it is the parent that is interrupted, and that ends its children."""
    global _watch
    if _watch is not None:
        _watch = None
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


def was_interrupted() -> bool:
    """Whether Ctrl-C has been pressed in this command."""
    return _watch is not None and _watch.since is not None


def call_it(called: str) -> None:
    """Say what the running command is called by, once that is known."""
    if _watch is not None:
        _watch.called = called
        tell(called=called)


def interrupted(called: str = "", kept: str = "") -> int:
    """Print one line on stderr after Ctrl-C, with what is ``kept``; return the exit status."""
    watch = _watch or _Watch(called)
    watch.called = called or watch.called
    watch.tell(f" ({on_one_line(kept)})" if kept else "")
    return watch.status


def will_keep(kept: str) -> None:
    """Say what of the work there is by now, for the line that ends it from outside."""
    if _watch is not None:
        _watch.kept = on_one_line(kept)
        tell(kept=_watch.kept)


@contextmanager
def keeping() -> Iterator[None]:
    """In the body, what is finished is written: after Ctrl-C there is time for it."""
    if _watch is None:
        yield
        return
    _watch.patience += KEEPING
    tell(keeping=_watch.patience - PATIENCE)
    try:
        yield
    finally:
        if _watch is not None:
            _watch.patience -= KEEPING
            tell(keeping=_watch.patience - PATIENCE)
