"""Files that are there whole or not at all, whatever ends the process that writes them."""

from __future__ import annotations

import errno
import os
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

__all__ = ["is_draft", "write_atomically"]

DRAFT = ".draft-"
"""In the name of a file that is being written, which a killed process leaves."""


def write_atomically(path: Path, write: Callable[[Path], object], force: bool = True) -> None:
    """Let ``write`` write a draft beside ``path``, and put that in its place when it is on disk.

    Without ``force`` nothing is overwritten: of two processes one is told FileExistsError. Whatever
    goes wrong, an older file stays as it is and the draft goes away. An OSError names ``path``.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "told.txt")
    ...     write_atomically(file, lambda draft: draft.write_text("all of it"))
    ...     file.read_text(), [each.name for each in file.parent.iterdir()]
    ('all of it', ['told.txt'])
    """
    draft = path.with_name(f"{path.name[:100]}{DRAFT}{uuid.uuid4().hex[:16]}")
    try:
        write(draft)
        _to_disk(draft)
        if force:
            draft.replace(path)
        else:
            _put_once(draft, path)
        _to_disk(path.parent)
    except OSError as error:
        code = error.errno or errno.EIO
        raise OSError(code, error.strerror or os.strerror(code), str(path)) from None
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def is_draft(path: Path) -> bool:
    """Whether a file is what a killed process left of one that it was writing."""
    return DRAFT in path.name


def _put_once(draft: Path, path: Path) -> None:
    """Give the draft its name; FileExistsError if another file has it."""
    try:
        os.link(draft, path)
    except FileExistsError:
        raise
    except OSError:  # a file system without links: the name is claimed by an empty file
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
        draft.replace(path)


def _to_disk(path: Path) -> None:
    """Wait until a file, or what a folder lists, is on disk, where the system can do that."""
    try:
        handle = os.open(path, os.O_RDONLY)
    except OSError:
        if path.is_dir():  # Windows opens no folder
            return
        raise
    try:
        os.fsync(handle)
    except OSError as error:
        if not path.is_dir() or error.errno not in (errno.EINVAL, errno.ENOTSUP):
            raise
    finally:
        os.close(handle)
