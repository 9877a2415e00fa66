"""Pictures of a run: snapshots against the wave, space-time map, spectra, errors, crest track.

`PICTURES` maps each kind of picture to the observable and the variables that it is drawn from.
`plot` draws a run, or a scene that it first runs; `draw` does the work of ``longwave plot``.
"""

import sys
import textwrap
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from longwave.lattice.refine import Announce
from longwave.lattice.trial import Progress
from longwave.reports.pictures import bench_plotting, drawing, run_data
from longwave.reports.pictures.growth_plotting import sideband_sizes
from longwave.reports.pictures.lattice_figures import strain_maps
from longwave.reports.pictures.shown import ShownFigure
from longwave.reports.pictures.style import WIDTHS, Part, page_width, save, styled
from longwave.reports.pictures.sweep_kinds import SWEEP_PICTURES, Choice, is_sweep
from longwave.runs import load_run
from longwave.runs.run_file import HOW_TO_WRITE, names_a_run, strain_fault
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines.methods import record_scene
from longwave.scenes.engines.run_record import UnfinishedRun
from longwave.scenes.observed.observables import MEASURED
from longwave.support.command_line import fail, fail_for_memory, one_line
from longwave.support.console import picture_path, progress_bar
from longwave.support.interruption import interrupted
from longwave.support.known_names import one_of
from longwave.support.labelled_arrays import Labelled, LabelledArrays
from longwave.support.request_limits import Announcer
from longwave.support.user_files import shown

if TYPE_CHECKING:
    import xarray as xr

ALL, GROWTH = "all", "growth"
"""Names of two kinds of pictures: all pictures of a run, and the growth of sidebands."""

MAX_COLUMNS, MAX_PANELS = 3, 12
"""Largest number of snapshots in a row, and in all; of more, evenly spaced ones are drawn."""

TITLE_CHARACTERS_AN_INCH = 12.9
"""Number of characters of a figure's title that fit into one inch."""

VISIBLE_DEVIATION, MIN_HALF_WIDTH = 0.02, 20
"""Deviation from the background, relative to the largest, that a picture must contain; and the
least half-width of a picture in sites."""

MAX_TITLE_CHARACTERS = 270
"""Largest number of characters in a line of a figure's title."""

MAP_TIMES, SNAPSHOT_TIMES = 201, 101
"""Number of times of a map or crest track if the scene states none, and number of snapshots added
to a scene on any lattice for its curves over time."""

Source = Labelled | Scene | str | Path
"""A run (a data set is one), or a scene or file to be run or read first."""


@dataclass(frozen=True)
class Picture:
    """A kind of picture.

    ``observable`` is the one that a scene must ask for, "" if none; ``variables`` are those that a
    run must have. ``part`` returns the part of a figure that draws a placed run; ``fits`` returns
    whether a run that has the variables can be drawn.
    """

    observable: str
    variables: Sequence[str]
    part: Callable[[LabelledArrays], Part]
    fits: Callable[[LabelledArrays], bool] = lambda _: True


def plot(
    source: Source,
    output: str | Path | None = None,
    kind: str = ALL,
    progress: Progress | None = None,
    announce: Announce | None = None,
    at: Choice | None = None,
    variable: str = "error",
    columns: int = 2,
) -> ShownFigure:
    """Draw a run; write the figure to ``output`` (PNG, PDF or SVG by its suffix) if it is given.

    ``source`` is a run, the path of a run's file (`save_run`), a scene, its TOML file or its name.
    A scene is run first, with only the observables that the pictures need; ``progress`` and
    ``announce`` are called as `run` calls them. ``kind`` is one of `PICTURES`, or "all" for those
    that the run has the variables of, one below the other.

    ``source`` may also be the data set or the file of a sweep. Then a ``variable`` of its cells is
    drawn over the swept dimensions, and work against precision (`SWEEP_PICTURES`), for the cells
    whose fields have the values in ``at``.

    ``columns`` is the figure's width in columns of a journal: 1 or 2, which are 3.4 or 7 inches.

    Raises ValueError for an unknown source, kind, number of columns or suffix, and for a run
    without the variables. Raises OSError if ``output`` cannot be written.
    """
    path = None if output is None else picture_path(output)
    kinds = (ALL, *PICTURES, *SWEEP_PICTURES)
    if kind not in kinds:
        raise ValueError(f"kind must be a known one, got {kind!r} ({one_of(kind, kinds)})")
    if columns not in WIDTHS:
        raise ValueError(f"columns must be 1 or 2, got {shown(columns)} (of a journal)")
    content = read_source(source)
    of_sweep = not isinstance(content, Scene) and is_sweep(content)
    _check_words(of_sweep, kind, at or {}, variable)
    data = _run(content, kind, progress, announce) if isinstance(content, Scene) else content
    with styled(WIDTHS[columns]), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        figure = _draw_sweep(data, kind, at or {}, variable) if of_sweep else _draw(data, kind)
        if path is not None:
            save(figure, path)
    return figure


def _check_words(of_sweep: bool, kind: str, at: Choice, variable: str) -> None:
    """Raise ValueError for arguments of sweeps given with a run, or kinds of runs with a sweep."""
    given = {"at": at, "variable": variable != "error", "kind": kind in SWEEP_PICTURES}
    wrong = [name for name, value in given.items() if value and not of_sweep]
    if wrong:
        raise ValueError(
            f"{wrong[0]} must not be given for a run or a scene, got it (it belongs to sweeps: "
            "`longwave sweep` writes one)"
        )
    if of_sweep and kind in PICTURES:
        kinds = ", ".join((ALL, *SWEEP_PICTURES))
        got = f"{kind!r} (a cell's run has the others)"
        raise ValueError(f"kind must be {kinds} for a sweep, got {got}")


def _run(
    scene: Scene, kind: str, progress: Progress | None, announce: Announce | None
) -> LabelledArrays:
    """Run a scene with what the pictures need, and return the run's data.

    A scene with observables is run with those of the pictures. Another one is run at its own times,
    and for curves over time also at `SNAPSHOT_TIMES` times between the first and the last.
    """
    if scene.has_moving_wave and not scene.bench:
        scene = _for_pictures(scene, kind)
    field = "slow_times" if scene.slow_times else "snapshots"
    times: tuple[float, ...] = getattr(scene, field)
    has_own_times = scene.bench or scene.has_moving_wave or kind in ("snapshots", "spectra")
    if has_own_times or not times:
        return record_scene(scene, progress, announce).arrays
    all_times = sorted({*times, *np.linspace(times[0], times[-1], SNAPSHOT_TIMES).tolist()})
    data = record_scene(scene.changed(**{field: tuple(all_times)}), progress, announce).arrays
    looked = run_data.with_looks(run_data.placed(data))
    return looked.isel(time=[all_times.index(t) for t in times])


def read_source(source: Source) -> Labelled | Scene:
    """Return the run or scene of ``source``; ValueError if it is neither, or cannot be read."""
    if isinstance(source, Scene | Labelled):
        return source
    if not isinstance(source, str | Path):
        got = f"{shown(source)} (such as 'run.nc')"
        raise ValueError(f"source must be a run, a scene, or the path or name of one, got {got}")
    if not names_a_run(source):
        return load_scene(str(source))
    try:
        return load_run(source)
    except OSError as error:
        reason = f"{Path(source)}: {error.strerror}"
        raise ValueError(f"source must be a run, got {reason} ({HOW_TO_WRITE})") from None


def _for_pictures(scene: Scene, kind: str) -> Scene:
    """Return the scene with the observables that pictures of that kind need.

    With kind "all" the error curve is included only if the scene asks for it, as computing it
    raises an error for a wave that cannot be distinguished from its background. With the error
    curve come the run's numerical errors, if the scene asks for them.
    """
    if kind == GROWTH:
        raise ValueError(
            f'kind must not be {GROWTH} for the scene of a wave, got it (wave = "perturbed_plane" '
            "has its growth measured)"
        )
    chosen = (picture.observable for name, picture in PICTURES.items() if kind in (ALL, name))
    observables = [name for name in chosen if name]
    if kind == ALL and "error_curve" not in scene.observables:
        observables.remove("error_curve")
    if "error_curve" in observables:
        observables += [name for name in MEASURED if name in scene.observables]
    distinct = tuple(dict.fromkeys(observables))
    return replace(scene, observables=distinct, look_points=scene.look_points or MAP_TIMES)


def _draw(run: Labelled, kind: str) -> ShownFigure:
    """Draw a run's pictures of one kind (or all), one below the other, under the run's title."""
    data = run_data.with_theory(
        run_data.with_looks(run_data.placed(run), run_data.MIN_MAP_TIMES if kind == ALL else 2)
    )
    chosen_pictures = _pictures(data, kind)
    return _stacked(_title(data), [picture.part(data) for picture in chosen_pictures])


def _draw_sweep(data: Labelled, kind: str, at: Choice, variable: str) -> ShownFigure:
    """Draw the pictures of a sweep; the title includes the chosen values."""
    from longwave.reports.pictures.sweep_plotting import sweep_parts

    values = ", ".join(f"{name} = {value}" for name, value in at.items())
    choice = one_line(values)[:MAX_TITLE_CHARACTERS]
    title = "\n".join(filter(None, (_title(data), choice)))
    sweep = cast("xr.Dataset", data)
    return _stacked(title, sweep_parts(sweep, None if kind == ALL else kind, at, variable))


def _stacked(title: str, parts: Sequence[Part]) -> ShownFigure:
    """Return a figure with a title and the parts below it, one below the other."""
    heights = [part.height for part in parts]
    width = int(TITLE_CHARACTERS_AN_INCH * page_width())
    title = "\n".join(textwrap.fill(line, width) for line in title.split("\n"))
    size = page_width(), sum(heights) + 0.25 * (1 + title.count("\n"))
    figure = ShownFigure(size, layout="constrained")
    figure.suptitle(title, parse_math=False, fontsize="medium")
    subfigures = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for subfigure, part in zip(subfigures, parts, strict=True):
        part.draw(subfigure)
    return figure


def _title(data: Labelled) -> str:
    """Return the title, with a line for a run that ended early; long lines are cut."""
    lines = filter(None, (data.attrs.get(key) for key in ("title", "blow_up", "unfinished")))
    most, mark = MAX_TITLE_CHARACTERS, " ..."
    return "\n".join(textwrap.shorten(one_line(line), most, placeholder=mark) for line in lines)


def _pictures(data: LabelledArrays, kind: str) -> Sequence[Picture]:
    """Return the pictures that can be drawn of the run; ValueError if there are none."""
    candidates = PICTURES.values() if kind == ALL else [PICTURES[kind]]
    drawable = [picture for picture in candidates if _has(data, picture)]
    if not drawable:
        needed = ", ".join(dict.fromkeys(name for p in candidates for name in p.variables))
        observables = ", ".join(dict.fromkeys(p.observable for p in candidates if p.observable))
        names = [name for name in data if data[name].dims != (name,) and name != "offset"]
        remedy = f"the scene must ask for {observables}"
        remedy = remedy if observables else "a chain on a bench watches it"
        got = f"{', '.join(names) or 'nothing'} ({remedy})"
        raise ValueError(f"source must hold what is drawn ({needed}), got {got}")
    return drawable


def _has(data: LabelledArrays, picture: Picture) -> bool:
    """Return whether the run has finite numbers in the picture's variables and passes `fits`."""
    names = picture.variables
    has_numbers = all(name in data and np.isfinite(data[name].values).any() for name in names)
    return has_numbers and picture.fits(data)


def _snapshots(data: LabelledArrays) -> Part:
    """Return panels of lattice and wave on a chain, or maps of both on two axes."""
    if "row" in data.sizes:
        return strain_maps(run_data.with_own(data))
    indices = drawing.even_indices(data.sizes["time"], MAX_PANELS)
    panels = run_data.snapshots(data, shown_half_width(data), indices)
    _, across = drawing.grid_shape(len(panels), MAX_COLUMNS)
    rows = [panels[i : i + across] for i in range(0, len(panels), across)]
    return drawing.snapshot_panels(rows, of_one=True)


def _spectra(data: LabelledArrays) -> Part:
    return drawing.spectrum_panels(
        run_data.spectra(data, drawing.even_indices(data.sizes["time"], drawing.MAX_SPECTRA))
    )


def shown_half_width(run: Labelled) -> int:
    """Return the half-width in sites of the range in which the wave differs from its background.

    Without a background, or if the wave equals it, that of all compared sites is returned.
    """
    data = LabelledArrays.of(run)
    sites = np.abs(data["site"].values)
    if "background" not in data:
        return int(sites.max())
    deviation = np.abs(data["analytic"].values - data["background"].values)
    others = tuple(axis for axis, name in enumerate(data["analytic"].dims) if name != "site")
    deviation = np.nan_to_num(deviation, posinf=0.0).max(axis=others)
    visible = sites[deviation > VISIBLE_DEVIATION * deviation.max()]
    return int(max(1.25 * visible.max(), MIN_HALF_WIDTH)) if visible.size else int(sites.max())


def _map(data: LabelledArrays) -> Part:
    """Return the space-time map, over the sites of the snapshots if the run has any."""
    half_width = shown_half_width(data) if _has(data, PICTURES["snapshots"]) else None
    return drawing.space_time_map(data, half_width)


def _errors(data: LabelledArrays) -> Part:
    return drawing.error_panels({rf"$\epsilon={data.attrs['eps']:g}$": run_data.error_curves(data)})


def _sizes(data: LabelledArrays) -> Part:
    return sideband_sizes(data, one_line(data.attrs.get("verdict", ""))[:MAX_TITLE_CHARACTERS])


PICTURES: Mapping[str, Picture] = {
    "snapshots": Picture("strain", ("strain", "analytic", "n"), _snapshots),
    "space_time": Picture("space_time", ("space_time",), _map),
    "spectra": Picture("strain", ("strain", "analytic"), _spectra),
    "errors": Picture("error_curve", ("error_curve",), _errors),
    "crest": Picture("crest_track", ("crest_position", "crest_strain"), drawing.crest_track),
    "sensors": Picture("", ("sensor",), bench_plotting.sensor_readings),
    "transmission": Picture(
        "", ("sensor",), bench_plotting.sensor_spectra, bench_plotting.has_spectra
    ),
    "balance": Picture("", bench_plotting.BALANCE, bench_plotting.energy_balance),
    "flux": Picture("", ("flux", "transmitted"), bench_plotting.fluxes),
    "modes": Picture("", ("mode_energy",), bench_plotting.mode_energies),
    "cells": Picture("", ("displacement",), bench_plotting.cells_at_times),
    GROWTH: Picture("", ("sideband_size", "sideband_theory", "slow_time"), _sizes),
}
"""Kind of picture -> how it is drawn and what it needs, in drawing order."""


def changed_source(source: str, changes: Mapping[str, Any]) -> str | Scene:
    """Return ``source``, or its scene with the ``changes`` of `--set` if there are any."""
    if not changes:
        return source
    if names_a_run(source):
        got = f"{source} (it was run as it is; name its scene)"
        raise ValueError(f"--set must not be given with the file of a run, got {got}")
    from longwave.runs.sweep_scene import changed_scene

    return changed_scene(source, changes)


def draw(
    source: str,
    path: str,
    program: str,
    *,
    kind: str,
    variable: str,
    at: Choice,
    changes: Mapping[str, Any],
    columns: int = 2,
) -> int:
    """Draw ``source`` to ``path`` and print the path; return the exit status.

    The status is 0, 2 for wrong input, or 130 after Ctrl-C, when the unfinished run is drawn if it
    can be. ``program`` is the command's name in messages.
    """
    try:
        content = read_source(changed_source(source, changes))
        if not isinstance(content, Scene) and (fault := strain_fault(content)):
            print(f"{source}: {fault}", file=sys.stderr)
        with progress_bar(Path(source).name, source) as (advance, tell):
            plot(content, path, kind, advance, Announcer(tell), at, variable, columns)
    except UnfinishedRun as stop:
        with suppress(ValueError, OSError):
            plot(stop.record.arrays, path, kind, columns=columns)
            return interrupted(program, f"what was run until then is in {path}")
        return interrupted(program, "too little was run to be drawn")
    except KeyboardInterrupt:
        return interrupted(program, "nothing was drawn yet")
    except (ValueError, OSError) as error:
        return fail(error)
    except MemoryError as error:
        return fail_for_memory(error)
    print(path)
    return 0
