"""Public entry points: run a scene, given as object, name or file, and resume a run.

`methods.method_of` decides which module runs the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from longwave.lattice.state import State
from longwave.scenes.description.named_scenes import load_scene, scene_of
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.methods import record_scene, run_scene
from longwave.support.user_files import shown, shown_path

if TYPE_CHECKING:
    import xarray as xr

    from longwave.lattice.refine import Announce
    from longwave.lattice.trial import Progress
    from longwave.solutions import ClosedForm


def run(
    scene: Scene | str | Path, progress: Progress | None = None, announce: Announce | None = None
) -> xr.Dataset:
    """Run a scene, given as object, name or file path, and return the Dataset of its observables.

    Dimensions: ``time`` (the snapshots), ``curve_time``, ``look_time``, ``site`` (offset from the
    site nearest to c t) and others that observables add. The variables are those of the requested
    observables (table in `observables.py`).

    Attributes: the scene as TOML, provenance, cost, ``blow_up`` (empty if there was none), and the
    time for which the run can be trusted. A run that blows up keeps the times before the blow-up.
    With a tolerance there are also ``error_estimate`` and its parts (`add_error_estimate`), and,
    for runs site by site, ``plan``: the scene with step and domain filled in. ``progress`` is
    called with the completed fraction, 0 .. 1; ``announce`` with the expected seconds, if many.

    Raises ValueError for an argument that is not a scene and for a scene that the wave,
    the lattice or the limits do not admit. Raises UnfinishedRun on Ctrl-C.
    """
    if isinstance(scene, str | Path):
        if str(scene).endswith(".nc"):
            raise ValueError(
                f"scene must be a scene, its name or its file, got {shown_path(scene)} "
                f"({INSTEAD['Dataset']})"
            )
        scene = load_scene(scene)
    if not isinstance(scene, Scene):
        kinds = [INSTEAD[one.__name__] for one in type(scene).__mro__ if one.__name__ in INSTEAD]
        raise ValueError(
            f"scene must be a scene, its name or its file, got {shown(scene)} "
            f"({(*kinds, EXAMPLE)[0]})"
        )
    return run_scene(scene, progress, announce)


INSTEAD = {
    "Dataset": "load_run reads a run's file, resume continues a run and plot draws it",
    "Sweep": "longwave.sweep runs it",
    "ClosedForm": "Scene.of(wave=..., lattice=...) puts a wave on a lattice",
    "Wave": "Scene.of(wave=..., lattice=...) puts a wave on a lattice",
    "Lattice": "Scene.of(lattice=..., wave=...) runs a wave on it, reduce derives its equation",
    "NumericLattice": "longwave.lattice.integrate takes it, a state and times",
    "State": "longwave.lattice.integrate takes a lattice, a state and times",
    "dict": "Scene.of(**...) makes a scene of keywords",
}
"""Remedy in the message about an argument that is not a scene, by the type's name."""

EXAMPLE = "such as 'rogue_cn_k_0.5'"


def state_at(run: xr.Dataset, t: float) -> State:
    """Return a copy of the state at snapshot ``t``; ValueError if the run has no such state."""
    if "state_y" not in run:
        raise ValueError(
            "run must hold its states to be resumed, got none (ask for the observable 'state')"
        )
    indices = np.flatnonzero(run["time"].values == t)
    if indices.size == 0:
        times = ", ".join(f"{time:g}" for time in run["time"].values)
        raise ValueError(f"at must be a snapshot of the run, got {t:g} (it has {times or 'none'})")
    row = run.isel(time=int(indices[0]))
    arrays = (np.array(row[name].values, dtype=np.float64) for name in ("state_y", "state_s"))
    f, v = (values[np.newaxis] if values.ndim == 1 else values for values in arrays)
    return State(t, f, v, int(row["state_left"]))


def resume(
    run: xr.Dataset,
    at: float | None = None,
    snapshots: Sequence[float] | None = None,
    progress: Progress | None = None,
    wave: ClosedForm | None = None,
) -> xr.Dataset:
    """Continue a run from a snapshot, bit for bit as if it had not been interrupted.

    ``at`` is the snapshot, by default the last one. ``snapshots`` are the times after it, by
    default those of the scene. A user-defined ``wave``, which no file stores, must be given again.
    The result holds the scene's observables after ``at``.

    Identical bits need identical stops: the times of ``curve_points`` and ``look_points`` depend on
    the end of the run. A wave with its next order is solved step by step from time to time, so it
    agrees to within that solver's error. A window's feed is interpolated up to the end, so a run to
    another end agrees to within the interpolation error.

    Raises ValueError if the run has no state at ``at`` or no snapshot after it.
    """
    start = state_at(run, float(run["time"].values[-1]) if at is None else at)
    scene = scene_of(run) if wave is None else replace(scene_of(run), wave=wave)
    later = tuple(t for t in (scene.snapshots if snapshots is None else snapshots) if t > start.t)
    if not later:
        raise ValueError(f"snapshots must lie after t = {start.t:g}, got none (name later ones)")
    remainder = scene.changed(t0=scene.t0, snapshots=later)
    return record_scene(remainder, progress, restart=start).dataset
