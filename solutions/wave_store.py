"""Waves whose numbers are cached on disk, so that later processes need no formulas."""

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any

from longwave.solutions.data_store import DataStore, open_store
from longwave.solutions.numeric_wave import Array, NumericWave, Part, WaveConstants
from longwave.solutions.run.evaluator import PointEvaluator
from longwave.solutions.run.linear_phase import Variables

if TYPE_CHECKING:
    from longwave.solutions.wave import Wave


def kept_wave(maker: str, key: str, make: Callable[[], "Wave"]) -> NumericWave:
    """Return a wave from the numbers cached under ``key``, or call ``make`` and cache them.

    ``maker`` is the module of ``make``. The returned wave calls ``make`` later if more is needed
    than the cache has, such as formulas; its errors are raised then.
    """
    store = open_store(maker, key)
    if store is None:
        return make()
    numbers = store.read("numbers")
    if isinstance(numbers, WaveConstants):
        return _CachedWave(numbers, store, make)
    wave = make()
    store.write("numbers", wave.numbers)
    cached = _CachedWave(wave.numbers, store, make)
    cached.full_wave = wave
    return cached


class _CachedWave(NumericWave):
    """A wave from the disk cache. `full_wave` provides the attributes that need the formulas."""

    def __init__(
        self, numbers: WaveConstants, store: DataStore, make: Callable[[], "Wave"]
    ) -> None:
        super().__init__(numbers, self._part, self._settled)
        self._store, self._make_wave = store, make

    def __reduce__(self) -> tuple[Callable[..., NumericWave], tuple[Any, ...]]:
        return kept_wave, (self._store.maker, self._store.key, self._make_wave)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, _CachedWave):
            return (
                self.__reduce__()[1][:2] == other.__reduce__()[1][:2]
                or self.full_wave == other.full_wave
            )
        return self.full_wave == other

    __hash__ = NumericWave.__hash__

    @cached_property
    def full_wave(self) -> "Wave":
        """The wave with its formulas, built on first access."""
        return self._make_wave()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.full_wave, name)

    def __repr__(self) -> str:
        return repr(self.full_wave)

    def _part(self, part: Part) -> PointEvaluator:
        cached: PointEvaluator | None = self._store.read(part)
        if cached is None:
            cached = self.full_wave._evaluator(part)
            self._store.write(part, cached)
        return cached

    def _settled(
        self, part: Part, variables: Variables, *point: float, highest: int | None = None
    ) -> Array:
        return self.full_wave._settled(part, variables, *point, highest=highest)

    def _out_of_range(self, error: OverflowError) -> str:
        return self.full_wave._out_of_range(error)
