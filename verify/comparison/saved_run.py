"""Saving a run, and going on from a snapshot of it."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lattice.refine import Progress
from lattice.state import State
from solutions import ClosedForm
from verify.comparison.scene import Scene
from verify.comparison.stated_run import run_from

if TYPE_CHECKING:
    import xarray as xr


def scene_of(run: "xr.Dataset") -> Scene:
    """The scene that a run carries."""
    return Scene.from_json(run.attrs["scene"])


def state_at(run: "xr.Dataset", t: float) -> State:
    """A copy of the state at a snapshot of a run whose scene asks for the observable ``state``.

    Raises ValueError if the run carries no states or has no snapshot at ``t``.
    """
    if "state_y" not in run:
        raise ValueError(
            "run must carry its states to be resumed, got none (ask for the observable 'state')"
        )
    found = np.flatnonzero(run["time"].values == t)
    if found.size == 0:
        kept = ", ".join(f"{kept:g}" for kept in run["time"].values)
        raise ValueError(f"at must be a snapshot of the run, got {t:g} (it kept {kept or 'none'})")
    row = run.isel(time=int(found[0]))
    y, s = (np.array(row[name].values, dtype=np.float64) for name in ("state_y", "state_s"))
    return State(t, int(row["state_left"]), y, s)


def resume(
    run: "xr.Dataset",
    at: float | None = None,
    snapshots: Sequence[float] | None = None,
    progress: Progress | None = None,
    wave: ClosedForm | None = None,
) -> "xr.Dataset":
    """Go on from a snapshot of a run, to the bit as if the run had not been interrupted.

    ``at`` is the snapshot, by default the last one; ``snapshots`` are the times wanted after it, by
    default those of the scene; a ``wave`` of your own, which no file holds, is to be given again.
    The result holds what the scene asks for after ``at``. Same bits need the same stops:
    ``curve_points`` and ``look_points`` times move with the end of the run.

    Raises ValueError if the run carries no state at ``at`` or nothing is wanted after it.
    """
    start = state_at(run, float(run["time"].values[-1]) if at is None else at)
    scene = scene_of(run) if wave is None else replace(scene_of(run), wave=wave)
    later = tuple(t for t in (scene.snapshots if snapshots is None else snapshots) if t > start.t)
    if not later:
        raise ValueError(f"snapshots must lie after t = {start.t:g}, got none (name later ones)")
    scene = replace(scene, snapshots=later)
    return run_from(scene, scene.moving_wave, start, progress).dataset


def save_run(run: "xr.Dataset", path: str | Path) -> None:
    """Write a run as netCDF 3; floats keep their bits. Raises OSError if it cannot be written."""
    run.to_netcdf(path, engine="scipy")


def load_run(path: str | Path) -> "xr.Dataset":
    """Read a run back into memory. Raises OSError if there is none."""
    import xarray as xr  # where no file is read it is not needed

    with xr.open_dataset(path, engine="scipy") as dataset:
        return dataset.load()
