"""Where machine code and data are kept from one process to the next, under keys of their sources.

What is kept lies in a folder that is named by a digest of all that it is made from
(`support.compiled.source_digest`) and of numba's settings. So nothing old is ever found, and going
back to an earlier source finds what was made from that.

The folder is the first that can be written of ``NUMBA_CACHE_DIR``, the module's ``__pycache__`` and
the user's cache. Where there is none, every process makes all anew, and a warning says so once. A
cache can only save time: whatever is missing, damaged or cannot be written is made anew.

Machine code is run. So it is read only from a file in a folder that are both no links, the user's
own, and closed to all others: nobody else can have put it there. A folder that is not is told once
and left alone, and the next is taken.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import stat
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from longwave.support.compiled.source_digest import Files

PRIVATE, OWN, WRITABLE = 0o700, 0o600, 0o022
"""The modes of a cache's folder and its files, and rights that others may not have on them."""

READABLE = 0o755
"""The mode of the folder in which they are, at most: with the mask 0 all could move them away."""

KEPT = 8
"""Versions of a module's folder that a cache keeps; the least lately used ones go first."""


@dataclass(frozen=True)
class CacheFolder:
    """The files made from ``sources`` that are kept in the folder ``path``; None keeps nothing.

    Read and written only by a process that runs what the sources say.
    """

    path: Path | None
    sources: Files = ()
    refused: tuple[str, ...] = ()
    """What is wrong with folders that would have come before, a line each."""

    def kept(self, name: str, make: Callable[[], bytes]) -> bytes:
        """The file's content, made if it is not there."""
        data = self.read(name)
        if data is None:
            data = make()
            self.write(name, data)
        return data

    def read(self, name: str) -> bytes | None:
        """The file's content; None if it is not there, damaged, or may be somebody else's."""
        from longwave.support.compiled.source_digest import are_older
        from longwave.support.sealed_file import open_plain, sealed_content

        if self.path is None or not are_older(self.sources):
            return None
        with suppress(OSError), _opened(self.path) as folder:
            number = open_plain(name if folder else self.path / name, folder)
            with open(number, "rb") as stream:
                if not _fault(os.fstat(number), others=WRITABLE):
                    held = sealed_content(stream.read())
                    title, _, data = (held or b"").partition(b"\n")
                    return data if title == self._title(name) else None
        return None

    def _title(self, name: str) -> bytes:
        """The first line of a file: one that was moved is not what its name says."""
        return f"{self.path and self.path.name}/{name}".encode()

    def write(self, name: str, data: bytes) -> None:
        """Keep a file, if it can be: a full disk or a folder that is gone is no error."""
        from longwave.support.compiled.source_digest import runs_as_written
        from longwave.support.sealed_file import write_sealed

        if self.path is not None and runs_as_written(self.sources):
            with suppress(OSError), _opened(self.path):
                content = self._title(name) + b"\n" + data
                write_sealed(self.path / name, content, durable=False, mode=OWN)


@lru_cache
def cache_folder(module: str, *others: str) -> CacheFolder:
    """The folder for what an imported module makes, with the ``others``; made if need be."""
    from longwave.support.compiled.source_digest import all_sources, text_digest

    sources = all_sources((module, *others))
    name, refused = f"{module}-{_digest(text_digest(sources))[:20]}", list[str]()
    for base in _bases(Path(str(sys.modules[module].__file__))):
        folder = base / name
        try:
            base.mkdir(READABLE, parents=True, exist_ok=True)
            folder.mkdir(mode=PRIVATE, exist_ok=True)
            with _opened(folder):
                tempfile.TemporaryFile(dir=folder).close()
                os.utime(folder)
        except NotPrivateError as error:
            refused.append(str(error))
            _warn(f"{error}: what it holds is not used (remove it)")
            continue
        except OSError:
            continue
        _prune(base, module)
        return CacheFolder(folder, sources, tuple(refused))
    _warn(
        "no folder for compiled kernels can be written: this process compiles them anew, which "
        "takes some seconds (set NUMBA_CACHE_DIR to a folder that can be written)"
    )
    return CacheFolder(None, refused=tuple(refused))


class NotPrivateError(OSError):
    """A folder that others may have put something into."""


@contextmanager
def _opened(path: Path) -> Iterator[int | None]:
    """The number of the folder, opened; None where files are not opened by it.

    Raises NotPrivateError for one that is a link, another user's, or open to others.
    """
    _check_private(path, path.lstat())
    if os.open not in os.supports_dir_fd:
        yield None
        return
    number = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        _check_private(path, os.fstat(number))
        yield number
    finally:
        os.close(number)


def _check_private(path: Path, state: os.stat_result) -> None:
    fault = "a link" if stat.S_ISLNK(state.st_mode) else _fault(state, PRIVATE ^ 0o777)
    if fault:
        raise NotPrivateError(f"a cache's folder must be the user's alone, got {path}, {fault}")


def _fault(state: os.stat_result, others: int) -> str:
    """Why others may have written there: "" if not, ``others`` being rights they may not have."""
    if not hasattr(os, "geteuid"):
        return ""
    if state.st_uid != os.geteuid():
        return f"of user {state.st_uid}"
    mode = stat.S_IMODE(state.st_mode)
    return f"with the mode {mode:04o}" if mode & others else ""


def _digest(sources: str) -> str:
    """What machine code depends on: the sources and numba's settings."""
    settings = numba_settings()
    if hasattr(os, "geteuid"):  # several users may have one NUMBA_CACHE_DIR
        settings.insert(0, f"user {os.geteuid()}")
    return hashlib.sha256("\n".join([sources, *settings]).encode()).hexdigest()


def numba_settings() -> list[str]:
    """Return numba's settings, of the environment and of the file in the current folder."""
    from longwave.support.compiled.source_digest import compiler_settings
    from longwave.support.sealed_file import open_plain

    settings = compiler_settings()
    with suppress(OSError), open(open_plain(".numba_config.yaml"), encoding="utf-8") as stream:
        settings.append(stream.read())
    return settings


def _bases(file: Path) -> Iterator[Path]:
    chosen = os.environ.get("NUMBA_CACHE_DIR", "")
    if chosen:
        yield Path(chosen)
    yield file.parent / "__pycache__"
    with suppress(RuntimeError):  # no home
        yield _users_cache() / "longwave" / "kernels"


def _users_cache() -> Path:
    """The platform's folder for the caches of this user."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _prune(base: Path, module: str) -> None:
    """Remove the least lately used versions of the module's folder."""
    try:
        versions = sorted(base.glob(f"{module}-*"), key=lambda path: path.stat().st_mtime)
    except OSError:  # another process has just removed one
        return
    for folder in versions[:-KEPT]:
        shutil.rmtree(folder, ignore_errors=True)


@lru_cache
def _warn(said: str) -> None:
    """Warn of it, once, in one line: without the line of this file."""
    warnings.warn_explicit(said, RuntimeWarning, "longwave", 0)
