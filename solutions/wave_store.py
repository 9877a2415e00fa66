"""Waves whose numbers are kept from one process to the next: the next one needs no formulas."""

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
    """The wave that ``make`` makes, a function of the module ``maker``, as ``key`` says.

    ``make`` is called where something is not kept, or is asked of a wave that takes formulas; the
    same errors are raised then.
    """
    store = open_store(maker, key)
    if store is None:
        return make()
    numbers = store.read("numbers")
    if isinstance(numbers, WaveConstants):
        return _KeptWave(numbers, store, make)
    wave = make()
    store.write("numbers", wave.numbers)
    found = _KeptWave(wave.numbers, store, make)
    found.made = wave
    return found


class _KeptWave(NumericWave):
    """A wave from disk. What only the formulas know is asked of the wave that is made then."""

    def __init__(
        self, numbers: WaveConstants, store: DataStore, make: Callable[[], "Wave"]
    ) -> None:
        super().__init__(numbers, self._part, self._settled)
        self._store, self._make_wave = store, make

    def __reduce__(self) -> tuple[Callable[..., NumericWave], tuple[Any, ...]]:
        return kept_wave, (self._store.maker, self._store.key, self._make_wave)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, _KeptWave):
            return self.__reduce__()[1][:2] == other.__reduce__()[1][:2] or self.made == other.made
        return self.made == other

    __hash__ = NumericWave.__hash__

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

    def _settled(
        self, part: Part, variables: Variables, *point: float, highest: int | None = None
    ) -> Array:
        return self.made._settled(part, variables, *point, highest=highest)

    def _out_of_range(self, error: OverflowError) -> str:
        return self.made._out_of_range(error)
