"""Pictures of a run: snapshots against the wave, space-time map, spectra, errors, crest track.

`PICTURES` says which pictures there are, and which observable and variables each is drawn from.
`plot` draws a run, or a scene that is run first; `draw` is the work of `longwave plot`.
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
from longwave.reports.pictures.bench_plotting import (
    BALANCE,
    cells_at_times,
    energy_balance,
    fluxes,
    has_spectra,
    mode_energies,
    sensor_readings,
    sensor_spectra,
)
from longwave.reports.pictures.drawing import (
    MOST_SPECTRA,
    crest_track,
    error_panels,
    even_places,
    grid_shape,
    snapshot_panels,
    space_time_map,
    spectrum_panels,
)
from longwave.reports.pictures.growth_plotting import sideband_sizes
from longwave.reports.pictures.lattice_figures import strain_maps
from longwave.reports.pictures.run_data import (
    LEAST_LOOKS,
    error_curves,
    placed,
    snapshots,
    spectra,
    with_looks,
    with_own,
    with_theory,
)
from longwave.reports.pictures.shown import ShownFigure
from longwave.reports.pictures.style import WIDTHS, Part, page_width, save, styled
from longwave.reports.pictures.sweep_kinds import SWEEP_PICTURES, Choice, is_sweep
from longwave.runs import load_run
from longwave.runs.run_file import REMEDY, names_a_run, strain_fault
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

ACROSS, MOST_PANELS = 3, 12
"""Snapshots side by side, and most of them; of more snapshots some are taken, evenly."""

LETTERS = 12.9
"""Of a title in an inch."""

SHOWN, LEAST_SHOWN = 0.02, 20
"""Share of the wave's largest deviation from its background that is still seen; fewest sites."""

MOST = 270
"""Most characters of a figure's title."""

LOOKS, LATTICE_LOOKS = 201, 101
"""Times of map and crest track where the scene does not state any; of a scene on any lattice, whose
snapshots they are."""

Source = Labelled | Scene | str | Path
"""A run, of which a data set is one, or what is run or read first."""


@dataclass(frozen=True)
class Picture:
    """One kind of picture: the observable ("" if no scene can ask for it) and the variables that it
    is drawn from, the part of a figure that it is of a placed run, and whether a run fits."""

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

    ``source`` is a run, the path of a file that holds one (`save_run`), or a scene, its TOML file
    or its name: a scene is run first, for what the pictures need and nothing else, ``progress``
    and ``announce`` being told as `run` tells them. ``kind`` is one of `PICTURES`, or "all": what
    the run holds of them, one below the other.

    It may be a sweep's data set or file as well: a ``variable`` of its cells is drawn over the
    swept dimensions, and work against precision (`SWEEP_PICTURES`), where the fields of ``at`` have
    these values.

    ``columns`` of a journal are as wide as the figure: 1 or 2, 3.4 or 7 inches.

    Raises ValueError in one line: source, kind, columns and suffix; a run without the variables.
    OSError if ``output`` cannot be written.
    """
    path = None if output is None else picture_path(output)
    if kind not in (ALL, *PICTURES, *SWEEP_PICTURES):
        known = one_of(kind, (ALL, *PICTURES, *SWEEP_PICTURES))
        raise ValueError(f"kind must be a known one, got {kind!r} ({known})")
    if columns not in WIDTHS:
        raise ValueError(f"columns must be 1 or 2, got {shown(columns)} (of a journal)")
    found = read_source(source)
    of_sweep = not isinstance(found, Scene) and is_sweep(found)
    _check_words(of_sweep, kind, at or {}, variable)
    data = _run(found, kind, progress, announce) if isinstance(found, Scene) else found
    with styled(WIDTHS[columns]), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing from font")
        figure = _draw_sweep(data, kind, at or {}, variable) if of_sweep else _draw(data, kind)
        if path is not None:
            save(figure, path)
    return figure


def _check_words(of_sweep: bool, kind: str, at: Choice, variable: str) -> None:
    """Refuse, before anything is run, what belongs to sweeps alone or to all but them."""
    given = {"at": at, "variable": variable != "error", "kind": kind in SWEEP_PICTURES}
    wrong = [name for name, value in given.items() if value and not of_sweep]
    if wrong:
        raise ValueError(
            f"{wrong[0]} must not be given for a run or a scene, got it (it belongs to sweeps: "
            "`longwave sweep` writes one)"
        )
    if of_sweep and kind in PICTURES:
        raise ValueError(
            f"kind must be {', '.join((ALL, *SWEEP_PICTURES))} for a sweep, got {kind!r} "
            "(a cell's run has the others)"
        )


def _run(
    scene: Scene, kind: str, progress: Progress | None, announce: Announce | None
) -> LabelledArrays:
    """Run a scene for what the pictures need.

    Where it has observables these are asked for; others are run at their own times and, where
    curves are drawn, between them.
    """
    if scene.bench:
        return record_scene(scene, progress, announce).arrays
    if scene.has_moving_wave:
        return record_scene(_for_pictures(scene, kind), progress, announce).arrays
    named = "slow_times" if scene.slow_times else "snapshots"
    own: tuple[float, ...] = getattr(scene, named)
    if not own or kind in ("snapshots", "spectra"):
        return record_scene(scene, progress, announce).arrays
    times = tuple(sorted({*own, *np.linspace(own[0], own[-1], LATTICE_LOOKS).tolist()}))
    made = record_scene(scene.changed(**{named: times}), progress, announce).arrays
    return with_looks(placed(made)).isel(time=[times.index(t) for t in own])


def read_source(source: Source) -> Labelled | Scene:
    """The run or the scene that is meant; ValueError if it is neither, or cannot be read."""
    if isinstance(source, Scene | Labelled):
        return source
    if not isinstance(source, str | Path):
        raise ValueError(
            f"source must be a run, a scene, or the path or name of one, got {shown(source)} "
            "(such as 'run.nc')"
        )
    if not names_a_run(source):
        return load_scene(str(source))
    try:
        return load_run(source)
    except OSError as error:
        reason = f"{Path(source)}: {error.strerror}"
        raise ValueError(f"source must be a run, got {reason} ({REMEDY})") from None


def _for_pictures(scene: Scene, kind: str) -> Scene:
    """The scene with the observables that are drawn.

    Of all pictures the error curve is drawn only if the scene asks for it: a run that is asked for
    it ends in an error where the wave cannot be told from its background. With it come the run's
    own errors, if the scene asks for them.
    """
    if kind == GROWTH:
        raise ValueError(
            f'kind must not be {GROWTH} for the scene of a wave, got it (wave = "perturbed_plane" '
            "has its growth measured)"
        )
    wanted = [p.observable for name, p in PICTURES.items() if kind in (ALL, name) and p.observable]
    if kind == ALL and "error_curve" not in scene.observables:
        wanted.remove("error_curve")
    if "error_curve" in wanted:
        wanted += [name for name in MEASURED if name in scene.observables]
    asked = tuple(dict.fromkeys(wanted))
    return replace(scene, observables=asked, look_points=scene.look_points or LOOKS)


def _draw(run: Labelled, kind: str) -> ShownFigure:
    """Draw the pictures of that kind, one below the other, the run's title above them."""
    data = with_theory(with_looks(placed(run), LEAST_LOOKS if kind == ALL else 2))
    drawn = _pictures(data, kind)
    return _stacked(_title(data), [picture.part(data) for picture in drawn])


def _draw_sweep(data: Labelled, kind: str, at: Choice, variable: str) -> ShownFigure:
    """Draw the pictures of a sweep, what was chosen of it in the title."""
    from longwave.reports.pictures.sweep_plotting import sweep_parts

    where = one_line(", ".join(f"{name} = {value}" for name, value in at.items()))[:MOST]
    title = "\n".join(filter(None, (_title(data), where)))
    sweep = cast("xr.Dataset", data)
    return _stacked(title, sweep_parts(sweep, None if kind == ALL else kind, at, variable))


def _stacked(title: str, parts: Sequence[Part]) -> ShownFigure:
    """A figure with a title and the parts below it."""
    heights = [part.height for part in parts]
    title = "\n".join(
        textwrap.fill(line, int(LETTERS * page_width())) for line in title.split("\n")
    )
    size = page_width(), sum(heights) + 0.25 * (1 + title.count("\n"))
    figure = ShownFigure(size, layout="constrained")
    figure.suptitle(title, parse_math=False, fontsize="medium")
    places = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False)[:, 0]
    for place, part in zip(places, parts, strict=True):
        part.draw(place)
    return figure


def _title(data: Labelled) -> str:
    """The run's title, and a line on how it ended if it ended early, each cut and wrapped."""
    lines = [data.attrs.get("title", ""), data.attrs.get("blow_up"), data.attrs.get("unfinished")]
    short = (textwrap.shorten(one_line(line), MOST, placeholder=" ...") for line in lines if line)
    return "\n".join(short)


def _pictures(data: LabelledArrays, kind: str) -> Sequence[Picture]:
    """The pictures that can be drawn of the run; ValueError if there is none."""
    wanted = PICTURES.values() if kind == ALL else [PICTURES[kind]]
    found = [picture for picture in wanted if _has(data, picture)]
    if not found:
        missing = ", ".join(dict.fromkeys(name for picture in wanted for name in picture.variables))
        asked = ", ".join(dict.fromkeys(p.observable for p in wanted if p.observable))
        given = (n for n in data if data[n].dims != (n,) and n != "offset")
        held = ", ".join(given) or "nothing"
        remedy = f"the scene must ask for {asked}" if asked else "a chain on a bench watches it"
        raise ValueError(f"source must hold what is drawn ({missing}), got {held} ({remedy})")
    return found


def _has(data: LabelledArrays, picture: Picture) -> bool:
    """Whether the run has the picture's variables, and numbers in them, and fits."""
    held = all(name in data and np.isfinite(data[name].values).any() for name in picture.variables)
    return held and picture.fits(data)


def _snapshots(data: LabelledArrays) -> Part:
    """Lattice against wave on a chain; on two axes maps of the strain and of the difference."""
    if "row" in data.sizes:
        return strain_maps(with_own(data))
    places = even_places(data.sizes["time"], MOST_PANELS)
    panels = snapshots(data, shown_half_width(data), places)
    _, across = grid_shape(len(panels), ACROSS)
    rows = [panels[i : i + across] for i in range(0, len(panels), across)]
    return snapshot_panels(rows, of_one=True)


def _spectra(data: LabelledArrays) -> Part:
    return spectrum_panels(spectra(data, even_places(data.sizes["time"], MOST_SPECTRA)))


def shown_half_width(run: Labelled) -> int:
    """Half-width in sites of what is shown: the wave as far as it differs from its background.

    Every site that is compared, where the wave is its background, and without one.
    """
    data = LabelledArrays.of(run)
    sites = np.abs(data["site"].values)
    if "background" not in data:
        return int(sites.max())
    deviation = np.abs(data["analytic"].values - data["background"].values)
    others = tuple(axis for axis, name in enumerate(data["analytic"].dims) if name != "site")
    deviation = np.nan_to_num(deviation, posinf=0.0).max(axis=others)
    seen = sites[deviation > SHOWN * deviation.max()]
    return int(max(1.25 * seen.max(), LEAST_SHOWN)) if seen.size else int(sites.max())


def _map(data: LabelledArrays) -> Part:
    """The map about the sites that the snapshots show, if there are snapshots."""
    shown = shown_half_width(data) if _has(data, PICTURES["snapshots"]) else None
    return space_time_map(data, shown)


def _errors(data: LabelledArrays) -> Part:
    return error_panels({rf"$\epsilon={data.attrs['eps']:g}$": error_curves(data)})


def _sizes(data: LabelledArrays) -> Part:
    return sideband_sizes(data, one_line(data.attrs.get("verdict", ""))[:MOST])


PICTURES: Mapping[str, Picture] = {
    "snapshots": Picture("strain", ("strain", "analytic", "n"), _snapshots),
    "space_time": Picture("space_time", ("space_time",), _map),
    "spectra": Picture("strain", ("strain", "analytic"), _spectra),
    "errors": Picture("error_curve", ("error_curve",), _errors),
    "crest": Picture("crest_track", ("crest_position", "crest_strain"), crest_track),
    "sensors": Picture("", ("sensor",), sensor_readings),
    "transmission": Picture("", ("sensor",), sensor_spectra, has_spectra),
    "balance": Picture("", BALANCE, energy_balance),
    "flux": Picture("", ("flux", "transmitted"), fluxes),
    "modes": Picture("", ("mode_energy",), mode_energies),
    "cells": Picture("", ("displacement",), cells_at_times),
    GROWTH: Picture("", ("sideband_size", "sideband_theory", "slow_time"), _sizes),
}
"""The kinds of pictures, in the order in which they are drawn."""


def changed_source(source: str, changes: Mapping[str, Any]) -> str | Scene:
    """A run's file or a scene's name, or the scene with the ``changes`` of `--set`."""
    if not changes:
        return source
    if names_a_run(source):
        raise ValueError(
            f"--set must not be given with the file of a run, got {source} (it was run as it is; "
            "name its scene)"
        )
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
    """Draw to the ``path`` and print it; return the exit status.

    0, 2 for wrong input, 130 after Ctrl-C, which ``program`` tells: what was run is drawn.
    """
    try:
        drawn = read_source(changed_source(source, changes))
        if not isinstance(drawn, Scene) and (fault := strain_fault(drawn)):
            print(f"{source}: {fault}", file=sys.stderr)
        with progress_bar(Path(source).name, source) as (advance, tell):
            plot(drawn, path, kind, advance, Announcer(tell), at, variable, columns)
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
