"""What a run must remember to be gone on with, bit by bit, by a process that comes after it.

A run is made of loops that take long: each advances one state through given times. All that is
decided between them follows from the run's scene and from what the loops gave; a process that comes
later decides the same again, and its n-th loop is the n-th of the one before. So a loop's number is
its name, and what it must remember is its own state alone.

A `CheckpointFolder` keeps that as files, for all loops in `kept_by`; without one a loop remembers
nothing. A file, which is sealed, has the stamp of its run, the loop's task and memory as plain data
(`support.plain_data`). One that is damaged, of another run, another machine or another task is not
read, nor is a link.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from contextvars import Context, ContextVar
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Any

import numpy as np

from longwave.support.atomic_file import remove_dead_drafts
from longwave.support.compiled.source_digest import compiler_settings
from longwave.support.plain_data import plain_bytes, plain_value
from longwave.support.request_limits import current_limits
from longwave.support.sealed_file import LOG, read_sealed, write_sealed

Memory = dict[str, Any]
"""By name: numbers, texts, arrays, and lists, tuples and dictionaries of them."""

LOOP = ".loop"
"""Suffix of a checkpoint's file."""

FIRST_COST = 0.01
"""Seconds that keeping a memory is taken to cost before it was done: two flushes to a disk."""

ANEW = "%s: begins anew: %s holds nothing of this scene, code and machine"

LEAST = 5.0
"""Seconds between two checkpoints of a loop: what a kill loses at most."""

SHARE = 0.01
"""The most of a run's time that its checkpoints take."""

PATIENCE = 60.0
"""Seconds until it is tried again where a checkpoint could not be written."""


def run_stamp(key: str) -> str:
    """What the bits of the run of that key follow from: another machine's may be others."""
    from longwave.support.compiled.native_code import processor

    return "\n".join([key, processor(), *compiler_settings()])


class CheckpointFolder:
    """Keeps the memories of one run's loops in a folder, which is made for the first of them.

    ``stamp`` is all that the run's bits follow from. A loop goes on ``least`` seconds before its
    memory is kept again, which takes at most the ``share`` of its time. A disk that is full stops
    no run: that is told, and tried again later.
    """

    def __init__(
        self, folder: Path, stamp: str, least: float = LEAST, share: float = SHARE
    ) -> None:
        self.least, self.share = least, share
        self._folder, self._stamp = folder, stamp
        self._usual, self._lock = least, Lock()
        self._spared, self._held = 0.0, 0.0
        self.is_recalled = False

    def read(self, name: str, task: str) -> Memory | None:
        """What was kept of the loop of that name; None if nothing that fits was."""
        path = self._path(name)
        data = self._content(path) if path in self._loops() else None
        if data is None:
            if path in self._loops():
                LOG.warning("%s is damaged: that part of the run is done again", path)
            return None
        stamp, kept_task, memory = _read(data)
        if memory is None or (stamp, kept_task) != (self._stamp, task):
            return None
        self.is_recalled = True
        return memory

    def write(self, name: str, task: str, memory: Memory) -> None:
        """Keep it at once, in the place of what was kept before; what is in it changes later."""
        data = plain_bytes((self._stamp, task, memory))
        try:
            if os.path.islink(self._folder):
                raise OSError(errno.EINVAL, "a link is there", str(self._folder))
            self._folder.mkdir(parents=True, exist_ok=True)
            write_sealed(self._path(name), data)
        except OSError as error:
            if self.least != PATIENCE:
                LOG.warning("%s: the run goes on without a checkpoint", error)
            self.least = PATIENCE
        else:
            self.least = self._usual

    @property
    def is_begun(self) -> bool:
        """Whether anything was kept that this run can go on with."""
        return any(True for _ in self._kept())

    def _kept(self) -> Iterator[float]:
        """The seconds of each loop that was kept of this run, with one in memory at a time."""
        for path in self._loops():
            stamp, _, memory = _read(self._content(path) or b"")
            if memory is not None and stamp == self._stamp:
                yield memory["seconds"]

    def tell(self, name: str) -> None:
        """Tell whether the run of that name goes on with what was kept, or can not."""
        kept = list(self._kept())
        self._held = sum(kept)
        if kept:
            LOG.info("%s: goes on where it was broken off", name)
        elif self._loops():
            LOG.info(ANEW, name, self._folder)

    def spared(self, seconds: float) -> None:
        """Count what need not be done again."""
        with self._lock:
            self._spared += seconds

    @property
    def spared_seconds(self) -> float:
        """All that was counted."""
        return self._spared

    @property
    def kept_seconds(self) -> float:
        """Those of what was kept, and is still to be found again."""
        return max(0.0, self._held - self._spared)

    def clear(self) -> None:
        """Remove what was kept: the run is finished. A folder that holds other files stays."""
        if os.path.islink(self._folder):
            return
        for path in self._loops():
            with suppress(OSError):
                path.unlink()
        with suppress(OSError):
            remove_dead_drafts(self._folder)
            self._folder.rmdir()

    def check(self, error: Exception) -> None:
        """Raise ValueError if what was kept may be why a run that goes on has the error."""
        if self.is_recalled:
            raise ValueError(
                f"a checkpoint must hold what its run remembers, got {self._folder} with "
                f"{type(error).__name__}: {error} (remove it)"
            ) from error

    def _content(self, path: Path) -> bytes | None:
        """That of a file, unless it would not fit the memory that a request may take."""
        return read_sealed(path, current_limits().memory_bytes, untyped=2)

    def _loops(self) -> list[Path]:
        if os.path.islink(self._folder):  # nobody has typed its name
            return []
        try:
            return sorted(self._folder.glob(f"[!.]*{LOOP}"))
        except OSError:  # a name that is too long, say
            return []

    def _path(self, name: str) -> Path:
        return self._folder / f"{name}{LOOP}"


def _read(data: bytes) -> tuple[str | None, str | None, Memory | None]:
    """Stamp, task and memory; none of them in what no checkpoint holds."""
    with suppress(ValueError):
        match plain_value(data):
            case (str(stamp), str(task), {"seconds": float()} as memory):
                return stamp, task, memory
    return None, None, None


def fitting(value: Any, like: Any) -> Any:
    """The value that a memory has in the place of ``like``, which machine code takes.

    Raises ValueError for an array of another type, shape or order than it, or in its place.

    >>> fitting([1.0], np.zeros(1))
    Traceback (most recent call last):
    ...
    ValueError: a checkpoint must hold what its run remembers, got list for float64 (1,) (remove it)
    """
    one, other = _form(value), _form(like)
    if one != other:
        raise ValueError(
            f"a checkpoint must hold what its run remembers, got {one} for {other} (remove it)"
        )
    return value


def _form(value: Any) -> str:
    if not isinstance(value, np.ndarray):
        return type(value).__name__
    order = "" if value.flags.c_contiguous else " not in the order of C"
    return f"{value.dtype} {value.shape}{order}"


@dataclass
class _Trail:
    """The loops so far, in the order in which they began."""

    keeper: CheckpointFolder
    stem: str = ""
    count: int = 0

    def next(self) -> str:
        self.count += 1
        return f"{self.stem}{self.count}"


_TRAIL: ContextVar[_Trail | None] = ContextVar("_TRAIL", default=None)


@contextmanager
def kept_by(keeper: CheckpointFolder) -> Iterator[None]:
    """Have the loops that begin in the body remembered.

    Raises ValueError where what was kept is not what they remember.
    """
    token = _TRAIL.set(_Trail(keeper))
    try:
        yield
    except (LookupError, TypeError, AttributeError) as error:
        keeper.check(error)
        raise
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


def kept_seconds() -> float:
    """The seconds of loops that are remembered and that the run has not come to yet."""
    trail = _TRAIL.get()
    return 0.0 if trail is None else trail.keeper.kept_seconds


@dataclass
class Loop:
    """One loop: ``memory`` is what one before it left, None if it begins.

    ``begun`` is when it would have begun if it had not been interrupted, as `perf_counter` tells.
    """

    keeper: CheckpointFolder | None = None
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
