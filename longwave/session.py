"""The long calls of a session in Python or a notebook, which show how far they are.

The rooms' own functions are silent; these show a bar on a terminal and a line in a notebook, with
the time that is left, unless they are given a ``progress`` of your own.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

    from longwave.drawn_convergence import Convergence
    from longwave.reports.pictures.plotting import Source
    from longwave.reports.pictures.shown import ShownFigure, ShownFilm
    from longwave.runs.sweep_file import Sweep
    from longwave.scenes.convergence import SceneConvergence
    from longwave.scenes.description.scene import Scene
    from longwave.scenes.fits.scene_fit import SceneFit
    from longwave.scenes.fits.sensor_records import SensorRecord
    from longwave.solutions import ClosedForm

Told = Callable[[float], object]
"""Told the share of the work that is done, 0 .. 1, or the seconds that it is expected to take."""


@contextmanager
def shown_progress(
    name: str, progress: Told | None, announce: Told | None
) -> Iterator[tuple[Any, Any]]:
    """A user's own progress, or the bar or line of `support.console`."""
    if progress is not None or announce is not None:
        yield progress, announce
        return
    from longwave.support.console import progress_bar

    with progress_bar(name, name, clock=perf_counter) as told:
        yield told


def _named(source: object) -> str:
    """How what is worked on is called beside the progress."""
    name = getattr(source, "name", source) if not isinstance(source, Path) else source.name
    return Path(name).name if isinstance(name, str) else "run"


def run(
    scene: Scene | str | Path, progress: Told | None = None, announce: Told | None = None
) -> xr.Dataset:
    """Run any scene, given as such, by its name or by its TOML file; `scenes.run` says more.

    One entry for all of them: a wave on any lattice, an envelope, disorder, losses, a chain on a
    bench, the growth of a perturbed plane wave. What is no scene is told what to call instead.

    >>> import longwave
    >>> longwave.run("toda_soliton").sizes["time"]
    3
    """
    from longwave.scenes.engines import scene_run

    try:
        with shown_progress(_named(scene), progress, announce) as told:
            return scene_run.run(scene, *told)
    except ValueError:
        _refuse_sweep(scene)
        raise


def _refuse_sweep(scene: object) -> None:
    """Raise ValueError for the name of a shipped sweep, which is no scene's."""
    from longwave.runs.sweep_file import shipped_sweeps

    if str(scene) in shipped_sweeps():
        raise ValueError(
            f"scene must be a scene, its name or its file, got the sweep {scene} (longwave.sweep "
            "runs it)"
        ) from None


def resume(
    run: xr.Dataset,
    at: float | None = None,
    snapshots: Sequence[float] | None = None,
    progress: Told | None = None,
    wave: ClosedForm | None = None,
) -> xr.Dataset:
    """Go on with a run from one of its snapshots, to the same bits: `scenes.resume` says more."""
    from longwave.scenes.engines import scene_run

    with shown_progress("run", progress, None) as (share, _):
        return scene_run.resume(run, at, snapshots, share, wave)


def sweep(
    source: Sweep | Scene | str | Path | Mapping[str, Any],
    grid: Mapping[str, Sequence[Any]] | None = None,
    *,
    store: str | Path | None = None,
    processes: int | None = None,
    progress: Told | None = None,
) -> xr.Dataset:
    """Run a scene for many values; return one data set with the swept dimensions.

    ``source`` is a sweep, its name, its TOML file or what that holds; with a ``grid``, the values
    of each field by its name in a scene's file, it is a scene. Runs go into the folder ``store``,
    by default NAME.store here, where the fields of the data set are read when they are used and a
    call that was stopped is gone on with. ``processes``: as many as there are cores unless given.

    Raises ValueError in one line for what is no sweep, and for one beyond the limits.
    """
    from longwave.runs.run_store import RunStore
    from longwave.runs.sweep import SweepState, run_shown
    from longwave.runs.sweep_cost import expected_sweep_cost
    from longwave.runs.sweep_dataset import sweep_dataset
    from longwave.runs.sweep_workers import sweep_workers
    from longwave.support.request_limits import check_request

    found = as_sweep(source, grid)
    kept = RunStore(Path(store or f"{found.name}.store"))
    held = kept.held()
    with (
        sweep_workers(processes, None) as workers,
        shown_progress(found.name, progress, None) as told,
    ):
        expected = expected_sweep_cost(found, kept, held)
        cost = expected.by(workers.count, together=True)
        check_request(found.name, cost, "take fewer or cheaper cells")
        if told[1] is not None:
            told[1](cost.seconds)
        state = SweepState(len(found), workers.count, expected=expected.each)
        run_shown(found, kept, workers, state, held, told)
    return sweep_dataset(found, kept)


def as_sweep(
    source: Sweep | Scene | str | Path | Mapping[str, Any],
    grid: Mapping[str, Sequence[Any]] | None = None,
) -> Sweep:
    """The sweep that is meant; ValueError in one line for what is none.

    >>> as_sweep("toda_soliton", {"eps": [0.1, 0.2], "parameters.kappa": [1]})
    <Sweep of toda_soliton: 2 eps x 1 kappa = 2 cells>
    """
    import tomllib
    from dataclasses import replace

    from longwave.runs.sweep_file import Sweep, load_sweep, sweep_of
    from longwave.scenes.description.named_scenes import load_scene
    from longwave.scenes.description.scene import Scene
    from longwave.support.user_files import shown

    if grid is not None and not isinstance(source, Sweep | Mapping):
        scene = source if isinstance(source, Scene) else load_scene(source)
        values = {name: _plain_list(name, given) for name, given in grid.items()}
        tables = {"title": scene.title, "scene": tomllib.loads(scene.toml()), "grid": values}
        made = sweep_of(tables, scene.name)
        return replace(made, base=scene.name)
    if grid is not None:
        raise ValueError(
            f"grid must be given with a scene, got it with {shown(source)} (which says itself what "
            "varies)"
        )
    if isinstance(source, Sweep):
        return source
    if isinstance(source, Mapping):
        return sweep_of(source)
    if isinstance(source, str | Path):
        return load_sweep(source)
    raise ValueError(
        f"source must be a sweep, its name, its file or its tables, got {shown(source)} (or a "
        'scene with a grid, such as {"eps": [0.1, 0.2]})'
    )


def _plain_list(name: str, given: Any) -> list[Any]:
    """The values as a list of Python's; ValueError for what is none."""
    from longwave.support.user_files import shown

    found = given.tolist() if hasattr(given, "tolist") else given
    if isinstance(found, str) or not isinstance(found, Sequence) or not found:
        raise ValueError(
            f"{name} in grid must be a list of values, got {shown(given)} (such as [0.1, 0.2])"
        )
    return list(found)


def fit_scene(
    scene: str | Path | Scene, records: Sequence[str | Path | SensorRecord], free: Sequence[str]
) -> SceneFit:
    """Fit constants and losses of a scene to records of its sensors: `scenes.fits.scene_fit`."""
    from longwave.scenes.fits import scene_fit

    with shown_progress(f"fit of {_named(scene)}", None, None):
        return scene_fit.fit_scene(scene, records, free)


def converge(
    scene: Scene | str | Path,
    eps: Sequence[float] = (),
    tolerance: float | None = None,
    progress: Told | None = None,
) -> Convergence:
    """Run a scene at several eps and fit the rate at which lattice and wave come together.

    Without ``eps`` at four values about the scene's own. Raises ValueError in one line as
    `scenes.convergence.scene_convergence` does.
    """
    from longwave.drawn_convergence import Convergence
    from longwave.scenes.convergence import scene_convergence
    from longwave.scenes.description.named_scenes import load_scene
    from longwave.scenes.description.scene import Scene

    asked = scene if isinstance(scene, Scene) else load_scene(scene)
    if tolerance is not None:
        asked = asked.with_tolerance(tolerance)
    with shown_progress(asked.name, progress, None) as (share, tell):
        found = scene_convergence(asked, eps, share, tell or (lambda _: None))
    return Convergence(**vars(found))


def plot(
    source: Source | SceneConvergence,
    output: str | Path | None = None,
    kind: str = "all",
    progress: Told | None = None,
    announce: Told | None = None,
    at: Mapping[str, Any] | None = None,
    variable: str = "error",
    columns: int = 2,
) -> ShownFigure:
    """Draw a run, a scene, which is run first, a sweep or a convergence: `reports` says how.

    The figure shows itself in a notebook, and is written to ``output`` (PNG, PDF or SVG) if given.
    It is as wide as so many ``columns`` of a journal, 1 or 2.
    """
    from longwave.drawn_convergence import Convergence
    from longwave.reports.pictures import plotting
    from longwave.scenes.convergence import SceneConvergence

    if isinstance(source, SceneConvergence):
        return Convergence(**vars(source)).plot(output)
    with shown_progress(_named(source), progress, announce) as told:
        return plotting.plot(source, output, kind, *told, at, variable, columns)


def animate(
    source: Source,
    output: str | Path | None = None,
    duration: float = 6.0,
    fps: float = 25.0,
    dpi: float = 110.0,
    times: tuple[float, float] | None = None,
    progress: Told | None = None,
    announce: Told | None = None,
) -> ShownFilm:
    """Make a film of a run, or of a scene, which is run first: `reports` says how.

    It shows itself in a notebook, and is written to ``output``, MP4 or GIF by its suffix; without
    one it is held in memory.
    """
    from longwave.reports.pictures import animation
    from longwave.reports.pictures.film_files import has_ffmpeg
    from longwave.reports.pictures.shown import ShownFilm

    with (
        shown_progress(_named(source), progress, announce) as told,
        tempfile.TemporaryDirectory() as work,
    ):
        suffix = ".mp4" if has_ffmpeg() else ".gif"
        path = Path(work) / f"film{suffix}" if output is None else Path(output)
        frames = animation.animate(source, path, duration, fps, dpi, times, *told)
        if output is not None:
            return ShownFilm(frames, path)
        return ShownFilm(frames, None, path.read_bytes(), suffix)
