"""Ctrl-C ends a command with one line within two seconds, whatever it is doing.

The first Ctrl-C is a KeyboardInterrupt, from which the command unwinds and reports what it saves. A
command that is in compiled code, waits for workers or lost the interrupt in a finalizer is ended by
a watcher thread, which the signal wakes without Python's help. A second Ctrl-C ends it at once.

SIGTERM, by which cluster schedulers end jobs, does the same to a command's process, and so does
SIGALRM after the time of `ended_after`. A command with stated limits is also watched by another
process (`supervision`), which is told what to report.
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
"""Signals that end a command: Ctrl-C, a scheduler's, a timer's, and that for too much memory."""

SIGNALLED = 128
"""Number that is added to a signal's number to give the exit status after the signal."""

INTERRUPTED = SIGNALLED + signal.SIGINT
"""Exit status after Ctrl-C."""

LONGEST_TIMER = 1e7
"""Seconds above which no timer is set."""

PATIENCE = 1.5
"""Seconds that a command has to end by itself after a signal."""

SAVING_SECONDS = 15.0
"""Additional seconds that `keeping` allows for writing finished results."""

SAME_PRESS = 0.3
"""Seconds in which a second signal counts as the first one, forwarded by another program."""

CHECK_INTERVAL = 0.05
"""Seconds between two checks of the time."""

SHOW_CURSOR = "\x1b[?25h"


class _Watch:
    """State of a running command: its name, what it has saved, and when it began to end."""

    def __init__(self, name: str) -> None:
        self.name, self.saved, self.limit, self.memory_limit = name, "", "", ""
        self.since: float | None = None
        self.status = INTERRUPTED
        self.patience = PATIENCE
        self.is_reported = self.over = self.left = False

    def press(self, number: int, *_: object) -> None:
        """Handle a signal: interrupt the main thread; on a second signal, end the process."""
        now = time.monotonic()
        if self.over or (self.since is not None and now > self.since + SAME_PRESS):
            self.end()
        if self.since is None:
            overdue = number in (signal.SIGALRM, TOO_LARGE)
            self.since, self.status = now, OVERDUE if overdue else SIGNALLED + number
            self.limit = self.memory_limit if number == TOO_LARGE else self.limit
            raise KeyboardInterrupt

    def watch(self, reading: int) -> None:
        """Run in a thread: some time after the pipe receives a signal's number, end the process."""
        byte = os.read(reading, 1)
        while byte and byte[0] not in ENDING:  # another handler's signal
            byte = os.read(reading, 1)
        started = time.monotonic()
        while byte and not self.left:
            if time.monotonic() > started + self.patience:
                self.end()
            time.sleep(CHECK_INTERVAL)
        os.close(reading)

    def tell(self, saved: str) -> None:
        """Report in one line, once, that the command was interrupted."""
        if not self.is_reported:
            self.is_reported = True
            tell(is_reported=True)
            print(self._line(saved), file=sys.stderr, flush=True)

    def _line(self, saved: str) -> str:
        """Return the line that says why the command ended, with the text ``saved`` at its end."""
        if self.status == OVERDUE:
            return f"error: {self.name} {self.limit}{saved}"
        return f"{self.name}: interrupted{saved}"

    def end(self) -> NoReturn:
        """End the process and its workers immediately."""
        with suppress(Exception):
            processes = sys.modules.get("multiprocessing")
            for child in processes.active_children() if processes else ():
                child.kill()
        if self.is_reported:
            time.sleep(CHECK_INTERVAL)  # the line may be on its way
        else:
            cursor = SHOW_CURSOR if os.isatty(2) else ""
            saved = f" ({self.saved})" if self.saved else ""
            tell(is_reported=True)
            os.write(2, f"{cursor}{self._line(saved)}\n".encode())
        os._exit(self.status)


_watch: _Watch | None = None


def interruptible(name: str, work: Callable[[], int], whole_process: bool) -> int:
    """Run ``work`` and return its exit status; 130 after Ctrl-C, 143 after SIGTERM, with one line.

    ``name`` is the command's name. With ``whole_process`` the command is all that the process does,
    and the signals are handled until the process has ended. Otherwise SIGTERM is left to the
    caller; ignored signals stay ignored.
    """
    if whole_process and _watch is None:
        return supervised(sys.argv[1:], lambda: _interruptible(name, work, whole_process))
    return _interruptible(name, work, whole_process)


def _interruptible(name: str, work: Callable[[], int], whole_process: bool) -> int:
    """Run ``work`` with signal handlers, if this is the main thread and no command is running."""
    is_main = threading.current_thread() is threading.main_thread()
    numbers = [
        number
        for number in ENDING[: len(ENDING) if whole_process else 1]
        if signal.getsignal(number) not in (signal.SIG_IGN, None)
    ]
    if _watch is not None or not is_main or not numbers:
        return _run_reporting(name, work)

    def work_watched() -> int:
        with _watching(_Watch(name), whole_process, numbers):
            return _run_reporting(name, work)

    return _run_reporting(name, work_watched)


def _run_reporting(name: str, work: Callable[[], int]) -> int:
    """Run ``work``, and report an interruption in one line."""
    try:
        return work()
    except BaseException as error:
        if not (isinstance(error, KeyboardInterrupt) or was_interrupted()):
            raise  # an interrupted import raises whatever it likes
        return interrupted(name)
    finally:
        # CPython remembers that a source it ran, as `python -c` does, was interrupted, and ends by
        # the signal and not with the status, until it has run another: namedtuple runs one.
        namedtuple("Forget", ())


@contextmanager
def _watching(watch: _Watch, whole_process: bool, numbers: Sequence[int]) -> Iterator[None]:
    """Install handlers for the signals ``numbers``, and the watcher thread, for the block."""
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
    """Return whether the running command is all that this process does."""
    return _watch is not None and signal.getsignal(signal.SIGALRM) == _watch.press


@contextmanager
def ended_after(seconds: float, limit: str) -> Iterator[None]:
    """End a command that `owns_process` after ``seconds``, as Ctrl-C does, and print ``limit``."""
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
    """End a command that `owns_process` if it takes more than ``size`` bytes; print ``limit``."""
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
    """Return the text printed for a command beyond its memory limit; "" if none was stated."""
    return _watch.memory_limit if _watch is not None else ""


def _ignore_from_here() -> None:
    """Ignore signals while Python exits, so that the process ends with its own status."""
    for number in ENDING:
        signal.signal(number, signal.SIG_IGN)


def _leave_to_parent() -> None:
    """Reset the signal handlers in a forked process, which its parent ends."""
    global _watch
    if _watch is not None:
        _watch = None
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_parent)


def was_interrupted() -> bool:
    """Return whether Ctrl-C or another signal of `ENDING` has reached this command."""
    return _watch is not None and _watch.since is not None


def name_command(name: str) -> None:
    """Set the name of the running command, once it is known."""
    if _watch is not None:
        _watch.name = name
        tell(name=name)


def interrupted(name: str = "", saved: str = "") -> int:
    """Print the line for Ctrl-C, which mentions what was ``saved``; return the exit status."""
    watch = _watch or _Watch(name)
    watch.name = name or watch.name
    watch.tell(f" ({on_one_line(saved)})" if saved else "")
    return watch.status


def note_saved(saved: str) -> None:
    """Set the text that is printed about saved work if the command is ended."""
    if _watch is not None:
        _watch.saved = on_one_line(saved)
        tell(saved=_watch.saved)


@contextmanager
def keeping() -> Iterator[None]:
    """Allow the block additional time after Ctrl-C for writing finished results."""
    if _watch is None:
        yield
        return
    _watch.patience += SAVING_SECONDS
    tell(saving=_watch.patience - PATIENCE)
    try:
        yield
    finally:
        if _watch is not None:
            _watch.patience -= SAVING_SECONDS
            tell(saving=_watch.patience - PATIENCE)
