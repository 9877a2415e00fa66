"""Waves whose numbers are kept from one process to the next, so that the next needs no SymPy.

What is kept is found under a key made of what the wave is asked for with, in a folder named by a
digest of the sources: of all files that making a wave may read. It is written only by a process
that ran what these files say (`runs_as_written`). A cache can only save time: whatever is missing,
damaged or cannot be written is made from the closed form.
"""

import hashlib
import pickle
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

from solutions.catalogue import CATALOGUE
from solutions.numeric_wave import Array, NumericWave, Part, WaveNumbers
from solutions.run.kernel_folder import cache_folder, read_whole, write_whole
from solutions.run.linear_phase import Variables
from solutions.run.program import PointEvaluator
from solutions.run.source_digest import all_sources, runs_as_written, text_digest

if TYPE_CHECKING:
    from solutions.wave import Wave

__all__ = ["kept_data", "kept_wave"]

Data = TypeVar("Data")

MOST_FILES = 512
"""Files in a folder; the oldest go first. A wave has up to five, of 1 to 40 kB."""


def kept_data(maker: str, key: str, make: Callable[[], Data]) -> Data:
    """Plain data that ``make``, a function of the module ``maker``, makes; kept if it can be."""
    store = _store(maker, key)
    kept = None if store is None else store.read("data")
    if kept is None:
        kept = make()
        if store is not None:
            store.write("data", kept)
    return cast("Data", kept)


def kept_wave(maker: str, key: str, make: Callable[[], "Wave"]) -> NumericWave:
    """The wave that ``make`` makes, a function of the module ``maker``, as ``key`` says.

    ``make`` is called where something is not kept, or is asked of a wave that takes formulas; the
    same errors are raised then.
    """
    store = _store(maker, key)
    if store is None:
        return make()
    numbers = store.read("numbers")
    if isinstance(numbers, WaveNumbers):
        return _KeptWave(numbers, store, make)
    wave = make()
    store.write("numbers", wave.numbers)
    found = _KeptWave(wave.numbers, store, make)
    found.made = wave
    return found


def _store(maker: str, key: str) -> "_Store | None":
    modules = (maker, __name__, *sorted({CATALOGUE.module(name) for name in CATALOGUE.names}))
    sources = all_sources(modules)
    folder = cache_folder(__name__, text_digest(sources))
    stem = hashlib.sha256(f"{maker} {key}".encode()).hexdigest()[:32]
    return None if folder is None else _Store(folder / stem, sources)


class _KeptWave(NumericWave):
    """A wave from disk. What only the formulas know is asked of the wave that is made then."""

    def __init__(self, numbers: WaveNumbers, store: "_Store", make: Callable[[], "Wave"]) -> None:
        super().__init__(numbers, self._part, self._settled)
        self._store, self._make_wave = store, make

    @cached_property
    def made(self) -> "Wave":
        """The wave with its formulas."""
        return self._make_wave()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.made, name)

    def __repr__(self) -> str:
        return repr(self.made)

    def _part(self, part: Part) -> PointEvaluator:
        kept = self._store.read(part)
        if kept is None:
            kept = self.made._evaluator(part)
            self._store.write(part, kept)
        found: PointEvaluator = kept
        return found

    def _settled(self, part: Part, variables: Variables, x: float, t: float) -> Array:
        return self.made._settled(part, variables, x, t)

    def _out_of_range(self, error: OverflowError) -> str:
        return self.made._out_of_range(error)


class _Store:
    """The files of one wave."""

    def __init__(self, stem: Path, sources: Sequence[tuple[str, Path]]) -> None:
        self._stem, self._sources = stem, sources

    def read(self, part: str) -> Any:
        """What was kept under that name, None if nothing was."""
        data = read_whole(self._path(part))
        with suppress(Exception):  # of another version of NumPy, say
            return None if data is None else pickle.loads(data)
        return None

    def write(self, part: str, value: object) -> None:
        """Keep it, if what is in memory is what the files say."""
        if not runs_as_written(tuple(self._sources)):
            return
        with suppress(pickle.PicklingError, TypeError, AttributeError):
            write_whole(self._path(part), pickle.dumps(value))
        with suppress(OSError):
            files = sorted(self._stem.parent.iterdir(), key=lambda path: path.stat().st_mtime)
            for path in files[:-MOST_FILES]:
                path.unlink(missing_ok=True)

    def _path(self, part: str) -> Path:
        return self._stem.with_name(f"{self._stem.name}.{part}")
