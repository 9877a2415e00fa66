"""Atomic writing of files: a draft is written next to the file and then renamed in one step.

A process that is killed at any moment, or a full disk, leaves the old file unchanged; at worst a
draft named ``.NAME.HOST-PROCESS-….draft`` remains.

On a network file system, a request that succeeded and was then repeated fails: EEXIST for a link,
ENOENT for a rename. After an error it is therefore checked whether the name leads to the draft's
file. A request for a file that another host has just replaced (ESTALE) is repeated. File systems
that cannot flush folders are not flushed, and where there are no hard links an empty file reserves
the name first.
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
"""Largest numbers of characters of a file's stem and of its suffix in the name of its draft, which
has at most 255 bytes."""

DRAFT = re.compile(r"\.([0-9a-f]{8})-([0-9]{1,9})-[0-9a-f]{16}\.draft")
"""Pattern of the end of a draft's name: host, process and a random number."""

OLD_DRAFT = 86400.0
"""Age in seconds from which on a draft is no longer being written."""

STALE_TRIES = 5

UNFLUSHED = (errno.EINVAL, errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP)
"""Error numbers of file systems that cannot flush folders or files; they write without being
asked."""


def write_atomically(
    path: str | Path,
    write: Callable[[Path], object],
    force: bool = True,
    durable: bool = True,
    follow: bool = True,
    mode: int | None = None,
) -> None:
    """Call ``write(draft)`` on a new file next to ``path``, and rename that file to ``path``.

    The draft has the suffix of ``path``. Without ``force`` nothing is overwritten: one of several
    processes wins. An existing file of the user keeps its permissions, unless a ``mode`` is given.
    If ``follow``, a symbolic link still leads to its file, and the file is replaced; otherwise, for
    names that no user typed, the link itself is replaced. If ``durable``, the file is on the disk
    before this function returns.

    Raises OSError that names the file if it cannot be written, FileExistsError if it exists and
    must not be overwritten or is a folder or device, and any error of ``write``. After an error the
    draft is removed and ``path`` is unchanged.
    """
    path = Path(path)
    target = Path(os.path.realpath(path)) if follow else path
    draft = draft_path(target)
    try:
        is_link = not follow and not_stale(target.is_symlink)
        if not is_link:  # a link is replaced, wherever it leads
            _check_target(target, force)
        if mode is None and follow:
            mode = _own_mode(target)
        if mode is not None:  # a private file must be private while it is written, too
            os.close(os.open(draft, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        write(draft)
        if durable:
            with draft.open("rb+") as stream:
                _flush(stream.fileno())
        if mode is not None:
            draft.chmod(mode)
        _rename(draft, target, force)
        if durable:
            _flush_folder(target.parent)
    except OSError as error:
        raise _error_for(error, path) from error
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def draft_path(path: Path) -> Path:
    """Return a new name for a draft of the file, in the same folder."""
    suffix = path.suffix if len(path.suffix) <= LONGEST_SUFFIX else ""
    name = f"{path.stem[:LONGEST_STEM]}.{_host()}-{os.getpid()}-{uuid.uuid4().hex[:16]}"
    return path.with_name(f".{name}.draft{suffix}")


def remove_dead_drafts(folder: Path, stem: str = "*") -> None:
    """Remove drafts of files with this stem that are old or of a dead process of this host."""
    for draft in folder.glob(f".{stem[:LONGEST_STEM]}.*.draft*"):
        with suppress(OSError):
            if _is_dead(draft):
                draft.unlink()


def _is_dead(draft: Path) -> bool:
    """Return whether the process that was writing the draft has ended."""
    match = DRAFT.search(draft.name)
    if match is None or match[1] != _host():
        return time.time() - draft.lstat().st_mtime > OLD_DRAFT
    try:
        os.kill(int(match[2]), 0)
    except ProcessLookupError:
        return True
    except PermissionError:  # another user's process
        return False
    return False


@lru_cache
def _host() -> str:
    """Return an identifier of this host and its process namespace, such as a container's."""
    import platform

    numbers = ""
    with suppress(OSError):
        numbers = os.readlink("/proc/self/ns/pid")
    return hashlib.sha256(f"{platform.node()} {numbers}".encode()).hexdigest()[:8]


def not_stale(ask: Callable[[], T]) -> T:
    """Return ``ask()``; call it again if another host has just replaced the file (ESTALE)."""
    for _ in range(STALE_TRIES - 1):
        try:
            return ask()
        except OSError as error:
            if error.errno != errno.ESTALE:
                raise
    return ask()


def leads_to(path: Path, file: os.stat_result) -> bool:
    """Return whether the path is a name of that file."""
    try:
        return os.path.samestat(not_stale(lambda: os.lstat(path)), file)
    except OSError:
        return False


def _check_target(target: Path, force: bool) -> None:
    """Raise FileExistsError if the target must not be replaced, before anything is written."""
    state = _state(target)
    if state is not None and not (force and stat.S_ISREG(state.st_mode)):
        is_file = stat.S_ISREG(state.st_mode)
        raise FileExistsError(errno.EEXIST, "exists already" if is_file else "is not a file")


def _own_mode(target: Path) -> int | None:
    """Return the permissions of the target; None if it is missing or belongs to another user."""
    state = _state(target)
    if state is None or (hasattr(os, "geteuid") and state.st_uid != os.geteuid()):
        return None
    return stat.S_IMODE(state.st_mode)


def _state(target: Path) -> os.stat_result | None:
    """Return the status of the target, or None if it is missing."""
    try:
        return not_stale(target.stat)
    except OSError as error:
        if error.errno not in (errno.ENOENT, errno.ENOTDIR, errno.ELOOP):
            raise
    return None


def _rename(draft: Path, target: Path, force: bool) -> None:
    """Rename the draft to the target; without ``force``, raise FileExistsError if that exists."""
    give_name = os.replace if force else os.link
    file = not_stale(lambda: os.lstat(draft))
    try:
        not_stale(lambda: give_name(draft, target))
    except OSError as error:
        if leads_to(target, file):  # it was done, and the request repeated
            return
        if force or isinstance(error, FileExistsError):
            raise
        _rename_without_links(draft, target)


def _rename_without_links(draft: Path, target: Path) -> None:
    """Reserve the target's name with an empty file, then rename the draft; needs no hard links."""
    number = os.open(target, os.O_CREAT | os.O_EXCL | os.O_WRONLY)
    try:
        _rename(draft, target, force=True)
    except BaseException:
        if leads_to(target, os.fstat(number)):
            target.unlink()
        raise
    finally:
        os.close(number)


def _flush_folder(folder: Path) -> None:
    """Flush the folder, so that the new name is on the disk."""
    with suppress(PermissionError):
        number = not_stale(lambda: os.open(folder, os.O_RDONLY))
        try:
            _flush(number)
        finally:
            os.close(number)


def _flush(number: int) -> None:
    """Flush the open file or folder with descriptor ``number``, if its file system can."""
    try:
        os.fsync(number)
    except OSError as error:
        if error.errno not in UNFLUSHED:
            raise


def _error_for(error: OSError, path: Path) -> OSError:
    """Return an error with the name of the file in place of its draft's name."""
    if error.errno is None:
        return OSError(f"{path}: {error}")
    return OSError(error.errno, error.strerror or str(error), str(path))
