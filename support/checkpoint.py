"""What a run must remember to be gone on with, bit by bit, by a process that comes after it.

A run is made of loops that take long: each advances one state through given times. All that is
decided between them follows from the run's scene and from what the loops gave; a process that comes
later decides the same again, and its n-th loop is the n-th of the one before. So a loop's number is
its name, and what it must remember is its own state alone.

Who keeps that, and where, is not known here: a `Keeper` does, for all loops in `kept_by`. Without
one a loop remembers nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import Context, ContextVar
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any, Protocol

Memory = dict[str, Any]
"""By name: numbers, texts, arrays, and lists, tuples and dictionaries of them."""

FIRST_COST = 0.01
"""Seconds that keeping a memory is taken to cost before it was done: two flushes to a disk."""


class Keeper(Protocol):
    """Keeps the memories of a run's loops."""

    least: float
    """Seconds that a loop goes on at least before its memory is kept again."""
    share: float
    """The most of a loop's time that keeping its memory may take."""

    def read(self, name: str, task: str) -> Memory | None:
        """What was kept of the loop of that name; None if nothing was, or of another task."""

    def write(self, name: str, task: str, memory: Memory) -> None:
        """Keep it at once, in the place of what was kept before; what is in it changes later."""

    def spared(self, seconds: float) -> None:
        """Count what need not be done again."""

    @property
    def spared_seconds(self) -> float:
        """All that was counted."""


@dataclass
class _Trail:
    """The loops so far, in the order in which they began."""

    keeper: Keeper
    stem: str = ""
    count: int = 0

    def next(self) -> str:
        self.count += 1
        return f"{self.stem}{self.count}"


_TRAIL: ContextVar[_Trail | None] = ContextVar("_TRAIL", default=None)


@contextmanager
def kept_by(keeper: Keeper) -> Iterator[None]:
    """Have the loops that begin in the body remembered."""
    token = _TRAIL.set(_Trail(keeper))
    try:
        yield
    finally:
        _TRAIL.reset(token)


def branches(count: int) -> list[Context]:
    """Contexts for work that is done at once: loops are numbered in each of them by themselves."""
    trail = _TRAIL.get()
    found = [Context() for _ in range(count)]
    for context in found:
        if trail is not None:
            context.run(_TRAIL.set, _Trail(trail.keeper, f"{trail.next()}-"))
    return found


def spared_seconds() -> float:
    """The seconds of loops that were remembered and not done again."""
    trail = _TRAIL.get()
    return 0.0 if trail is None else trail.keeper.spared_seconds


@dataclass
class Loop:
    """One loop: ``memory`` is what one before it left, None if it begins.

    ``begun`` is when it would have begun if it had not been interrupted, as `perf_counter` tells.
    """

    keeper: Keeper | None = None
    name: str = ""
    task: str = ""
    memory: Memory | None = None
    begun: float = field(default_factory=perf_counter)

    def __post_init__(self) -> None:
        self._kept, self._cost = perf_counter(), FIRST_COST
        if self.memory is not None and self.keeper is not None:
            self.begun -= self.memory["seconds"]
            self.keeper.spared(self.memory["seconds"])

    def offer(self, remember: Callable[[], Memory]) -> None:
        """Have kept what ``remember`` gives, if it is time; the loop is between two steps."""
        if self.keeper is not None:
            passed = perf_counter() - self._kept
            if passed >= max(self.keeper.least, self._cost / self.keeper.share):
                self._keep(remember)

    def end(self, remember: Callable[[], Memory]) -> None:
        """Have kept that it has come to its end, unless that takes longer than to do it again."""
        if self.keeper is not None:
            passed = perf_counter() - self._kept
            if self.keeper.share * passed >= self._cost:
                self._keep(remember)

    def _keep(self, remember: Callable[[], Memory]) -> None:
        assert self.keeper is not None
        now = perf_counter()
        self.keeper.write(self.name, self.task, remember() | {"seconds": now - self.begun})
        self._kept = perf_counter()
        self._cost = self._kept - now


def begin_loop(task: str) -> Loop:
    """The loop that begins now, with what was kept of it; ``task`` says in full what it does."""
    trail = _TRAIL.get()
    if trail is None:
        return Loop()
    name = trail.next()
    return Loop(trail.keeper, name, task, trail.keeper.read(name, task))
