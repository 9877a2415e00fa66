"""Progress in a notebook: one line of the standard error, with the time that is left."""

from __future__ import annotations

import sys
import threading
from time import monotonic
from types import TracebackType
from typing import Self

from longwave.support.request_limits import duration

SILENT = 1.0
"""Seconds of a call that shows nothing: most are over by then."""

TICK = 0.25
"""Seconds between two looks."""

KNOWN = 0.02
"""Share of the work from which on the time that is left is told by the time that it took."""


def in_notebook() -> bool:
    """Whether this is the kernel of a notebook: it shows no bars, but lines that are written over.

    >>> in_notebook()
    False
    """
    found = sys.modules.get("IPython")
    return found is not None and hasattr(found.get_ipython(), "kernel")


class ProgressLine:
    """The line ``name: 42 %, 12 s left``, written over as the work goes on; a thread does that.

    In the body ``share`` is set to the share of the work that is done, and ``expected`` to the
    seconds that it is expected to take, if they are known.
    """

    def __init__(self, name: str) -> None:
        self.name, self.share, self.expected = name, 0.0, 0.0
        self._begun, self._width, self._over = monotonic(), 0, threading.Event()
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
            self._write(f"{end} {duration(monotonic() - self._begun)}", "\n")

    def text(self, seconds: float) -> str:
        """What the line says after so many seconds.

        >>> line = ProgressLine("toda_soliton")
        >>> line.expected = 40.0
        >>> line.text(1.0)
        'about 39 s left'
        >>> line.share = 0.25
        >>> line.text(12.0)
        '25 %, 36 s left'
        """
        if self.share >= KNOWN:
            left = seconds * (1.0 - self.share) / self.share
            return f"{100.0 * self.share:.0f} %, {duration(left)} left"
        if self.expected > seconds:
            return f"about {duration(self.expected - seconds)} left"
        return f"{duration(seconds)} so far"

    def _watch(self) -> None:
        while not self._over.wait(TICK):
            seconds = monotonic() - self._begun
            if seconds >= SILENT:
                self._write(self.text(seconds))

    def _write(self, words: str, end: str = "") -> None:
        line = f"{self.name}: {words}"
        sys.stderr.write(f"\r{line.ljust(self._width)}{end}")
        sys.stderr.flush()
        self._width = len(line)
