"""A hard case as data, and what running it returns."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple


class Measurement(NamedTuple):
    """The number that a hard case is judged by, and what else was seen, in words."""

    value: float
    detail: str


@dataclass(frozen=True)
class HardCase:
    """The outcome of one hard case; it passes if ``measured <= bound``."""

    name: str
    what: str
    measured: float
    bound: float
    passed: bool
    seconds: float
    detail: str


@dataclass(frozen=True)
class Case:
    """A hard case to run. ``slow`` ones take more than about two seconds.

    >>> case = Case("sum", "0.1 + 0.2 is 0.3", 1e-15, lambda: Measurement(0.1 + 0.2 - 0.3, ""))
    >>> case.run().passed
    True
    """

    name: str
    what: str
    bound: float
    measure: Callable[[], Measurement]
    slow: bool = False

    def run(self) -> HardCase:
        """Measure and judge; NaN does not pass."""
        begun = time.perf_counter()
        value, detail = self.measure()
        seconds = time.perf_counter() - begun
        passed = bool(value <= self.bound)
        return HardCase(self.name, self.what, value, self.bound, passed, seconds, detail)
