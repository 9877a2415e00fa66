"""Drawing: snapshots, errors, space-time maps, crest tracks, spectra and costs, in one style."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from longwave.reports.latex import scientific
from longwave.reports.pictures.error_curve import ErrorCurve
from longwave.reports.pictures.style import (
    ANALYTICAL,
    BEADS,
    BEADS_AN_INCH,
    CURVES,
    LATTICE,
    NUMERICAL,
    OWN,
    PowerTicks,
    page_width,
    part,
)
from longwave.support.labelled_arrays import LabelledArrays, LabelledValues

Sites = NDArray[np.float64]


@part(lambda rows, wave="", of_one=False: SNAPSHOT * len(rows) + 0.35)
def snapshot_panels(
    figure: FigureBase,
    rows: Sequence[Sequence[LabelledArrays]],
    wave: str = "",
    of_one: bool = False,
) -> None:
    """Two panels for each of `run_data.snapshots`, one row per run, lettered (A), (B), ... .

    The strains, and below them the lattice less the wave on the band of the run's own error.
    ``wave`` is what the legend calls the analytical strain, where the run's own word is not taken.
    Rows have axes of their own, unless they are all ``of_one`` run. The legend stands in the place
    that a shorter row leaves, and otherwise above.
    """
    across = max(len(row) for row in rows)
    letters = map(chr, range(ord("A"), ord("Z") + 1))
    signs: dict[str, Any] = {}
    differences: dict[str, Any] = {}
    free: FigureBase | Axes = figure
    heights = (2, 1) * len(rows)
    grid = figure.subplots(len(heights), across, squeeze=False, height_ratios=heights)
    for row, panels in zip(rows, grid.reshape(len(rows), 2, across), strict=True):
        alike = [at for row in rows for at in row] if of_one else row
        limits = spread_limits([at[name].values for at in alike for name in ("strain", "analytic")])
        largest = max(map(_largest_difference, alike))
        for column, at in enumerate(row):
            above, below = panels[:, column]
            above.sharex(below)
            signs |= _draw_snapshot(above, at, next(letters), wave or at.attrs["wave"])
            differences |= _draw_difference(below, at, largest)
            above.set_ylim(*limits)
            above.tick_params(labelbottom=False, labelleft=column == 0)
            below.tick_params(labelleft=column == 0)
        panels[0, 0].set_ylabel(field_label(row[0]))
        panels[1, 0].set_ylabel("difference")
        free = _without(panels[:, len(row) :]) or free
        for ax in panels[1, : len(row)]:
            ax.set_xlabel(MOVING)
    figure.align_ylabels(grid[:, 0])
    add_legend(free, signs | differences)


SNAPSHOT = 2.2
"""Height of a row of snapshots in inches."""

MOVING = "$n - c\\,t$  (sites)"
"""The label of the sites in the frame that moves along."""


def _without(axes: NDArray[Any]) -> Axes | None:
    """Take away axes that nothing is drawn in; the first, bare, stays for a legend."""
    for place, ax in enumerate(axes.flat):
        ax.set_axis_off()
        if place:
            ax.remove()
    return axes.flat[0] if axes.size else None


def add_legend(place: FigureBase | Axes, signs: Mapping[str, Any]) -> None:
    """The legend of these signs by their labels: in bare axes, or above a figure."""
    if isinstance(place, Axes):
        place.legend(signs.values(), signs.keys(), loc="center")
        return
    ncols = min(len(signs), max(1, int(page_width() / LEGEND_ENTRY)))
    place.legend(signs.values(), signs.keys(), loc="outside upper right", ncols=ncols)


LEGEND_ENTRY = 1.5
"""Inches of an entry of a legend above a figure."""


def even_places(count: int, most: int) -> list[int]:
    """At most that many places of ``count``, evenly from the first to the last.

    >>> even_places(7, 3), even_places(2, 3), even_places(0, 3)
    ([0, 3, 6], [0, 1], [])
    """
    return [round(place) for place in np.linspace(0, count - 1, min(count, most)).tolist()]


def _draw_snapshot(ax: Axes, at: LabelledArrays, letter: str, wave: str) -> dict[str, Any]:
    """Draw one panel, the wave as a thin line on the lattice; return the signs by their labels.

    Of a carrier whose waves are too many to be seen the envelopes are compared.
    """
    offset, beads = at["offset"].values, _are_beads(ax, at["strain"].size)
    enveloped = at.get("strain_envelope")
    if enveloped is not None and np.isfinite(enveloped.values).any() and not beads:
        signs = _draw_envelopes(ax, at)
    else:
        look = BEADS if beads else NUMERICAL
        signs = {"lattice": ax.plot(offset, at["strain"].values, **look)[0]}
        (signs[wave],) = ax.plot(offset, at["analytic"].values, **ANALYTICAL)
    eps, time = at.attrs["eps"], float(at["time"].values)
    ax.set_title(rf"({letter})  $\epsilon={eps:g}$, $t={time:g}$", loc="left")
    if np.unique(offset).size > 1:
        ax.set_xlim(offset[0], offset[-1])
    ax.locator_params(axis="x", nbins=5)
    return signs


def _draw_envelopes(ax: Axes, at: LabelledArrays) -> dict[str, Any]:
    """Draw a carrier's strain, and its envelope and the wave's to either side of zero."""
    offset = at["offset"].values
    (line,) = ax.plot(offset, at["strain"].values, color=LATTICE, linewidth=0.5, zorder=1)
    signs = {"lattice": line}
    for name, label, look in (
        ("strain_envelope", r"its envelope, $\propto |A|$", NUMERICAL),
        ("analytic_envelope", "envelope of the wave", ANALYTICAL),
    ):
        for side in (1.0, -1.0):
            (signs[label],) = ax.plot(offset, side * at[name].values, **look)
    return signs


def _are_beads(ax: Axes, count: int) -> bool:
    across = ax.get_subplotspec()
    columns = 1 if across is None else across.get_gridspec().ncols
    return count <= BEADS_AN_INCH * page_width() / columns


def _largest_difference(at: LabelledArrays) -> float:
    """What an axis of differences must hold."""
    apart = np.abs(at["strain"].values - at["analytic"].values)
    return max(float(np.max(apart[np.isfinite(apart)], initial=0.0)), _own(at) or 0.0)


def _own(at: LabelledArrays) -> float | None:
    """A snapshot's own error; None where it was not measured."""
    own = float(at["own"].values) if "own" in at else math.nan
    return own if math.isfinite(own) else None


def _draw_difference(ax: Axes, at: LabelledArrays, largest: float) -> dict[str, Any]:
    """Draw the lattice less the wave on the band of the own error; return signs and labels."""
    offset, own = at["offset"].values, _own(at)
    apart = at["strain"].values - at["analytic"].values
    (line,) = ax.plot(offset, apart, color="black", linewidth=0.8)
    signs: dict[str, Any] = {"lattice $-$ wave": line}
    if own is not None:
        signs[OWN_ERROR] = ax.axhspan(-own, own, color=OWN, alpha=0.5, lw=0, zorder=0)
    top = 1.15 * largest or 1.0
    ax.set_ylim(-top, top)
    ax.locator_params(axis="y", nbins=3)
    ax.yaxis.set_major_formatter(PowerTicks(-2, 3))
    ax.set_title(f"own error {told_error(own)}" if own else "", loc="right", fontsize=7.0, pad=2.0)
    return signs


OWN_ERROR = "own error of the run"


def told_error(own: float) -> str:
    """An error to one digit, as mathematics.

    >>> told_error(3.2e-8), told_error(1e-3)
    ('$3\\\\times 10^{-8}$', '$0.001$')
    """
    return scientific(own, 1).replace(r"$1\times ", "$")


def spread_limits(arrays: Sequence[Sites]) -> tuple[float, float]:
    """An axis that holds all finite values with a margin, and is no point where all are equal.

    >>> spread_limits([np.array([0.0, 100.0, np.nan])]), spread_limits([np.zeros(3)])
    ((-6.0, 106.0), (-1.0, 1.0))
    """
    values = np.concatenate([np.ravel(array) for array in arrays])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if values.size else (0.0, 0.0)
    margin = 0.06 * (high - low)
    if not margin > 1e-12 * max(abs(low), abs(high)):
        margin = 0.1 * abs(high) or 1.0
    return low - margin, high + margin


ErrorPanels = Mapping[str, Mapping[str, ErrorCurve]]
"""Curves of each title by their labels, which may hold mathematics in dollars."""


@part(2.0)
def error_panels(figure: FigureBase, panels: ErrorPanels) -> None:
    """One panel of curves for each title, without markers but where there is one point alone."""
    axes = figure.subplots(1, len(panels), squeeze=False)[0]
    for ax, (title, curves) in zip(axes, panels.items(), strict=True):
        ax.set_title(title, loc="left")
        for (label, curve), look in zip(curves.items(), CURVES, strict=False):
            marker = "" if curve.errors.size > 1 else look["marker"]
            errors = np.where(np.isfinite(curve.errors), curve.errors, np.nan)
            ax.plot(curve.times, errors, label=label, **look | {"marker": marker})
            if curve.own is not None and np.isfinite(curve.own).any():
                _draw_own(ax, curve.times, curve.errors, curve.own, look["color"])
        ax.set_xlabel("$t$")
        ax.set_ylabel(r"$L^\infty_\epsilon$")
        entries = len(ax.get_legend_handles_labels()[1])
        ax.set_ylim(0, ax.get_ylim()[1] * (1.0 + max(0, entries - 2) * LEGEND_ROOM))
        ax.locator_params(axis="x", nbins=6)
        ax.yaxis.set_major_formatter(PowerTicks())
        ax.legend()


def _draw_own(ax: Axes, times: Sites, errors: Sites, own: Sites, colour: str) -> None:
    """Draw a band about a curve, or bars where the run's own error is known at a few times.

    It is often thinner than the line, so its label says how much it is.
    """
    label = rf"own error $\leq$ {told_error(float(np.nanmax(own)))}"
    known = np.isfinite(own)
    if known.sum() > BARS * own.size:
        ends = errors - own, errors + own
        ax.fill_between(times, *ends, color=colour, alpha=0.3, lw=0, label=label)
    else:
        look: dict[str, Any] = {"color": colour, "linestyle": "", "marker": "o", "capsize": 3.0}
        ax.errorbar(times[known], errors[known], own[known], label=label, **look)


LEGEND_ROOM = 0.1
"""Of the height of a panel, that an entry of its legend beyond the second takes."""

BARS = 0.5
"""Share of the times at which the own error must be known for it to be a band."""

LEAST_CELLS = 24
"""Fewest cells of sites that are shown."""


def field_label(run: LabelledArrays | LabelledValues, strain: str = "$y_n$") -> str:
    """The axis label of what a run or one of its variables holds, ``strain`` unless told.

    >>> field_label(LabelledArrays({}, {"field_kind": "displacement"}))
    'displacement'
    """
    units = str(run.attrs.get("field_kind") or run.attrs.get("units", ""))
    return "displacement" if units.startswith("displacement") else strain


@part(2.6)
def space_time_map(figure: FigureBase, run: LabelledArrays, half_width: int | None = None) -> None:
    """The variable ``space_time`` of a run, over the time and the first sites of its cells.

    It is drawn on an even grid of times and of places in the moving frame, which passes the sites
    one by one: the variable ``shift`` says how far from c t those are that stand at 0.
    `half_width` is how many sites are shown to either side of c t; `LEAST_CELLS` at least.
    """
    times, place, values = moving_grid(run)
    edges = time_edges(place)
    ax = figure.subplots()
    extent: Any = (*time_edges(times)[[0, -1]], *edges[[0, -1]])
    look: dict[str, Any] = {"origin": "lower", "aspect": "auto", "interpolation": "bilinear"}
    drawn = ax.imshow(values.T, extent=extent, **look)
    if half_width is not None:
        least = LEAST_CELLS / 2 * float(edges[1] - edges[0])
        shown = min(max(half_width, least), float(edges[-1]))
        ax.set_ylim(-shown, shown)
    ax.set_xlabel("$t$")
    ax.set_ylabel(MOVING)
    strain = run["space_time"]
    label = field_label(strain)
    figure.colorbar(
        drawn, ax=ax, label=f"envelope of {label}" if strain.attrs.get("carried") else label
    )


def moving_grid(run: LabelledArrays) -> tuple[Sites, Sites, Sites]:
    """Even times, even places in the moving frame, and the values (time, place) of a run's map.

    >>> from longwave.support.labelled_arrays import LabelledArray
    >>> looks = {"look_time": np.array([0.0, 1.0]), "map_site": np.array([-1, 0, 1])}
    >>> held = {name: LabelledArray((name,), values) for name, values in looks.items()}
    >>> ramp = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 2.0]])
    >>> held["space_time"] = LabelledArray(("look_time", "map_site"), ramp)
    >>> held["shift"] = LabelledArray(("look_time",), np.array([0.0, 0.5]))
    >>> moving_grid(LabelledArrays(held))[2]
    array([[0. , 1. , 2. ],
           [0. , 0.5, 1.5]])
    """
    strain = run["space_time"]
    time, starts = (run[dimension].values for dimension in strain.dims)
    edges = cell_edges(starts)
    middles = (edges[1:] + edges[:-1]) / 2
    place = np.linspace(middles[0], middles[-1], middles.size)
    shift = run["shift"].values if "shift" in run else np.zeros(time.size)
    rows = zip(shift, strain.values, strict=True)
    sheared = np.array([np.interp(place, middles + by, row) for by, row in rows])
    even = np.linspace(time[0], time[-1], time.size)
    if time.size > 1 and np.all(np.diff(time) > 0.0):
        after = np.clip(np.searchsorted(time, even), 1, time.size - 1)
        share = ((even - time[after - 1]) / (time[after] - time[after - 1]))[:, np.newaxis]
        sheared = (1.0 - share) * sheared[after - 1] + share * sheared[after]
    return even, place, sheared


def time_edges(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges half way between the times, the first and the last time in the middle of their cells.

    >>> time_edges(np.array([0.0, 2.0, 3.0]))
    array([-1. ,  1. ,  2.5,  3.5])
    """
    if times.size == 1:
        return times[0] + np.array([-0.5, 0.5])
    middles = (times[1:] + times[:-1]) / 2
    return np.array([2 * times[0] - middles[0], *middles, 2 * times[-1] - middles[-1]])


def cell_edges(starts: NDArray[np.integer]) -> NDArray[np.float64]:
    """Edges of the cells of sites that begin at `starts`; all sites lie evenly about 0.

    >>> cell_edges(np.array([-4, -1, 2]))
    array([-4.5, -1.5,  1.5,  4.5])
    """
    return np.array([*starts, 1 - starts[0]]) - 0.5


WAVES_CREST = "crest_position_wave"

LABELS = {"crest_position": "crest at " + MOVING, "crest_strain": "$y$ at the crest"}


def _crest_rows() -> int:
    """Panels of a crest's track below each other: both in one column of a journal."""
    return 1 if page_width() > len(LABELS) * 2.0 else len(LABELS)


@part(lambda run: 0.3 + 1.7 * _crest_rows())
def crest_track(figure: FigureBase, run: LabelledArrays) -> None:
    """The crest's position and strain as points: a crest may give way to another one.

    The wave's own, which a run that is `run_data.with_theory` has, and a soliton's strain by the
    law of its losses are lines.
    """
    rows = _crest_rows()
    panels = figure.subplots(rows, len(LABELS) // rows, squeeze=False)
    for ax, (name, label) in zip(panels.flat, LABELS.items(), strict=True):
        values, wave = run[name], run.get(f"{name}_wave")
        times = run[values.dims[0]].values
        every = max(1, -(-times.size // CREST_POINTS))
        ax.plot(times[::every], values.values[::every], label="lattice", **BEADS)
        if wave is not None:
            told = run.attrs["wave"]
            steady = np.where(_is_steady(run[WAVES_CREST].values), wave.values, np.nan)
            ax.plot(times, steady, label=told, **ANALYTICAL)
        if name == "crest_strain" and "crest_law" in run:
            law = run["crest_law"].values
            ax.plot(times, law, label="law", color="black", linestyle="--", lw=0.9)
        ax.set_xlabel("$t$")
        field = "envelope" if run.attrs.get("carried") else field_label(run, "$y$")
        ax.set_ylabel(label.replace("$y$", field))
        ax.locator_params(axis="x", nbins=6)
        ax.yaxis.set_major_formatter(PowerTicks())
        ax.legend()


CREST_POINTS = 50
"""Most points of a crest's track that are drawn."""

JUMP = 3.0, 8.0
"""A crest gives way to another where it moves so many sites, and so many times the median step."""


def _is_steady(position: Sites) -> NDArray[np.bool_]:
    """Where a crest has not given way to another one since the time before."""
    values = np.asarray(position, dtype=float)
    steps = np.abs(np.diff(values, prepend=values[:1]))
    known = steps[np.isfinite(steps)]
    sites, times = JUMP
    return steps <= max(sites, times * float(np.median(known)) if known.size else 0.0)


MOST_SPECTRA = 6
"""Most spectra."""

DECADES = 1.0
"""How far below the rounding the axis of amplitudes ends."""


@part(lambda found: 1.9 * grid_shape(found.sizes["time"])[0] + 0.35)
def spectrum_panels(figure: FigureBase, found: LabelledArrays) -> None:
    """One panel for each time of `run_data.spectra`, all with the same axes.

    The run's own error is a line: amplitudes below it are not trusted, and can still be seen.
    """
    count = found.sizes["time"]
    amplitude = f"amplitude of {field_label(found, '$y$')}"
    grid, free = panel_grid(figure, count, "wavenumber  (1/site)", amplitude)
    signs: dict[str, Any] = {}
    for place, ax in enumerate(grid):
        signs |= _draw_spectrum(ax, found.isel(time=place))
    grid[0].set_ylim(*_amplitude_limits(found))
    add_legend(free or figure, signs)


LEAST_PANEL = 1.6
"""Least width of a panel in inches."""


def grid_shape(count: int, most: int = 12) -> tuple[int, int]:
    """Rows and columns of that many panels, at most ``most`` side by side.

    At most one place is left, in the last row, where the legend stands.

    >>> [grid_shape(count, 3) for count in (1, 3, 4, 5, 6, 7)]
    [(1, 1), (1, 3), (2, 2), (2, 3), (2, 3), (4, 2)]
    """
    widest = max(1, min(count, most, int(page_width() / LEAST_PANEL)))
    shapes = [(-(-count // across), across) for across in range(widest, 0, -1)]
    return next((down, across) for down, across in shapes if down * across - count <= 1)


def panel_grid(
    figure: FigureBase, count: int, x: str, y: str, most: int = 12
) -> tuple[list[Axes], Axes | None]:
    """That many panels with the same axes, the lowest of each column and the left ones labelled.

    With them come the bare axes that are left for a legend, if there are any.
    """
    down, across = grid_shape(count, most)
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    panels = list(grid.flat)[:count]
    for ax in panels[-across:]:
        ax.set_xlabel(x)
        ax.tick_params(labelbottom=True)
    for ax in grid[:, 0]:
        ax.set_ylabel(y)
    return panels, _without(grid.flat[count:])


WAVENUMBER_TICKS = [0.0, np.pi / 2, np.pi], ["0", r"$\pi/2$", r"$\pi$"]
"""Of an axis of wavenumbers per site: places and texts."""

STABLE = "#d9d9d9"
"""The colour of where plane waves are stable."""


def draw_grid(ax: Axes) -> None:
    """Draw thin lines at the ticks."""
    ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)


def _draw_spectrum(ax: Axes, at: LabelledArrays) -> dict[str, Any]:
    """Draw the amplitudes at one time; return the signs by their labels."""
    lattice, wave = (
        np.where(np.isfinite(values) & (values > 0.0), values, np.nan)
        for values in (at["lattice"].values, at["wave"].values)
    )
    if np.isfinite([lattice, wave]).any():
        ax.set_yscale("log")
    wavenumbers = at["wavenumber"].values
    signs = {"lattice": ax.plot(wavenumbers, lattice, **NUMERICAL)[0]}
    (signs["wave"],) = ax.plot(wavenumbers, wave, **ANALYTICAL)
    looks: dict[str, tuple[str, Any]] = {
        "own": (OWN_ERROR + ", at most", {"color": OWN, "linestyle": "--", "linewidth": 1.2}),
        "rounding": ("rounding", {"color": "black", "linestyle": ":", "linewidth": 0.8}),
    }
    for name, (label, look) in looks.items():
        level = float(at[name].values)
        if 0.0 < level < math.inf:
            signs[label] = ax.axhline(level, zorder=1.5, **look)
    ax.set_xlim(0.0, np.pi)
    ax.set_xticks(*WAVENUMBER_TICKS)
    ax.set_title(f"$t={float(at['time'].values):g}$", loc="left")
    return signs


def _amplitude_limits(found: LabelledArrays) -> tuple[float, float]:
    """From below the rounding to above all amplitudes; some range where all is constant."""
    every = np.concatenate([found["lattice"].values.ravel(), found["wave"].values.ravel()])
    every = every[np.isfinite(every) & (every > 0.0)]
    high = float(every.max()) if every.size else 1.0
    floors = [floor for floor in found["rounding"].values.tolist() if 0.0 < floor < high]
    low = min([*floors, 0.1 * high]) / 10.0**DECADES
    return low, 3.0 * high


LEGEND = 4
"""Most entries of the legend side by side."""

COST_HEIGHT = 1.8
"""Height of one row of panels, in inches."""


CostPanels = Mapping[str, Mapping[str, Sequence[tuple[float, float]]]]
"""For each title the curves by their labels: points (x, y), both positive."""


def cost_figure(
    panels: CostPanels,
    x: str,
    y: str,
    across: int = 3,
    height: float = COST_HEIGHT,
    x_ticks: Sequence[float] = (),
    digits: Sequence[float] = (),
    cheapest: str = "",
) -> Figure:
    """Draw the panels, at most ``across`` in a row of that height, with the same axes and one
    legend.

    ``x_ticks`` are those of a logarithmic axis where they are not the usual ones. With ``digits``
    the vertical axis is linear with these ticks, the last one its end. Where x is work and y an
    error, ``cheapest`` says what the points are, such as "runs": lines join the `cheapest_places`
    alone, as the legend says.
    """
    down, _ = grid_shape(len(panels), across)
    figure = Figure((page_width(), height * down + 0.4), layout="constrained")
    grid, free = panel_grid(figure, len(panels), x, y, across)
    labels = dict.fromkeys(label for curves in panels.values() for label in curves)
    looks = dict(zip(labels, CURVES, strict=False))
    for (title, curves), ax in zip(panels.items(), grid, strict=True):
        _draw_costs(ax, curves, looks, bool(cheapest))
        ax.set_title(title, loc="left")
    first = grid[0]
    shown = first.get_xlim()
    if math.floor(math.log10(shown[1])) >= math.log10(shown[0]):  # a power of ten, which is told
        first.xaxis.set_minor_formatter(NullFormatter())
    if x_ticks:
        first.set_xticks(x_ticks, [f"{tick:g}" for tick in x_ticks])
        first.set_xticks([], minor=True)
        first.set_xlim(shown)
    if digits:
        first.set_yscale("linear")
        first.set_ylim(0, digits[-1])
        first.set_yticks(digits)
    handles = {h.get_label(): h for ax in grid for h in ax.lines}
    ordered = [handles[label] for label in looks]
    words: Any = {"title": CHEAPEST.format(cheapest), "title_fontsize": 8.0} if cheapest else {}
    if free:
        free.legend(handles=ordered, loc="center", **words)
    else:
        columns = min(len(ordered), LEGEND)
        figure.legend(handles=ordered, loc="outside upper center", ncols=columns, **words)
    return figure


CHEAPEST = "points: {}; lines: the cheapest\nfor an error (monotone envelope)"


def cheapest_places(work: Sites, errors: Sites) -> NDArray[np.intp]:
    """The places of the runs that no other one beats in both, in the order of their work.

    Their errors fall as the work grows: work that has no place on a line was done in vain.

    >>> cheapest_places(np.array([1.0, 3.0, 2.0, 4.0]), np.array([0.1, 0.02, 0.2, np.nan]))
    array([0, 1])
    """
    order = np.lexsort((errors, work))
    order = order[np.isfinite(work[order]) & np.isfinite(errors[order])]
    best = np.minimum.accumulate(errors[order])
    return order[np.flatnonzero(errors[order] < np.concatenate([[np.inf], best[:-1]])[: best.size])]


def _draw_costs(
    ax: Axes,
    curves: Mapping[str, Sequence[tuple[float, float]]],
    looks: Mapping[str, dict[str, Any]],
    cheapest: bool,
) -> None:
    """Draw one panel; points that are not finite and positive are left out."""
    for label, points in curves.items():
        values = np.array([p for p in points if min(p) > 0 and np.all(np.isfinite(p))])
        x, y = values.reshape(-1, 2).T
        style = dict(looks[label], markersize=4.0)
        if cheapest:
            ax.loglog(x, y, **style | {"linestyle": "", "markersize": 2.5, "alpha": 0.5})
        joined = cheapest_places(x, y) if cheapest else slice(None)
        ax.loglog(x[joined], y[joined], label=label, **style)
    draw_grid(ax)
