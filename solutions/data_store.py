"""Data that are kept from one process to the next, so that the next needs no SymPy to make them.

What is kept is found under a key made of what is asked for, in a folder named by a digest of the
sources: of all files that making it may read (`support.compiled.kernel_folder`). It is plain data
(`support.plain_data`) and a few types of `solutions`, told by what they hold.
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

MOST_FILES, SPARE_FILES = 512, 128
"""Files that stay in a folder; the oldest go first, when there are so many more: to look for them
takes as long as a small run. A wave has up to five, of 1 to 40 kB."""

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
"""Those that may stand in what is kept, by the modules of `solutions`: what they hold is plain."""

Data = TypeVar("Data")


def kept_data(maker: str, key: str, make: Callable[[], Data]) -> Data:
    """Plain data that ``make``, a function of the module ``maker``, makes; kept if it can be.

    They must follow from ``key`` and from the sources alone: from no other file and no setting.
    """
    store = open_store(maker, key)
    kept = None if store is None else store.read("data")
    if kept is None:
        kept = make()
        if store is not None:
            store.write("data", kept)
    return cast("Data", kept)


class DataStore:
    """The files of what the module ``maker`` makes of ``key``, in ``folder``."""

    def __init__(self, maker: str, key: str, folder: CacheFolder) -> None:
        self.maker, self.key = maker, key
        self._folder = folder
        self._stem = hashlib.sha256(f"{maker} {key}".encode()).hexdigest()[:32]

    def read(self, part: str) -> Any:
        """What was kept under that name, None if nothing was."""
        data = self._folder.read(f"{self._stem}.{part}")
        with suppress(ValueError):
            return None if data is None else plain_value(data, _kind)
        return None

    def write(self, part: str, value: object) -> None:
        """Keep it, if it can be."""
        with suppress(TypeError, ValueError):
            self._folder.write(f"{self._stem}.{part}", plain_bytes(value, _kind))
        folder = self._folder.path
        with suppress(OSError):
            files = [] if folder is None else [*folder.iterdir()]
            if len(files) > MOST_FILES + SPARE_FILES:
                files.sort(key=lambda path: path.stat().st_mtime)
                for path in files[:-MOST_FILES]:
                    path.unlink(missing_ok=True)


@lru_cache
def _kind(name: str) -> PlainKind | None:
    """The type of that name, or long numbers; None if it has no place in what is kept."""
    if name == "mpf":
        from longwave.solutions.run.linear_phase import LONG, long_of

        return PlainKind(LONG.mpf, lambda number: tuple(map(int, number._mpf_)), long_of)
    if name not in TYPES:
        return None
    cls: Any = getattr(import_module(f"longwave.solutions.{TYPES[name]}"), name)
    if issubclass(cls, tuple):
        return PlainKind(cls, tuple, lambda parts: cls(*parts))

    def made(parts: dict[str, Any]) -> Any:
        value = object.__new__(cls)
        vars(value).update(parts)
        return value

    return PlainKind(cls, vars, made)


def open_store(maker: str, key: str) -> DataStore | None:
    """The store for what the module ``maker`` makes, with the closed forms, of ``key``.

    None where no folder can be written.
    """
    folder = cache_folder(__name__, maker, *CATALOGUE.modules)
    return None if folder.path is None else DataStore(maker, key, folder)
