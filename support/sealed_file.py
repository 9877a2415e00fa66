"""Files that end with their checksum: whole, or as good as missing.

Files appear whole or not at all; the line after a file's end, which HDF5 passes over, tells of one
that was damaged since.
"""

from __future__ import annotations

import errno
import hashlib
import logging
import math
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from longwave.support.atomic_file import not_stale, write_atomically

if TYPE_CHECKING:
    from hashlib import _Hash as Hash

LOG = logging.getLogger("longwave.store")
"""What happens to runs and checkpoints on the way."""

SEAL = b"\nlongwave run, sha256 of all before this line: "
"""How the line after a file's end begins; the digest, in hexadecimal, and a line's end follow."""

SEAL_LENGTH = len(SEAL) + 64 + 1

WRITE_TRIES = 3

PART = 2**20
"""Bytes that are read at once."""

NO_FILE = errno.ELOOP, errno.EINVAL, errno.EMLINK
"""Errors of `open_plain` for a link, and for what is no file."""

DAMAGED = "%s is damaged: it counts as missing, and is made anew"
LINKED = "%s is a link, or no file: it counts as missing, and is made anew"
"""What the log is told of files that are not taken."""


def write_sealed(
    path: Path,
    content: bytes,
    force: bool = True,
    durable: bool = True,
    mode: int | None = None,
) -> None:
    """Write the content and its seal, whole or not at all, in the place of a link too.

    Nobody has typed the name; raises as `write_atomically`. A draft that somebody else removes is
    written anew.
    """

    def write(draft: Path) -> None:
        with draft.open("wb") as stream:
            stream.write(content)
            stream.write(_seal(hashlib.sha256(content)))

    for left in reversed(range(WRITE_TRIES)):
        try:
            write_atomically(path, write, force, durable, follow=False, mode=mode)
            return
        except OSError as error:
            if not left or error.errno not in (errno.ENOENT, errno.ESTALE):
                raise


def open_plain(path: str | Path, folder: int | None = None, untyped: int = 1) -> int:
    """Open a file for reading whose last ``untyped`` names nobody has typed; return its descriptor.

    ``path`` may be one in an open ``folder``. None of these names is followed if it is a link, also
    if it becomes one meanwhile: each is opened in the folder that was opened before it. Raises
    OSError for what is not there and what is no file: a pipe would be waited for.
    """
    if untyped > 1:
        with _opened_folder(Path(path).parent, untyped - 1) as inner:
            return open_plain(Path(path).name if inner is not None else path, inner)
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    flags |= getattr(os, "O_BINARY", 0)
    number = not_stale(lambda: os.open(path, flags, dir_fd=folder))
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(errno.EINVAL, "is no file", str(path))
    return number


@contextmanager
def _opened_folder(folder: Path, untyped: int) -> Iterator[int | None]:
    """Open a folder whose last ``untyped`` names nobody has typed, each in the one above it.

    Gives None, having looked for links by name, where files are not opened by folder. Raises
    OSError, ELOOP for a link.
    """
    names = folder.parts[-untyped:]
    if os.open not in os.supports_dir_fd:
        for place in (folder, *folder.parents)[:untyped]:
            check_no_link(place)
        yield None
        return
    number = os.open(folder.parents[untyped - 1], os.O_RDONLY | os.O_DIRECTORY)
    try:
        for name in names:
            outer, number = number, _inner_folder(number, name, folder)
            os.close(outer)
        yield number
    finally:
        os.close(number)


def _inner_folder(outer: int, name: str, folder: Path) -> int:
    flags = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW
    try:
        return not_stale(lambda: os.open(name, flags, dir_fd=outer))
    except NotADirectoryError:
        raise OSError(errno.ELOOP, "a folder must be no link", str(folder)) from None


def check_no_link(folder: Path) -> None:
    """Raise OSError for a folder that is a link, if nobody has typed its name."""
    if not_stale(folder.is_symlink):
        raise OSError(errno.ELOOP, "a folder in a store must be no link (remove it)", str(folder))


def read_sealed(path: Path, most: float = math.inf, untyped: int = 1) -> bytes | None:
    """The content of such a file; None if it is not there, a link, longer than that, or damaged.

    The last ``untyped`` names of the path are followed as by `open_plain`.
    """

    def content() -> bytes | None:
        with open(open_plain(path, untyped=untyped), "rb") as stream:
            longer = os.fstat(stream.fileno()).st_size > most
            return None if longer else sealed_content(stream.read())

    try:
        return not_stale(content)
    except OSError:
        return None


def sealed_content(held: bytes) -> bytes | None:
    """What was sealed, of all that a file holds; None if it is damaged."""
    content = held[:-SEAL_LENGTH]
    return content if held[len(content) :] == _seal(hashlib.sha256(content)) else None


def is_whole(path: Path) -> bool:
    """Whether there is a run's file as it was written; one that is damaged is told, and a link.

    The file's folder, which nobody has typed either, must be no link.
    """

    def whole() -> bool:
        with open(open_plain(path, untyped=2), "rb") as stream:
            return is_sealed(stream)

    try:
        found = not_stale(whole)
    except FileNotFoundError:
        return False
    except OSError as error:
        if error.errno not in NO_FILE:
            raise
        LOG.warning(LINKED, path)
        return False
    if not found:
        LOG.warning(DAMAGED, path)
    return found


def is_sealed(stream: BinaryIO) -> bool:
    """Whether what stands before the seal of an open file is what was sealed."""
    total = hashlib.sha256()
    left = os.fstat(stream.fileno()).st_size - SEAL_LENGTH
    while left > 0 and (part := stream.read(min(left, PART))):
        total.update(part)
        left -= len(part)
    return left == 0 and stream.read() == _seal(total)


def _seal(total: Hash) -> bytes:
    return SEAL + total.hexdigest().encode() + b"\n"
