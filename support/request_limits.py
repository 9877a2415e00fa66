"""What a request may cost: memory and time, estimated before it begins, refused beyond a limit.

The command line has `--max-memory` and `--max-time`; in Python `request_limits` sets them, and
without it memory alone is limited: to half of what the machine, or the process's group, has.

An estimate knows nothing of what a file holds or how a formula expands. So a limit that is stated
at the command line is enforced as well, by the system (`enforced_memory`).
"""

from __future__ import annotations

import math
import os
import re
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from longwave.support.user_files import cut

SHARE = 0.5
"""Of the memory that there is, what a request may take unless told."""

USUAL_SECONDS = 3600.0
"""What a request of the command line may take unless told."""

LONG = 5.0
"""Seconds from which on a command says beforehand how long it will take."""

UNKNOWN_MACHINE = 4e9
"""Bytes that a machine is taken to have which does not say."""

PROGRAM, BESIDE = 4.8e8, 2.2e8
"""Bytes of data that a command may have in any case, for its libraries and threads (0.39 GB with
`longwave plot` of a scene, of which 0.28 were in use), and those that it has and does not use (0.19
with `longwave fit`). What is in use is limited by `supervision`."""

CGROUPS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")

MEMORY_UNITS = {"": 1.0, "K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}
TIME_UNITS = {"": 1.0, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0, "d": 86_400.0}

_QUANTITY = re.compile(r"\s*(\d{1,12}(?:\.\d{1,12})?(?:e\d{1,2})?)\s*([A-Za-z]*)\s*", re.ASCII)


class OverBudgetError(ValueError):
    """More than a limit allows: a request, or the next runs of a search, which take ``work``."""

    def __init__(self, message: str, work: float = math.nan) -> None:
        super().__init__(message)
        self.work = work


class Cancelled(BaseException):
    """The work is ended by what it tells its progress; who catches every Exception lets it pass."""


@dataclass(frozen=True)
class ExpectedCost:
    """What a request is estimated to cost; ``memory_bytes`` is the most it holds at once.

    Of the ``seconds`` a process takes those ``once``, however many such requests it serves.
    """

    seconds: float = 0.0
    memory_bytes: float = 0.0
    steps: float = 0.0
    once: float = 0.0


@dataclass(frozen=True)
class RequestLimits:
    """The most that a request may take; infinite where there is no limit."""

    memory_bytes: float
    seconds: float


_limits: ContextVar[RequestLimits | None] = ContextVar("limits", default=None)


def current_limits() -> RequestLimits:
    """The limits that hold here: those of the innermost `request_limits`."""
    return _limits.get() or RequestLimits(SHARE * machine_memory(), math.inf)


@contextmanager
def request_limits(
    memory: float | str | None = None, seconds: float | str | None = None
) -> Iterator[RequestLimits]:
    """Other limits in the body: bytes or such as "4G", seconds or such as "30min"; None keeps one.

    Raises ValueError for what is neither.

    >>> with request_limits("2.5G", "2h") as limits:
    ...     limits
    RequestLimits(memory_bytes=2500000000.0, seconds=7200.0)
    """
    before = current_limits()
    limits = RequestLimits(
        before.memory_bytes if memory is None else read_memory("memory", memory),
        before.seconds if seconds is None else read_time("seconds", seconds),
    )
    token = _limits.set(limits)
    try:
        yield limits
    finally:
        _limits.reset(token)


@contextmanager
def enforced_memory(size: float) -> Iterator[None]:
    """Have requests of memory fail in the body where the process has more than ``size`` bytes.

    What fails raises MemoryError. The limit is RLIMIT_DATA: on Linux all private data counts, on
    macOS the heap alone.
    """
    before = resource.getrlimit(resource.RLIMIT_DATA)
    if math.isinf(size):
        yield
        return
    most = int(max(size + BESIDE, PROGRAM))
    if before[0] != resource.RLIM_INFINITY:
        most = min(most, before[0])
    resource.setrlimit(resource.RLIMIT_DATA, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


def check_request(what: str, cost: ExpectedCost, cheaper: str) -> None:
    """Raise OverBudgetError, with the estimate and what makes ``what`` ``cheaper``, or return.

    >>> check_request("the run", ExpectedCost(seconds=3.0, memory_bytes=1e6), "take fewer sites")
    """
    limits = current_limits()
    steps = f" for {cost.steps:.2g} steps" if cost.steps else ""
    if cost.memory_bytes > limits.memory_bytes:
        raise OverBudgetError(
            f"{what} must fit {memory_text(limits.memory_bytes)}, got about "
            f"{memory_text(cost.memory_bytes)} ({cheaper}, or raise --max-memory)"
        )
    if cost.seconds > limits.seconds:
        raise OverBudgetError(
            f"{what} must take at most {duration(limits.seconds)}, got about "
            f"{duration(cost.seconds)}{steps} ({cheaper}, or raise --max-time)"
        )


def is_too_much(cost: ExpectedCost) -> bool:
    """Whether the cost is beyond the limits that hold here."""
    limits = current_limits()
    return cost.memory_bytes > limits.memory_bytes or cost.seconds > limits.seconds


class Announcer:
    """Passes on how many seconds are expected, if they are many and not what was said before.

    >>> told = Announcer(print)
    >>> for seconds in (3.0, 30.0, 40.0, 90.0):
    ...     told(seconds)
    30.0
    90.0
    """

    def __init__(self, announce: Callable[[float], None]) -> None:
        self._announce = announce
        self._said = LONG / 2.0

    def __call__(self, seconds: float) -> None:
        """Announce work to come."""
        if seconds >= max(LONG, 2.0 * self._said):
            self._said = seconds
            self._announce(seconds)


@cache
def machine_memory() -> float:
    """Bytes that this process can have: the machine's, or what its group of processes may take."""
    found = UNKNOWN_MACHINE
    with suppress(ValueError, OSError, AttributeError):
        found = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    for path in CGROUPS:
        with suppress(ValueError, OSError):
            found = min(found, float(Path(path).read_text(encoding="ascii")))
    return found


def read_memory(name: str, given: float | str) -> float:
    """Bytes in ``given``, a number or a text such as "500M"; ValueError for anything else.

    >>> read_memory("--max-memory", "4GB"), read_memory("--max-memory", "none")
    (4000000000.0, inf)
    """
    unit = str(given).strip().upper().removesuffix("B").removesuffix("I")
    return _quantity(name, unit, MEMORY_UNITS, "500M, 4G or none")


def read_time(name: str, given: float | str) -> float:
    """Seconds in ``given``, a number or a text such as "30min"; ValueError for anything else.

    >>> read_time("--max-time", "30min"), read_time("--max-time", 90)
    (1800.0, 90.0)
    """
    return _quantity(name, str(given).strip().lower(), TIME_UNITS, "90s, 30min, 2h, 1d or none")


def _quantity(name: str, text: str, units: dict[str, float], usual: str) -> float:
    if text.lower() in ("none", "inf"):
        return math.inf
    match = _QUANTITY.fullmatch(text)
    if match is None or match[2] not in units or not float(match[1]) > 0:
        raise ValueError(
            f"{name} must be a positive amount, got {cut(text, 60)!r} (such as {usual})"
        )
    return float(match[1]) * units[match[2]]


def memory_text(size: float) -> str:
    """Bytes in the unit that reads best.

    >>> memory_text(2.5e9), memory_text(12e6), memory_text(math.inf)
    ('2.5 GB', '12 MB', 'any memory')
    """
    if math.isinf(size):
        return "any memory" if size > 0 else "no memory"
    for factor, unit in ((1e12, "TB"), (1e9, "GB"), (1e6, "MB")):
        if size >= factor:
            return f"{_two_digits(size / factor)} {unit}"
    return f"{size / 1e3:.3g} kB"


def duration(seconds: float) -> str:
    """Seconds in the unit that reads best, to two digits.

    >>> duration(44.4), duration(600), duration(20_000), duration(1e6), duration(1e12)
    ('44 s', '10 min', '5.6 h', '12 days', '3.2e+04 years')
    """
    for size, unit in ((31_557_600, "years"), (86_400, "days"), (3600, "h"), (60, "min")):
        if seconds >= 2 * size:
            return f"{_two_digits(seconds / size)} {unit}"
    return f"{_two_digits(seconds)} s"


def _two_digits(number: float) -> str:
    return f"{number:.0f}" if 99.5 <= number < 1e4 else f"{number:.2g}"
