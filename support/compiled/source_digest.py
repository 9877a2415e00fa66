"""A digest of all that a module's compiled kernels are built from.

It covers the module and every module of the project that it imports, directly or through others:
their text, and what of them is in memory.  The text alone would not do: Python runs old byte code
where a file changed and kept time and size, and a file may change after it was imported.  What is
in memory alone would not do either: an intrinsic may reach its helpers in any way it likes.
"""

from __future__ import annotations

import hashlib
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass
from functools import cache, lru_cache
from importlib.machinery import SourceFileLoader
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

__all__ = [
    "Sources",
    "all_sources",
    "imported_sources",
    "runs_as_written",
    "source_digest",
    "text_digest",
]

PACKAGE = "longwave"
"""The project's own package; of all others the version counts."""

HOUSE = Path(__file__).resolve().parents[2]
"""The folder that holds the rooms: a checkout, or the installed package."""

EXACT = ("sympy", "mpmath", "python-flint", "numpy")
"""Packages that exact numbers are made with."""


@dataclass(frozen=True)
class Sources:
    """What a module is built from, directly or through others.

    ``files``: the project's modules with their files.  ``loaded``: those of them that are imported
    along with the module, and not later, inside a function.  ``packages``: all others.
    """

    files: Mapping[str, Path]
    loaded: Set[str]
    packages: Set[str]


@lru_cache
def source_digest(module: str) -> str:
    """The digest (hexadecimal) of what the kernels of the imported ``module`` are built from.

    >>> import longwave.solutions.run.linear_phase
    >>> names = "longwave.solutions.run.linear_phase", "longwave.support.compiled.source_digest"
    >>> source_digest(names[0]) == source_digest(names[1])
    False
    """
    sources = imported_sources(module)
    total = hashlib.sha256()
    for name in sorted(sources.files):
        total.update(_text_digest(sources.files[name]))
    for name in sorted(sources.loaded & sys.modules.keys()):
        total.update(_memory_digest(name))
    versions = [f"{name} {_version(name)}" for name in sorted(sources.packages)]
    total.update("\n".join(versions).encode())
    return total.hexdigest()


Files = tuple[tuple[str, Path], ...]
"""Modules with their files, in order."""


@lru_cache
def all_sources(modules: tuple[str, ...]) -> Files:
    """Every file of the project that these modules import, which need not be imported for that."""
    found: dict[str, Path] = {}
    for module in modules:
        start = _file(HOUSE, module)
        if start is not None and module not in found:
            found |= _sources(module, start).files
    return tuple(sorted(found.items()))


@lru_cache
def text_digest(sources: Files) -> str:
    """The digest of their text, and of the versions of Python and of what exact numbers need."""
    total = hashlib.sha256("\n".join(name for name, _ in sources).encode())
    for _, path in sources:
        total.update(_text_digest(path))
    versions = (f"{name} {_version(name)}" for name in (*EXACT, "sys"))
    total.update("\n".join(versions).encode())
    return total.hexdigest()


@lru_cache
def runs_as_written(sources: Files) -> bool:
    """Whether those of the modules that are imported run what their files say now.

    Not so where Python took old byte code, a file having changed and kept time and size, and
    perhaps not where a file is younger than the first import of a room.
    """
    from longwave.support.lazy_face import BEGUN

    for name, path in sources:
        module = sys.modules.get(name)
        loader = getattr(getattr(module, "__spec__", None), "loader", None)
        if not isinstance(loader, SourceFileLoader):
            continue
        state = path.stat()
        if max(state.st_mtime, state.st_ctime) >= BEGUN:
            return False
        if loader.get_code(name) != loader.source_to_code(path.read_bytes(), str(path)):
            return False
    return True


@lru_cache
def _text_digest(path: Path) -> bytes:
    return hashlib.sha256(path.read_bytes()).digest()


@lru_cache
def _memory_digest(module: str) -> bytes:
    facts = "\n".join(_facts_of_module(sys.modules[module]))
    return hashlib.sha256(f"{module}\n{facts}".encode()).digest()


def imported_sources(module: str) -> Sources:
    """The sources of the imported ``module``.

    >>> sources = imported_sources("longwave.solutions.run.linear_phase")
    >>> "longwave.solutions.run.doubledouble" in sources.loaded, "mpmath" in sources.packages
    (True, True)
    """
    return _sources(module, Path(str(sys.modules[module].__file__)).absolute())


def _sources(module: str, start: Path) -> Sources:
    root = start.parents[len(_package(module, start))]
    files: dict[str, Path] = {}
    loaded: set[str] = set()
    packages = {"numba", "llvmlite", "numpy"}
    waiting = [(module, start, True)]
    while waiting:
        name, path, early = waiting.pop()
        if name in loaded or (name in files and not early):
            continue
        files[name] = path
        loaded |= {name} if early else set()
        for other, file, at_once in _imported(root, name, path):
            if file is not None:
                waiting.append((other, file, early and at_once))
            elif early and at_once:
                packages.add(other)
    return Sources(files, loaded, packages)


@cache
def _imported(root: Path, module: str, path: Path) -> tuple[tuple[str, Path | None, bool], ...]:
    """What a module imports: modules of the project with their files, and packages; if at once."""
    found: list[tuple[str, Path | None, bool]] = []
    for stem, inner, at_once in _imports(path):
        above = _absolute(stem, _package(module, path))
        names = (f"{above}.{inner}", above) if inner else (above,)
        files = ((name, file) for name in names if (file := _file(root, name)) is not None)
        found.append((*next(files, (above.split(".")[0], None)), at_once))
    return tuple(found)


_IMPORT = re.compile(
    r"^([ \t]*)(?:from[ \t]+([.\w]+)[ \t]+import[ \t]+(?:\(([^)]*)\)|([^\n]*))"
    r"|import[ \t]+([^\n]*))",
    re.MULTILINE,
)
_COMMENT = re.compile(r"#[^\n]*")


@cache
def _imports(path: Path) -> tuple[tuple[str, str, bool], ...]:
    """What a file imports: the module (with dots if relative), a name in it, and if at once.

    Read without Python's parser, which would take a tenth of a second for the whole project.
    """
    found = []
    for indent, stem, inside, plain, modules in _IMPORT.findall(path.read_text(encoding="utf-8")):
        names = _COMMENT.sub("", inside or plain or modules).replace("\\", " ").split(",")
        for name in (words[0] for text in names if (words := text.split())):
            found.append((stem, name, not indent) if stem else (name, "", not indent))
    return tuple(found)


def _absolute(stem: str, package: list[str]) -> str:
    name = stem.lstrip(".")
    level = len(stem) - len(name)
    above = package[: len(package) - level + 1] if level else []
    return ".".join([*above, *([name] if name else [])])


def _package(module: str, path: Path) -> list[str]:
    parts = module.split(".")
    return parts if path.name == "__init__.py" else parts[:-1]


@cache
def _file(root: Path, module: str) -> Path | None:
    """The file of a module of the project, None for any other name."""
    if module.split(".")[0] != PACKAGE:
        return None
    stem = root.joinpath(*module.split("."))
    files = (stem.with_name(f"{stem.name}.py"), stem / "__init__.py")
    return next((path for path in files if path.is_file()), None)


@cache
def _version(package: str) -> str:
    """The version of an installed package; that of Python for one of its own modules."""
    if package in sys.stdlib_module_names:
        return sys.version
    try:
        return version(package)
    except PackageNotFoundError:
        return ""


def _facts_of_module(module: ModuleType) -> Iterator[str]:
    """Byte code and constants of a module, one text each.

    Functions and classes of other modules are theirs to tell.
    """
    for name, value in sorted(vars(module).items()):
        is_own = getattr(value, "__module__", None) in (None, module.__name__)
        if is_own and not (name.startswith("__") and name.endswith("__")):
            yield from (f"{name}: {fact}" for fact in _facts(value))


def _facts(value: Any) -> Iterator[str]:
    """What numba could build into a kernel of a module's value."""
    code = _code(value)
    if code is not None:
        yield from _code_facts(code)
    elif isinstance(value, type):
        for name, member in sorted(vars(value).items()):
            inner = _code(getattr(member, "__func__", member))
            if inner is not None:
                yield from (f"{name}: {fact}" for fact in _code_facts(inner))
    elif isinstance(value, _array_types()):
        yield f"{value.dtype} {value.shape} {hashlib.sha256(value.tobytes()).hexdigest()}"
    elif isinstance(value, tuple):
        yield from (fact for item in value for fact in _facts(item))
    elif isinstance(value, bool | int | float | complex | str | bytes):
        yield repr(value)


@lru_cache(maxsize=1)
def _array_types() -> Any:
    import numpy as np  # with kernels; data are kept without

    return np.ndarray, np.generic


def _code(value: Any) -> CodeType | None:
    """The code of a function, of numba's dispatcher or intrinsic about one, or of a property."""
    for name in ("py_func", "_defn", "fget", "__wrapped__"):
        inner = getattr(value, name, None) if not isinstance(value, type) else None
        value = inner if hasattr(inner, "__code__") else value
    code = getattr(value, "__code__", None)
    return code if isinstance(code, CodeType) else None


def _code_facts(code: CodeType) -> Iterator[str]:
    yield f"{code.co_code.hex()} {code.co_names} {code.co_varnames} {code.co_freevars}"
    yield from _constant_facts(code.co_consts)


def _constant_facts(constants: Iterable[Any]) -> Iterator[str]:
    for constant in constants:
        if isinstance(constant, CodeType):
            yield from _code_facts(constant)
        elif isinstance(constant, frozenset):
            yield repr(sorted(map(repr, constant)))
        elif isinstance(constant, tuple):
            yield from _constant_facts(constant)
        else:
            yield repr(constant)
