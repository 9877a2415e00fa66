"""Checkpoints: what a run needs to be resumed, bit by bit, by a later process.

A run consists of long loops; each advances one state through given times. All decisions between
them follow from the run's scene and from the loops' results. A later process decides the same
again, and its n-th loop is the n-th of the earlier one. So a loop is identified by its number, and
its checkpoint holds only its own state.

A `CheckpointFolder` stores checkpoints as files, for all loops in `checkpoints_in`; outside it,
nothing is stored. A file is sealed and has the stamp of its run, the loop's task and its state as
plain data (`support.plain_data`). A file that is damaged, a link, or of another run, machine or
task is ignored.
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
"""State of a loop, keyed by name: numbers, texts, arrays, and lists, tuples and dictionaries of
these."""

LOOP = ".loop"
"""Suffix of checkpoint files."""

FIRST_COST = 0.01
"""Assumed seconds that the first checkpoint takes: two flushes to a disk."""

NO_CHECKPOINT = "%s: begins anew: %s has no checkpoint of this scene, code and machine"

LEAST = 5.0
"""Least seconds between two checkpoints of a loop: a killed run loses little more work than
that."""

SHARE = 0.01
"""Largest fraction of a run's time that its checkpoints take."""

RETRY_SECONDS = 60.0
"""Seconds before the next attempt after a checkpoint could not be written."""


def run_stamp(key: str) -> str:
    """Return a text with all that determines a run's bits: its ``key``, processor and settings."""
    from longwave.support.compiled.native_code import processor

    return "\n".join([key, processor(), *compiler_settings()])


class CheckpointFolder:
    """Stores the checkpoints of one run's loops in a folder, created for the first of them.

    ``stamp`` contains all that determines the run's bits. A loop runs at least ``least`` seconds
    between two checkpoints, which take at most the fraction ``share`` of its time. A full disk does
    not stop the run: a warning is logged, and the checkpoint tried again later.
    """

    def __init__(
        self, folder: Path, stamp: str, least: float = LEAST, share: float = SHARE
    ) -> None:
        self.least, self.share = least, share
        self._folder, self._stamp = folder, stamp
        self._usual, self._lock = least, Lock()
        self.restored_seconds = 0.0
        """Seconds of work restored from checkpoints so far."""
        self._stored = 0.0
        self.is_recalled = False

    def read(self, name: str, task: str) -> Memory | None:
        """Return the state of the loop ``name``; None if missing or of another run or task."""
        path = self._path(name)
        data = self._content(path) if path in self._loops() else None
        if data is None:
            if path in self._loops():
                LOG.warning("%s is damaged: that part of the run is done again", path)
            return None
        stamp, stored_task, memory = _read(data)
        if memory is None or (stamp, stored_task) != (self._stamp, task):
            return None
        self.is_recalled = True
        return memory

    def write(self, name: str, task: str, memory: Memory) -> None:
        """Store the state of the loop ``name`` now, replacing the loop's earlier checkpoint."""
        data = plain_bytes((self._stamp, task, memory))
        try:
            if os.path.islink(self._folder):
                raise OSError(errno.EINVAL, "is a link (remove it)", str(self._folder))
            self._folder.mkdir(parents=True, exist_ok=True)
            write_sealed(self._path(name), data)
        except OSError as error:
            if self.least != RETRY_SECONDS:
                LOG.warning("%s: the run goes on without a checkpoint", error)
            self.least = RETRY_SECONDS
        else:
            self.least = self._usual

    @property
    def is_begun(self) -> bool:
        """Whether there is a checkpoint with which this run can be resumed."""
        return any(True for _ in self._loop_seconds())

    def _loop_seconds(self) -> Iterator[float]:
        """Yield the seconds of each stored loop of this run, loading one at a time."""
        for path in self._loops():
            stamp, _, memory = _read(self._content(path) or b"")
            if memory is not None and stamp == self._stamp:
                yield memory["seconds"]

    def tell(self, name: str) -> None:
        """Log whether the run called ``name`` is resumed from checkpoints, or cannot be resumed."""
        seconds = list(self._loop_seconds())
        self._stored = sum(seconds)
        if seconds:
            LOG.info("%s: goes on where it was broken off", name)
        elif self._loops():
            LOG.info(NO_CHECKPOINT, name, self._folder)

    def add_restored(self, seconds: float) -> None:
        """Add to the seconds of work restored from checkpoints."""
        with self._lock:
            self.restored_seconds += seconds

    @property
    def stored_seconds(self) -> float:
        """Seconds of stored work that the run has not restored yet."""
        return max(0.0, self._stored - self.restored_seconds)

    def clear(self) -> None:
        """Remove the checkpoints of a finished run, and the folder if it has no other files."""
        if os.path.islink(self._folder):
            return
        for path in self._loops():
            with suppress(OSError):
                path.unlink()
        with suppress(OSError):
            remove_dead_drafts(self._folder)
            self._folder.rmdir()

    def check(self, error: Exception) -> None:
        """Raise ValueError if a checkpoint may be the cause of a resumed run's error."""
        if self.is_recalled:
            raise ValueError(
                f"a checkpoint must have the state of its run, got {self._folder} with "
                f"{type(error).__name__}: {error} (remove it)"
            ) from error

    def _content(self, path: Path) -> bytes | None:
        """Return a file's content, or None if it exceeds the memory limit of requests."""
        return read_sealed(path, current_limits().memory_bytes, untyped=2)

    def _loops(self) -> list[Path]:
        if os.path.islink(self._folder):  # no user typed its name
            return []
        try:
            return sorted(self._folder.glob(f"[!.]*{LOOP}"))
        except OSError:  # a name that is too long, say
            return []

    def _path(self, name: str) -> Path:
        return self._folder / f"{name}{LOOP}"


def _read(data: bytes) -> tuple[str | None, str | None, Memory | None]:
    """Return stamp, task and state from a checkpoint's bytes; None for each if they are invalid."""
    with suppress(ValueError):
        match plain_value(data):
            case (str(stamp), str(task), {"seconds": float()} as memory):
                return stamp, task, memory
    return None, None, None


def fitting(value: Any, like: Any) -> Any:
    """Return a restored value if compiled code can take it in place of the value ``like``.

    Raises ValueError for an array of another type, shape or memory order, or another type of value.

    >>> fitting([1.0], np.zeros(1))
    Traceback (most recent call last):
    ...
    ValueError: a checkpoint must have the state of its run, got list for float64 (1,) (remove it)
    """
    got, expected = _form(value), _form(like)
    if got != expected:
        raise ValueError(
            f"a checkpoint must have the state of its run, got {got} for {expected} (remove it)"
        )
    return value


def _form(value: Any) -> str:
    """Return the type of a value as text; for an array its dtype, shape and memory order."""
    if not isinstance(value, np.ndarray):
        return type(value).__name__
    order = "" if value.flags.c_contiguous else " not in the order of C"
    return f"{value.dtype} {value.shape}{order}"


@dataclass
class _Trail:
    """Counter of the loops of a run, which numbers them in the order in which they begin."""

    keeper: CheckpointFolder
    stem: str = ""
    count: int = 0

    def next(self) -> str:
        self.count += 1
        return f"{self.stem}{self.count}"


_TRAIL: ContextVar[_Trail | None] = ContextVar("_TRAIL", default=None)


@contextmanager
def checkpoints_in(keeper: CheckpointFolder) -> Iterator[None]:
    """Store the loops started in this block in ``keeper``, and resume them from its checkpoints.

    Raises ValueError if a stored state does not fit its loop.
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
    """Return contexts for concurrent work, in each of which loops are numbered separately."""
    trail = _TRAIL.get()
    contexts = [Context() for _ in range(count)]
    for context in contexts:
        if trail is not None:
            context.run(_TRAIL.set, _Trail(trail.keeper, f"{trail.next()}-"))
    return contexts


def restored_seconds() -> float:
    """Return the seconds of work restored from checkpoints in this run."""
    trail = _TRAIL.get()
    return 0.0 if trail is None else trail.keeper.restored_seconds


def stored_seconds() -> float:
    """Return the seconds of stored work that the run has not restored yet."""
    trail = _TRAIL.get()
    return 0.0 if trail is None else trail.keeper.stored_seconds


@dataclass
class Loop:
    """A loop; ``memory`` is its state stored by an earlier process, or None.

    ``begun`` is the `perf_counter` time at which it began, moved back by the seconds of the earlier
    process.
    """

    keeper: CheckpointFolder | None = None
    name: str = ""
    task: str = ""
    memory: Memory | None = None
    begun: float = field(default_factory=perf_counter)

    def __post_init__(self) -> None:
        self._last, self._cost = perf_counter(), FIRST_COST
        if self.memory is not None and self.keeper is not None:
            self.begun -= self.memory["seconds"]
            self.keeper.add_restored(self.memory["seconds"])

    def offer(self, remember: Callable[[], Memory]) -> None:
        """Store the state ``remember()``, between two steps, if a checkpoint is due."""
        if self.keeper is not None:
            elapsed = perf_counter() - self._last
            if elapsed >= max(self.keeper.least, self._cost / self.keeper.share):
                self._store(remember)

    def end(self, remember: Callable[[], Memory]) -> None:
        """Store the final state, ``remember()``, if enough time has passed since the last store."""
        if self.keeper is not None:
            elapsed = perf_counter() - self._last
            if self.keeper.share * elapsed >= self._cost:
                self._store(remember)

    def _store(self, remember: Callable[[], Memory]) -> None:
        """Write a checkpoint of ``remember()`` and measure what it costs."""
        assert self.keeper is not None
        now = perf_counter()
        self.keeper.write(self.name, self.task, remember() | {"seconds": now - self.begun})
        self._last = perf_counter()
        self._cost = self._last - now


def begin_loop(task: str) -> Loop:
    """Return the loop that begins now, with its stored state; ``task`` describes it in full."""
    trail = _TRAIL.get()
    if trail is None:
        return Loop()
    name = trail.next()
    return Loop(trail.keeper, name, task, trail.keeper.read(name, task))
