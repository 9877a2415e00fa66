"""Digest of all that cached code and data are made from: the project's sources, and versions.

It covers the text of every project file that a module imports, directly or indirectly, at once or
later. The code in memory may differ: Python runs old byte code if a file changed without changing
time and size, and a file may change after it was imported. So results of a process are cached only
if it `runs_as_written`.
"""

from __future__ import annotations

import hashlib
import os
import re
import sys
from collections.abc import Iterator
from functools import cache, lru_cache
from importlib.machinery import SourceFileLoader
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGE = "longwave"
"""Name of the project's own package; other packages are covered by their versions."""

HOUSE = Path(__file__).resolve().parents[2]
"""Folder that contains the rooms: a checkout, or the installed package."""

ROOT = Path(__file__).absolute().parents[3]
"""Folder from which the package is imported."""

MAKERS = ("sympy", "mpmath", "python-flint", "numpy", "numba", "llvmlite")
"""Packages whose versions affect cached numbers and machine code."""

KERNEL_MAKERS = ("numba", "llvmlite")
"""Packages that generate a kernel's text; it depends on NumPy only through the layout of arrays."""

Files = tuple[tuple[str, Path], ...]
"""Sorted modules with their files."""


def source_digest(*modules: str) -> str:
    """Return the digest (hexadecimal) of these modules' sources, whether imported yet or not.

    >>> names = "longwave.solutions.run.linear_phase", "longwave.support.compiled.source_digest"
    >>> source_digest(names[0]) == source_digest(names[1])
    False
    """
    return text_digest(all_sources(modules))


@lru_cache
def all_sources(modules: tuple[str, ...]) -> Files:
    """Return every project file that these modules need, found without importing the modules.

    >>> files = dict(all_sources(("longwave.solutions.run.linear_phase",)))
    >>> "longwave.solutions.run.doubledouble" in files
    True
    """
    files: dict[str, Path] = {}
    waiting = [(module, _file(module) or _file_in_memory(module)) for module in modules]
    while waiting:
        module, path = waiting.pop()
        if path is not None and module not in files:
            files[module] = path
            waiting += _imported(module, path)
    return tuple(sorted(files.items()))


@lru_cache
def text_digest(sources: Files) -> str:
    """Return the digest of the sources, and of the versions of Python and `MAKERS`."""
    return _digest(sources, sys.version, MAKERS)


@lru_cache
def kernel_digest(sources: Files) -> str:
    """Return the digest of the sources, and of the versions of Python and `KERNEL_MAKERS`."""
    return _digest(sources, str(sys.implementation.cache_tag), KERNEL_MAKERS)


def _digest(sources: Files, python: str, packages: tuple[str, ...]) -> str:
    """Return the digest of sources, a Python version and the versions of packages."""
    total = hashlib.sha256("\n".join(name for name, _ in sources).encode())
    for _, path in sources:
        total.update(_text_digest(path))
    versions = [python, *(f"{name} {installed_version(name)}" for name in packages)]
    total.update("\n".join(versions).encode())
    return total.hexdigest()


@lru_cache
def are_older(sources: Files) -> bool:
    """Return whether the files of imported modules were last changed before a room was imported."""
    from longwave.support.lazy_exports import BEGUN

    states = (path.stat() for name, path in sources if name in sys.modules)
    return all(max(state.st_mtime, state.st_ctime) < BEGUN for state in states)


@lru_cache
def runs_as_written(sources: Files) -> bool:
    """Return whether the imported modules among ``sources`` run what their files contain now.

    False if Python used old byte code because a file changed without changing time and size. Also
    False if a file is younger than the first import of a room, which may be needlessly strict.
    """
    if not are_older(sources):
        return False
    for name, path in sources:
        loader = getattr(getattr(sys.modules.get(name), "__spec__", None), "loader", None)
        if not isinstance(loader, SourceFileLoader):
            continue
        if loader.get_code(name) != loader.source_to_code(path.read_bytes(), str(path)):
            return False
    return True


@lru_cache
def _text_digest(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


@cache
def _imported(module: str, path: Path) -> tuple[tuple[str, Path], ...]:
    """Return the project's modules, with their files, that a module imports."""
    modules = []
    for stem, inner in _imports(path):
        package = module.split(".")[: None if path.name == "__init__.py" else -1]
        above = _absolute(stem, package)
        names = (f"{above}.{inner}", above) if inner else (above,)
        files = ((name, file) for name in names if (file := _file(name)) is not None)
        modules += [*files][:1]
    return tuple(modules)


_IMPORT = re.compile(
    r"^[ \t]*(?:from[ \t]+([.\w]+)[ \t]+import[ \t]+(?:\(([^)]*)\)|([^\n]*))"
    r"|import[ \t]+([^\n]*))",
    re.MULTILINE,
)
_COMMENT = re.compile(r"#[^\n]*")


def _imports(path: Path) -> Iterator[tuple[str, str]]:
    """Yield a file's imports as (module, name), found faster than by Python's own parser."""
    for stem, inside, plain, modules in _IMPORT.findall(path.read_text(encoding="utf-8")):
        names = _COMMENT.sub("", inside or plain or modules).replace("\\", " ").split(",")
        for name in (words[0] for text in names if (words := text.split())):
            yield (stem, name) if stem else (name, "")


def _absolute(stem: str, package: list[str]) -> str:
    name = stem.lstrip(".")
    level = len(stem) - len(name)
    above = package[: len(package) - level + 1] if level else []
    return ".".join([*above, *([name] if name else [])])


@cache
def _file(module: str) -> Path | None:
    """Return the file of a project module, None for any other name."""
    if module.split(".")[0] != PACKAGE:
        return None
    stem = ROOT.joinpath(*module.split("."))
    files = (stem.with_name(f"{stem.name}.py"), stem / "__init__.py")
    return next((path for path in files if path.is_file()), None)


def _file_in_memory(module: str) -> Path | None:
    """Return the file of an imported module from outside the project, such as a user's, or None."""
    name = getattr(sys.modules.get(module), "__file__", None)
    return None if name is None else Path(name).absolute()


def installed_version(package: str) -> str | None:
    """Return the installed version of a package, or None."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


def compiler_settings() -> list[str]:
    """Return the environment variables that affect how kernels are compiled, and their values."""
    return [
        f"{name}={value}"
        for name, value in sorted(os.environ.items())
        if name.startswith("NUMBA_") and name != "NUMBA_CACHE_DIR"
    ]
