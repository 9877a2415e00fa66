"""Progress in a notebook: one rewritten line on stderr, with the time left."""

from __future__ import annotations

import sys
import threading
from time import monotonic
from types import TracebackType
from typing import Self

from longwave.support.request_limits import duration
from longwave.support.slow_work import TimeLeft

SILENT = 1.0
"""Seconds before the line appears: most calls end earlier."""

TICK = 0.25
"""Seconds between two updates."""


def in_notebook() -> bool:
    """Return whether this is a notebook's kernel, which rewrites a line but shows no bars.

    >>> in_notebook()
    False
    """
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")


class ProgressLine:
    """A line ``name: 42 %, about 12 s left``, rewritten by a thread as ``left`` changes."""

    def __init__(self, name: str) -> None:
        self.name, self.left = name, TimeLeft()
        self._width, self._over = 0, threading.Event()
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._over.set()
        self._thread.join()
        if self._width:
            end = "done in" if kind is None else "stopped after"
            self._write(f"{end} {duration(monotonic() - self.left.begun)}", "\n")

    def _watch(self) -> None:
        while not self._over.wait(TICK):
            if monotonic() >= self.left.begun + SILENT:
                self._write(self.left.words())

    def _write(self, words: str, end: str = "") -> None:
        line = f"{self.name}: {words}"
        sys.stderr.write(f"\r{line.ljust(self._width)}{end}")
        sys.stderr.flush()
        self._width = len(line)
