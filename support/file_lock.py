"""File locks: held by one process at a time, and released when it ends.

Where files cannot be locked (ENOLCK, ENOSYS, ..., or a lock that excludes nobody), work continues
without: two processes may then do the same work, which is logged once.
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

MAX_TRIES = 1000
"""Largest number of attempts to get a lock whose holder keeps removing its file."""

UNLOCKED_MESSAGE = (
    "%s: files cannot be locked there (%s): two processes that want the same run may both make it; "
    "none is lost or half written"
)

_WARNED: set[int] = set()
"""Device numbers of file systems for which a warning was logged."""

_TESTED: set[int] = set()
"""Device numbers of file systems for which it was tested whether a lock excludes another."""


@contextmanager
def locked(path: Path, wait: Callable[[], None] = lambda: None) -> Iterator[None]:
    """Hold the lock file ``path`` in the block, and remove the file afterwards.

    ``wait`` is called before waiting for another holder. Where files cannot be locked, the block
    runs all the same. A symbolic link of that name, which no user typed, is removed. Raises OSError
    that names the file if it cannot be created.
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
    """Return the descriptor of the lock file, which is locked if its file system can lock files."""
    for _ in range(MAX_TRIES):
        number = _opened(path)
        try:
            if _try_lock(path, number, wait):
                return number
        except OSError as error:
            _warn_once(path.parent, error.strerror or str(error))
            return number
        except BaseException:
            os.close(number)
            raise
        os.close(number)
    number = _opened(path)
    _warn_once(path.parent, "the inode of a file changes each time it is opened")
    return number


def _opened(path: Path) -> int:
    """Open the lock file; a symbolic link with its name is removed first."""
    for _ in range(MAX_TRIES):
        try:
            return not_stale(lambda: os.open(path, FLAGS, 0o666))
        except OSError:
            if not path.is_symlink():
                raise
            LOG.warning("%s is a link: it is removed", path)
            path.unlink(missing_ok=True)
    raise OSError(errno.ELOOP, "becomes a link each time it is removed", str(path))


def _try_lock(path: Path, number: int, wait: Callable[[], None]) -> bool:
    """Lock the file with descriptor ``number``; return whether ``path`` still leads to it.

    Raises OSError if the file cannot be locked.
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
    if file.st_dev not in _TESTED:
        _TESTED.add(file.st_dev)
        _check_that_it_excludes(path)
    return True


def _check_that_it_excludes(path: Path) -> None:
    """Raise OSError if another process could lock or remove the file that is locked here."""
    with suppress(FileNotFoundError):
        number = not_stale(lambda: os.open(path, FLAGS & ~os.O_CREAT))
        try:
            fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return
        finally:
            os.close(number)
    raise OSError(errno.ENOLCK, "a lock there excludes nobody")


def _warn_once(folder: Path, reason: str) -> None:
    """Log, once for each file system, why files in the folder are not locked."""
    device = os.stat(folder).st_dev
    if device not in _WARNED:
        _WARNED.add(device)
        LOG.warning(UNLOCKED_MESSAGE, folder, reason)
