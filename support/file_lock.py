"""A lock that is a file: held by one process at a time, and let go of when its process ends."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # no such locks there: two processes may then do the same work, no more
    fcntl = None  # type: ignore[assignment]


@contextmanager
def locked(path: Path, wait: Callable[[], None] = lambda: None) -> Iterator[None]:
    """Hold the lock ``path`` in the body, and remove its file after it.

    ``wait`` is called before another holder is waited for. Raises OSError that names the file if it
    cannot be made, and for a link: nobody has typed its name.
    """
    number = _acquired(path, wait)
    try:
        yield
    finally:
        with suppress(OSError):
            path.unlink()
        os.close(number)


def _acquired(path: Path, wait: Callable[[], None]) -> int:
    """The number of the open file that is locked, and is the one that the path leads to."""
    told = False
    while True:
        flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
        number = os.open(path, flags | getattr(os, "O_NONBLOCK", 0), 0o666)
        try:
            if fcntl is not None:
                try:
                    fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
                except BlockingIOError:
                    if not told:
                        wait()
                    told = True
                    fcntl.flock(number, fcntl.LOCK_EX)
            if _leads_to(path, number):
                return number
        except BaseException:
            os.close(number)
            raise
        os.close(number)


def _leads_to(path: Path, number: int) -> bool:
    """Whether the path still leads to that file: its last holder may have removed it."""
    try:
        return os.path.samestat(path.stat(), os.fstat(number))
    except FileNotFoundError:
        return False
