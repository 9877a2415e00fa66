"""Drawing: snapshots, error curves, space-time maps, crest tracks and costs, in one style.

Colours can be told apart by colour-blind readers.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from numpy.typing import NDArray

from longwave.support.atomic_file import write_atomically

Sites = NDArray[np.float64]

TEXT_WIDTH = 6.5
"""Width of the report's text, in inches; figures are drawn at the size at which they are set."""

NUMERICAL: dict[str, Any] = {"color": "blue", "linestyle": "-", "linewidth": 1.0}
"""The lattice's own strain, as in the paper."""

ANALYTICAL: dict[str, Any] = {"color": "red", "linestyle": "--", "linewidth": 1.0, "dashes": (4, 3)}
"""The mKdV wave, as in the paper."""

CURVES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "linestyle": "-", "marker": "o"},
    {"color": "#D55E00", "linestyle": "--", "marker": "s"},
    {"color": "#009E73", "linestyle": "-.", "marker": "^"},
    {"color": "#CC79A7", "linestyle": ":", "marker": "D"},
    {"color": "#000000", "linestyle": (0, (5, 1)), "marker": "v"},
    {"color": "#56B4E9", "linestyle": (0, (3, 1, 1, 1)), "marker": "P"},
    {"color": "#E69F00", "linestyle": (0, (1, 1)), "marker": "X"},
    {"color": "#999999", "linestyle": (0, (8, 2)), "marker": "*"},
)
"""Okabe and Ito's colours, told apart by line and marker as well."""

_SETTINGS: Any = {
    "font.family": "STIXGeneral",
    "font.size": 10.0,
    "axes.titlesize": 10.0,
    "axes.labelsize": 10.0,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 9.0,
    "mathtext.fontset": "stix",
    "lines.markersize": 3.0,
    "lines.linewidth": 1.2,
    "axes.linewidth": 0.6,
    "legend.frameon": False,
    "pdf.fonttype": 42,
    "svg.hashsalt": "longwave",
    "savefig.dpi": 160,
}


_CHANGING = {".pdf": "CreationDate", ".svg": "Date"}
"""What a picture's metadata would say differently each time, by suffix."""


@contextmanager
def styled() -> Iterator[None]:
    """Draw with the report's settings, whatever the user's own are; nothing leaks out."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def save(figure: Figure, path: Path) -> Path:
    """Write the figure to the path, the same bytes for the same content; return the path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomically(path, lambda draft: _write(figure, draft), durable=False)
    return path


def _write(figure: Figure, path: Path) -> None:
    suffix = path.suffix.lower()
    figure.savefig(path, metadata={_CHANGING.get(suffix, "Software"): None})
    if suffix == ".svg":
        text = path.read_text(encoding="utf-8")
        path.write_text(_with_numbered_clips(text), encoding="utf-8")


def _with_numbered_clips(text: str) -> str:
    """A picture whose clipping paths are numbered: Matplotlib names them after the last bits of a
    layout, which differ from one drawing to the next."""
    for place, name in enumerate(re.findall(r'<clipPath id="(p[0-9a-f]{10})">', text)):
        text = text.replace(name, f"clip{place}")
    return text


PANEL_HEIGHT = 1.55
"""Height of one row of panels, in inches."""


@dataclass(frozen=True)
class Snapshot:
    """The strain at one time, on the sites shown.

    `offset` is n - c t in sites; `numerical` is the lattice's y_n and `analytical` is eps Y,
    both with the shape of `offset`.
    """

    time: float
    eps: float
    offset: Sites
    numerical: Sites
    analytical: Sites


def snapshot_figure(rows: Sequence[Sequence[Snapshot]], wave: str = "mKdV wave") -> Figure:
    """Draw one panel per snapshot, one row per run; panels are lettered (A), (B), ... .

    ``wave`` is what the legend calls the analytical strain.
    """
    figure = Figure((TEXT_WIDTH, snapshot_height(len(rows))), layout="constrained")
    draw_snapshot_panels(figure, rows, wave)
    return figure


def snapshot_height(rows: int) -> float:
    """Height in inches of that many rows of panels and their legend."""
    return PANEL_HEIGHT * rows + 0.35


def draw_snapshot_panels(
    figure: FigureBase, rows: Sequence[Sequence[Snapshot]], wave: str = "mKdV wave"
) -> None:
    """Draw the panels of `snapshot_figure` into a figure; shorter rows end in empty places."""
    across = max(len(row) for row in rows)
    panels = figure.subplots(len(rows), across, squeeze=False)
    letters = map(chr, range(ord("A"), ord("Z") + 1))
    for row, axes in zip(rows, panels, strict=True):
        low, high = _limits(row)
        for column, (snapshot, ax) in enumerate(zip(row, axes, strict=False)):
            _draw_snapshot(ax, snapshot, next(letters), wave)
            ax.set_ylim(low, high)
            ax.tick_params(labelleft=column == 0)
        axes[0].set_ylabel("$y_n$")
        for ax in axes[len(row) :]:
            ax.set_visible(False)
    for ax in panels[-1]:
        ax.set_xlabel("$n - c\\,t$  (sites)")
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper right", ncols=2)


def even_places(count: int, most: int) -> list[int]:
    """At most that many places of ``count``, evenly from the first to the last.

    >>> even_places(7, 3), even_places(2, 3), even_places(0, 3)
    ([0, 3, 6], [0, 1], [])
    """
    return [round(place) for place in np.linspace(0, count - 1, min(count, most)).tolist()]


def _draw_snapshot(ax: Axes, snapshot: Snapshot, letter: str, wave: str) -> None:
    """Draw one panel: the numerical strain solid blue, the analytical one dashed red on it."""
    ax.plot(snapshot.offset, snapshot.numerical, label="lattice", **NUMERICAL)
    ax.plot(snapshot.offset, snapshot.analytical, label=wave, **ANALYTICAL)
    ax.set_title(rf"({letter})  $\epsilon={snapshot.eps:g}$, $t={snapshot.time:g}$", loc="left")
    if np.unique(snapshot.offset).size > 1:
        ax.set_xlim(snapshot.offset[0], snapshot.offset[-1])
    ax.locator_params(axis="x", nbins=5)


def _limits(row: Sequence[Snapshot]) -> tuple[float, float]:
    """Return the strain axis that all panels of a row share."""
    return spread_limits([part for s in row for part in (s.numerical, s.analytical)])


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


ERROR_HEIGHT = 2.0
"""Height of a panel of error curves, in inches."""


@dataclass(frozen=True)
class ErrorCurve:
    """The relative sup error at each of the times; `label` may hold mathematics in dollars.

    ``own`` is the run's own error in the same units, NaN at times where it was not measured.
    """

    label: str
    times: NDArray[np.float64]
    errors: NDArray[np.float64]
    own: NDArray[np.float64] | None = None


def error_figure(panels: Sequence[tuple[str, Sequence[ErrorCurve]]]) -> Figure:
    """Draw one panel of curves for each (title, curves)."""
    size = (TEXT_WIDTH if len(panels) > 1 else 0.5 * TEXT_WIDTH, ERROR_HEIGHT)
    figure = Figure(size, layout="constrained")
    draw_error_panels(figure, panels)
    return figure


def draw_error_panels(
    figure: FigureBase, panels: Sequence[tuple[str, Sequence[ErrorCurve]]]
) -> None:
    """Draw the panels of `error_figure` into a figure."""
    for ax, (title, curves) in zip(
        figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True
    ):
        ax.set_title(title, loc="left")
        _draw_curves(ax, curves)


def _draw_curves(ax: Axes, curves: Sequence[ErrorCurve]) -> None:
    """Draw the curves of one panel through all their points, without markers but of one alone."""
    for curve, look in zip(curves, CURVES, strict=False):
        marker = "" if curve.times.size > 1 else look["marker"]
        errors = np.where(np.isfinite(curve.errors), curve.errors, np.nan)
        ax.plot(curve.times, errors, label=curve.label, **look | {"marker": marker})
        if curve.own is not None and np.isfinite(curve.own).any():
            _draw_own(ax, curve, curve.own, look["color"])
    ax.set_xlabel("$t$")
    ax.set_ylabel(r"$L^\infty_\epsilon$")
    ax.set_ylim(bottom=0)
    ax.locator_params(axis="x", nbins=6)
    ax.ticklabel_format(axis="y", scilimits=(-3, 3), useMathText=True)
    ax.legend()


def scientific(value: float) -> str:
    """A number to one digit, as mathematics.

    >>> print(scientific(0.0), scientific(0.02), scientific(1.4e-9), scientific(3e-5))
    0 0.02 $10^{-9}$ $3\\times10^{-5}$
    """
    text = f"{value:.0e}"
    if not np.isfinite(value) or value == 0.0 or 1e-3 <= abs(value) < 1e3:
        return f"{value:.1g}"
    digits, _, power = text.partition("e")
    return f"${'' if digits == '1' else digits + chr(92) + 'times'}10^{{{int(power)}}}$"


def _draw_own(ax: Axes, curve: ErrorCurve, own: NDArray[np.float64], colour: str) -> None:
    """Draw a band about a curve, or bars where the run's own error is known at a few times.

    It is often thinner than the line, so its label says how much it is.
    """
    label = rf"own error $\leq$ {scientific(float(np.nanmax(own)))}"
    known = np.isfinite(own)
    if known.sum() > BARS * own.size:
        low, high = curve.errors - own, curve.errors + own
        ax.fill_between(curve.times, low, high, color=colour, alpha=0.3, lw=0, label=label)
    else:
        bars = own[known]
        look: dict[str, Any] = {"color": colour, "linestyle": "", "marker": "o", "capsize": 3.0}
        ax.errorbar(curve.times[known], curve.errors[known], bars, label=label, **look)


BARS = 0.5
"""Share of the times at which the own error must be known for it to be a band."""

MAP_HEIGHT = 3.0
"""Height of a map, in inches."""

LEAST_CELLS = 24
"""Fewest cells of sites that are shown."""


def space_time_figure(strain: xr.DataArray) -> Figure:
    """Draw the variable `space_time` of a run."""
    figure = Figure((TEXT_WIDTH, MAP_HEIGHT), layout="constrained")
    draw_space_time(figure, strain)
    return figure


def draw_space_time(
    figure: FigureBase, strain: xr.DataArray, half_width: int | None = None
) -> None:
    """Draw the map into a figure; `strain` has a time and, then, the first sites of its cells.

    `half_width` is how many sites are shown to either side of c t; `LEAST_CELLS` at least.
    """
    time, place = (strain[dimension].values for dimension in strain.dims)
    edges = cell_edges(place)
    ax = figure.subplots()
    drawn = ax.pcolormesh(time_edges(time), edges, strain.values.T, cmap="viridis", rasterized=True)
    if half_width is not None:
        least = LEAST_CELLS / 2 * float(edges[1] - edges[0])
        shown = min(max(half_width, least), float(edges[-1]))
        ax.set_ylim(-shown, shown)
    ax.set_xlabel("$t$")
    ax.set_ylabel("$n - c\\,t$  (sites)")
    figure.colorbar(drawn, ax=ax, label="$|y_n|$" if strain.attrs.get("carried") else "$y_n$")


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


CREST_HEIGHT = 2.0
"""Height of the two panels, in inches."""

LABELS = {"crest_position": "crest at $n - c\\,t$  (sites)", "crest_strain": "$y$ at the crest"}


def draw_crest(figure: FigureBase, run: xr.Dataset) -> None:
    """Draw the crest's position and strain as points: a crest may give way to another one."""
    for ax, (name, label), look in zip(
        figure.subplots(1, len(LABELS)), LABELS.items(), CURVES, strict=False
    ):
        values = run[name]
        (time,) = values.dims
        ax.plot(values[time], values, color=look["color"], linestyle="", marker=".")
        ax.set_xlabel("$t$")
        ax.set_ylabel(label)
        ax.locator_params(axis="x", nbins=6)
        ax.ticklabel_format(axis="y", scilimits=(-3, 3), useMathText=True)


LEGEND = 4
"""Most entries of the legend side by side."""

COST_HEIGHT = 1.8
"""Height of one row of panels, in inches."""


@dataclass(frozen=True)
class CostPanel:
    """Curves of one panel: for each label the points (x, y), both positive."""

    title: str
    curves: Mapping[str, Sequence[tuple[float, float]]]


@dataclass(frozen=True)
class CostAxes:
    """The axes that all panels share: labels, and ticks where they are not those of a logarithm.

    With ``digits`` the vertical axis is linear with these ticks, the last one its end.
    """

    x: str
    y: str
    x_ticks: Sequence[float] = ()
    digits: Sequence[float] = ()


def cost_figure(
    panels: Sequence[CostPanel], axes: CostAxes, across: int = 3, height: float = COST_HEIGHT
) -> Figure:
    """Draw the panels, ``across`` in a row of that height, with the same axes and one legend."""
    across = min(across, len(panels))
    down = -(-len(panels) // across)
    figure = Figure((TEXT_WIDTH, height * down + 0.4), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    looks = dict(zip(_labels(panels), CURVES, strict=False))
    for panel, ax in zip(panels, grid.flat, strict=False):
        _draw_costs(ax, panel, looks)
    _set_ticks(grid[0, 0], axes)
    for ax in list(grid.flat)[len(panels) :]:
        ax.set_visible(False)
    for ax in list(grid.flat)[max(0, len(panels) - across) : len(panels)]:
        ax.set_xlabel(axes.x)
        ax.tick_params(labelbottom=True)
    for ax in grid[:, 0]:
        ax.set_ylabel(axes.y)
    handles = {h.get_label(): h for ax in grid.flat for h in ax.lines}
    ordered = [handles[label] for label in looks]
    figure.legend(handles=ordered, loc="outside upper center", ncols=min(len(ordered), LEGEND))
    return figure


def _set_ticks(ax: Axes, axes: CostAxes) -> None:
    """Set the ticks that are given, on an axis that the other panels share."""
    if axes.x_ticks:
        shown = ax.get_xlim()
        ax.set_xticks(axes.x_ticks, [f"{tick:g}" for tick in axes.x_ticks])
        ax.set_xticks([], minor=True)
        ax.set_xlim(shown)
    if axes.digits:
        ax.set_yscale("linear")
        ax.set_ylim(0, axes.digits[-1])
        ax.set_yticks(axes.digits)


def _labels(panels: Sequence[CostPanel]) -> list[str]:
    return list(dict.fromkeys(label for panel in panels for label in panel.curves))


def _draw_costs(ax: Axes, panel: CostPanel, looks: Mapping[str, dict[str, object]]) -> None:
    """Draw one panel; points that are not finite and positive are left out."""
    for label, points in panel.curves.items():
        values = np.array([p for p in points if min(p) > 0 and np.all(np.isfinite(p))])
        style = dict(looks[label], markersize=4.0)
        ax.loglog(*values.reshape(-1, 2).T, label=label, **style)
    ax.set_title(panel.title, loc="left")
    ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)
