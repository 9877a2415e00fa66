"""The file that a run is written to: looked at before, checkpoints beside it until it is there.

A finished run that cannot be written where it was asked for is kept elsewhere.
"""

from __future__ import annotations

import logging
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from longwave.runs.run_file import is_run_file, save_run
from longwave.runs.run_store import UnkeptRunError, run_key, runs_its_sources
from longwave.support.checkpoint import LEAST, SHARE, CheckpointFolder, checkpoints_in, run_stamp
from longwave.support.command_line import BROKEN, fail, one_line
from longwave.support.console import check_output
from longwave.support.sealed_file import LOG

if TYPE_CHECKING:
    import xarray as xr

    from longwave.scenes.description.scene import Scene

SUFFIX = ".checkpoint"
"""After the name of the file: the folder beside it."""

PACE = LEAST, SHARE
"""Least seconds between two checkpoints, and the most of the time that they take."""


def check_run_output(output: str | None, force: bool) -> None:
    """Raise ValueError, before the run, if it can or may not be written there.

    Not even ``force`` overwrites what is no run.
    """
    check_output(output, suffixes=(".nc",), force=force)
    if output is not None and Path(output).exists() and not is_run_file(Path(output)):
        raise ValueError(
            f"--output must name a run, got {output}, which is another file (name a new one)"
        )


def save_anywhere(run: xr.Dataset, output: str, force: bool) -> int:
    """Write a run; where that fails, keep it in a folder that is named in one line on stderr.

    Returns the exit status: 0, or ``BROKEN`` if it is not where it was asked for.
    """
    try:
        save_run(run, output, force)
    except OSError as error:
        return _save_elsewhere(run, output, error)
    return 0


def fail_or_save_elsewhere(error: ValueError | OSError) -> int:
    """Tell an error; a finished run that a store could not write is kept elsewhere."""
    if isinstance(error, UnkeptRunError):
        return _save_elsewhere(error.run, str(error.filename), error)
    return fail(error)


def _save_elsewhere(run: xr.Dataset, output: str, error: OSError) -> int:
    """Keep a run that could not be written; tell why, and where it is now."""
    reason = f"{output}: {error.strerror or error}"
    kept = _kept_elsewhere(run, Path(output).name)
    where = "it fits nowhere else either" if kept is None else f"the run is kept in {kept}"
    fail(f"{reason} ({where})")
    return BROKEN


def _kept_elsewhere(run: xr.Dataset, name: str) -> Path | None:
    """The run's file in a new folder: of temporary files, of the user, or the working one."""
    for base in (None, Path.home, Path.cwd):
        with suppress(OSError, RuntimeError):
            folder = Path(tempfile.mkdtemp(prefix="longwave-", dir=base and base()))
            try:
                save_run(run, folder / name)
            except OSError:
                folder.rmdir()
                raise
            return folder / name
    return None


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


class OutputCheckpoint:
    """Checkpoints of a run in the folder ``OUTPUT.checkpoint``; none without an output.

    One that was killed is gone on with and ends with the same bits; what another scene, other code
    or another machine left there is not used. Where sources changed since the process began, of
    which nobody knows what it runs, nothing is kept. A ``store`` has checkpoints of its own.
    """

    def __init__(self, output: str | None, store: str | None = None) -> None:
        self._output, self._store = output, store
        self._folder: CheckpointFolder | None = None

    @property
    def _place(self) -> Path:
        return Path(f"{self._output}{SUFFIX}")

    @contextmanager
    def kept(self, scene: Scene) -> Iterator[None]:
        """Have the loops of the scene's run in the body kept."""
        if self._output is None or self._store is not None or not runs_its_sources():
            yield
            return
        self._folder = CheckpointFolder(self._place, run_stamp(run_key(scene)), *PACE)
        with store_messages(), checkpoints_in(self._folder):
            self._folder.tell(scene.name)
            yield

    def left(self, count: str = "", written: bool = False) -> str:
        """What Ctrl-C leaves, in words: what can be gone on with, and else the ``count`` of what is
        ``written`` to the output."""
        if self._store is not None:
            return _kept_in(self._store)
        if self._folder is None or not self._folder.is_begun:
            return count
        if written:
            return f"{count}; the same command with --force goes on"
        return _kept_in(str(self._place))

    def settle(self, made: Callable[[], xr.Dataset], force: bool) -> int:
        """Write what is ``made`` of the run to the output, if there is one, and remove them.

        This comes before the run is printed: nobody may read that. Returns the exit status, as
        `save_anywhere` does; without an output nothing is made.
        """
        status = 0 if self._output is None else save_anywhere(made(), self._output, force)
        if status == 0 and self._folder is not None:
            self._folder.clear()
        return status


def _kept_in(folder: str) -> str:
    """What Ctrl-C leaves in a folder, in words."""
    return f"what was done is kept in {folder}; the same command goes on"
