"""Functions for interactive sessions: run, sweep, fit, converge, plot and film with a progress bar.

The functions of the other rooms print nothing. These show a bar in a terminal or a line in a
notebook, with the remaining time, unless they are given a ``progress`` callback.
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

ProgressCallback = Callable[[float], object]
"""A function called with the finished fraction, 0 to 1, or with the expected seconds."""


@contextmanager
def display_progress(
    name: str, progress: ProgressCallback | None, announce: ProgressCallback | None
) -> Iterator[tuple[Any, Any]]:
    """Yield (progress, announce); if both are None, the callbacks of a bar labelled ``name``."""
    if progress is not None or announce is not None:
        yield progress, announce
        return
    from longwave.support.console import progress_bar

    with progress_bar(name, name, clock=perf_counter) as callbacks:
        yield callbacks


def _label(source: object) -> str:
    """Return the label shown next to the progress bar: the name of a scene, sweep or file."""
    name = getattr(source, "name", source) if not isinstance(source, Path) else source.name
    return Path(name).name if isinstance(name, str) else "run"


def run(
    scene: Scene | str | Path,
    progress: ProgressCallback | None = None,
    announce: ProgressCallback | None = None,
) -> xr.Dataset:
    """Run any scene, given as a Scene, by name or by its TOML file; see `scenes.run`.

    This is the entry for all kinds: a wave on a lattice, an envelope, disorder, losses, a chain on
    a bench, the growth of a perturbed plane wave. Raises ValueError with the function to call
    instead if ``scene`` is something else.

    >>> import longwave
    >>> longwave.run("toda_soliton").sizes["time"]
    3
    """
    from longwave.scenes.engines import scene_run

    try:
        with display_progress(_label(scene), progress, announce) as callbacks:
            return scene_run.run(scene, *callbacks)
    except ValueError:
        _refuse_sweep(scene)
        raise


def _refuse_sweep(scene: object) -> None:
    """Raise ValueError if ``scene`` is the name of a shipped sweep."""
    from longwave.runs.sweep_file import shipped_sweeps

    if str(scene) in shipped_sweeps():
        got = f"the sweep {scene} (use longwave.sweep)"
        raise ValueError(f"scene must be a scene, its name or its file, got {got}") from None


def resume(
    run: xr.Dataset,
    at: float | None = None,
    snapshots: Sequence[float] | None = None,
    progress: ProgressCallback | None = None,
    wave: ClosedForm | None = None,
) -> xr.Dataset:
    """Continue a run from one of its snapshots, with the same bits; see `scenes.resume`."""
    from longwave.scenes.engines import scene_run

    with display_progress("run", progress, None) as (share, _):
        return scene_run.resume(run, at, snapshots, share, wave)


def sweep(
    source: Sweep | Scene | str | Path | Mapping[str, Any],
    grid: Mapping[str, Sequence[Any]] | None = None,
    *,
    store: str | Path | None = None,
    processes: int | None = None,
    progress: ProgressCallback | None = None,
) -> xr.Dataset:
    """Run a scene for many values; return one data set with the swept dimensions.

    ``source`` is a sweep: a Sweep, its name, its TOML file or that file's tables. With a ``grid``,
    which maps names of fields to values, it is a scene. Runs are saved in the folder ``store``, by
    default NAME.store in the working directory. Fields of the data set are read from there on
    demand, and an interrupted call is resumed. ``processes`` is the number of workers, by default
    one for each core.

    Raises ValueError in one line if ``source`` is no sweep, or if it exceeds the limits.
    """
    from longwave.runs.run_store import RunStore
    from longwave.runs.sweep import SweepState, run_with_progress
    from longwave.runs.sweep_cost import expected_sweep_cost
    from longwave.runs.sweep_dataset import sweep_dataset
    from longwave.runs.sweep_workers import sweep_workers
    from longwave.support.request_limits import check_request

    plan = as_sweep(source, grid)
    run_store = RunStore(Path(store or f"{plan.name}.store"))
    stored_keys = run_store.stored_runs()
    with (
        sweep_workers(processes, None) as workers,
        display_progress(plan.name, progress, None) as callbacks,
    ):
        expected = expected_sweep_cost(plan, run_store, stored_keys)
        cost = expected.on_workers(workers.count, share_memory=True)
        check_request(plan.name, cost, "take fewer or cheaper cells")
        if callbacks[1] is not None:
            callbacks[1](cost.seconds)
        state = SweepState(len(plan), workers.count, expected=expected.seconds_by_cell)
        run_with_progress(plan, run_store, workers, state, stored_keys, callbacks)
    return sweep_dataset(plan, run_store)


def as_sweep(
    source: Sweep | Scene | str | Path | Mapping[str, Any],
    grid: Mapping[str, Sequence[Any]] | None = None,
) -> Sweep:
    """Return the Sweep that ``source`` and ``grid`` describe; ValueError if they describe none.

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
        values = {name: _plain_list(name, sequence) for name, sequence in grid.items()}
        tables = {"title": scene.title, "scene": tomllib.loads(scene.toml()), "grid": values}
        return replace(sweep_of(tables, scene.name), base=scene.name)
    if grid is not None:
        got = f"it with {shown(source)} (leave it out: the source states what varies)"
        raise ValueError(f"grid must be given with a scene, got {got}")
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
    """Convert the values of a field to a list of Python objects; raise ValueError if impossible."""
    from longwave.support.user_files import shown

    values = given.tolist() if hasattr(given, "tolist") else given
    if isinstance(values, str) or not isinstance(values, Sequence) or not values:
        got = f"{shown(given)} (such as [0.1, 0.2])"
        raise ValueError(f"{name} in grid must be a list of values, got {got}")
    return list(values)


def fit_scene(
    scene: str | Path | Scene, records: Sequence[str | Path | SensorRecord], free: Sequence[str]
) -> SceneFit:
    """Fit constants and losses of a scene to its sensors' records; see `scenes.fits.scene_fit`."""
    from longwave.scenes.fits import scene_fit

    with display_progress(f"fit of {_label(scene)}", None, None):
        return scene_fit.fit_scene(scene, records, free)


def converge(
    scene: Scene | str | Path,
    eps: Sequence[float] = (),
    tolerance: float | None = None,
    progress: ProgressCallback | None = None,
) -> Convergence:
    """Run a scene at several eps and fit the rate at which the lattice approaches the wave.

    By default ``eps`` has four values about the scene's own. Raises ValueError in one line as
    `scenes.convergence.scene_convergence` does.
    """
    from longwave.drawn_convergence import Convergence
    from longwave.scenes.convergence import scene_convergence
    from longwave.scenes.description.named_scenes import load_scene
    from longwave.scenes.description.scene import Scene

    base = scene if isinstance(scene, Scene) else load_scene(scene)
    if tolerance is not None:
        base = base.with_tolerance(tolerance)
    with display_progress(base.name, progress, None) as (share, tell):
        study = scene_convergence(base, eps, share, tell or (lambda _: None))
    return Convergence(**vars(study))


def plot(
    source: Source | SceneConvergence,
    output: str | Path | None = None,
    kind: str = "all",
    progress: ProgressCallback | None = None,
    announce: ProgressCallback | None = None,
    at: Mapping[str, Any] | None = None,
    variable: str = "error",
    columns: int = 2,
) -> ShownFigure:
    """Draw a run, a scene (which is run first), a sweep or a convergence; see `reports`.

    The figure is displayed in a notebook, and written to ``output`` (PNG, PDF or SVG) if given. Its
    width is that of 1 or 2 ``columns`` of a journal.
    """
    from longwave.drawn_convergence import Convergence
    from longwave.reports.pictures import plotting
    from longwave.scenes.convergence import SceneConvergence

    if isinstance(source, SceneConvergence):
        return Convergence(**vars(source)).plot(output)
    with display_progress(_label(source), progress, announce) as callbacks:
        return plotting.plot(source, output, kind, *callbacks, at, variable, columns)


def animate(
    source: Source,
    output: str | Path | None = None,
    duration: float = 6.0,
    fps: float = 25.0,
    dpi: float = 110.0,
    times: tuple[float, float] | None = None,
    progress: ProgressCallback | None = None,
    announce: ProgressCallback | None = None,
) -> ShownFilm:
    """Make a film of a run or of a scene (which is run first); see `reports`.

    The film is displayed in a notebook. It is written to ``output``, MP4 or GIF by its suffix, or
    else kept in memory.
    """
    from longwave.reports.pictures import animation
    from longwave.reports.pictures.film_files import has_ffmpeg
    from longwave.reports.pictures.shown import ShownFilm

    with (
        display_progress(_label(source), progress, announce) as callbacks,
        tempfile.TemporaryDirectory() as folder,
    ):
        suffix = ".mp4" if has_ffmpeg() else ".gif"
        path = Path(folder) / f"film{suffix}" if output is None else Path(output)
        frames = animation.animate(source, path, duration, fps, dpi, times, *callbacks)
        if output is not None:
            return ShownFilm(frames, path)
        return ShownFilm(frames, None, path.read_bytes(), suffix)
