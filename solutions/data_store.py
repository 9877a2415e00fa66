"""Disk cache of data built from formulas, so that later processes need no SymPy.

An entry is found by a key that describes the request, in a folder named by a digest of the
sources that may influence it (`support.compiled.kernel_folder`). Entries are plain data
(`support.plain_data`) and a few types of `solutions`, stored by their contents.
"""

import hashlib
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache
from importlib import import_module
from typing import Any, TypeVar, cast

from longwave.solutions.catalogue import CATALOGUE
from longwave.support.compiled.kernel_folder import CacheFolder, cache_folder
from longwave.support.plain_data import PlainKind, plain_bytes, plain_value

MAX_FILES, SPARE_FILES = 512, 128
"""If a folder has more than ``MAX_FILES + SPARE_FILES`` files, its oldest ones are removed until
``MAX_FILES`` are left. A wave has up to five, of 1 to 40 kB."""

TYPES = {
    "WaveConstants": "numeric_wave",
    "Rates": "numeric_wave",
    "Evaluator": "run.evaluator",
    "RationalEvaluator": "run.rational_evaluator",
    "Program": "run.program",
    "JacobiProgram": "run.program",
    "Bytecode": "run.bytecode",
    "MpmathFormula": "functions.multiprecision",
}
"""Type that an entry may contain -> the type's module in `solutions`. Attributes are plain data."""

Data = TypeVar("Data")


def kept_data(maker: str, key: str, make: Callable[[], Data]) -> Data:
    """Return plain data from the cache, or call ``make`` and cache its result.

    ``maker`` is the module of ``make``: the cache is invalid if that module changes.

    The data must depend on ``key`` and the sources only, not on other files or settings.
    """
    store = open_store(maker, key)
    cached = None if store is None else store.read("data")
    if cached is None:
        cached = make()
        if store is not None:
            store.write("data", cached)
    return cast("Data", cached)


class DataStore:
    """Cache files in ``folder`` of one request: the module that makes the data, and a key."""

    def __init__(self, maker: str, key: str, folder: CacheFolder) -> None:
        self.maker, self.key = maker, key
        self._folder = folder
        self._stem = hashlib.sha256(f"{maker} {key}".encode()).hexdigest()[:32]

    def read(self, part: str) -> Any:
        """Return the entry stored under the name ``part``, None if it is missing or invalid."""
        data = self._folder.read(f"{self._stem}.{part}")
        with suppress(ValueError):
            return None if data is None else plain_value(data, _kind)
        return None

    def write(self, part: str, value: object) -> None:
        """Store ``value`` as ``part`` if possible; remove the oldest files beyond a limit."""
        with suppress(TypeError, ValueError):
            self._folder.write(f"{self._stem}.{part}", plain_bytes(value, _kind))
        folder = self._folder.path
        with suppress(OSError):
            files = [] if folder is None else [*folder.iterdir()]
            if len(files) > MAX_FILES + SPARE_FILES:
                files.sort(key=lambda path: path.stat().st_mtime)
                for path in files[:-MAX_FILES]:
                    path.unlink(missing_ok=True)


@lru_cache
def _kind(name: str) -> PlainKind | None:
    """Return how the type ``name`` is stored and rebuilt; None if entries cannot contain it."""
    if name == "mpf":
        from longwave.solutions.run.linear_phase import LONG, long_of

        return PlainKind(LONG.mpf, lambda number: tuple(map(int, number._mpf_)), long_of)
    if name not in TYPES:
        return None
    type_: Any = getattr(import_module(f"longwave.solutions.{TYPES[name]}"), name)
    if issubclass(type_, tuple):
        return PlainKind(type_, tuple, lambda parts: type_(*parts))

    def rebuild(parts: dict[str, Any]) -> Any:
        value = object.__new__(type_)
        vars(value).update(parts)
        return value

    return PlainKind(type_, vars, rebuild)


def open_store(maker: str, key: str) -> DataStore | None:
    """Return the store for a request; None if no folder can be written.

    Entries may depend on the module ``maker`` and on the closed forms.
    """
    folder = cache_folder(__name__, maker, *CATALOGUE.modules)
    return None if folder.path is None else DataStore(maker, key, folder)
