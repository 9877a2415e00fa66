"""Where machine code and data are kept from one process to the next, under keys of their sources.

What is kept lies in a folder that is named by a digest of all that it is made from
(`support.compiled.source_digest`) and of numba's settings. So nothing old is ever found, and going
back to an earlier source finds what was made from that.

The folder is the first that can be written of ``NUMBA_CACHE_DIR``, the module's ``__pycache__`` and
the user's cache. Where there is none, every process makes all anew, and a warning says so once. A
cache can only save time: whatever is missing, damaged or cannot be written is made anew.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
import warnings
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from longwave.support.compiled.source_digest import Files

KEPT = 8
"""Versions of a module's folder that a cache keeps; the least lately used ones go first."""


@dataclass(frozen=True)
class CacheFolder:
    """The files made from ``sources`` that are kept in the folder ``path``; None keeps nothing.

    Read and written only by a process that runs what the sources say.
    """

    path: Path | None
    sources: Files = ()

    def kept(self, name: str, make: Callable[[], bytes]) -> bytes:
        """The file's content, made if it is not there."""
        data = self.read(name)
        if data is None:
            data = make()
            self.write(name, data)
        return data

    def read(self, name: str) -> bytes | None:
        """The file's content; None if it is not there, or damaged."""
        from longwave.support.compiled.source_digest import are_older
        from longwave.support.sealed_file import read_sealed

        if self.path is None or not are_older(self.sources):
            return None
        return read_sealed(self.path / name)

    def write(self, name: str, data: bytes) -> None:
        """Keep a file, if it can be: a full disk or a folder that is gone is no error."""
        from longwave.support.compiled.source_digest import runs_as_written
        from longwave.support.sealed_file import write_sealed

        if self.path is not None and runs_as_written(self.sources):
            with suppress(OSError):
                write_sealed(self.path / name, data, durable=False)


@lru_cache
def cache_folder(module: str, *others: str) -> CacheFolder:
    """The folder for what an imported module makes, with the ``others``; made if need be."""
    from longwave.support.compiled.source_digest import all_sources, text_digest

    sources = all_sources((module, *others))
    name = f"{module}-{_digest(text_digest(sources))[:20]}"
    for base in _bases(Path(str(sys.modules[module].__file__))):
        folder = base / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
            os.utime(folder)
        except OSError:
            continue
        _prune(base, module)
        return CacheFolder(folder, sources)
    _tell_once()
    return CacheFolder(None)


def _digest(sources: str) -> str:
    """What machine code depends on: the sources and numba's settings."""
    from longwave.support.compiled.source_digest import compiler_settings

    settings = compiler_settings()
    with suppress(OSError):
        settings.append(Path(".numba_config.yaml").read_text(encoding="utf-8"))
    return hashlib.sha256("\n".join([sources, *settings]).encode()).hexdigest()


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
def _tell_once() -> None:
    warnings.warn(
        "no folder for compiled kernels can be written: this process compiles them anew, which "
        "takes some seconds (set NUMBA_CACHE_DIR to a folder that can be written)",
        RuntimeWarning,
        stacklevel=1,
    )
