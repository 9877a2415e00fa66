"""A lock that is a file: held by one process at a time, and let go of when its process ends.

Where files cannot be locked (ENOLCK, ENOSYS, ..., or a lock that excludes nobody), work goes on
without: two processes may then do the same, which is told once.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from longwave.support.atomic_file import leads_to, not_stale
from longwave.support.sealed_file import LOG

try:
    import fcntl
except ImportError:
    fcntl = None  # type: ignore[assignment]

FLAGS = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)

TRIES = 1000
"""How often a lock is asked for whose holder has removed its file meanwhile."""

UNLOCKED = (
    "%s: files cannot be locked there (%s): two processes that want the same run may both make it; "
    "none is lost or half written"
)

_TOLD: set[int] = set()
"""The file systems of which that was told."""

_TRIED: set[int] = set()
"""Those of which it was tried whether a lock excludes another."""


@contextmanager
def locked(path: Path, wait: Callable[[], None] = lambda: None) -> Iterator[None]:
    """Hold the lock ``path`` in the body, and remove its file after it.

    ``wait`` is called before another holder is waited for. Where files cannot be locked, the body
    is run all the same. A link of that name, which nobody has typed, is removed. Raises OSError
    that names the file if it cannot be made.
    """
    number = _acquired(path, cache(wait))
    try:
        yield
    finally:
        with suppress(OSError):
            if leads_to(path, os.fstat(number)):  # else it is another holder's
                path.unlink()
        with suppress(OSError):
            os.close(number)


def _acquired(path: Path, wait: Callable[[], None]) -> int:
    """The number of the file, which is open, and locked if that can be."""
    for _ in range(TRIES):
        number = _opened(path)
        try:
            if _is_held(path, number, wait):
                return number
        except OSError as error:
            _tell(path.parent, error.strerror or str(error))
            return number
        except BaseException:
            os.close(number)
            raise
        os.close(number)
    number = _opened(path)
    _tell(path.parent, "the number of a file changes each time that it is looked at")
    return number


def _opened(path: Path) -> int:
    for _ in range(TRIES):
        try:
            return not_stale(lambda: os.open(path, FLAGS, 0o666))
        except OSError:
            if not path.is_symlink():
                raise
            LOG.warning("%s is a link: it is removed", path)
            path.unlink(missing_ok=True)
    raise OSError(errno.ELOOP, "is made a link each time that it is removed", str(path))


def _is_held(path: Path, number: int, wait: Callable[[], None]) -> bool:
    """Lock the open file; whether the path still leads to it: its holder may have removed it.

    Raises OSError where that cannot be.
    """
    if fcntl is None:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS))
    try:
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            wait()
            fcntl.flock(number, fcntl.LOCK_EX)
        file = os.fstat(number)
    except OSError as error:
        if error.errno == errno.ESTALE:  # removed from another host
            return False
        raise
    if not leads_to(path, file):
        return False
    if file.st_dev not in _TRIED:
        _TRIED.add(file.st_dev)
        _check_that_it_excludes(path)
    return True


def _check_that_it_excludes(path: Path) -> None:
    """Raise OSError if a file that is locked can be locked, or removed, by another."""
    with suppress(FileNotFoundError):
        number = not_stale(lambda: os.open(path, FLAGS & ~os.O_CREAT))
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return
        finally:
            os.close(number)
    raise OSError(errno.ENOLCK, "a lock there excludes nobody")


def _tell(folder: Path, reason: str) -> None:
    """Tell once of each file system why nothing is locked there."""
    device = os.stat(folder).st_dev
    if device not in _TOLD:
        _TOLD.add(device)
        LOG.warning(UNLOCKED, folder, reason)
