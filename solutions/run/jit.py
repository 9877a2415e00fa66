"""Numba's ``njit`` with a cache on disk that follows the sources.

Numba's own cache looks at the one file in which a kernel stands: it serves old machine code after
a change in a function, an intrinsic or a constant that the kernel takes from another file.  Here a
kernel's machine code lies in a folder that is named by a digest of all that it is built from: the
text of every file of the project that its module imports, directly or through others; the byte
code and the constants that these modules hold in memory (Python's own cache of byte code can be
stale as well); the versions of numba, llvmlite, NumPy and of what else these files import; numba's
settings.  The processor is in the key of each entry.  So nothing old is ever found, and going back
to an earlier source finds what was compiled from that.

The folder is the first that can be written of ``NUMBA_CACHE_DIR``, the module's ``__pycache__`` and
the user's cache.  Where there is none, every process compiles anew, and a warning says so once.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import shutil
import sys
import tempfile
import uuid
import warnings
from collections.abc import Callable, Iterator
from functools import cached_property, lru_cache, partial
from importlib import import_module
from pathlib import Path
from types import FunctionType
from typing import Any

import numba
from numba.core import config
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    NullCache,
    _CacheLocator,
)
from numba.core.registry import CPUDispatcher
from numba.core.serialize import dumps
from numba.misc.appdirs import AppDirs
from numba.np import linalg as numba_linalg

from solutions.run.source_digest import source_digest

__all__ = ["njit"]

KEPT = 8
"""Versions of a module's kernels that a cache keeps; the least lately used ones go first."""


def njit(
    *, cache: bool = False, inner: bool = False, **options: Any
) -> Callable[[Callable[..., Any]], Any]:
    """``numba.njit(**options)``; with ``cache``, machine code is kept from one process to the next.

    An ``inner`` function is called from other compiled ones alone: without an entry for Python it
    compiles in half the time.

    >>> @njit(error_model="numpy")
    ... def half(x):
    ...     return 0.5 * x
    >>> half(3.0)
    1.5
    """

    if inner:
        options |= {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}

    def compiled(function: Callable[..., Any]) -> Any:
        kernel = numba.njit(**options)(function)
        if inner and isinstance(kernel, CPUDispatcher):
            kernel.__class__ = _Inner
        if cache and hasattr(kernel, "_cache"):  # numba returns the function where it is disabled
            kernel._cache = KernelCache(function)
        return kernel

    return compiled


class _Inner(CPUDispatcher):
    def __call__(self, *_: Any, **__: Any) -> Any:
        raise TypeError(
            f"{self.py_func.__name__} must be called from compiled code (it has no other entry)"
        )


class KernelCache(NullCache):
    """The cache of one kernel, opened when the kernel is first called.

    A cache can only save time: whatever goes wrong in it (a full disk, a damaged file, a folder
    removed by another process) means that the kernel is compiled.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._function = function

    @cached_property
    def _files(self) -> NullCache | FunctionCache:
        folder = cache_folder(self._function.__module__)
        return NullCache() if folder is None else _FolderCache(self._function, folder)

    @property
    def cache_path(self) -> str | None:
        """The folder with the machine code, None if there is none."""
        path: str | None = self._files.cache_path
        return path

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel for that signature, None if it is not there."""
        _load_numba_without_blas()
        try:
            return self._files.load_overload(sig, target_context)
        except Exception:
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep the compiled kernel."""
        try:
            self._files.save_overload(sig, data)
        except (OSError, pickle.PicklingError):
            return


@lru_cache
def _load_numba_without_blas() -> None:
    """Spare the 0.2 s that numba takes to import SciPy's BLAS, which is there, before any kernel.

    What needs it (``np.dot`` in a kernel) imports it then.
    """
    ensure = numba_linalg.ensure_blas
    numba_linalg.ensure_blas = lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        numba_linalg.ensure_blas = ensure


class _FolderCache(FunctionCache):
    """Numba's cache of a function in a given folder, one file for each signature."""

    def __init__(self, function: Callable[..., Any], folder: Path) -> None:
        self._impl_class: Any = partial(_FolderImplementation, folder)
        super().__init__(function)
        self._cache_file: Any = _Overloads(folder, self._impl.filename_base)


class _FolderImplementation(CompileResultCacheImpl):
    """How numba is told the folder, whatever locators the user has configured."""

    def __init__(self, folder: Path, function: FunctionType) -> None:
        self._lineno = function.__code__.co_firstlineno
        self._locator = _FolderLocator(folder, function)
        abiflags = getattr(sys, "abiflags", "")
        self._filename_base = self.get_filename_base(function.__qualname__, abiflags)


class _FolderLocator(_CacheLocator):
    def __init__(self, folder: Path, function: FunctionType) -> None:
        self._folder = folder
        self._lineno = function.__code__.co_firstlineno
        self._py_file = function.__code__.co_filename

    def get_cache_path(self) -> str:
        return str(self._folder)

    def get_source_stamp(self) -> str:
        return self._folder.name

    def get_disambiguator(self) -> str:
        return str(self._lineno)


class _Overloads:
    """The machine code of one kernel, a file for each key (signature and processor).

    Numba's own index numbers the files: two processes that write at once can give one number to two
    signatures.  A file that names its key cannot be mistaken.
    """

    def __init__(self, folder: Path, base: str) -> None:
        self._folder = folder
        self._base = base

    def _path(self, key: Any) -> Path:
        return (
            self._folder / f"{self._base}.{hashlib.sha256(str(key).encode()).hexdigest()[:16]}.nbc"
        )

    def load(self, key: Any) -> Any:
        """The data saved under ``key``, None if there are none."""
        path = self._path(key)
        if not path.is_file():
            return None
        found, data = pickle.loads(path.read_bytes())
        return data if found == key else None

    def save(self, key: Any, data: Any) -> None:
        """Write the data under ``key``; readers see the whole file or none."""
        path = self._path(key)
        draft = path.with_suffix(f".{uuid.uuid4().hex[:16]}")
        try:
            draft.write_bytes(dumps((key, data)))
            draft.replace(path)
        finally:
            draft.unlink(missing_ok=True)

    def flush(self) -> None:
        """Remove the files."""
        for path in self._folder.glob(f"{self._base}.*.nbc"):
            path.unlink(missing_ok=True)


@lru_cache
def cache_folder(module: str) -> Path | None:
    """The folder for the kernels of an imported module, made if need be; None if none can be."""
    name = f"{module}-{_digest(module)[:20]}"
    for base in _bases(Path(str(sys.modules[module].__file__))):
        folder = base / name
        try:
            folder.mkdir(parents=True, exist_ok=True)
            tempfile.TemporaryFile(dir=folder).close()
            os.utime(folder)
        except OSError:
            continue
        _prune(base, module)
        return folder
    _tell_once()
    return None


def _digest(module: str) -> str:
    """What the machine code depends on: the sources and numba's settings."""
    settings = ("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "DEBUGINFO_DEFAULT")
    values = [f"{name} {getattr(config, name, None)}" for name in settings]
    return hashlib.sha256("\n".join([source_digest(module), *values]).encode()).hexdigest()


def _bases(file: Path) -> Iterator[Path]:
    chosen = getattr(config, "CACHE_DIR", "")
    if chosen:
        yield Path(chosen)
    yield file.parent / "__pycache__"
    yield Path(AppDirs("longwave", appauthor=False).user_cache_dir) / "kernels"


def _prune(base: Path, module: str) -> None:
    """Remove the least lately used versions of the module's kernels."""
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
