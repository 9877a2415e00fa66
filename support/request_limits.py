"""Limits of a request's memory and time, estimated before it begins and refused beyond a limit.

The command line has `--max-memory` and `--max-time`; in Python `request_limits` sets them. Without
it only memory is limited, to half of what the machine, or the process's group, has.

An estimate does not know the size of a file's content or of an expanded formula. A limit that is
stated on the command line is therefore also enforced by the system (`enforced_memory`).
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

MEMORY_FRACTION = 0.5
"""Default fraction of the available memory that a request may take."""

USUAL_SECONDS = 3600.0
"""Default limit, in seconds, on a request of the command line."""

LONG = 5.0
"""Least expected seconds that a command announces."""

UNKNOWN_MACHINE = 4e9
"""Bytes of memory that are assumed if the machine does not report its memory."""

PROGRAM_BYTES, UNUSED_BYTES = 4.8e8, 2.2e8
"""Bytes of data that a command may have in any case, for its libraries and threads (0.39 GB with
`longwave plot` of a scene, of which 0.28 were in use), and bytes allocated but unused (0.19 GB with
`longwave fit`). Memory in use is limited by `supervision`."""

CGROUPS = ("/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes")

MEMORY_UNITS = {"": 1.0, "K": 1e3, "M": 1e6, "G": 1e9, "T": 1e12}
TIME_UNITS = {"": 1.0, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0, "d": 86_400.0}

_QUANTITY = re.compile(r"\s*(\d{1,12}(?:\.\d{1,12})?(?:e\d{1,2})?)\s*([A-Za-z]*)\s*", re.ASCII)


class OverBudgetError(ValueError):
    """A request, or the next runs of a search, exceed a limit; ``work`` is that of the runs."""

    def __init__(self, message: str, work: float = math.nan) -> None:
        super().__init__(message)
        self.work = work


class Cancelled(BaseException):
    """Work was ended by its progress callback; not an Exception, so that handlers ignore it."""


@dataclass(frozen=True)
class ExpectedCost:
    """Estimated cost of a request; ``memory_bytes`` is its peak memory.

    The part ``once`` of ``seconds`` is spent only once by a process, however many such requests it
    serves.
    """

    seconds: float = 0.0
    memory_bytes: float = 0.0
    steps: float = 0.0
    once: float = 0.0


@dataclass(frozen=True)
class RequestLimits:
    """Limits of a request; a limit that is not set is infinite."""

    memory_bytes: float
    seconds: float


_limits: ContextVar[RequestLimits | None] = ContextVar("limits", default=None)


def current_limits() -> RequestLimits:
    """Return the limits of the innermost `request_limits`, or the defaults."""
    return _limits.get() or RequestLimits(MEMORY_FRACTION * machine_memory(), math.inf)


@contextmanager
def request_limits(
    memory: float | str | None = None, seconds: float | str | None = None
) -> Iterator[RequestLimits]:
    """Set limits in the block: bytes or "4G", seconds or "30min"; None keeps the outer limit.

    Raises ValueError for other values.

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
    """Make allocations beyond ``size`` bytes of data (RLIMIT_DATA) fail with MemoryError."""
    before = resource.getrlimit(resource.RLIMIT_DATA)
    if math.isinf(size):
        yield
        return
    most = int(max(size + UNUSED_BYTES, PROGRAM_BYTES))
    if before[0] != resource.RLIM_INFINITY:
        most = min(most, before[0])
    resource.setrlimit(resource.RLIMIT_DATA, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


def check_request(work: str, cost: ExpectedCost, cheaper: str) -> None:
    """Raise OverBudgetError if the cost exceeds the limits; the message suggests ``cheaper``.

    >>> check_request("the run", ExpectedCost(seconds=3.0, memory_bytes=1e6), "take fewer sites")
    """
    limits = current_limits()
    steps = f" for {cost.steps:.2g} steps" if cost.steps else ""
    if cost.memory_bytes > limits.memory_bytes:
        raise OverBudgetError(
            f"{work} must fit {memory_text(limits.memory_bytes)}, got about "
            f"{memory_text(cost.memory_bytes)} ({cheaper}, or raise --max-memory)"
        )
    if cost.seconds > limits.seconds:
        raise OverBudgetError(
            f"{work} must take at most {duration(limits.seconds)}, got about "
            f"{duration(cost.seconds)}{steps} ({cheaper}, or raise --max-time)"
        )


def is_too_much(cost: ExpectedCost) -> bool:
    """Return whether the cost exceeds the current limits."""
    limits = current_limits()
    return cost.memory_bytes > limits.memory_bytes or cost.seconds > limits.seconds


class Announcer:
    """Callback that announces expected seconds of `LONG` or more, again only if they have doubled.

    >>> told = Announcer(print)
    >>> for seconds in (3.0, 30.0, 40.0, 90.0):
    ...     told(seconds)
    30.0
    90.0
    """

    def __init__(self, announce: Callable[[float], None]) -> None:
        self._announce = announce
        self._announced = LONG / 2.0

    def __call__(self, seconds: float) -> None:
        """Announce the seconds if they are `LONG` or more, and twice the last ones announced."""
        if seconds >= max(LONG, 2.0 * self._announced):
            self._announced = seconds
            self._announce(seconds)


@cache
def machine_memory() -> float:
    """Return the machine's memory in bytes, or that of this process's control group if less."""
    size = UNKNOWN_MACHINE
    with suppress(ValueError, OSError, AttributeError):
        size = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    for path in CGROUPS:
        with suppress(ValueError, OSError):
            size = min(size, float(Path(path).read_text(encoding="ascii")))
    return size


def read_memory(name: str, amount: float | str) -> float:
    """Parse bytes from a number or a text such as "500M". Raises ValueError for other texts.

    >>> read_memory("--max-memory", "4GB"), read_memory("--max-memory", "none")
    (4000000000.0, inf)
    """
    unit = str(amount).strip().upper().removesuffix("B").removesuffix("I")
    return _quantity(name, unit, MEMORY_UNITS, "500M, 4G or none")


def read_time(name: str, amount: float | str) -> float:
    """Parse seconds from a number or a text such as "30min". Raises ValueError for other texts.

    >>> read_time("--max-time", "30min"), read_time("--max-time", 90)
    (1800.0, 90.0)
    """
    return _quantity(name, str(amount).strip().lower(), TIME_UNITS, "90s, 30min, 2h, 1d or none")


def _quantity(name: str, text: str, units: dict[str, float], usual: str) -> float:
    """Parse a positive amount with one of the units, given by name with their sizes."""
    if text.lower() in ("none", "inf"):
        return math.inf
    match = _QUANTITY.fullmatch(text)
    if match is None or match[2] not in units or not float(match[1]) > 0:
        raise ValueError(
            f"{name} must be a positive amount, got {cut(text, 60)!r} (such as {usual})"
        )
    return float(match[1]) * units[match[2]]


def memory_text(size: float) -> str:
    """Return bytes as text in a readable unit.

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
    """Return seconds as text in a readable unit, to two digits.

    >>> duration(44.4), duration(600), duration(20_000), duration(1e6), duration(1e12)
    ('44 s', '10 min', '5.6 h', '12 days', '3.2e+04 years')
    """
    for size, unit in ((31_557_600, "years"), (86_400, "days"), (3600, "h"), (60, "min")):
        if seconds >= 2 * size:
            return f"{_two_digits(seconds / size)} {unit}"
    return f"{_two_digits(seconds)} s"


def _two_digits(number: float) -> str:
    """Return the number as text with two digits; from 99.5 to 1e4 as an integer."""
    return f"{number:.0f}" if 99.5 <= number < 1e4 else f"{number:.2g}"
