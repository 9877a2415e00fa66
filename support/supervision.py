"""Supervision: a command with stated limits runs in a child process, which a small parent watches.

Compiled code may hold Python's lock for minutes, and a process without memory can do nothing, so
neither can be relied on to end itself. The parent measures the memory of the command and its
children, and kills them if they do not end themselves.
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
"""Options by which the user states limits."""

OVERDUE = 2
"""Exit status of a command that exceeded its limits."""

TOO_LARGE = signal.SIGUSR1
"""Signal that ends a command with too much memory."""

CHECK_INTERVAL, MAX_CHECK_FRACTION = 0.02, 0.1
"""Seconds between two checks of a command, and the largest fraction of time spent on checks."""

PATIENCE = 1.75
"""Seconds after exceeding a limit at which a command is killed; in the first 1.5 s it may end
itself."""

EXTRA_BYTES, MIN_BYTES, ENDING_BYTES = 5e7, 3.2e8, 5e7
"""Bytes allowed beyond a command's limit, bytes allowed in any case, and bytes that a command may
still take while it ends."""

_pipe: int | None = None


def supervised(argv: Sequence[str], work: Callable[[], int]) -> int:
    """Return ``work()``. If ``argv`` states limits, call it in a child process that is watched.

    In that case only the child returns; this process exits with the child's status.
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
    _tell_through(telling)
    threading.Thread(target=_end_with, args=(ending,), daemon=True).start()
    signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return work()


def tell(**facts: Any) -> None:
    """Send ``facts``, attributes of `_Supervisor`, to the watching process, if there is one."""
    if _pipe is not None:
        with suppress(OSError):
            os.write(_pipe, json.dumps(facts).encode() + b"\n")


def _tell_through(pipe: int | None = None) -> None:
    """Let `tell` send facts through this pipe; with None, as in a fork, it sends nothing."""
    global _pipe
    if pipe is not None:
        os.set_blocking(pipe, False)
    _pipe = pipe


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_tell_through)


def _end_with(pipe: int) -> None:
    """Run in a thread of the command: end the command if the watching process is gone."""
    os.read(pipe, 1)
    _send(os.getpid(), signal.SIGTERM)


class _Supervisor:
    """Watcher of a command; its attributes are told by the command: name, limits, saved work."""

    def __init__(self, command: int, pipe: int) -> None:
        self._command, self._pipe, self._rest = command, pipe, b""
        self.name = self.saved = self.time_limit = self.memory_limit = ""
        self.end = self.memory = float("inf")
        self.saving, self.is_reported = 0.0, False
        self._since: float | None = None

    def watch(self) -> NoReturn:
        """Watch the command until it has ended, and exit with its status."""
        while True:
            ended, status = os.waitpid(self._command, os.WNOHANG)
            if ended:
                self._leave(status)
            started = time.monotonic()
            self._look(started)
            wait = max(CHECK_INTERVAL, (time.monotonic() - started) / MAX_CHECK_FRACTION)
            if select.select([self._pipe], [], [], wait)[0] and not self._read():
                time.sleep(CHECK_INTERVAL / 10)  # it is ending

    def _read(self) -> bool:
        """Read facts from the command; return whether there may be more."""
        data = os.read(self._pipe, 1 << 16)
        *lines, self._rest = (self._rest + data).split(b"\n")
        for line in lines:
            vars(self).update(json.loads(line))
        return bool(data)

    def _look(self, now: float) -> None:
        """End the command if it exceeds a limit at the time ``now``."""
        if now > self.end + self.saving + PATIENCE:
            self._kill(self.time_limit)
        if self.memory == float("inf"):
            return
        allowed = max(self.memory + EXTRA_BYTES, MIN_BYTES)
        used = memory_in_use(self._command, allowed)
        if used > allowed and self._since is None:
            self._since = now
            _send(self._command, TOO_LARGE)
        late = self._since is not None and now > self._since + self.saving + PATIENCE
        if late or used > allowed + ENDING_BYTES:
            self._kill(self.memory_limit)

    def _kill(self, limit: str) -> NoReturn:
        """Kill the command and its children, and report the exceeded ``limit`` in one line."""
        for process in processes_of(self._command):
            _send(process, signal.SIGKILL)
        _, status = os.waitpid(self._command, 0)
        while select.select([self._pipe], [], [], 0.0)[0] and self._read():
            pass
        if os.WIFEXITED(status):  # it ended before it was killed
            self._leave(status)
        self._say(limit)

    def _say(self, limit: str) -> NoReturn:
        """Report the exceeded ``limit``, unless the command has reported it, and exit."""
        if self.is_reported:
            os._exit(OVERDUE)
        cursor = "\x1b[?25h" if os.isatty(2) else ""
        saved = f" ({self.saved})" if self.saved else ""
        os.write(2, f"{cursor}error: {self.name} {limit}{saved}\n".encode())
        os._exit(OVERDUE)

    def _leave(self, status: int) -> NoReturn:
        """Exit with the status of the command."""
        if os.WIFEXITED(status):
            os._exit(os.WEXITSTATUS(status))
        number = os.WTERMSIG(status)
        if number == signal.SIGABRT and self.memory_limit:
            self._say(self.memory_limit)  # some libraries abort if they get no memory
        if number != signal.SIGKILL:
            signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
        os._exit(128 + number)


def _send(process: int, number: int) -> None:
    """Send a signal to a process, if it still exists."""
    with suppress(ProcessLookupError, PermissionError):
        os.kill(process, number)


def processes_of(leader: int) -> list[int]:
    """Return a process and all its descendants, where the system lists them."""
    processes = [leader]
    for process in processes:
        with suppress(OSError):
            for task in os.listdir(f"/proc/{process}/task"):
                with suppress(OSError):
                    text = Path(f"/proc/{process}/task/{task}/children").read_text(encoding="ascii")
                    processes += map(int, text.split())
    return processes


def memory_in_use(leader: int, enough: float = 0.0) -> int:
    """Return the bytes of private memory that a process and its descendants use.

    Shared pages count once. They are not looked for if the total that counts them repeatedly is at
    most ``enough``.
    """
    processes = processes_of(leader)
    used = sum(_kilobytes(f"/proc/{p}/status", ("RssAnon:", "VmSwap:")) for p in processes)
    if used * 1024 <= enough or len(processes) == 1:
        return used * 1024
    shared = ("Pss_Anon:", "SwapPss:")
    return 1024 * sum(_kilobytes(f"/proc/{process}/smaps_rollup", shared) for process in processes)


def _kilobytes(path: str, names: tuple[str, ...]) -> int:
    """Return the sum of the fields ``names`` of a /proc file, or 0 if the file is gone."""
    with suppress(OSError):
        lines = Path(path).read_text(encoding="ascii", errors="replace").splitlines()
        return sum(int(line.split()[1]) for line in lines if line.startswith(names))
    return 0
