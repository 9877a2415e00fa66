"""Progress in a notebook: one line of the standard error, with the time that is left."""

from __future__ import annotations

import sys
import threading
from time import monotonic
from types import TracebackType
from typing import Self

from longwave.support.request_limits import duration
from longwave.support.slow_work import TimeLeft

SILENT = 1.0
"""Seconds of a call that shows nothing: most are over by then."""

TICK = 0.25
"""Seconds between two looks."""


def in_notebook() -> bool:
    """Whether this is the kernel of a notebook: it shows no bars, but lines that are written over.

    >>> in_notebook()
    False
    """
    found = sys.modules.get("IPython")
    return found is not None and hasattr(found.get_ipython(), "kernel")


class ProgressLine:
    """The line ``name: 42 %, about 12 s left``, written over as the work goes on; a thread does
    that.

    What is done and expected is told to ``left`` (`slow_work.TimeLeft`).
    """

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
