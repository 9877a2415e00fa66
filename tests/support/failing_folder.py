"""A folder that behaves, for one process, like one on an unreliable network file system.

For names in that folder alone, the process sees what the client of such a file system reports:

* a request that succeeded and is repeated fails: EEXIST of link and mkdir, ENOENT of rename, unlink
and rmdir;
* ESTALE, at random, when a name is looked up, and for an open file that another process removed;
* attributes of a name, or its absence, may be outdated for some time, until this process changes
the name, opens it, or (for an absent name) lists its folder or creates something there;
* no folder and no file is flushed: no power fails here;
* locks work, are refused (ENOLCK, EOPNOTSUPP, ENOSYS), or are granted to everybody; links are made
or refused.
"""

from __future__ import annotations

import errno
import fcntl
import os
import random
import stat
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

WORK, REFUSED, BLIND = "work", "refused", "blind"
"""Kinds of locks: working, refused with an error, and excluding nobody."""

REPEATED = {
    "link": errno.EEXIST,
    "mkdir": errno.EEXIST,
    "replace": errno.ENOENT,
    "unlink": errno.ENOENT,
    "rmdir": errno.ENOENT,
}
"""Error of a request that is repeated after it succeeded."""

FLOCK_ERRORS = (errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOSYS)


def failure(number: int, path: object) -> OSError:
    return OSError(number, os.strerror(number), str(path))


OTHERS = ("stat", "lstat", "fstat", "open", "scandir", "fsync")
"""Requests that are handled by the methods of these names."""


@dataclass
class FailingFolder:
    """The folder as one process sees it, from its first use on."""

    folder: str
    seed: int = 0
    repeated: float = 0.1
    """Rate at which a request is repeated."""
    stale: float = 0.1
    """Rate at which a name is stale."""
    locks: str = WORK
    links: bool = True
    old: float = 0.2
    """Seconds for which attributes are cached."""
    _cached: dict[tuple[str, bool], tuple[float, os.stat_result | None]] = field(
        default_factory=dict
    )
    _has_failed: bool = False

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)
        self._os = {name: getattr(os, name) for name in (*REPEATED, *OTHERS)}
        self._flock = fcntl.flock

    @contextmanager
    def seen(self) -> Iterator[None]:
        """Replace the requests of this process in the body."""
        with pytest.MonkeyPatch.context() as patch:
            for name in REPEATED:
                patch.setattr(os, name, self._changing(name))
            for name in OTHERS:
                patch.setattr(os, name, getattr(self, f"_{name}"))
            patch.setattr(fcntl, "flock", self._locking)
            yield

    def _holds(self, path: object) -> bool:
        if isinstance(path, int):
            path = os.readlink(f"/proc/self/fd/{path}").removesuffix(" (deleted)")
        return str(path).startswith(self.folder)

    def _fails(self, rate: float) -> bool:
        """Return whether this request fails; not twice in a row, because a client repeats it."""
        self._has_failed = not self._has_failed and self._random.random() < rate
        return self._has_failed

    def _go_stale(self, path: Any) -> None:
        """Raise ESTALE now and then, for files only: nobody replaces a folder."""
        if self._fails(self.stale) and stat.S_ISREG(self._mode(path)):
            raise failure(errno.ESTALE, path)

    def _mode(self, path: Any) -> int:
        with suppress(FileNotFoundError):
            return int(self._os["lstat"](path).st_mode)
        return 0

    def _forget(self, *paths: object) -> None:
        """Drop cached attributes of the names, and of absent names next to them."""
        for path in map(str, paths):
            self._forget_absent(os.path.dirname(path))
            for follow in (True, False):
                self._cached.pop((path, follow), None)

    def _forget_absent(self, folder: str) -> None:
        for name, follow in list(self._cached):
            if os.path.dirname(name) == folder and self._cached[name, follow][1] is None:
                del self._cached[name, follow]

    def _changing(self, name: str) -> Callable[..., Any]:
        def change(*given: Any, **options: Any) -> None:
            if not self._holds(given[0]):
                return self._os[name](*given, **options)
            paths = [path for path in given if isinstance(path, str | Path)]
            self._forget(*paths)
            if name in ("link", "replace"):
                self._go_stale(given[0])
            if name == "link" and not self.links:
                raise failure(errno.EPERM, given[0])
            self._os[name](*given, **options)
            if self._fails(self.repeated):
                raise failure(REPEATED[name], given[0])
            return None

        return change

    def _stat(self, path: Any, *, follow_symlinks: bool = True, **options: Any) -> os.stat_result:
        if isinstance(path, int) or options or not self._holds(path):
            return self._os["stat"](path, follow_symlinks=follow_symlinks, **options)
        self._go_stale(path)
        place = str(path), follow_symlinks
        now = time.monotonic()
        since, found = self._cached.get(place, (-1e9, None))
        if now - since > self.old:
            try:
                found = self._os["stat"](path, follow_symlinks=follow_symlinks)
            except FileNotFoundError:
                found = None
            self._cached[place] = now, found
        if found is None:
            raise failure(errno.ENOENT, path)
        return found

    def _lstat(self, path: Any, **options: Any) -> os.stat_result:
        return self._stat(path, follow_symlinks=False, **options)

    def _fstat(self, number: int) -> os.stat_result:
        found = self._os["fstat"](number)
        if found.st_nlink == 0 and self._holds(number):
            raise failure(errno.ESTALE, number)
        return found

    def _open(self, path: Any, flags: int, *given: Any, **options: Any) -> int:
        place, folder = path, options.get("dir_fd")
        if folder is not None:
            place = os.path.join(os.readlink(f"/proc/self/fd/{folder}"), path)
        if self._holds(place):
            self._go_stale(place)
            if flags & os.O_CREAT:
                self._forget(place)
            for follow in (True, False):
                since, found = self._cached.get((str(place), follow), (-1e9, None))
                if found is None and time.monotonic() - since <= self.old:
                    raise failure(errno.ENOENT, place)
                self._cached.pop((str(place), follow), None)
        return self._os["open"](path, flags, *given, **options)

    def _scandir(self, path: Any = ".") -> Any:
        self._forget_absent(str(path))
        return self._os["scandir"](path)

    def _fsync(self, number: int) -> None:
        if not self._holds(number):
            self._os["fsync"](number)
        elif stat.S_ISDIR(self._os["fstat"](number).st_mode):
            raise failure(errno.EINVAL, number)

    def _locking(self, number: int, how: int) -> None:
        if not self._holds(number) or self.locks == WORK:
            self._flock(number, how)
        elif self.locks == REFUSED:
            raise failure(self._random.choice(FLOCK_ERRORS), number)
