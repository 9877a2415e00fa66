"""A hard case as data, and what running it returns."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple


class Reading(NamedTuple):
    """The number that a hard case is judged by, what else was seen, and what the program said."""

    value: float
    detail: str
    message: str = ""


@dataclass(frozen=True)
class HardCaseResult:
    """The outcome of one hard case; it passes if ``measured <= bound``.

    ``message`` is what the program tells its user, where the case is about that.
    """

    name: str
    what: str
    criterion: str
    measured: float
    bound: float
    passed: bool
    seconds: float
    detail: str
    message: str = ""


@dataclass(frozen=True)
class HardCase:
    """A hard case to run: ``what`` is done, and the ``criterion``, a number to be bounded.

    Texts hold mathematics between dollars, as claims do. ``slow`` ones take more than about two
    seconds.

    >>> case = HardCase("sum", "0.1 + 0.2", "less 0.3", 1e-15, lambda: Reading(0.1 + 0.2 - 0.3, ""))
    >>> case.run().passed
    True
    """

    name: str
    what: str
    criterion: str
    bound: float
    measure: Callable[[], Reading]
    slow: bool = False

    def run(self) -> HardCaseResult:
        """Measure and judge; NaN does not pass."""
        begun = time.perf_counter()
        value, detail, message = self.measure()
        seconds = time.perf_counter() - begun
        return HardCaseResult(
            self.name,
            self.what,
            self.criterion,
            value,
            self.bound,
            bool(value <= self.bound),
            seconds,
            detail,
            message,
        )
