"""Files that appear whole or not at all: written beside their place, then put there in one step.

Whoever is killed at any moment, or finds the disk full, leaves the older file as it was; at worst a
draft stays beside it, named ``.NAME.….draft``.
"""

import errno
import os
import stat
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

LONGEST_STEM, LONGEST_SUFFIX = 40, 12
"""Letters of a file's name that its draft's keeps: a name has at most 255 bytes."""


def write_atomically(
    path: str | Path,
    write: Callable[[Path], object],
    force: bool = True,
    durable: bool = True,
    follow: bool = True,
) -> None:
    """Have ``write(draft)`` write a file beside ``path``, and give it that name when it is whole.

    The draft has the suffix of ``path``. Without ``force`` nothing is overwritten: of several
    processes one wins. A file that is there keeps its permissions, and a link still leads to the
    file that it led to; unless told to ``follow`` it, where nobody has typed the name, the file
    takes its place. What can be lost if the power fails need not be ``durable``, on the disk before
    this returns.

    Raises OSError that names the file where it cannot be written (FileExistsError if it is there
    and is not to be overwritten, and for a folder or a device) and what ``write`` raises; the draft
    is gone then, and ``path`` as it was.
    """
    path = Path(path)
    place = Path(os.path.realpath(path)) if follow else path
    draft = draft_path(place)
    try:
        is_link = not follow and place.is_symlink()
        if not is_link:  # which is replaced, wherever it leads
            _check_place(place, force)
        write(draft)
        if durable:
            with draft.open("rb+") as stream:
                os.fsync(stream.fileno())
        if place.exists() and not is_link:
            draft.chmod(stat.S_IMODE(place.stat().st_mode))
        if force:
            draft.replace(place)
        else:
            _put_new(draft, place)
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
    return path.with_name(f".{path.stem[:LONGEST_STEM]}.{uuid.uuid4().hex[:16]}.draft{suffix}")


def _check_place(place: Path, force: bool) -> None:
    """Refuse what is not to be replaced, before anything is written."""
    if place.exists() and not (force and place.is_file()):
        kind = "exists already" if place.is_file() else "is there, and is no file"
        raise FileExistsError(errno.EEXIST, kind)


def _put_new(draft: Path, place: Path) -> None:
    """Give the draft its name; FileExistsError if another process has taken it."""
    try:
        os.link(draft, place)
    except FileExistsError:
        raise
    except OSError:  # a file system without hard links: take the name first
        os.close(os.open(place, os.O_CREAT | os.O_EXCL | os.O_WRONLY))
        draft.replace(place)


def _flush_folder(folder: Path) -> None:
    """Have the new name on the disk; systems that cannot flush a folder do that by themselves."""
    with suppress(PermissionError):
        number = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(number)
        finally:
            os.close(number)


def _named(error: OSError, path: Path) -> OSError:
    """The error with the file in the place of its draft."""
    if error.errno is None:
        return OSError(f"{path}: {error}")
    return OSError(error.errno, error.strerror or str(error), str(path))
