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
from collections.abc import Container
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

from longwave.support.atomic_file import not_stale, write_atomically

if TYPE_CHECKING:
    from hashlib import _Hash as Hash

LOG = logging.getLogger("longwave.store")
"""What happens to runs and checkpoints on the way."""

SEAL = b"\nlongwave run, sha256 of all before this line: "
"""How the line after a file's end begins; the digest, in hexadecimal, and a line's end follow."""

SEAL_LENGTH = len(SEAL) + 64 + 1

NEW_FILE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)

WRITE_TRIES = 3

PART = 2**20
"""Bytes that are read at once."""


def write_sealed(
    path: Path,
    content: bytes,
    force: bool = True,
    durable: bool = True,
    private: bool = False,
) -> None:
    """Write the content and its seal, whole or not at all, in the place of a link too.

    Nobody has typed the name; raises as `write_atomically`. A draft that somebody else removes is
    written anew. With ``private``, it is open to its user alone, whatever the umask is.
    """

    def write(draft: Path) -> None:
        number = os.open(draft, NEW_FILE, 0o600 if private else 0o666)
        with open(number, "wb") as stream:
            stream.write(content)
            stream.write(_seal(hashlib.sha256(content)))

    for left in reversed(range(WRITE_TRIES)):
        try:
            write_atomically(path, write, force, durable, follow=False)
            return
        except OSError as error:
            if not left or error.errno not in (errno.ENOENT, errno.ESTALE):
                raise


def open_plain(path: str | Path, folder: int | None = None) -> int:
    """The number of a file that is opened to be read, by a name that nobody has typed.

    ``path`` may be one in an open ``folder``. Raises OSError for what is not there and what is no
    file: a link might lead anywhere, a pipe would be waited for.
    """
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)
    flags |= getattr(os, "O_BINARY", 0)
    number = not_stale(lambda: os.open(path, flags, dir_fd=folder))
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise OSError(errno.EINVAL, "is no file", str(path))
    return number


def check_no_link(folder: Path) -> None:
    """Raise OSError for a folder that is a link, if nobody has typed its name."""
    if not_stale(folder.is_symlink):
        raise OSError(errno.ELOOP, "a folder in a store must be no link (remove it)", str(folder))


def read_sealed(path: Path, most: float = math.inf) -> bytes | None:
    """The content of such a file; None if it is not there, a link, longer than that, or damaged."""

    def content() -> bytes | None:
        with open(open_plain(path), "rb") as stream:
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


class FileStamp(NamedTuple):
    """Identity of an open file and of its content; its user cannot set the time of a change."""

    device: int
    file: int
    size: int
    modified: int
    changed: int

    @classmethod
    def of(cls, stream: BinaryIO) -> FileStamp:
        """Return that of an open file."""
        told = os.fstat(stream.fileno())
        return cls(told.st_dev, told.st_ino, told.st_size, told.st_mtime_ns, told.st_ctime_ns)


def is_whole(path: Path) -> bool:
    """Whether there is a run's file as it was written; one that is damaged is told, and a link."""
    stream = open_whole(path)
    if stream is None:
        return False
    stream.close()
    return True


def open_whole(path: Path, checked: Container[FileStamp] = ()) -> BinaryIO | None:
    """Return a file as it was written, open to be read; None for none, and for one that is told.

    Those ``checked`` before are not read again. What is read then is what was checked, whatever
    has the name meanwhile.
    """

    def opened() -> BinaryIO | None:
        stream = open(open_plain(path), "rb")  # noqa: SIM115 - the caller's to close
        try:
            if FileStamp.of(stream) in checked or _is_sealed(stream):
                stream.seek(0)
                return stream
        except BaseException:
            stream.close()
            raise
        stream.close()
        return None

    try:
        found = not_stale(opened)
    except FileNotFoundError:
        return None
    except OSError as error:
        if error.errno not in (errno.ELOOP, errno.EINVAL, errno.EMLINK):
            raise
        LOG.warning("%s is a link, or no file: it counts as missing, and is made anew", path)
        return None
    if found is None:
        LOG.warning("%s is damaged: it counts as missing, and is made anew", path)
    return found


def _is_sealed(stream: BinaryIO) -> bool:
    """Whether what stands before the seal of a file is what was sealed."""
    total = hashlib.sha256()
    left = os.fstat(stream.fileno()).st_size - SEAL_LENGTH
    while left > 0 and (part := stream.read(min(left, PART))):
        total.update(part)
        left -= len(part)
    return left == 0 and stream.read() == _seal(total)


def _seal(total: Hash) -> bytes:
    return SEAL + total.hexdigest().encode() + b"\n"
