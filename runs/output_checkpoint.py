"""What a run leaves beside the file that it is to be written to, until that is there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from longwave.runs.run_store import run_key, runs_its_sources
from longwave.runs.save_elsewhere import save_anywhere
from longwave.runs.store_messages import kept_in, store_messages
from longwave.support.checkpoint import kept_by
from longwave.support.checkpoint_folder import LEAST, SHARE, CheckpointFolder, run_stamp

if TYPE_CHECKING:
    import xarray as xr

    from longwave.scenes.scene import Scene

SUFFIX = ".checkpoint"
"""After the name of the file: the folder beside it."""

PACE = LEAST, SHARE
"""Least seconds between two checkpoints, and the most of the time that they take."""


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
        with store_messages(), kept_by(self._folder):
            self._folder.tell(scene.name)
            yield

    def left(self, count: str = "", written: bool = False) -> str:
        """What Ctrl-C leaves, in words: what can be gone on with, and else the ``count`` of what is
        ``written`` to the output."""
        if self._store is not None:
            return kept_in(self._store)
        if self._folder is None or not self._folder.is_begun:
            return count
        if written:
            return f"{count}; the same command with --force goes on"
        return kept_in(str(self._place))

    def settle(self, made: Callable[[], xr.Dataset], force: bool) -> int:
        """Write what is ``made`` of the run to the output, if there is one, and remove them.

        This comes before the run is printed: nobody may read that. Returns the exit status, as
        `save_anywhere` does; without an output nothing is made.
        """
        status = 0 if self._output is None else save_anywhere(made(), self._output, force)
        if status == 0 and self._folder is not None:
            self._folder.clear()
        return status
