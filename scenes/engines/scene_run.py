"""Running a scene of any lattice, given as such, by its name or by its file, and going on with it.

Which module runs it, and to what it is compared, the scene says (`Scene.method`).
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
    scene: Scene | str | Path,
    progress: Progress | None = None,
    announce: Announce | None = None,
) -> xr.Dataset:
    """Run a scene, given as such, by its name or by its file, and return what it asks for.

    Dimensions: ``time`` (the snapshots), ``curve_time``, ``look_time``, ``site`` (offset from the
    site nearest to c t) and what else the observables add. The table of observables
    (`observables.py`) says which variables each of them adds; none other is there.

    Attributes: the scene as TOML, what made the run (`provenance`), cost, ``blow_up`` (empty if
    there was none), and what can be trusted of it. A run that blows up keeps the times before it.
    With a tolerance also ``error_estimate`` and its parts (`judged`), and ``plan``, the scene with
    step and domain filled in, if sites were computed one by one. ``progress`` is called with the
    share of the work that is done, 0 .. 1; ``announce`` with the seconds that are expected to pass,
    if they are many.

    Raises ValueError in one line for what is no scene and for what the wave, the lattice or the
    limits do not admit, and UnfinishedRun on Ctrl-C.
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
    "Dataset": "load_run reads a run's file, resume goes on with a run and plot draws it",
    "Sweep": "longwave.sweep runs it",
    "ClosedForm": "Scene.of(wave=..., lattice=...) puts a wave on a lattice",
    "Wave": "Scene.of(wave=..., lattice=...) puts a wave on a lattice",
    "Lattice": "Scene.of(lattice=..., wave=...) runs a wave on it, reduce derives its equation",
    "NumericLattice": "longwave.lattice.integrate takes it, a state and times",
    "State": "longwave.lattice.integrate takes a lattice, it and times",
    "dict": "Scene.of(**...) makes a scene of keywords",
}
"""What to call for what is no scene, by its type."""

EXAMPLE = "such as 'rogue_cn_k_0.5'"


def state_at(run: xr.Dataset, t: float) -> State:
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
    held = (np.array(row[name].values, dtype=np.float64) for name in ("state_y", "state_s"))
    f, v = (values[np.newaxis] if values.ndim == 1 else values for values in held)
    return State(t, f, v, int(row["state_left"]))


def resume(
    run: xr.Dataset,
    at: float | None = None,
    snapshots: Sequence[float] | None = None,
    progress: Progress | None = None,
    wave: ClosedForm | None = None,
) -> xr.Dataset:
    """Go on from a snapshot of a run, to the bit as if the run had not been interrupted.

    ``at`` is the snapshot, by default the last one; ``snapshots`` are the times wanted after it, by
    default those of the scene; a ``wave`` of your own, which no file holds, is to be given again.
    The result holds what the scene asks for after ``at``. Same bits need the same stops:
    ``curve_points`` and ``look_points`` times move with the end of the run. A wave with its next
    order is solved for from one time to the next: it is the same to within that solution's error.
    In a window, whose feed is interpolated up to the end, a run to another end is the same to
    within that interpolation's error.

    Raises ValueError if the run carries no state at ``at`` or nothing is wanted after it.
    """
    start = state_at(run, float(run["time"].values[-1]) if at is None else at)
    scene = scene_of(run) if wave is None else replace(scene_of(run), wave=wave)
    later = tuple(t for t in (scene.snapshots if snapshots is None else snapshots) if t > start.t)
    if not later:
        raise ValueError(f"snapshots must lie after t = {start.t:g}, got none (name later ones)")
    rest = scene.changed(t0=scene.t0, snapshots=later)
    return record_scene(rest, progress, restart=start).dataset
