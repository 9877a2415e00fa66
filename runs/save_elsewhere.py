"""What becomes of a finished run that cannot be written where it was asked for: it is kept."""

from __future__ import annotations

import tempfile
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from longwave.runs.run_file import is_run_file, save_run
from longwave.runs.run_store import UnkeptRunError
from longwave.support.command_line import fail
from longwave.support.console import check_output

if TYPE_CHECKING:
    import xarray as xr

BROKEN = 1
"""Exit status where a run is finished and is not where it was asked for."""


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
