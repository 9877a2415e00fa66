"""Files that end with their checksum: either whole, or treated as missing.

Files are written atomically; the line after a file's end, which HDF5 ignores, reveals later damage.
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
"""Logger of messages about runs and checkpoints."""

SEAL = b"\nlongwave run, sha256 of all before this line: "
"""Beginning of the line after a file's end; the hexadecimal digest and a newline follow."""

SEAL_LENGTH = len(SEAL) + 64 + 1

WRITE_TRIES = 3

CHUNK_BYTES = 2**20
"""Number of bytes read at a time."""

NO_FILE = errno.ELOOP, errno.EINVAL, errno.EMLINK
"""Errors that `open_plain` raises for a link and for anything that is not a regular file."""

DAMAGED = "%s is damaged: it counts as missing, and is made anew"
LINKED = "%s is a link, or no file: it counts as missing, and is made anew"
"""Log message for a path that is ignored because it is a link or not a regular file."""


def write_sealed(
    path: Path, content: bytes, force: bool = True, durable: bool = True, mode: int | None = None
) -> None:
    """Write content and seal atomically, replacing a link; raise errors as `write_atomically`."""

    def write(draft: Path) -> None:
        with draft.open("wb") as stream:
            stream.write(content)
            stream.write(_seal(hashlib.sha256(content)))

    for attempts_left in reversed(range(WRITE_TRIES)):
        try:
            write_atomically(path, write, force, durable, follow=False, mode=mode)
            return
        except OSError as error:
            if not attempts_left or error.errno not in (errno.ENOENT, errno.ESTALE):
                raise


def open_plain(path: str | Path, folder: int | None = None, untyped: int = 1) -> int:
    """Open a file for reading; return its descriptor.

    Links are not followed in the last ``untyped`` parts of ``path``, which no user typed. ``path``
    may be relative to an open ``folder``. Each part is opened in the folder opened before it, so
    that a link is not followed even if it appears meanwhile. Raises OSError for a missing file and
    for anything but a file, such as a pipe, which would block.
    """
    if untyped > 1:
        with _opened_folder(Path(path).parent, untyped - 1) as inner:
            return open_plain(Path(path).name if inner is not None else path, inner)
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    flags |= getattr(os, "O_BINARY", 0)
    number = not_stale(lambda: os.open(path, flags, dir_fd=folder))
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(errno.EINVAL, "is not a file", str(path))
    return number


@contextmanager
def _opened_folder(folder: Path, untyped: int) -> Iterator[int | None]:
    """Open a folder without links in its last ``untyped`` parts; yield the descriptor, if any."""
    names = folder.parts[-untyped:]
    if os.open not in os.supports_dir_fd:
        for part in (folder, *folder.parents)[:untyped]:
            check_no_link(part)
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
    """Open a folder inside an open one. Raises OSError, ELOOP for a link."""
    flags = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW
    try:
        return not_stale(lambda: os.open(name, flags, dir_fd=outer))
    except NotADirectoryError:
        raise OSError(errno.ELOOP, "a folder must not be a link", str(folder)) from None


def check_no_link(folder: Path) -> None:
    """Raise OSError if a folder of a store is a link."""
    if not_stale(folder.is_symlink):
        raise OSError(
            errno.ELOOP, "a folder in a store must not be a link (remove it)", str(folder)
        )


def read_sealed(path: Path, max_bytes: float = math.inf, untyped: int = 1) -> bytes | None:
    """Return a sealed file's content; None if the file is missing, linked, damaged or too long."""

    def content() -> bytes | None:
        with open(open_plain(path, untyped=untyped), "rb") as stream:
            longer = os.fstat(stream.fileno()).st_size > max_bytes
            return None if longer else sealed_content(stream.read())

    try:
        return not_stale(content)
    except OSError:
        return None


def sealed_content(data: bytes) -> bytes | None:
    """Return the sealed part of a file's bytes; None if the file is damaged."""
    content = data[:-SEAL_LENGTH]
    return content if data[len(content) :] == _seal(hashlib.sha256(content)) else None


def is_whole(path: Path) -> bool:
    """Return whether a run's file is undamaged and not linked; log a message if it is not."""

    def whole() -> bool:
        with open(open_plain(path, untyped=2), "rb") as stream:
            return is_sealed(stream)

    try:
        is_intact = not_stale(whole)
    except FileNotFoundError:
        return False
    except OSError as error:
        if error.errno not in NO_FILE:
            raise
        LOG.warning(LINKED, path)
        return False
    if not is_intact:
        LOG.warning(DAMAGED, path)
    return is_intact


def is_sealed(stream: BinaryIO) -> bool:
    """Return whether the content of an open file matches its seal."""
    total = hashlib.sha256()
    bytes_left = os.fstat(stream.fileno()).st_size - SEAL_LENGTH
    while bytes_left > 0 and (part := stream.read(min(bytes_left, CHUNK_BYTES))):
        total.update(part)
        bytes_left -= len(part)
    return bytes_left == 0 and stream.read() == _seal(total)


def _seal(total: Hash) -> bytes:
    """Return the seal for a hash of the content."""
    return SEAL + total.hexdigest().encode() + b"\n"
