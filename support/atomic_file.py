"""Files that appear whole or not at all: written beside their place, then put there in one step.

Whoever is killed at any moment, or finds the disk full, leaves the older file as it was; at worst a
draft stays beside it, named ``.NAME.HOST-PROCESS-….draft``.

On a network file system, a request that was done and then repeated ends with an error: EEXIST of a
link, ENOENT of a rename. So after an error it is looked whether the name leads to the draft's file.
What another host has just replaced (ESTALE) is asked for again. A file system that flushes no
folders is left alone, and where there are no hard links an empty file takes the name first.
"""

import errno
import hashlib
import os
import re
import stat
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")

LONGEST_STEM, LONGEST_SUFFIX = 40, 12
"""Letters of a file's name that its draft's keeps: a name has at most 255 bytes."""

DRAFT = re.compile(r"\.([0-9a-f]{8})-([0-9]{1,9})-[0-9a-f]{16}\.draft")
"""How the name of a draft goes on: its host and process, and a random number."""

OLD_DRAFT = 86400.0
"""Seconds after which nobody is still writing a draft."""

STALE_TRIES = 5

UNFLUSHED = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP)
"""Errors of file systems that flush no folder, or nothing when asked: they do it by themselves."""


def write_atomically(
    path: str | Path,
    write: Callable[[Path], object],
    force: bool = True,
    durable: bool = True,
    follow: bool = True,
    mode: int | None = None,
) -> None:
    """Have ``write(draft)`` write a file beside ``path``, and give it that name when it is whole.

    The draft has the suffix of ``path``. Without ``force`` nothing is overwritten: of several
    processes one wins. A user's own file that is there keeps its permissions, unless there is a
    ``mode`` to have, and a link still leads to the file that it led to; unless told to ``follow``
    them, where nobody has typed the name, a new file takes their place. What can be lost if the
    power fails need not be ``durable``, on the disk before this returns.

    Raises OSError that names the file where it cannot be written (FileExistsError if it is there
    and is not to be overwritten, and for a folder or a device) and what ``write`` raises; the draft
    is gone then, and ``path`` as it was.
    """
    path = Path(path)
    place = Path(os.path.realpath(path)) if follow else path
    draft = draft_path(place)
    try:
        is_link = not follow and not_stale(place.is_symlink)
        if not is_link:  # which is replaced, wherever it leads
            _check_place(place, force)
        if mode is None and follow:
            mode = _own_mode(place)
        if mode is not None:  # what is private is so while it is written, too
            os.close(os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        write(draft)
        if durable:
            with draft.open("rb+") as stream:
                _flush(stream.fileno())
        if mode is not None:
            draft.chmod(mode)
        _put(draft, place, force)
        if durable:
            _flush_folder(place.parent)
    except OSError as error:
        raise _named(error, path) from error
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def draft_path(path: Path) -> Path:
    """A new name for a draft of the file, in its folder."""
    suffix = path.suffix if len(path.suffix) <= LONGEST_SUFFIX else ""
    name = f"{path.stem[:LONGEST_STEM]}.{_host()}-{os.getpid()}-{uuid.uuid4().hex[:16]}"
    return path.with_name(f".{name}.draft{suffix}")


def remove_dead_drafts(folder: Path, stem: str = "*") -> None:
    """Remove the drafts that killed processes have left in a folder, of files of that stem.

    A draft of this host goes if its process is no more, any other a day after it was written: where
    locks do nothing, another process may be about to give it its name.
    """
    for draft in folder.glob(f".{stem[:LONGEST_STEM]}.*.draft*"):
        with suppress(OSError):
            if _is_dead(draft):
                draft.unlink()


def _is_dead(draft: Path) -> bool:
    found = DRAFT.search(draft.name)
    if found is None or found[1] != _host():
        return time.time() - draft.lstat().st_mtime > OLD_DRAFT
    try:
        os.kill(int(found[2]), 0)
    except ProcessLookupError:
        return True
    except PermissionError:  # another user's
        return False
    return False


@lru_cache
def _host() -> str:
    """This host, and in it what numbers processes: a container does that by itself."""
    import platform

    numbers = ""
    with suppress(OSError):
        numbers = os.readlink("/proc/self/ns/pid")
    return hashlib.sha256(f"{platform.node()} {numbers}".encode()).hexdigest()[:8]


def not_stale(ask: Callable[[], T]) -> T:
    """What ``ask`` gives, asked again where another host has just replaced the file (ESTALE)."""
    for _ in range(STALE_TRIES - 1):
        try:
            return ask()
        except OSError as error:
            if error.errno != errno.ESTALE:
                raise
    return ask()


def leads_to(path: Path, file: os.stat_result) -> bool:
    """Whether the path is a name of that file."""
    try:
        return os.path.samestat(not_stale(lambda: os.lstat(path)), file)
    except OSError:
        return False


def _check_place(place: Path, force: bool) -> None:
    """Refuse what is not to be replaced, before anything is written."""
    mode = _mode(place)
    if mode is not None and not (force and stat.S_ISREG(mode)):
        kind = "exists already" if stat.S_ISREG(mode) else "is there, and is no file"
        raise FileExistsError(errno.EEXIST, kind)


def _mode(place: Path) -> int | None:
    """The mode of what is there; None if nothing is, or a link that leads nowhere."""
    state = _state(place)
    return None if state is None else state.st_mode


def _own_mode(place: Path) -> int | None:
    """The permissions of what is there; None if nothing is, or another user's file."""
    state = _state(place)
    if state is None or (hasattr(os, "geteuid") and state.st_uid != os.geteuid()):
        return None
    return stat.S_IMODE(state.st_mode)


def _state(place: Path) -> os.stat_result | None:
    try:
        return not_stale(place.stat)
    except OSError as error:
        if error.errno not in (errno.ENOENT, errno.ENOTDIR, errno.ELOOP):
            raise
    return None


def _put(draft: Path, place: Path, force: bool) -> None:
    """Give the draft its name; without ``force`` FileExistsError if another file has it."""
    name = os.replace if force else os.link
    file = not_stale(lambda: os.lstat(draft))
    try:
        not_stale(lambda: name(draft, place))
    except OSError as error:
        if leads_to(place, file):  # done, and asked for once more
            return
        if force or isinstance(error, FileExistsError):
            raise
        _put_where_no_links_are(draft, place)


def _put_where_no_links_are(draft: Path, place: Path) -> None:
    """Give the draft its name, having taken that by an empty file."""
    number = os.open(place, os.O_CREAT | os.O_EXCL | os.O_WRONLY)
    try:
        _put(draft, place, force=True)
    except BaseException:
        if leads_to(place, os.fstat(number)):
            place.unlink()
        raise
    finally:
        os.close(number)


def _flush_folder(folder: Path) -> None:
    """Have the new name on the disk."""
    with suppress(PermissionError):
        number = not_stale(lambda: os.open(folder, os.O_RDONLY))
        try:
            _flush(number)
        finally:
            os.close(number)


def _flush(number: int) -> None:
    try:
        os.fsync(number)
    except OSError as error:
        if error.errno not in UNFLUSHED:
            raise


def _named(error: OSError, path: Path) -> OSError:
    """The error with the file in the place of its draft."""
    if error.errno is None:
        return OSError(f"{path}: {error}")
    return OSError(error.errno, error.strerror or str(error), str(path))
