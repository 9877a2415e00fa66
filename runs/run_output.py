"""The output file of `longwave run`: checks before the run, checkpoints next to it during the run.

A finished run that cannot be written to its output is saved in a spare folder instead.
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
from longwave.runs.run_store import UnsavedRunError, run_key, runs_its_sources
from longwave.support.checkpoint import LEAST, SHARE, CheckpointFolder, checkpoints_in, run_stamp
from longwave.support.command_line import BROKEN, fail, one_line
from longwave.support.console import check_output
from longwave.support.sealed_file import LOG

if TYPE_CHECKING:
    import xarray as xr

    from longwave.scenes.description.scene import Scene

FOLDER_SUFFIX = ".checkpoint"
"""Suffix of the checkpoint folder, appended to the name of the output file."""

CHECKPOINT_PACE = LEAST, SHARE
"""Least seconds between two checkpoints, and the largest fraction of the run time they may take."""


def check_run_output(output: str | None, force: bool) -> None:
    """Raise ValueError, before the run, if its output cannot or may not be written."""
    check_output(output, suffixes=(".nc",), force=force)
    if output is not None and Path(output).exists() and not is_run_file(Path(output)):
        got = f"{output}, another file (name a new one)"
        raise ValueError(f"--output must name a new file or a run, got {got}")


def save_anywhere(run: xr.Dataset, output: str, force: bool) -> int:
    """Write a run to ``output``; if that fails, save it in a spare folder and print the path.

    Returns the exit status: 0, or ``BROKEN`` if the run was not written to ``output``.
    """
    try:
        save_run(run, output, force)
    except OSError as error:
        return _save_elsewhere(run, output, error)
    return 0


def fail_or_save_elsewhere(error: ValueError | OSError) -> int:
    """Print an error and return the exit status; save a run elsewhere if a store could not."""
    if isinstance(error, UnsavedRunError):
        return _save_elsewhere(error.run, str(error.filename), error)
    return fail(error)


def _save_elsewhere(run: xr.Dataset, output: str, error: OSError) -> int:
    """Save a run that could not be written in a spare folder; print the reason and its new path."""
    reason = f"{output}: {error.strerror or error}"
    saved = _save_in_spare_folder(run, Path(output).name)
    where = "no other folder takes it" if saved is None else f"the run is saved in {saved}"
    fail(f"{reason} ({where})")
    return BROKEN


def _save_in_spare_folder(run: xr.Dataset, name: str) -> Path | None:
    """Write the run to a new folder: temporary, home or working directory. None if all fail."""
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


class _StderrLines(logging.Handler):
    """Log handler that prints each record in one line on stderr, and each warning once."""

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
    """Print the log messages of stores on stderr within the context."""
    handler, level = _StderrLines(), LOG.level
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.setLevel(level)
        LOG.removeHandler(handler)


class OutputCheckpoint:
    """Checkpoints of a run in the folder ``OUTPUT.checkpoint``; none without an output.

    An interrupted run is resumed from them and ends with the same bits. Checkpoints of another
    scene, other code or another machine are not used. None are written if the sources changed after
    the process started, because its code is then unknown. With a ``store``, which has checkpoints
    of its own, this writes none.
    """

    def __init__(self, output: str | None, store: str | None = None) -> None:
        self._output, self._store = output, store
        self._folder: CheckpointFolder | None = None

    @property
    def _folder_path(self) -> Path:
        return Path(f"{self._output}{FOLDER_SUFFIX}")

    @contextmanager
    def checkpointed(self, scene: Scene) -> Iterator[None]:
        """Write checkpoints of the scene's run within the context."""
        if self._output is None or self._store is not None or not runs_its_sources():
            yield
            return
        self._folder = CheckpointFolder(
            self._folder_path, run_stamp(run_key(scene)), *CHECKPOINT_PACE
        )
        with store_messages(), checkpoints_in(self._folder):
            self._folder.tell(scene.name)
            yield

    def interrupt_message(self, count: str = "", written: bool = False) -> str:
        """Return the message after Ctrl-C: how to resume, or else the text ``count`` on work done.

        ``written`` says whether partial results are in the output file.
        """
        if self._store is None and (self._folder is None or not self._folder.is_begun):
            return count
        if self._store is None and written:
            return f"{count}; repeat the command with --force to resume"
        folder = self._store or self._folder_path
        return f"progress is saved in {folder}; repeat the command to resume"

    def settle(self, build: Callable[[], xr.Dataset], force: bool) -> int:
        """Write the run that ``build`` returns to the output, and remove the checkpoints.

        Call this before printing the run: printing may fail if nobody reads. Returns the exit
        status, as `save_anywhere` does. Without an output, ``build`` is not called.
        """
        status = 0 if self._output is None else save_anywhere(build(), self._output, force)
        if status == 0 and self._folder is not None:
            self._folder.clear()
        return status
