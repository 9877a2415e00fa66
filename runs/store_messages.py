"""What a store does, told on the standard error: found, gone on with, damaged, waited for."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from longwave.runs.run_store import RunStore
from longwave.support.command_line import one_line
from longwave.support.sealed_file import LOG

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress
    from longwave.scenes.scene import Scene


class _Lines(logging.Handler):
    """Each record in one line on the standard error, a warning once."""

    def __init__(self) -> None:
        super().__init__()
        self._warned: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        line = one_line(record.getMessage())
        if line not in self._warned:
            print(line, file=sys.stderr, flush=True)
        if record.levelno >= logging.WARNING:
            self._warned.add(line)


@contextmanager
def store_messages() -> Iterator[None]:
    """Tell on the standard error what a store says while the body runs."""
    handler, level = _Lines(), LOG.level
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.setLevel(level)
        LOG.removeHandler(handler)


def kept_in(store: str) -> str:
    """What Ctrl-C leaves in a store, in words."""
    return f"what was done is kept in {store}; the same command goes on"


def fetch_with_messages(
    folder: str, scene: Scene, progress: Progress, announce: Announce
) -> xr.Dataset:
    """The scene's run from the store in the folder, made if it is not there; raises as `fetch`."""
    with store_messages():
        return RunStore(folder).run(scene, progress, announce)
