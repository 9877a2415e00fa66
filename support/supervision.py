"""A command that states limits runs in a process of its own; a small one watches and ends it.

Compiled code may hold Python's lock for minutes, and a process without memory can do nothing any
more, so neither can be relied upon to end itself. The small process reads what the command and all
that it has started have in memory, and kills them where they do not end themselves.
"""

from __future__ import annotations

import json
import os
import select
import signal
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NoReturn

OPTIONS = ("--max-time", "--max-memory")
"""Options that state limits."""

OVERDUE = 2
"""Exit status of a command beyond its limits."""

TOO_LARGE = signal.SIGUSR1
"""Signal that ends a command which has too much memory."""

LOOK, SHARE = 0.02, 0.1
"""Seconds between two looks at a command, and the largest share of them that looking may take."""

PATIENCE = 1.75
"""Seconds after a limit from which on the command is killed; it has 1.5 to end itself."""

BESIDE, FLOOR, LATE = 5e7, 3.2e8, 5e7
"""Bytes that a command may have beyond its limit, those it may have in any case, and those that it
may take before it is killed while it ends."""

_told: int | None = None


def supervised(argv: Sequence[str], work: Callable[[], int]) -> int:
    """Return what ``work`` returns, done in a watched process if the words state limits.

    What calls this goes on in the watched process alone. `tell` is how that says its limits.
    """
    stated = any(word.partition("=")[0] in OPTIONS for word in argv)
    if not stated or not hasattr(os, "fork") or threading.active_count() > 1:
        return work()
    reading, telling = os.pipe()
    ending, living = os.pipe()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, (signal.SIGINT, signal.SIGTERM))
    command = os.fork()
    if command:
        os.close(telling)
        os.close(ending)
        for number in (signal.SIGINT, signal.SIGTERM):
            if signal.getsignal(number) != signal.SIG_IGN:
                signal.signal(number, lambda number, _: _send(command, number))
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        _Supervisor(command, reading).watch()
    os.close(reading)
    os.close(living)
    _begin_telling(telling)
    threading.Thread(target=_end_with, args=(ending,), daemon=True).start()
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return work()


def tell(**facts: Any) -> None:
    """Tell the watching process, if there is one, what `_Supervisor` keeps."""
    if _told is not None:
        with suppress(OSError):
            os.write(_told, json.dumps(facts).encode() + b"\n")


def _begin_telling(pipe: int) -> None:
    global _told
    os.set_blocking(pipe, False)
    _told = pipe


def _leave_to_command() -> None:
    """In a fork of the command: it has nothing to tell."""
    global _told
    _told = None


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_leave_to_command)


def _end_with(pipe: int) -> None:
    """In a thread of the command: end as SIGTERM does when the watching process has gone."""
    os.read(pipe, 1)
    _send(os.getpid(), signal.SIGTERM)


class _Supervisor:
    """What is known of a command: what it is called by, its limits, and what it keeps."""

    def __init__(self, command: int, pipe: int) -> None:
        self._command, self._pipe, self._rest = command, pipe, b""
        self.called = self.kept = self.time_limit = self.memory_limit = ""
        self.end = self.memory = float("inf")
        self.keeping, self.said = 0.0, False
        self._since: float | None = None

    def watch(self) -> NoReturn:
        """Watch the command until it has ended, and end with its exit status."""
        while True:
            ended, status = os.waitpid(self._command, os.WNOHANG)
            if ended:
                self._leave(status)
            begun = time.monotonic()
            self._look(begun)
            wait = max(LOOK, (time.monotonic() - begun) / SHARE)
            if select.select([self._pipe], [], [], wait)[0] and not self._read():
                time.sleep(LOOK / 10)  # it is ending

    def _read(self) -> bool:
        """Take in what the command tells; return whether there may be more."""
        found = os.read(self._pipe, 1 << 16)
        *lines, self._rest = (self._rest + found).split(b"\n")
        for line in lines:
            vars(self).update(json.loads(line))
        return bool(found)

    def _look(self, now: float) -> None:
        """End the command if it is beyond a limit."""
        if now > self.end + self.keeping + PATIENCE:
            self._kill(self.time_limit)
        if self.memory == float("inf"):
            return
        allowed = max(self.memory + BESIDE, FLOOR)
        used = memory_in_use(self._command, allowed)
        if used > allowed and self._since is None:
            self._since = now
            _send(self._command, TOO_LARGE)
        late = self._since is not None and now > self._since + self.keeping + PATIENCE
        if late or used > allowed + LATE:
            self._kill(self.memory_limit)

    def _kill(self, limit: str) -> NoReturn:
        """Kill the command with all that it has started, and say why in one line."""
        for process in processes_of(self._command):
            _send(process, signal.SIGKILL)
        _, status = os.waitpid(self._command, 0)
        while select.select([self._pipe], [], [], 0.0)[0] and self._read():
            pass
        if os.WIFEXITED(status):  # it was faster
            self._leave(status)
        self._say(limit)

    def _say(self, limit: str) -> NoReturn:
        """Say why the command was ended, unless it has, and end."""
        if self.said:
            os._exit(OVERDUE)
        shown = "\x1b[?25h" if os.isatty(2) else ""
        kept = f" ({self.kept})" if self.kept else ""
        os.write(2, f"{shown}error: {self.called} {limit}{kept}\n".encode())
        os._exit(OVERDUE)

    def _leave(self, status: int) -> NoReturn:
        """End as the command has ended."""
        if os.WIFEXITED(status):
            os._exit(os.WEXITSTATUS(status))
        number = os.WTERMSIG(status)
        if number == signal.SIGABRT and self.memory_limit:
            self._say(self.memory_limit)  # libraries abort that get no memory
        if number != signal.SIGKILL:
            signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
        os._exit(128 + number)


def _send(process: int, number: int) -> None:
    with suppress(ProcessLookupError, PermissionError):
        os.kill(process, number)


def processes_of(leader: int) -> list[int]:
    """Return a process and all that it has started, where the system can say."""
    found = [leader]
    for process in found:
        with suppress(OSError):
            for task in os.listdir(f"/proc/{process}/task"):
                with suppress(OSError):
                    text = Path(f"/proc/{process}/task/{task}/children").read_text(encoding="ascii")
                    found += map(int, text.split())
    return found


def memory_in_use(leader: int, enough: float = 0.0) -> int:
    """Return the bytes of private memory that a process and all that it has started have in use.

    Pages that several of them share count once, unless all together have less than ``enough``.
    """
    processes = processes_of(leader)
    used = sum(
        _kilobytes(f"/proc/{process}/status", ("RssAnon:", "VmSwap:")) for process in processes
    )
    if used * 1024 <= enough or len(processes) == 1:
        return used * 1024
    shared = ("Pss_Anon:", "SwapPss:")
    return 1024 * sum(_kilobytes(f"/proc/{process}/smaps_rollup", shared) for process in processes)


def _kilobytes(path: str, names: tuple[str, ...]) -> int:
    """Return the sum of the named fields of a file of the system, 0 if it is gone."""
    with suppress(OSError):
        lines = Path(path).read_text(encoding="ascii", errors="replace").splitlines()
        return sum(int(line.split()[1]) for line in lines if line.startswith(names))
    return 0
