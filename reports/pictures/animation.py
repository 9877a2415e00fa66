"""Films of a run: the lattice against the wave in the moving frame, with the time and the error.

`animate` makes a film of a run, or of a scene that is run first; `draw_film` is the work of
``longwave animate``.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.refine import Announce
from longwave.lattice.trial import Progress
from longwave.reports.pictures import plotting
from longwave.reports.pictures.film import FILM_SIZE, ChainFilm, Film, PlaneFilm
from longwave.reports.pictures.film_files import film_path, has_ffmpeg, save_film
from longwave.reports.pictures.run_data import check_run, placed, within
from longwave.reports.pictures.style import styled
from longwave.runs.run_file import SWEPT, names_a_run
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import scene_run
from longwave.scenes.engines.methods import expected_cost
from longwave.support.command_line import fail, fail_for_memory, one_line
from longwave.support.console import check_output, default_output, progress_bar
from longwave.support.interruption import interrupted
from longwave.support.labelled_arrays import Labelled, LabelledArray, LabelledArrays, select
from longwave.support.request_limits import Announcer, ExpectedCost, check_request

Array = NDArray[np.float64]

CHEAPER_RUN = "take a larger eps, end earlier or compare fewer sites"
"""Advice in the error message for a run that exceeds the limits of time or memory."""

BOUNDS = {"duration": (0.2, 600.0), "fps": (1.0, 50.0), "dpi": (30.0, 400.0)}
"""Allowed ranges of a film's duration in seconds, frames per second and pixels per inch. (A GIF's
frames last a whole number of 1/100 s.)"""

MAX_FRAMES, MAX_STRAINS = 3000, 2e7
"""Largest number of frames of a film, and of strains in all frames (four numbers each)."""

FEW_FRAMES = 25
"""Number of frames below which `draw_film` prints that the run has few snapshots."""

MAX_TITLE_CHARACTERS = 100
"""Largest number of characters of a film's title, which has one line."""


@dataclass(frozen=True)
class FilmOptions:
    """Duration in seconds, frames per second, pixels per inch and range of times of a film."""

    duration: float = 6.0
    fps: float = 25.0
    dpi: float = 110.0
    times: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        for name, (least, most) in BOUNDS.items():
            value = getattr(self, name)
            if not least <= value <= most:
                bounds = f"{least:g} <= {name} <= {most:g}"
                raise ValueError(f"{name} must satisfy {bounds}, got {value:g}")
        if self.count > MAX_FRAMES:
            got = f"{self.count} (take a shorter duration or fewer fps)"
            raise ValueError(f"a film must have at most {MAX_FRAMES} frames, got {got}")
        if self.times is not None and not self.times[0] < self.times[1]:
            first, last = self.times
            raise ValueError(f"times must satisfy first < last, got {first:g} and {last:g}")

    @property
    def count(self) -> int:
        """Number of frames of a scene that is run for the film."""
        return max(2, round(self.duration * self.fps))


def animate(
    source: plotting.Source,
    output: str | Path,
    duration: float = 6.0,
    fps: float = 25.0,
    dpi: float = 110.0,
    times: tuple[float, float] | None = None,
    progress: Progress | None = None,
    announce: Announce | None = None,
) -> int:
    """Write a film of a run to ``output``, MP4 or GIF by its suffix; return its number of frames.

    ``source`` is a run, the path of a run's file, a scene, its TOML file or its name. A run is
    shown at its snapshots, which share ``duration``. A scene is run for ``duration * fps``
    snapshots, from its start to its end or between two ``times``. ``progress`` is called with the
    finished share of the run and then of the film, ``announce`` with the expected seconds of both.

    Raises ValueError for an unknown source or suffix, a number out of bounds, a run without
    snapshots, and a film that is expected to exceed the limits of time or memory. Raises OSError if
    ``output`` cannot be written; no partial file is left.
    """
    path = film_path(output)
    options = FilmOptions(duration, fps, dpi, times)
    report, progress = announce or (lambda _: None), progress or (lambda _: None)
    data = plotting.read_source(source)
    if isinstance(data, Scene):
        scene = _scene_of_film(data, options)
        report(_check_cost(scene.name, options, options.count, path, expected_cost(scene)))
        data = scene_run.run(scene, progress, announce)
    frames = _within(data, options.times)
    count = frames.sizes["time"]
    report(_check_cost("the film", options, count, path, ExpectedCost()))
    with styled():
        film = film_of(frames, options.dpi)
        rate = min(options.fps, len(film) / options.duration)
        save_film(film, path, rate, progress)
    return count


FRAME_SECONDS, PIXEL_SECONDS = 0.012, 3e-8
"""Seconds to draw and write a frame: a constant part, and a part for each of its pixels.

A frame takes 9 to 150 ms from 50 to 400 dpi, in processor time and with ffmpeg, on a 3 GHz server.
"""

FILM_BYTES, PIXEL_BYTES = 4e8, 120.0
"""Memory of the drawing process in bytes: a constant part, and a part for each pixel of a frame."""


def _check_cost(
    subject: str, options: FilmOptions, frames: int, path: Path, run: ExpectedCost
) -> float:
    """Return the expected seconds of run and film; raise OverBudgetError beyond the limits."""
    pixels = FILM_SIZE[0] * FILM_SIZE[1] * options.dpi**2
    memory_bytes = FILM_BYTES + PIXEL_BYTES * pixels + pixels * frames * (path.suffix == ".gif")
    seconds = run.seconds + frames * (FRAME_SECONDS + PIXEL_SECONDS * pixels)
    cost = ExpectedCost(seconds, max(run.memory_bytes, memory_bytes), run.steps)
    cheaper = "take fewer frames or dpi"
    check_request(subject, cost, f"{CHEAPER_RUN}, or {cheaper}" if run.seconds else cheaper)
    return cost.seconds


def _scene_of_film(scene: Scene, options: FilmOptions) -> Scene:
    """Return the scene with the times of the film's frames as its snapshots. Raises ValueError if
    all frames together have more than `MAX_STRAINS` sites."""
    if scene.bench:
        sites = scene.bench.sites
    else:
        scene.check_compared()
        sites = 2 * scene.cells_within(1) + 1
    if sites * options.count > MAX_STRAINS:
        raise ValueError(
            f"compared sites in all frames must be at most {MAX_STRAINS:.0e}, got "
            f"{sites} x {options.count} (take a shorter duration, fewer fps or fewer sites)"
        )
    if scene.slow_times and options.times is None:
        return scene.changed(slow_times=_frames(scene.slow_times, options.count))
    begin, end = scene.t0, scene.snapshots[-1:]
    if scene.slow_times:
        from longwave.scenes.starts.lattice_derivation import derivation

        begin = scene.lattice_times(derivation(scene).slow)[0]
    first, last = options.times or (begin, *end)
    if first < begin:
        raise ValueError(f"times must begin at t0 = {begin:g} or later, got {first:g}")
    moments = _frames((first, last), options.count)
    if scene.bench:
        observed = {"state": True, "energy": True}
        return scene.changed(times=sorted({begin, *moments}), observables=observed)
    return scene.changed(slow_times=(), t0=begin, snapshots=moments, observables=("strain",))


def _frames(times: Sequence[float], count: int) -> tuple[float, ...]:
    """Return ``count`` evenly spaced times from the first to the last of the given ones."""
    return tuple(np.unique(np.linspace(times[0], times[-1], count)).tolist())


def _within(source: Labelled, times: tuple[float, float] | None) -> LabelledArrays:
    """Return the snapshots between two times with finite strains; ValueError if there is none."""
    data = LabelledArrays.of(source)
    if SWEPT in data.attrs:
        raise ValueError(
            "source must be the run of a scene, got the result of a sweep (longwave plot draws it)"
        )
    if "cell" in data.sizes:
        data = bench_frames(data)
    for name in ("strain", "analytic", "n", "error"):
        if name not in data:
            got = f"none of {name} (the scene must ask for strain)"
            raise ValueError(f"source must hold snapshots of the strain, got {got}")
    check_run(data)
    first, last = times or (-np.inf, np.inf)
    times_of_frames = data["time"].values
    selected = np.flatnonzero((times_of_frames >= first) & (times_of_frames <= last))
    for name in ("strain",) if "tracked" in data.attrs else ("strain", "analytic"):
        rows = np.asarray(data[name].values, dtype=float).reshape(times_of_frames.size, -1)
        selected = selected[np.isfinite(rows[selected]).all(axis=1)]
    if not selected.size:
        raise ValueError(
            f"source must hold a finite snapshot between {first:g} and {last:g}, got "
            f"{data.sizes['time']} snapshots of which none is (run it with others)"
        )
    return data.isel(time=selected)


def bench_frames(data: Labelled) -> LabelledArrays:
    """Return frames of a bench's chain: displacements of the first field, and its energy."""
    for name in ("displacement", "energy"):
        if name not in data.variables:
            raise ValueError(
                f"source must hold the {name} of all cells at all times, got none (watch state and "
                "energy)"
            )
    moved = data.variables["displacement"]
    displacement = select(moved, {"field": 0}).values
    cells = np.broadcast_to(np.arange(displacement.shape[1], dtype=float), displacement.shape)
    attributes = {"tracked": "energy", "wave": "", "along": "$n$", "drawn": "$u_n$"}
    fields = {"strain": displacement, "analytic": np.full(displacement.shape, np.nan)}
    fields |= {"offset": cells, "n": cells}
    frames = {
        "time": data.variables["time"],
        "site": LabelledArray(("site",), cells[0]),
        **{name: LabelledArray(("time", "site"), values) for name, values in fields.items()},
        "error": LabelledArray(("time",), data.variables["energy"].values),
    }
    return LabelledArrays(frames, attributes | {"title": data.attrs.get("title", "")})


def film_of(data: Labelled, dpi: float = 110.0, half_width: int | None = None) -> Film:
    """Return the film of a run's snapshots: lines on a chain, maps on a lattice with two axes.

    ``half_width`` is the number of sites to either side of c t, by default enough to show the wave
    as far as it differs from its background.
    """
    run = LabelledArrays.of(data) if "tracked" in data.attrs else placed(data)
    title = one_line(data.attrs.get("title", ""))[:MAX_TITLE_CHARACTERS]
    if "row" in run.sizes:
        return PlaneFilm(run, title, dpi)
    if "tracked" in run.attrs:
        return ChainFilm(run, title, dpi)
    levels = run["background"].values if "background" in run else np.zeros(1)
    level = float(np.mean(levels[~np.isnan(levels)])) if np.isfinite(levels).any() else 0.0
    width = plotting.shown_half_width(run) if half_width is None else half_width
    return ChainFilm(within(run, width).assign_attrs(level=level), title, dpi)


def draw_film(
    source: str,
    output: str | None,
    options: dict[str, Any],
    program: str,
    force: bool = False,
    changes: Mapping[str, Any] | None = None,
) -> int:
    """Write the film and print its path; return the exit status.

    The status is 0, 2 for wrong input, or 130 after Ctrl-C. Without ``output`` the film is an MP4
    in the working directory, or a GIF if ffmpeg is not installed.
    """
    path = output or default_output(source, ".mp4" if has_ffmpeg() else ".gif")
    try:
        check_output(path, "run.gif", force=force)
        film_path(path)
        FilmOptions(**options)
        drawn = plotting.changed_source(source, changes or {})
        with progress_bar(Path(source).name, f"film of {Path(source).name}") as (bar, tell):
            count = animate(drawn, path, **options, progress=bar, announce=Announcer(tell))
    except KeyboardInterrupt:
        return interrupted(program, f"{path} was not written")
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail_for_memory(error)
    if count < FEW_FRAMES and names_a_run(source):
        print(f"{source} has {count} snapshots: so many frames (a scene has more)", file=sys.stderr)
    print(path)
    return 0
