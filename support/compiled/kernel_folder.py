"""Cache folders for machine code and data, named by a digest of their sources.

A folder's name has a digest of all that its files are made from (`support.compiled.source_digest`)
and of numba's settings. Outdated files are therefore never found, and going back to an earlier
source finds its files again.

The folder is the first writable one of ``NUMBA_CACHE_DIR``, the module's ``__pycache__`` and the
user's cache. If there is none, every process compiles anew, after one warning. Anything missing,
damaged or unwritable is also made anew.

Machine code is executed, so it is read only if both the file and its folder are no links, belong to
the user and are closed to everybody else: nobody else can have put it there. A folder that is not
private is reported once and skipped.
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

FOLDER_MODE, FILE_MODE, OTHERS_WRITE = 0o700, 0o600, 0o022
"""Modes of a cache's folder and of its files, and permissions that others must not have on
these."""

BASE_MODE = 0o755
"""Mode of the folder that contains the cache folders: at umask 0, others could otherwise move
them."""

MAX_VERSIONS = 8
"""Largest number of versions of a module's cache folder; least recently used ones are removed."""


@dataclass(frozen=True)
class CacheFolder:
    """Cache, in the folder ``path``, of files made from ``sources``; no cache if ``path`` is None.

    They are read and written only by a process whose code is what the sources say.
    """

    path: Path | None
    sources: Files = ()
    refused: tuple[str, ...] = ()
    """Reasons why earlier choices of folders were skipped, one line each."""

    def get_or_make(self, name: str, make: Callable[[], bytes]) -> bytes:
        """Return the content of the file ``name``; if it is missing, call ``make`` and store it."""
        data = self.read(name)
        if data is None:
            data = make()
            self.write(name, data)
        return data

    def read(self, name: str) -> bytes | None:
        """Return the file's content; None if it is missing, damaged, or not private."""
        from longwave.support.compiled.source_digest import are_older
        from longwave.support.sealed_file import open_plain, sealed_content

        if self.path is None or not are_older(self.sources):
            return None
        with suppress(OSError), _opened(self.path) as folder:
            number = open_plain(name if folder else self.path / name, folder)
            with open(number, "rb") as stream:
                if not _fault(os.fstat(number), others=OTHERS_WRITE):
                    content = sealed_content(stream.read())
                    title, _, data = (content or b"").partition(b"\n")
                    return data if title == self._title(name) else None
        return None

    def _title(self, name: str) -> bytes:
        """Return the first line of the file ``name``, by which a renamed file is recognised."""
        return f"{self.path and self.path.name}/{name}".encode()

    def write(self, name: str, data: bytes) -> None:
        """Store a file if possible; a full disk or a missing folder is no error."""
        from longwave.support.compiled.source_digest import runs_as_written
        from longwave.support.sealed_file import write_sealed

        if self.path is not None and runs_as_written(self.sources):
            with suppress(OSError), _opened(self.path):
                content = self._title(name) + b"\n" + data
                write_sealed(self.path / name, content, durable=False, mode=FILE_MODE)


@lru_cache
def cache_folder(module: str, *others: str) -> CacheFolder:
    """Return the cache folder, created if needed, of an imported ``module`` and the ``others``."""
    from longwave.support.compiled.source_digest import all_sources, text_digest

    sources = all_sources((module, *others))
    name, refused = f"{module}-{_digest(text_digest(sources))[:20]}", list[str]()
    for base in _bases(Path(str(sys.modules[module].__file__))):
        folder = base / name
        try:
            base.mkdir(BASE_MODE, parents=True, exist_ok=True)
            folder.mkdir(mode=FOLDER_MODE, exist_ok=True)
            with _opened(folder):
                tempfile.TemporaryFile(dir=folder).close()
                os.utime(folder)
        except NotPrivateError as error:
            refused.append(str(error))
            _warn(f"{error}: its files are not used (remove it)")
            continue
        except OSError:
            continue
        _prune(base, module)
        return CacheFolder(folder, sources, tuple(refused))
    _warn(
        "no folder for compiled kernels is writable: this process compiles them anew, which "
        "takes some seconds (set NUMBA_CACHE_DIR to a writable folder)"
    )
    return CacheFolder(None, refused=tuple(refused))


class NotPrivateError(OSError):
    """A cache folder into which others may have put files."""


@contextmanager
def _opened(path: Path) -> Iterator[int | None]:
    """Open a folder, yield its descriptor, if any; raise NotPrivateError if others may write."""
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
    """Raise NotPrivateError if the folder is not the user's alone."""
    fault = "a link" if stat.S_ISLNK(state.st_mode) else _fault(state, FOLDER_MODE ^ 0o777)
    if fault:
        raise NotPrivateError(f"a cache folder must be private to the user, got {path} {fault}")


def _fault(state: os.stat_result, others: int) -> str:
    """Return why others may have written to a file or folder; empty if they cannot have."""
    if not hasattr(os, "geteuid"):
        return ""
    if state.st_uid != os.geteuid():
        return f"of user {state.st_uid}"
    mode = stat.S_IMODE(state.st_mode)
    return f"with the mode {mode:04o}" if mode & others else ""


def _digest(sources: str) -> str:
    """Return the digest of all that machine code depends on: sources, numba's settings and user."""
    settings = numba_settings()
    if hasattr(os, "geteuid"):  # several users may have one NUMBA_CACHE_DIR
        settings.insert(0, f"user {os.geteuid()}")
    return hashlib.sha256("\n".join([sources, *settings]).encode()).hexdigest()


def numba_settings() -> list[str]:
    """Return numba's settings, from the environment and from its file in the current folder."""
    from longwave.support.compiled.source_digest import compiler_settings
    from longwave.support.sealed_file import open_plain

    settings = compiler_settings()
    with suppress(OSError), open(open_plain(".numba_config.yaml"), encoding="utf-8") as stream:
        settings.append(stream.read())
    return settings


def _bases(file: Path) -> Iterator[Path]:
    """Yield the folders that may contain cache folders, in order of preference."""
    chosen = os.environ.get("NUMBA_CACHE_DIR", "")
    if chosen:
        yield Path(chosen)
    yield file.parent / "__pycache__"
    with suppress(RuntimeError):  # no home
        yield _users_cache() / "longwave" / "kernels"


def _users_cache() -> Path:
    """Return the platform's folder for this user's caches."""
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")


def _prune(base: Path, module: str) -> None:
    """Remove the least recently used cache folders of the module in ``base``."""
    try:
        versions = sorted(base.glob(f"{module}-*"), key=lambda path: path.stat().st_mtime)
    except OSError:  # another process has just removed one
        return
    for folder in versions[:-MAX_VERSIONS]:
        shutil.rmtree(folder, ignore_errors=True)


@lru_cache
def _warn(text: str) -> None:
    """Issue the warning ``text`` once, in one line that does not quote the source."""
    warnings.warn_explicit(text, RuntimeWarning, "longwave", 0)
