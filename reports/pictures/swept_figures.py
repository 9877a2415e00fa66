"""Pictures of a sweep: curves with error bars, heat maps, and work against precision.

An axis is a swept dimension: numbers in their places, evenly spaced ones in the logarithm on a
logarithmic axis, or texts side by side. Cells without a value are grey; those that were run and
came to no end bear a cross; those whose value has a large error of its own are hatched.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import FigureBase
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import CURVES, time_edges

Array = NDArray[np.float64]

CURVE_HEIGHT, HEAT_HEIGHT = 3.2, 2.7
"""Height of a panel of curves, and of a row of heat maps, in inches."""

HEAT_ACROSS = 3
"""Heat maps side by side."""

WIDE = 30.0
"""Ratio of the largest to the smallest of positive values from which colours are logarithmic."""

EMPTY = "#d9d9d9"
"""The colour of a cell without a value."""

LETTERS = {"eps": r"$\epsilon$", "kappa": r"$\kappa$", "alpha": r"$\alpha$", "beta": r"$\beta$"}
"""How names of fields are written where they are Greek."""

LETTER = re.compile("[A-Za-z](_?[0-9A-Za-z])?")
"""Names that are one letter, with or without an index."""

LONGEST_TICK, LONGEST_BESIDE, LONGEST_ABOVE = 16, 24, 80
"""Characters of a text beside a tick, and in a legend beside a picture, as in the
title of a map, or above it."""

CUT = "..."
"""What stands for the middle of a longer one."""


@dataclass(frozen=True)
class SweptAxis:
    """A swept dimension: its name, and its numbers or texts in the order of the cells."""

    name: str
    values: Sequence[float] | Sequence[str]

    @property
    def is_text(self) -> bool:
        """Whether the values are texts, which have no distance."""
        return any(isinstance(value, str) for value in self.values)

    @property
    def places(self) -> Array:
        """Where the values are on the axis."""
        if self.is_text:
            return np.arange(len(self.values), dtype=float)
        return np.asarray(self.values, dtype=float)

    @property
    def is_logarithmic(self) -> bool:
        """Whether the values are more evenly spaced in their logarithms than themselves."""
        places = np.sort(self.places)
        if self.is_text or places.size < 3 or places[0] <= 0.0 or places[-1] < 4.0 * places[0]:
            return False
        plain, logs = np.diff(places), np.diff(np.log(places))
        return bool(np.std(logs) / np.mean(logs) < np.std(plain) / np.mean(plain))

    @property
    def edges(self) -> Array:
        """Edges half way between the places, which must be in order."""
        if self.is_logarithmic:
            return np.exp(time_edges(np.log(self.places)))
        return time_edges(self.places)


@dataclass(frozen=True)
class SweptCurve:
    """Values along an axis, and their ``bars``, (2, values): how far down and up; NaN for none.

    Where one is missing because what was run came to no end, it is ``faulty``. ``band`` is how far
    what they are the mean of is spread, on either side.
    """

    label: str
    values: Array
    bars: Array
    faulty: NDArray[np.bool_]
    band: Array | None = None

    @property
    def crosses(self) -> NDArray[np.bool_]:
        """Where a cross stands for the value."""
        return self.faulty & ~np.isfinite(self.values)


def draw_swept_curves(
    figure: FigureBase,
    axis: SweptAxis,
    curves: Sequence[SweptCurve],
    what: str,
    joined: bool = True,
    told: str = "",
) -> None:
    """Draw curves over a swept dimension, in logarithms where their values are wide.

    Points are ``joined`` by lines where the axis has numbers. What is ``told`` stands above.
    """
    ax = figure.subplots()
    logarithmic = _is_wide(np.concatenate([curve.values for curve in curves]))
    drawn, rows = [], 0
    for number, curve in enumerate(curves):
        look: dict[str, Any] = CURVES[number % len(CURVES)] | {"markersize": 4.0}
        if axis.is_text or not joined:
            look["linestyle"] = ""
        aside = BESIDE * (number - (len(curves) - 1) / 2) if axis.is_text else 0.0
        places = axis.places + aside
        if np.isfinite(curve.values).any():
            drawn.append((_draw_curve(ax, places, curve, look, logarithmic), curve.label))
        if curve.crosses.any():
            sign = _draw_crosses(ax, places[curve.crosses], rows, look["color"])
            rows += 1
            if not np.isfinite(curve.values).any():
                drawn.append((sign, curve.label))
    if logarithmic:
        ax.set_yscale("log")
    else:
        ax.ticklabel_format(axis="y", useOffset=False)
    _leave_room(ax, rows)
    _set_axis(ax, axis, "x")
    ax.set_ylabel(what)
    ax.set_title("; ".join(filter(None, (told, NO_RESULT if rows else ""))), loc="left")
    ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)
    if len(curves) > 1:
        legend = ax.legend(*zip(*drawn, strict=True), loc="center left", bbox_to_anchor=(1.0, 0.5))
        _plain_legend(legend, LONGEST_BESIDE)


BESIDE = 0.1
"""How far points of several curves stand beside each other at a text."""

NO_RESULT = "\N{MULTIPLICATION SIGN}: no result"
"""What the crosses at the lower edge of curves are."""


def _draw_curve(
    ax: Axes, places: Array, curve: SweptCurve, look: dict[str, Any], logarithmic: bool
) -> Any:
    """Draw the values with their bars and band; return what stands in a legend."""
    order = np.argsort(places, kind="stable")
    places, values, bars = places[order], curve.values[order], curve.bars[:, order]
    if logarithmic:
        bars[0] = np.minimum(bars[0], 0.99 * values)
    known = bars if np.isfinite(bars).any() else None
    sign = ax.errorbar(places, values, known, capsize=3.0, **look)
    if curve.band is not None:
        band = np.nan_to_num(curve.band[order])
        if not look["linestyle"]:
            wide = {"color": look["color"], "alpha": 0.2, "linewidth": 8.0}
            ax.vlines(places, values - band, values + band, **wide)
        else:
            ends = values - band, values + band
            ax.fill_between(places, *ends, color=look["color"], alpha=0.2, linewidth=0.0)
    return sign


ROW = 0.04
"""Height of a row of crosses, in the height of the axes."""


def _draw_crosses(ax: Axes, places: Array, row: int, colour: str) -> Any:
    """Crosses in a row at the lower edge; return what stands in a legend."""
    heights, transform = np.full(places.size, ROW * (row + 0.5)), ax.get_xaxis_transform()
    (sign,) = ax.plot(places, heights, "x", color=colour, markersize=5.0, transform=transform)
    return sign


def _leave_room(ax: Axes, rows: int) -> None:
    """Move the values out of the way of that many rows of crosses, which are on grey."""
    if rows:
        share, scale = ROW * rows, ax.yaxis.get_transform()
        low, high = scale.transform(np.array(ax.get_ylim()))
        ends = np.array([low - share / (1.0 - share) * (high - low), low])
        bottom, top = scale.inverted().transform(ends).tolist()
        ax.set_ylim(bottom=bottom)
        ax.axhspan(bottom, top, color=EMPTY, linewidth=0.0, zorder=0.0)


@dataclass(frozen=True)
class HeatMap:
    """Values over two axes, (x, y), NaN where there is none; ``faulty`` cells came to no end.

    ``bars`` are errors of the values themselves, NaN where they are not known.
    """

    title: str
    values: Array
    faulty: NDArray[np.bool_]
    bars: Array

    @property
    def is_unsure(self) -> NDArray[np.bool_]:
        """Where a value's own error is more than the share ``UNSURE`` of it."""
        large = np.nan_to_num(self.bars) > UNSURE * np.abs(np.nan_to_num(self.values))
        return np.asarray(large & np.isfinite(self.values))


UNSURE = 0.1
"""Of a value in a heat map: it is hatched where its own error is more."""

HATCH = "////"


def heat_height(count: int) -> float:
    """Height in inches of that many heat maps."""
    return HEAT_HEIGHT * -(-count // HEAT_ACROSS) + (0.6 if count == 1 else 0.0)


def draw_heat_maps(
    figure: FigureBase, axes: tuple[SweptAxis, SweptAxis], maps: Sequence[HeatMap], what: str
) -> None:
    """Draw maps with the same axes and the same colours."""
    across = min(HEAT_ACROSS, len(maps))
    grid = figure.subplots(-(-len(maps) // across), across, squeeze=False, sharex=True, sharey=True)
    norm = _colours(np.concatenate([found.values.ravel() for found in maps]))
    orders = [np.argsort(axis.places, kind="stable") for axis in axes]
    x, y = (
        SweptAxis(axis.name, [axis.values[place] for place in order])
        for axis, order in zip(axes, orders, strict=True)
    )
    for ax, found in zip(grid.flat, maps, strict=False):
        held = (found.values, found.faulty, found.is_unsure)
        values, faulty, unsure = (part[np.ix_(*orders)].T for part in held)
        ax.set_facecolor(EMPTY)
        shown = np.ma.masked_invalid(values)
        drawn = ax.pcolormesh(x.edges, y.edges, shown, cmap="viridis", norm=norm, rasterized=True)
        rows, columns = np.nonzero(faulty)
        ax.plot(x.places[columns], y.places[rows], "x", color="black", markersize=4.0)
        dark = np.asarray(norm(shown) < DARK)
        _hatch(ax, x.edges, y.edges, unsure & dark, "white")
        _hatch(ax, x.edges, y.edges, unsure & ~dark, "black")
        ax.set_title(_short(found.title, LONGEST_BESIDE), loc="left", parse_math=False)
        _set_axis(ax, x, "x")
        _set_axis(ax, y, "y")
    for ax in list(grid.flat)[len(maps) :]:
        ax.set_visible(False)
    for ax in list(grid.flat)[: max(0, len(maps) - across)]:
        ax.set_xlabel("")
    for ax in list(grid.flat)[max(0, len(maps) - across) : len(maps)]:
        ax.tick_params(labelbottom=True)
    for ax in grid[:, 1:].flat:
        ax.set_ylabel("")
    figure.colorbar(drawn, ax=list(grid.flat), label=what)
    if any(np.isfinite(found.bars).any() for found in maps):
        some = any(found.is_unsure.any() for found in maps)
        look = {"hatch": HATCH} if some else {"alpha": 0.0}
        told = f"own error {'above' if some else 'nowhere above'} {UNSURE:.0%} of the value"
        sign = Patch(facecolor="none", edgecolor="black", linewidth=0.0, label=told, **look)
        figure.legend(handles=[sign], loc="outside lower left")


DARK = 0.6
"""Of the range of colours, below which they are dark: hatches are white there, else black."""


def _hatch(ax: Axes, x: Array, y: Array, cells: NDArray[np.bool_], colour: str) -> None:
    """Hatch the cells, (y, x), between the edges."""
    corners = [
        [(x[j], y[i]), (x[j + 1], y[i]), (x[j + 1], y[i + 1]), (x[j], y[i + 1])]
        for i, j in np.argwhere(cells)
    ]
    if corners:
        ax.add_collection(
            PolyCollection(corners, facecolor="none", edgecolor=colour, linewidth=0.0, hatch=HATCH)
        )


@dataclass(frozen=True)
class WorkCurve:
    """Errors at growing work: estimated ones, and achieved ones against the wave, of one family.

    ``own`` are errors of the achieved ones themselves, NaN where they are not known.
    """

    label: str
    seconds: Array
    updates: Array
    estimated: Array
    achieved: Array
    own: Array


WORK_HEIGHT = 3.0
"""Height of the panels of work against precision, in inches."""

LONGEST_IN_TWO = 50
"""Characters of the longest text of a legend in two columns above a picture."""

OF_ESTIMATE, OF_WAVE = "estimated", "relative to the wave"


def work_columns(curves: Sequence[WorkCurve]) -> int:
    """Columns of the legend above the panels of work against precision."""
    longest = max((len(curve.label) for curve in curves), default=0)
    return 2 if longest + len(f": {OF_WAVE}") <= LONGEST_IN_TWO else 1


def work_height(curves: Sequence[WorkCurve]) -> float:
    """Height in inches of the panels of work against precision with their legend."""
    return WORK_HEIGHT + 0.4 * len(curves) / work_columns(curves)


def draw_work_precision(
    figure: FigureBase, curves: Sequence[WorkCurve], joined: bool = True
) -> None:
    """Errors against work, both in logarithms: seconds, and site updates, which repeat exactly.

    Estimates are ``joined``, and where there are none what was achieved.
    """
    panels = figure.subplots(1, 2, sharey=True)
    for number, curve in enumerate(curves):
        look: dict[str, Any] = CURVES[number % len(CURVES)] | {"markersize": 4.0}
        look |= {} if joined else {"linestyle": ""}
        for ax, work in zip(panels, (curve.seconds, curve.updates), strict=True):
            name = f"{curve.label}: " if curve.label else ""
            achieved = look | {"markerfacecolor": "none"}
            if np.isfinite(curve.estimated).any():
                ax.loglog(work, _positive(curve.estimated), label=f"{name}{OF_ESTIMATE}", **look)
                achieved["linestyle"] = ""
            values = _positive(curve.achieved)
            if np.isfinite(values).any():
                ax.loglog(work, values, label=f"{name}{OF_WAVE}", **achieved)
            low = np.maximum(values - curve.own, 0.01 * values)
            ax.vlines(work, low, values + curve.own, color=look["color"], linewidth=1.0)
    along = {
        "seconds of the run": np.concatenate([curve.seconds for curve in curves]),
        "site updates": np.concatenate([curve.updates for curve in curves]),
    }
    for ax, (words, done) in zip(panels, along.items(), strict=True):
        ax.set_xlabel(words)
        ax.xaxis.set_minor_formatter(NullFormatter())
        known = done[np.isfinite(done)]
        if known.size and known.max() < 1.1 * known.min():  # the same work in all cells
            ax.set_xlim(known.min() / 2.0, 2.0 * known.max())
        low, high = ax.get_xlim()
        if high < 10.0 * low:  # no power of ten may be among them
            ticks = np.geomspace(low, high, 5)[1::2]
            ax.set_xticks(ticks, [f"{tick:.3g}" for tick in ticks])
        ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)
    panels[0].set_ylabel("error")
    handles, labels = panels[0].get_legend_handles_labels()
    above = figure.legend(handles, labels, loc="outside upper center", ncols=work_columns(curves))
    _plain_legend(above, LONGEST_ABOVE)


def _positive(values: Array) -> Array:
    return np.where(values > 0.0, values, np.nan)


def _plain_legend(legend: Any, longest: int) -> None:
    """Show texts of a file as they are, if they are not longer than that."""
    for text in legend.get_texts():
        text.set_parse_math(False)
        text.set_text(_short(text.get_text(), longest))


def _short(text: str, longest: int) -> str:
    """A text with its middle left out if it is longer: texts of one axis may begin alike."""
    if len(text) <= longest:
        return text
    half = (longest - len(CUT)) // 2
    return f"{text[:half].rstrip()}{CUT}{text[-half:].lstrip()}"


def _is_wide(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return known.size > 1 and known.min() > 0.0 and known.max() >= WIDE * known.min()


def _colours(values: Array) -> Normalize:
    """Logarithmic colours for wide positive values; some range where all are equal."""
    known = values[np.isfinite(values)]
    if not known.size:
        return Normalize(0.0, 1.0)
    low, high = float(known.min()), float(known.max())
    if _is_wide(values):
        return LogNorm(low, high)
    return Normalize(low, high) if low < high else Normalize(low - 0.5, low + 0.5)


def _set_axis(ax: Axes, axis: SweptAxis, letter: str) -> None:
    """Name an axis, and put its ticks at the values where they are few or texts."""
    label = LETTERS.get(axis.name, f"${axis.name}$" if LETTER.fullmatch(axis.name) else axis.name)
    getattr(ax, f"set_{letter}label")(label, parse_math=label.startswith("$"))
    set_ticks = getattr(ax, f"set_{letter}ticks")
    if axis.is_text:
        texts = [_short(str(value), LONGEST_TICK) for value in axis.values]
        set_ticks(axis.places, texts, parse_math=False, rotation=30 if letter == "x" else 0)
    elif axis.is_logarithmic:
        getattr(ax, f"set_{letter}scale")("log")
        ticks = axis.places[:: -(-len(axis.places) // MOST_TICKS)]
        set_ticks(ticks, [_plain(tick) for tick in ticks])
        set_ticks([], minor=True)


def _plain(value: float) -> str:
    """Three digits of a number, and all of a long one that has no power of ten."""
    return f"{value:.0f}" if 1e3 <= value < 1e7 else f"{value:.3g}"


MOST_TICKS = 6
"""Ticks of a logarithmic axis, which has them at its values."""
