"""Drawing: snapshots, errors, space-time maps, crest tracks, spectra and costs, in one style."""

import math
from collections.abc import Mapping, Sequence
from string import ascii_uppercase
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from longwave.reports.latex import scientific
from longwave.reports.pictures import style
from longwave.reports.pictures.error_curve import ErrorCurve
from longwave.support.labelled_arrays import LabelledArrays, LabelledValues

Sites = NDArray[np.float64]


@style.part(lambda rows, wave="", of_one=False: SNAPSHOT_HEIGHT * len(rows) + 0.35)
def snapshot_panels(
    figure: FigureBase,
    rows: Sequence[Sequence[LabelledArrays]],
    wave: str = "",
    of_one: bool = False,
) -> None:
    """Draw two panels for each of `run_data.snapshots`, a row per run, lettered (A), (B), ....

    The upper panel has the strains. The lower one has the lattice's strain minus the wave's, over
    the band of the run's numerical error. ``wave`` is the label of the wave in the legend, by
    default that of the run. Each row has its own axis limits, unless all rows are ``of_one`` run.
    The legend stands in the gap of a shorter row, or else above the figure.
    """
    across, letters = max(len(row) for row in rows), iter(ascii_uppercase)
    signs: dict[str, Any] = {}
    differences: dict[str, Any] = {}
    free: FigureBase | Axes = figure
    heights = (2, 1) * len(rows)
    grid = figure.subplots(len(heights), across, squeeze=False, height_ratios=heights)
    for row, panels in zip(rows, grid.reshape(len(rows), 2, across), strict=True):
        compared = [at for row in rows for at in row] if of_one else row
        fields = [at[name].values for at in compared for name in ("strain", "analytic")]
        limits = spread_limits(fields)
        largest = max(map(_largest_difference, compared))
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
        free = _hide_axes(panels[:, len(row) :]) or free
        for ax in panels[1, : len(row)]:
            ax.set_xlabel(MOVING)
    figure.align_ylabels(grid[:, 0])
    add_legend(free, signs | differences)


SNAPSHOT_HEIGHT = 2.2
"""Height of a row of snapshots, in inches."""

MOVING = "$n - c\\,t$  (sites)"
"""Axis label for the position in the moving frame, n - c t in sites."""


def _hide_axes(axes: NDArray[Any]) -> Axes | None:
    """Hide unused axes; return the first, which a legend may take, and remove the others."""
    for index, ax in enumerate(axes.flat):
        ax.set_axis_off()
        if index:
            ax.remove()
    return axes.flat[0] if axes.size else None


def add_legend(axes_or_figure: FigureBase | Axes, signs: Mapping[str, Any]) -> None:
    """Draw a legend in empty axes or above a figure; ``signs`` maps labels to handles."""
    if isinstance(axes_or_figure, Axes):
        axes_or_figure.legend(signs.values(), signs.keys(), loc="center")
        return
    ncols = min(len(signs), max(1, int(style.page_width() / LEGEND_ENTRY_WIDTH)))
    axes_or_figure.legend(signs.values(), signs.keys(), loc="outside upper right", ncols=ncols)


LEGEND_ENTRY_WIDTH = 1.5
"""Width of an entry of the legend above a figure, in inches."""


def even_indices(count: int, most: int) -> list[int]:
    """Return at most ``most`` evenly spaced indices of ``count`` items, first and last included.

    >>> even_indices(7, 3), even_indices(2, 3), even_indices(0, 3)
    ([0, 3, 6], [0, 1], [])
    """
    return [round(index) for index in np.linspace(0, count - 1, min(count, most)).tolist()]


def _draw_snapshot(ax: Axes, at: LabelledArrays, letter: str, wave: str) -> dict[str, Any]:
    """Draw a panel with the wave as a thin line over the lattice; return legend handles by label.

    If a carrier's oscillations are too dense to be seen, the envelopes are drawn instead.
    """
    offset, beads = at["offset"].values, _are_beads(ax, at["strain"].size)
    strain_envelope = at.get("strain_envelope")
    if strain_envelope is not None and np.isfinite(strain_envelope.values).any() and not beads:
        signs = _draw_envelopes(ax, at)
    else:
        look = style.BEADS if beads else style.NUMERICAL
        signs = {"lattice": ax.plot(offset, at["strain"].values, **look)[0]}
        (signs[wave],) = ax.plot(offset, at["analytic"].values, **style.ANALYTICAL)
    eps, time = at.attrs["eps"], float(at["time"].values)
    ax.set_title(rf"({letter})  $\epsilon={eps:g}$, $t={time:g}$", loc="left")
    if np.unique(offset).size > 1:
        ax.set_xlim(offset[0], offset[-1])
    ax.locator_params(axis="x", nbins=5)
    return signs


def _draw_envelopes(ax: Axes, at: LabelledArrays) -> dict[str, Any]:
    """Draw a carrier's strain, and plus and minus the envelopes of the lattice and the wave."""
    offset = at["offset"].values
    (line,) = ax.plot(offset, at["strain"].values, color=style.LATTICE, linewidth=0.5, zorder=1)
    signs = {"lattice": line}
    for name, label, look in (
        ("strain_envelope", r"its envelope, $\propto |A|$", style.NUMERICAL),
        ("analytic_envelope", "envelope of the wave", style.ANALYTICAL),
    ):
        for side in (1.0, -1.0):
            (signs[label],) = ax.plot(offset, side * at[name].values, **look)
    return signs


def _are_beads(ax: Axes, count: int) -> bool:
    """Return whether ``count`` values are few enough for the axes to be drawn as beads."""
    cell = ax.get_subplotspec()
    columns = 1 if cell is None else cell.get_gridspec().ncols
    return count <= style.BEADS_AN_INCH * style.page_width() / columns


def _largest_difference(at: LabelledArrays) -> float:
    """Return the scale of an axis: max |lattice - wave| or, if larger, the numerical error."""
    difference = np.abs(at["strain"].values - at["analytic"].values)
    return max(float(np.max(difference[np.isfinite(difference)], initial=0.0)), _own(at) or 0.0)


def _own(at: LabelledArrays) -> float | None:
    """Return the numerical error of a snapshot, None if it was not measured."""
    own = float(at["own"].values) if "own" in at else math.nan
    return own if math.isfinite(own) else None


def _draw_difference(ax: Axes, at: LabelledArrays, largest: float) -> dict[str, Any]:
    """Draw lattice minus wave over the band of the numerical error; return the handles by label."""
    offset, own = at["offset"].values, _own(at)
    difference = at["strain"].values - at["analytic"].values
    (line,) = ax.plot(offset, difference, color="black", linewidth=0.8)
    signs: dict[str, Any] = {"lattice $-$ wave": line}
    if own is not None:
        signs[OWN_ERROR] = ax.axhspan(-own, own, color=style.OWN, alpha=0.5, lw=0, zorder=0)
    top = 1.15 * largest or 1.0
    ax.set_ylim(-top, top)
    ax.locator_params(axis="y", nbins=3)
    ax.yaxis.set_major_formatter(style.PowerTicks(-2, 3))
    ax.set_title(f"own error {error_text(own)}" if own else "", loc="right", fontsize=7.0, pad=2.0)
    return signs


OWN_ERROR = "own error of the run"
"""Legend label of a run's numerical error, which is due to its step and domain."""


def error_text(own: float) -> str:
    """Return the LaTeX of a numerical error, to one digit.

    >>> error_text(3.2e-8), error_text(1e-3)
    ('$3\\\\times 10^{-8}$', '$0.001$')
    """
    return scientific(own, 1).replace(r"$1\times ", "$")


def spread_limits(arrays: Sequence[Sites]) -> tuple[float, float]:
    """Return axis limits around all finite values, with a margin even if all are equal.

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
"""Panel title -> curve label -> error curve; labels may have LaTeX in dollars."""


@style.part(2.0)
def error_panels(figure: FigureBase, panels: ErrorPanels) -> None:
    """Draw a panel of error curves for each title, with markers only for single points."""
    axes = figure.subplots(1, len(panels), squeeze=False)[0]
    for ax, (title, curves) in zip(axes, panels.items(), strict=True):
        ax.set_title(title, loc="left")
        for (label, curve), look in zip(curves.items(), style.CURVES, strict=False):
            marker = "" if curve.errors.size > 1 else look["marker"]
            errors = np.where(np.isfinite(curve.errors), curve.errors, np.nan)
            ax.plot(curve.times, errors, label=label, **look | {"marker": marker})
            if curve.own is not None and np.isfinite(curve.own).any():
                _draw_own(ax, curve.times, curve.errors, curve.own, look["color"])
        ax.set(xlabel="$t$", ylabel=r"$L^\infty_\epsilon$")
        entries = len(ax.get_legend_handles_labels()[1])
        ax.set_ylim(0, ax.get_ylim()[1] * (1.0 + max(0, entries - 2) * LEGEND_ENTRY_HEIGHT))
        ax.locator_params(axis="x", nbins=6)
        ax.yaxis.set_major_formatter(style.PowerTicks())
        ax.legend()


def _draw_own(ax: Axes, times: Sites, errors: Sites, own: Sites, colour: str) -> None:
    """Draw a run's numerical error as a band, or as bars if it is known at few times.

    The legend states the largest value, as the band is often thinner than the line.
    """
    label = rf"own error $\leq$ {error_text(float(np.nanmax(own)))}"
    known = np.isfinite(own)
    if known.mean() > BAND_FRACTION:
        ends = errors - own, errors + own
        ax.fill_between(times, *ends, color=colour, alpha=0.3, lw=0, label=label)
    else:
        look: dict[str, Any] = {"color": colour, "linestyle": "", "marker": "o", "capsize": 3.0}
        ax.errorbar(times[known], errors[known], own[known], label=label, **look)


LEGEND_ENTRY_HEIGHT = 0.1
"""Height of each legend entry beyond the second, as a fraction of the panel's height."""

BAND_FRACTION = 0.5
"""Least fraction of times with a known numerical error for which it is drawn as a band."""

MIN_MAP_CELLS = 24
"""Least number of cells (groups of adjacent sites) that a space-time map shows."""


def field_label(run: LabelledArrays | LabelledValues, strain: str = "$y_n$") -> str:
    """Return the axis label of a run's or variable's field: "displacement", or else ``strain``.

    >>> field_label(LabelledArrays({}, {"field_kind": "displacement"}))
    'displacement'
    """
    units = str(run.attrs.get("field_kind") or run.attrs.get("units", ""))
    return "displacement" if units.startswith("displacement") else strain


@style.part(2.6)
def space_time_map(figure: FigureBase, run: LabelledArrays, half_width: int | None = None) -> None:
    """Draw the variable ``space_time`` of a run over time and sites, in the moving frame.

    The map is interpolated to even times and positions by `moving_grid`. At least `MIN_MAP_CELLS`
    cells and at most ``half_width`` sites to either side of c t are shown, by default all.
    """
    times, position, values = moving_grid(run)
    edges = time_edges(position)
    ax = figure.subplots()
    extent: Any = (*time_edges(times)[[0, -1]], *edges[[0, -1]])
    look: dict[str, Any] = {"origin": "lower", "aspect": "auto", "interpolation": "bilinear"}
    image = ax.imshow(values.T, extent=extent, **look)
    if half_width is not None:
        least = MIN_MAP_CELLS / 2 * float(edges[1] - edges[0])
        height = min(max(half_width, least), float(edges[-1]))
        ax.set_ylim(-height, height)
    ax.set(xlabel="$t$", ylabel=MOVING)
    strain = run["space_time"]
    label = "envelope of " * bool(strain.attrs.get("carried")) + field_label(strain)
    figure.colorbar(image, ax=ax, label=label)


def moving_grid(run: LabelledArrays) -> tuple[Sites, Sites, Sites]:
    """Return even times, even positions in the moving frame and a map's values (time, position).

    The map moves with the frame by whole sites. The variable ``shift`` of the run is the offset
    from c t of the map's site 0.

    >>> from longwave.support.labelled_arrays import LabelledArray
    >>> looks = {"look_time": np.array([0.0, 1.0]), "map_site": np.array([-1, 0, 1])}
    >>> variables = {name: LabelledArray((name,), values) for name, values in looks.items()}
    >>> ramp = np.array([[0.0, 1.0, 2.0], [0.0, 1.0, 2.0]])
    >>> variables["space_time"] = LabelledArray(("look_time", "map_site"), ramp)
    >>> variables["shift"] = LabelledArray(("look_time",), np.array([0.0, 0.5]))
    >>> moving_grid(LabelledArrays(variables))[2]
    array([[0. , 1. , 2. ],
           [0. , 0.5, 1.5]])
    """
    strain = run["space_time"]
    time, starts = (run[dimension].values for dimension in strain.dims)
    edges = cell_edges(starts)
    middles = (edges[1:] + edges[:-1]) / 2
    position = np.linspace(middles[0], middles[-1], middles.size)
    shift = run["shift"].values if "shift" in run else np.zeros(time.size)
    rows = zip(shift, strain.values, strict=True)
    sheared = np.array([np.interp(position, middles + by, row) for by, row in rows])
    even = np.linspace(time[0], time[-1], time.size)
    if time.size > 1 and np.all(np.diff(time) > 0.0):
        after = np.clip(np.searchsorted(time, even), 1, time.size - 1)
        weight = ((even - time[after - 1]) / (time[after] - time[after - 1]))[:, np.newaxis]
        sheared = (1.0 - weight) * sheared[after - 1] + weight * sheared[after]
    return even, position, sheared


def time_edges(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return edges half way between the times; the outer times are in the middle of their cells.

    >>> time_edges(np.array([0.0, 2.0, 3.0]))
    array([-1. ,  1. ,  2.5,  3.5])
    """
    if times.size == 1:
        return times[0] + np.array([-0.5, 0.5])
    middles = (times[1:] + times[:-1]) / 2
    return np.array([2 * times[0] - middles[0], *middles, 2 * times[-1] - middles[-1]])


def cell_edges(starts: NDArray[np.integer]) -> NDArray[np.float64]:
    """Return the edges of cells (groups of adjacent sites) whose first sites are ``starts``.

    The cells must lie evenly about site 0.

    >>> cell_edges(np.array([-4, -1, 2]))
    array([-4.5, -1.5,  1.5,  4.5])
    """
    return np.array([*starts, 1 - starts[0]]) - 0.5


CREST_LABELS = {"crest_position": "crest at " + MOVING, "crest_strain": "$y$ at the crest"}
"""Variable of a run -> axis label of its panel in the picture of the crest's track."""


def _crest_rows() -> int:
    """Return the number of rows of crest panels: two on a page one column wide, else one."""
    return 1 if style.page_width() > len(CREST_LABELS) * 2.0 else len(CREST_LABELS)


@style.part(lambda run: 0.3 + 1.7 * _crest_rows())
def crest_track(figure: FigureBase, run: LabelledArrays) -> None:
    """Draw the crest's position and strain over time as points, as a crest may jump to another.

    The wave's crest, of a run `run_data.with_theory`, and a soliton's strain by the law of its
    losses are drawn as lines.
    """
    rows = _crest_rows()
    panels = figure.subplots(rows, len(CREST_LABELS) // rows, squeeze=False)
    for ax, (name, label) in zip(panels.flat, CREST_LABELS.items(), strict=True):
        values, wave = run[name], run.get(f"{name}_wave")
        times = run[values.dims[0]].values
        every = max(1, -(-times.size // MAX_CREST_POINTS))
        ax.plot(times[::every], values.values[::every], label="lattice", **style.BEADS)
        if wave is not None:
            is_steady = _is_steady(run["crest_position_wave"].values)
            steady = np.where(is_steady, wave.values, np.nan)
            ax.plot(times, steady, label=run.attrs["wave"], **style.ANALYTICAL)
        if name == "crest_strain" and "crest_law" in run:
            law = run["crest_law"].values
            ax.plot(times, law, label="law", color="black", linestyle="--", lw=0.9)
        field = "envelope" if run.attrs.get("carried") else field_label(run, "$y$")
        ax.set(xlabel="$t$", ylabel=label.replace("$y$", field))
        ax.locator_params(axis="x", nbins=6)
        ax.yaxis.set_major_formatter(style.PowerTicks())
        ax.legend()


MAX_CREST_POINTS = 50
"""Largest number of points that are drawn of a crest's track."""

JUMP_SITES, JUMP_STEPS = 3.0, 8.0
"""Sites, and multiples of the median step: a step beyond both is a jump to another crest."""


def _is_steady(position: Sites) -> NDArray[np.bool_]:
    """Return a mask of the times at which the crest did not jump to another crest."""
    values = np.asarray(position, dtype=float)
    steps = np.abs(np.diff(values, prepend=values[:1]))
    known = steps[np.isfinite(steps)]
    return steps <= max(JUMP_SITES, JUMP_STEPS * float(np.median(known)) if known.size else 0.0)


MAX_SPECTRA = 6
"""Largest number of times at which spectra are drawn."""


@style.part(lambda spectra: 1.9 * grid_shape(spectra.sizes["time"])[0] + 0.35)
def spectrum_panels(figure: FigureBase, spectra: LabelledArrays) -> None:
    """Draw a panel for each time of `run_data.spectra`; the line is the run's numerical error."""
    amplitude = f"amplitude of {field_label(spectra, '$y$')}"
    grid, free = panel_grid(figure, spectra.sizes["time"], "wavenumber  (1/site)", amplitude)
    signs: dict[str, Any] = {}
    for index, ax in enumerate(grid):
        signs |= _draw_spectrum(ax, spectra.isel(time=index))
    grid[0].set_ylim(*_amplitude_limits(spectra))
    add_legend(free or figure, signs)


MIN_PANEL_WIDTH = 1.6
"""Least width of a panel, in inches."""


def grid_shape(count: int, most: int = 12) -> tuple[int, int]:
    """Return rows and columns of a grid of ``count`` panels, with at most ``most`` columns.

    At most one cell is empty, in the last row, for the legend.

    >>> [grid_shape(count, 3) for count in (1, 3, 4, 5, 6, 7)]
    [(1, 1), (1, 3), (2, 2), (2, 3), (2, 3), (4, 2)]
    """
    widest = max(1, min(count, most, int(style.page_width() / MIN_PANEL_WIDTH)))
    shapes = [(-(-count // across), across) for across in range(widest, 0, -1)]
    return next((rows, across) for rows, across in shapes if rows * across - count <= 1)


def panel_grid(
    figure: FigureBase, count: int, x: str, y: str, most: int = 12
) -> tuple[list[Axes], Axes | None]:
    """Return ``count`` panels with shared, labelled axes, and any empty cell for a legend."""
    rows, across = grid_shape(count, most)
    grid = figure.subplots(rows, across, squeeze=False, sharex=True, sharey=True)
    panels = list(grid.flat)[:count]
    for ax in panels[-across:]:
        ax.set_xlabel(x)
        ax.tick_params(labelbottom=True)
    for ax in grid[:, 0]:
        ax.set_ylabel(y)
    return panels, _hide_axes(grid.flat[count:])


WAVENUMBER_TICKS = [0.0, np.pi / 2, np.pi], ["0", r"$\pi/2$", r"$\pi$"]
"""Tick positions and tick labels on an axis of wavenumbers per site."""

STABLE = "#d9d9d9"
"""Colour of the region in which plane carrier waves are modulationally stable."""


def draw_grid(ax: Axes) -> None:
    """Draw thin grid lines at the major ticks."""
    ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)


def _draw_spectrum(ax: Axes, at: LabelledArrays) -> dict[str, Any]:
    """Draw the amplitudes at one time; return the handles by their labels."""
    lattice, wave = (
        np.where(np.isfinite(values) & (values > 0.0), values, np.nan)
        for values in (at["lattice"].values, at["wave"].values)
    )
    if np.isfinite([lattice, wave]).any():
        ax.set_yscale("log")
    wavenumbers = at["wavenumber"].values
    signs = {"lattice": ax.plot(wavenumbers, lattice, **style.NUMERICAL)[0]}
    (signs["wave"],) = ax.plot(wavenumbers, wave, **style.ANALYTICAL)
    looks: dict[str, tuple[str, Any]] = {
        "own": (OWN_ERROR + ", at most", {"color": style.OWN, "linestyle": "--", "linewidth": 1.2}),
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


def _amplitude_limits(spectra: LabelledArrays) -> tuple[float, float]:
    """Return amplitude limits: from a tenth of the rounding error to above all amplitudes."""
    amplitudes = np.concatenate([spectra[name].values.ravel() for name in ("lattice", "wave")])
    amplitudes = amplitudes[np.isfinite(amplitudes) & (amplitudes > 0.0)]
    high = float(amplitudes.max()) if amplitudes.size else 1.0
    floors = [floor for floor in spectra["rounding"].values.tolist() if 0.0 < floor < high]
    return min([*floors, 0.1 * high]) / 10.0, 3.0 * high


MAX_LEGEND_COLUMNS = 4
"""Largest number of entries in a row of the legend of a cost figure."""

CostPanels = Mapping[str, Mapping[str, Sequence[tuple[float, float]]]]
"""Panel title -> curve label -> points (x, y) with both numbers positive."""


def cost_figure(
    panels: CostPanels,
    x: str,
    y: str,
    across: int = 3,
    height: float = 1.8,
    x_ticks: Sequence[float] = (),
    digits: Sequence[float] = (),
    cheapest: str = "",
) -> Figure:
    """Return a figure of panels with shared axes and one legend, ``across`` in a row.

    ``height`` is that of a row in inches. ``x_ticks`` replace the usual ticks of the logarithmic x
    axis. With ``digits`` the y axis is linear, with these ticks, and ends at the last of them.
    ``cheapest`` is for work as x and errors as y: it names the points in the legend, such as
    "runs", and lines join only the points of `cheapest_indices`.
    """
    down, _ = grid_shape(len(panels), across)
    figure = Figure((style.page_width(), height * down + 0.4), layout="constrained")
    grid, free = panel_grid(figure, len(panels), x, y, across)
    labels = dict.fromkeys(label for curves in panels.values() for label in curves)
    looks = dict(zip(labels, style.CURVES, strict=False))
    for (title, curves), ax in zip(panels.items(), grid, strict=True):
        _draw_costs(ax, curves, looks, bool(cheapest))
        ax.set_title(title, loc="left")
    first = grid[0]
    limits = first.get_xlim()
    low, high = map(math.log10, limits)
    if math.floor(high) >= low:  # a power of ten is on the axis, labelled
        first.xaxis.set_minor_formatter(NullFormatter())
    if x_ticks:
        first.set_xticks(x_ticks, [f"{tick:g}" for tick in x_ticks])
        first.set_xticks([], minor=True)
        first.set_xlim(limits)
    if digits:
        first.set_yscale("linear")
        first.set_ylim(0, digits[-1])
        first.set_yticks(digits)
    handles = {h.get_label(): h for ax in grid for h in ax.lines}
    options: dict[str, Any] = {"handles": [handles[label] for label in looks]}
    if cheapest:
        options |= {"title": CHEAPEST_TITLE.format(cheapest), "title_fontsize": 8.0}
    if free:
        free.legend(loc="center", **options)
    else:
        columns = min(len(looks), MAX_LEGEND_COLUMNS)
        figure.legend(loc="outside upper center", ncols=columns, **options)
    return figure


CHEAPEST_TITLE = "points: {}; lines: the cheapest\nfor an error (monotone envelope)"
"""Legend title if lines join the points of `cheapest_indices`; the braces name the points."""


def cheapest_indices(work: Sites, errors: Sites) -> NDArray[np.intp]:
    """Return the indices of the runs that no other run beats in both work and error.

    They are sorted by work, and their errors fall; NaN is left out.

    >>> cheapest_indices(np.array([1.0, 3.0, 2.0, 4.0]), np.array([0.1, 0.02, 0.2, np.nan]))
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
    """Draw the curves of one panel; points that are not finite and positive are left out."""
    for label, points in curves.items():
        values = np.array([p for p in points if min(p) > 0 and np.all(np.isfinite(p))])
        x, y = values.reshape(-1, 2).T
        look = dict(looks[label], markersize=4.0)
        if cheapest:
            ax.loglog(x, y, **look | {"linestyle": "", "markersize": 2.5, "alpha": 0.5})
        best = cheapest_indices(x, y) if cheapest else slice(None)
        ax.loglog(x[best], y[best], label=label, **look)
    draw_grid(ax)
