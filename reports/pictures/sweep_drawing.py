"""Curves, heat maps and panels of work against precision over the dimensions of a sweep.

An axis is a swept dimension: numbers at their values, on a logarithmic axis if their logarithms are
evenly spaced, or texts side by side. Cells without a value are grey; those that were run without a
result have a cross; those whose value has a large error of its own are hatched.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import FigureBase
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from longwave.reports.latex import greek
from longwave.reports.pictures import drawing
from longwave.reports.pictures.style import CURVES, part

Array = NDArray[np.float64]
Cells = NDArray[np.bool_]

MAX_HEAT_COLUMNS = 3
"""Largest number of heat maps side by side."""

LOG_SCALE_RATIO = 30.0
"""Ratio of the largest to the smallest positive value above which a scale is logarithmic."""

EMPTY_COLOUR = "#d9d9d9"
"""Colour of a cell without a value."""

LARGE_ERROR, HATCH = 0.1, "////"
"""Numerical error relative to the value above which a heat map's cell is hatched; the hatch."""

DARK_FRACTION = 0.6
"""Fraction of the colour range that is dark; hatches are white there, else black."""

CURVE_OFFSET = 0.1
"""Sideways distance between points of different curves at one text, where texts are 1 apart."""

ROW_HEIGHT = 0.04
"""Height of a row of crosses, as a fraction of the axes' height."""

NO_RESULT = "\N{MULTIPLICATION SIGN}: no result"
"""Explanation of the crosses at the lower edge of curves."""

OF_ESTIMATE, OF_WAVE = "estimated", "relative to the wave"
"""Legend labels of a run's estimated error, and of its error relative to the wave."""

LETTER = re.compile(r"\\[a-z]+|[A-Za-z](_?[0-9A-Za-z])?")
"""Pattern of names to set as mathematics: one letter or a LaTeX command, perhaps with an index."""

LONGEST_TICK, LONGEST_BESIDE, LONGEST_ABOVE, LONGEST_IN_TWO = 16, 24, 80, 50
"""Largest number of characters of a tick label, of a legend entry beside a picture or a map's
title, of a legend entry above a picture, and of an entry there in two columns."""

CUT = "..."
"""Text that replaces the middle of a text that is too long."""

MAX_TICKS = 6
"""Largest number of ticks of a logarithmic axis; they are at some of its values."""


@dataclass(frozen=True)
class SweptAxis:
    """A swept dimension: its name, and its numbers or texts in the order of the cells."""

    name: str
    values: Sequence[float] | Sequence[str]

    @property
    def is_text(self) -> bool:
        """Whether the values are texts, which are spaced evenly."""
        return any(isinstance(value, str) for value in self.values)

    @property
    def places(self) -> Array:
        """Positions of the values on the axis."""
        return np.asarray(range(len(self.values)) if self.is_text else self.values, dtype=float)

    @property
    def is_logarithmic(self) -> bool:
        """Whether the logarithms of the values are more evenly spaced than the values."""
        places = np.sort(self.places)
        if self.is_text or places.size < 3 or places[0] <= 0.0 or places[-1] < 4.0 * places[0]:
            return False
        plain, logs = np.diff(places), np.diff(np.log(places))
        return bool(np.std(logs) / np.mean(logs) < np.std(plain) / np.mean(plain))

    @property
    def order(self) -> NDArray[np.intp]:
        """Indices of the cells, sorted by position."""
        return np.argsort(self.places, kind="stable")

    @property
    def in_order(self) -> SweptAxis:
        """The axis with its values sorted by position."""
        return SweptAxis(self.name, [self.values[place] for place in self.order])

    @property
    def edges(self) -> Array:
        """Edges half way between the positions, which must be sorted."""
        if self.is_logarithmic:
            return np.exp(drawing.time_edges(np.log(self.places)))
        return drawing.time_edges(self.places)

    def set_on(self, ax: Axes, letter: str, labelled: bool = True) -> None:
        """Set label and ticks of the x or y axis; texts and log axes have ticks at the values."""
        letter_of_field = greek(self.name)
        label = f"${letter_of_field}$" if LETTER.fullmatch(letter_of_field) else self.name
        if labelled:
            getattr(ax, f"set_{letter}label")(label, parse_math=label.startswith("$"))
        set_ticks = getattr(ax, f"set_{letter}ticks")
        if self.is_text:
            texts = [_short(str(value), LONGEST_TICK) for value in self.values]
            set_ticks(self.places, texts, parse_math=False, rotation=30 if letter == "x" else 0)
        elif self.is_logarithmic:
            getattr(ax, f"set_{letter}scale")("log")
            ticks = self.places[:: -(-len(self.places) // MAX_TICKS)]
            set_ticks(ticks, [f"{v:.0f}" if 1e3 <= v < 1e7 else f"{v:.3g}" for v in ticks])
            set_ticks([], minor=True)


@part(3.2)
def swept_curves(
    figure: FigureBase,
    axis: SweptAxis,
    curves: Mapping[str, xr.Dataset],
    joined: bool = True,
    caption: str = "",
) -> None:
    """Draw curves over a swept dimension, on a logarithmic axis if the values have a wide range.

    A curve has a ``value``, its bars' lengths ``low`` and ``high`` (NaN for none), optionally a
    ``band`` to either side, and is ``faulty`` in cells that were run without a result. If
    ``joined``, lines join the points on an axis of numbers. The text ``caption`` stands above.
    """
    ax, order, axis = figure.subplots(), axis.order, axis.in_order
    logarithmic = _is_wide(np.concatenate([curve["value"].values for curve in curves.values()]))
    handles, rows = {}, 0
    for number, (label, cells) in enumerate(curves.items()):
        curve = cells.isel(dict.fromkeys(cells.dims, order))
        look: dict[str, Any] = CURVES[number % len(CURVES)] | {"markersize": 4.0}
        if axis.is_text or not joined:
            look["linestyle"] = ""
        offset = CURVE_OFFSET * (number - (len(curves) - 1) / 2) if axis.is_text else 0.0
        places, known = axis.places + offset, np.isfinite(curve["value"].values)
        crosses = places[curve["faulty"].values & ~known]
        if crosses.size:
            heights = np.full(crosses.size, ROW_HEIGHT * (rows + 0.5))
            cross: dict[str, Any] = {"color": look["color"], "markersize": 5.0}
            cross["transform"] = ax.get_xaxis_transform()
            handles[label] = ax.plot(crosses, heights, "x", **cross)[0]
            rows += 1
        if known.any():
            handles[label] = _draw_curve(ax, places, curve, look, logarithmic)
    if logarithmic:
        ax.set_yscale("log")
    else:
        ax.ticklabel_format(axis="y", useOffset=False)
    _leave_room(ax, rows)
    axis.set_on(ax, "x")
    ax.set_ylabel(curve.attrs["label"])
    ax.set_title("; ".join(filter(None, (caption, NO_RESULT if rows else ""))), loc="left")
    drawing.draw_grid(ax)
    if len(curves) > 1:
        options: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5)}
        _plain_legend(ax.legend(handles.values(), handles.keys(), **options), LONGEST_BESIDE)


def _draw_curve(
    ax: Axes, places: Array, curve: xr.Dataset, look: dict[str, Any], logarithmic: bool
) -> Any:
    """Draw a curve's values with error bars and band at ``places``; return the legend's handle."""
    values, low, high = (curve[name].values for name in ("value", "low", "high"))
    bars = np.array([np.minimum(low, 0.99 * values) if logarithmic else low, high])
    known = bars if np.isfinite(bars).any() else None
    handle = ax.errorbar(places, values, known, capsize=3.0, **look)
    if "band" in curve:
        band = np.nan_to_num(curve["band"].values)
        colour = {"color": look["color"], "alpha": 0.2}
        if look["linestyle"]:
            ax.fill_between(places, values - band, values + band, linewidth=0.0, **colour)
        else:
            ax.vlines(places, values - band, values + band, linewidth=8.0, **colour)
    return handle


def _leave_room(ax: Axes, rows: int) -> None:
    """Extend the y axis downwards by a grey strip for ``rows`` rows of crosses."""
    if rows:
        height, scale = ROW_HEIGHT * rows, ax.yaxis.get_transform()
        low, high = scale.transform(np.array(ax.get_ylim()))
        ends = np.array([low - height / (1.0 - height) * (high - low), low])
        bottom, top = scale.inverted().transform(ends).tolist()
        ax.set_ylim(bottom=bottom)
        ax.axhspan(bottom, top, color=EMPTY_COLOUR, linewidth=0.0, zorder=0.0)


def _maps_height(axes: Mapping[str, SweptAxis], maps: Mapping[str, xr.Dataset]) -> float:
    return 2.7 * drawing.grid_shape(len(maps), MAX_HEAT_COLUMNS)[0] + (
        0.6 if len(maps) == 1 else 0.0
    )


@part(_maps_height)
def heat_maps(
    figure: FigureBase, axes: Mapping[str, SweptAxis], maps: Mapping[str, xr.Dataset]
) -> None:
    """Draw a heat map over two dimensions for each title, with shared axes and colours.

    A map has the ``value`` of each cell, NaN if it has none, its ``own`` error, NaN if that is not
    known, and is ``faulty`` in cells that were run without a result.
    """
    grid, free = drawing.panel_grid(figure, len(maps), "", "", MAX_HEAT_COLUMNS)
    norm = _colours(np.concatenate([cells["value"].values.ravel() for cells in maps.values()]))
    x, y = (axis.in_order for axis in axes.values())
    _, across = drawing.grid_shape(len(maps), MAX_HEAT_COLUMNS)
    orders = {name: axis.order for name, axis in axes.items()}
    has_unsure = []
    for place, (ax, (title, cells)) in enumerate(zip(grid, maps.items(), strict=True)):
        cells = cells.isel(orders).transpose(*reversed(list(axes)))
        values, own = cells["value"].values, np.nan_to_num(cells["own"].values)
        unsure = np.isfinite(values) & (own > LARGE_ERROR * np.abs(np.nan_to_num(values)))
        ax.set_facecolor(EMPTY_COLOUR)
        masked = np.ma.masked_invalid(values)
        mesh = ax.pcolormesh(x.edges, y.edges, masked, cmap="viridis", norm=norm, rasterized=True)
        rows, columns = np.nonzero(cells["faulty"].values)
        ax.plot(x.places[columns], y.places[rows], "x", color="black", markersize=4.0)
        dark = np.asarray(norm(masked) < DARK_FRACTION)
        _hatch(ax, x.edges, y.edges, unsure & dark, "white")
        _hatch(ax, x.edges, y.edges, unsure & ~dark, "black")
        ax.set_title(_short(title, LONGEST_BESIDE), loc="left", parse_math=False)
        x.set_on(ax, "x", labelled=place >= len(maps) - across)
        y.set_on(ax, "y", labelled=place % across == 0)
        if np.isfinite(cells["own"]).any():
            has_unsure.append(bool(unsure.any()))
    figure.colorbar(mesh, ax=[*grid, *([free] if free else [])], label=cells.attrs["label"])
    if has_unsure:
        look: dict[str, Any] = {"hatch": HATCH} if any(has_unsure) else {"alpha": 0.0}
        where = "above" if any(has_unsure) else "nowhere above"
        text = f"own error {where} {LARGE_ERROR:.0%} of the value"
        handle = Patch(facecolor="none", edgecolor="black", linewidth=0.0, label=text, **look)
        if free:
            free.legend(handles=[handle], loc="center")
        else:
            figure.legend(handles=[handle], loc="outside lower left")


def _hatch(ax: Axes, x: Array, y: Array, cells: Cells, colour: str) -> None:
    """Hatch cells, a mask of shape (y, x), between the given edges."""
    corners = [
        [(x[j], y[i]), (x[j + 1], y[i]), (x[j + 1], y[i + 1]), (x[j], y[i + 1])]
        for i, j in np.argwhere(cells)
    ]
    if corners:
        look: dict[str, Any] = {"edgecolor": colour, "linewidth": 0.0, "hatch": HATCH}
        ax.add_collection(PolyCollection(corners, facecolor="none", **look))


def _work_columns(labels: Collection[str]) -> int:
    """Return the number of columns of the legend above the panels of work against precision."""
    longest = max(map(len, labels), default=0)
    return 2 if longest + len(f": {OF_WAVE}") <= LONGEST_IN_TWO else 1


@part(lambda curves, joined=True: 3.0 + 0.4 * len(curves) / _work_columns(curves))
def work_precision(
    figure: FigureBase, curves: Mapping[str, xr.Dataset], joined: bool = True
) -> None:
    """Draw errors against work, on logarithmic axes: against seconds, and against site updates.

    Site updates are exactly reproducible. A curve has ``seconds``, ``updates``, ``estimated``
    errors, errors ``achieved`` against the wave, and the ``own`` errors of these. If ``joined``,
    lines join the estimates, or the achieved errors where there are no estimates.
    """
    panels = figure.subplots(1, 2, sharey=True)
    works = {"seconds": "seconds of the run", "updates": "site updates"}
    for number, (label, curve) in enumerate(curves.items()):
        look: dict[str, Any] = CURVES[number % len(CURVES)] | {"markersize": 4.0}
        look |= {} if joined else {"linestyle": ""}
        for ax, work in zip(panels, works, strict=True):
            _draw_work(ax, work, f"{label}: " if label else "", curve, look)
    for ax, (work, x_label) in zip(panels, works.items(), strict=True):
        ax.set_xlabel(x_label)
        ax.xaxis.set_minor_formatter(NullFormatter())
        values = np.concatenate([np.ravel(curve[work]) for curve in curves.values()])
        known = values[np.isfinite(values)]
        if known.size and known.max() < 1.1 * known.min():  # the same work in all cells
            ax.set_xlim(known.min() / 2.0, 2.0 * known.max())
        low, high = ax.get_xlim()
        if high < 10.0 * low:  # no power of ten may be among them
            ticks = np.geomspace(low, high, 5)[1::2]
            ax.set_xticks(ticks, [f"{tick:.3g}" for tick in ticks])
        drawing.draw_grid(ax)
    panels[0].set_ylabel("error")
    handles, labels = panels[0].get_legend_handles_labels()
    options: dict[str, Any] = {"ncols": _work_columns(curves), "title_fontsize": 8.0}
    options["title"] = drawing.CHEAPEST_TITLE.format("runs")
    above = figure.legend(handles, labels, loc="outside upper center", **options)
    _plain_legend(above, LONGEST_ABOVE)


def _draw_work(ax: Axes, along: str, name: str, curve: xr.Dataset, look: dict[str, Any]) -> None:
    work, own = (np.atleast_1d(curve[key]) for key in (along, "own"))
    errors = (np.atleast_1d(curve[key]) for key in ("estimated", "achieved"))
    estimated, values = (np.where(error > 0.0, error, np.nan) for error in errors)
    achieved = look | {"markerfacecolor": "none"}
    if np.isfinite(curve["estimated"]).any():
        _join_cheapest(ax, work, estimated, look, f"{name}{OF_ESTIMATE}")
        achieved["linestyle"] = ""
    if np.isfinite(values).any():
        _join_cheapest(ax, work, values, achieved, f"{name}{OF_WAVE}")
    low = np.maximum(values - own, 0.01 * values)
    ax.vlines(work, low, values + own, color=look["color"], linewidth=1.0)


def _join_cheapest(ax: Axes, work: Array, errors: Array, look: dict[str, Any], label: str) -> None:
    """Draw all points, and a line through those that no other point beats in work and error."""
    ax.loglog(work, errors, label=label, **look | {"linestyle": ""})
    cheapest = drawing.cheapest_indices(work, errors)
    ax.loglog(work[cheapest], errors[cheapest], **look | {"marker": ""})


def _plain_legend(legend: Any, longest: int) -> None:
    """Show a legend's texts literally, without LaTeX, each shortened to ``longest`` characters."""
    for text in legend.get_texts():
        text.set_parse_math(False)
        text.set_text(_short(text.get_text(), longest))


def _short(text: str, longest: int) -> str:
    """Return a text with its middle cut out if it has more than ``longest`` characters.

    Texts of one axis often begin alike, so the end is kept.
    """
    if len(text) <= longest:
        return text
    half = (longest - len(CUT)) // 2
    return f"{text[:half].rstrip()}{CUT}{text[-half:].lstrip()}"


def _is_wide(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return known.size > 1 and known.min() > 0.0 and known.max() >= LOG_SCALE_RATIO * known.min()


def _colours(values: Array) -> Normalize:
    """Return a logarithmic colour scale for positive values of a wide range, else a linear one."""
    known = values[np.isfinite(values)]
    if not known.size:
        return Normalize(0.0, 1.0)
    low, high = float(known.min()), float(known.max())
    if _is_wide(values):
        return LogNorm(low, high)
    return Normalize(low, high) if low < high else Normalize(low - 0.5, low + 0.5)
