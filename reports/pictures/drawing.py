"""Drawing: snapshots, errors, space-time maps, crest tracks, spectra and costs, in one style.

Colours can be told apart by colour-blind readers.
"""

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, ParamSpec

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from longwave.reports.latex import scientific
from longwave.support.atomic_file import write_atomically

Sites = NDArray[np.float64]
Shown = ParamSpec("Shown")

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


@dataclass(frozen=True)
class Part:
    """A part of a figure: its height in inches, and what draws it."""

    height: float
    draw: Callable[[FigureBase], None]

    def figure(self, width: float = TEXT_WIDTH) -> Figure:
        """The part alone, as a figure of that width in inches."""
        made = Figure((width, self.height), layout="constrained")
        self.draw(made)
        return made


def part(
    height: float | Callable[..., float],
) -> Callable[[Callable[Concatenate[FigureBase, Shown], None]], Callable[Shown, Part]]:
    """Let the function below, which draws on a figure, return the `Part` that does so.

    The ``height``, in inches, may be a function of what is shown.
    """

    def declare(draw: Callable[Concatenate[FigureBase, Shown], None]) -> Callable[Shown, Part]:
        @wraps(draw)
        def made(*shown: Shown.args, **words: Shown.kwargs) -> Part:
            inches = height(*shown, **words) if callable(height) else height
            return Part(inches, lambda figure: draw(figure, *shown, **words))

        return made

    return declare


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


@part(lambda rows, wave="": 1.55 * len(rows) + 0.35)
def snapshot_panels(
    figure: FigureBase, rows: Sequence[Sequence[xr.Dataset]], wave: str = ""
) -> None:
    """One panel for each of `run_data.snapshots`, one row per run, lettered (A), (B), ... .

    ``wave`` is what the legend calls the analytical strain, where the run's own word is not taken.
    Shorter rows end in empty places.
    """
    across = max(len(row) for row in rows)
    panels = figure.subplots(len(rows), across, squeeze=False)
    letters = map(chr, range(ord("A"), ord("Z") + 1))
    for row, axes in zip(rows, panels, strict=True):
        limits = spread_limits([at[name].values for at in row for name in ("strain", "analytic")])
        for column, (at, ax) in enumerate(zip(row, axes, strict=False)):
            _draw_snapshot(ax, at, next(letters), wave or at.attrs["wave"])
            ax.set_ylim(*limits)
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


def _draw_snapshot(ax: Axes, at: xr.Dataset, letter: str, wave: str) -> None:
    """Draw one panel: the numerical strain solid blue, the analytical one dashed red on it."""
    offset = at["offset"].values
    ax.plot(offset, at["strain"], label="lattice", **NUMERICAL)
    ax.plot(offset, at["analytic"], label=wave, **ANALYTICAL)
    eps, time = at.attrs["eps"], float(at["time"])
    ax.set_title(rf"({letter})  $\epsilon={eps:g}$, $t={time:g}$", loc="left")
    if np.unique(offset).size > 1:
        ax.set_xlim(offset[0], offset[-1])
    ax.locator_params(axis="x", nbins=5)


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


ErrorPanels = Mapping[str, Mapping[str, xr.DataArray]]
"""For each title the relative sup errors over time, by labels that may hold mathematics in dollars.

The coordinate ``own`` is the run's own error in the same units, NaN where it was not measured.
"""


@part(2.0)
def error_panels(figure: FigureBase, panels: ErrorPanels) -> None:
    """One panel of curves for each title, without markers but where there is one point alone."""
    axes = figure.subplots(1, len(panels), squeeze=False)[0]
    for ax, (title, curves) in zip(axes, panels.items(), strict=True):
        ax.set_title(title, loc="left")
        for (label, curve), look in zip(curves.items(), CURVES, strict=False):
            marker = "" if curve.size > 1 else look["marker"]
            errors = np.where(np.isfinite(curve), curve, np.nan)
            (along,) = curve.dims
            ax.plot(curve[along].values, errors, label=label, **look | {"marker": marker})
            if "own" in curve.coords and np.isfinite(curve["own"]).any():
                _draw_own(ax, curve[along].values, curve.values, curve["own"].values, look["color"])
        ax.set_xlabel("$t$")
        ax.set_ylabel(r"$L^\infty_\epsilon$")
        ax.set_ylim(bottom=0)
        ax.locator_params(axis="x", nbins=6)
        ax.ticklabel_format(axis="y", scilimits=(-3, 3), useMathText=True)
        ax.legend()


def _draw_own(ax: Axes, times: Sites, errors: Sites, own: Sites, colour: str) -> None:
    """Draw a band about a curve, or bars where the run's own error is known at a few times.

    It is often thinner than the line, so its label says how much it is.
    """
    largest = scientific(float(np.nanmax(own)), 1).replace(r"$1\times ", "$")
    label = rf"own error $\leq$ {largest}"
    known = np.isfinite(own)
    if known.sum() > BARS * own.size:
        ends = errors - own, errors + own
        ax.fill_between(times, *ends, color=colour, alpha=0.3, lw=0, label=label)
    else:
        look: dict[str, Any] = {"color": colour, "linestyle": "", "marker": "o", "capsize": 3.0}
        ax.errorbar(times[known], errors[known], own[known], label=label, **look)


BARS = 0.5
"""Share of the times at which the own error must be known for it to be a band."""

LEAST_CELLS = 24
"""Fewest cells of sites that are shown."""


@part(3.0)
def space_time_map(figure: FigureBase, strain: xr.DataArray, half_width: int | None = None) -> None:
    """The variable `space_time` of a run; it has a time and, then, the first sites of its cells.

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


LABELS = {"crest_position": "crest at $n - c\\,t$  (sites)", "crest_strain": "$y$ at the crest"}


@part(2.0)
def crest_track(figure: FigureBase, run: xr.Dataset) -> None:
    """The crest's position and strain as points: a crest may give way to another one.

    A soliton's strain by the law of its losses is a line.
    """
    for ax, (name, label), look in zip(
        figure.subplots(1, len(LABELS)), LABELS.items(), CURVES, strict=False
    ):
        values = run[name]
        (time,) = values.dims
        ax.plot(values[time], values, color=look["color"], linestyle="", marker=".")
        if name == "crest_strain" and "crest_law" in run:
            ax.plot(values[time], run["crest_law"], color="black", linewidth=0.8, label="law")
            ax.legend()
        ax.set_xlabel("$t$")
        ax.set_ylabel(label)
        ax.locator_params(axis="x", nbins=6)
        ax.ticklabel_format(axis="y", scilimits=(-3, 3), useMathText=True)


SPECTRA_ACROSS, MOST_SPECTRA = 3, 6
"""Spectra side by side, and most of them."""

DECADES = 1.0
"""How far below the rounding the axis of amplitudes ends."""


@part(lambda found: 1.9 * -(-found.sizes["time"] // SPECTRA_ACROSS) + 0.35)
def spectrum_panels(figure: FigureBase, found: xr.Dataset) -> None:
    """One panel for each time of `run_data.spectra`, all with the same axes."""
    times = found["time"].values
    grid = panel_grid(
        figure, len(times), SPECTRA_ACROSS, "wavenumber  (1/site)", "amplitude of $y$"
    )
    for ax, place in zip(grid.flat, range(len(times)), strict=False):
        _draw_spectrum(ax, found.isel(time=place))
    grid[0, 0].set_ylim(*_amplitude_limits(found))
    handles = {h.get_label(): h for h in grid[0, 0].get_legend_handles_labels()[0]}
    figure.legend(handles=list(handles.values()), loc="outside upper right", ncols=len(handles))


def panel_grid(figure: FigureBase, count: int, across: int, x: str, y: str) -> Any:
    """That many panels with the same axes, the lowest of each column and the left ones labelled."""
    across = min(across, count)
    down = -(-count // across)
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    for ax in list(grid.flat)[count:]:
        ax.set_visible(False)
    for ax in list(grid.flat)[max(0, count - across) : count]:
        ax.set_xlabel(x)
        ax.tick_params(labelbottom=True)
    for ax in grid[:, 0]:
        ax.set_ylabel(y)
    return grid


WAVENUMBER_TICKS = [0.0, np.pi / 2, np.pi], ["0", r"$\pi/2$", r"$\pi$"]
"""Of an axis of wavenumbers per site: places and texts."""

STABLE = "#d9d9d9"
"""The colour of where plane waves are stable."""


def draw_grid(ax: Axes) -> None:
    """Draw thin lines at the ticks."""
    ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)


def _draw_spectrum(ax: Axes, at: xr.Dataset) -> None:
    lattice, wave = (
        at[name].where(np.isfinite(at[name]) & (at[name] > 0.0)) for name in ("lattice", "wave")
    )
    if np.isfinite([lattice, wave]).any():
        ax.set_yscale("log")
    ax.plot(at["wavenumber"], lattice, label="lattice", **NUMERICAL)
    ax.plot(at["wavenumber"], wave, label="wave", **ANALYTICAL)
    own, rounding = float(at["own"]), float(at["rounding"])
    if np.isfinite(own):
        ax.axhspan(0.0, own, color="#E69F00", alpha=0.25, lw=0, label="own error, at most")
    level = rounding if 0.0 < rounding < np.inf else np.nan
    ax.axhline(level, color="black", linestyle=":", linewidth=0.8, label="rounding")
    ax.set_xlim(0.0, np.pi)
    ax.set_xticks(*WAVENUMBER_TICKS)
    ax.set_title(f"$t={float(at['time']):g}$", loc="left")


def _amplitude_limits(found: xr.Dataset) -> tuple[float, float]:
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
) -> Figure:
    """Draw the panels, ``across`` in a row of that height, with the same axes and one legend.

    ``x_ticks`` are those of a logarithmic axis where they are not the usual ones. With ``digits``
    the vertical axis is linear with these ticks, the last one its end.
    """
    down = -(-len(panels) // min(across, len(panels)))
    figure = Figure((TEXT_WIDTH, height * down + 0.4), layout="constrained")
    grid = panel_grid(figure, len(panels), across, x, y)
    labels = dict.fromkeys(label for curves in panels.values() for label in curves)
    looks = dict(zip(labels, CURVES, strict=False))
    for (title, curves), ax in zip(panels.items(), grid.flat, strict=False):
        _draw_costs(ax, curves, looks)
        ax.set_title(title, loc="left")
    first = grid[0, 0]
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
    handles = {h.get_label(): h for ax in grid.flat for h in ax.lines}
    ordered = [handles[label] for label in looks]
    figure.legend(handles=ordered, loc="outside upper center", ncols=min(len(ordered), LEGEND))
    return figure


def _draw_costs(
    ax: Axes,
    curves: Mapping[str, Sequence[tuple[float, float]]],
    looks: Mapping[str, dict[str, object]],
) -> None:
    """Draw one panel; points that are not finite and positive are left out."""
    for label, points in curves.items():
        values = np.array([p for p in points if min(p) > 0 and np.all(np.isfinite(p))])
        style = dict(looks[label], markersize=4.0)
        ax.loglog(*values.reshape(-1, 2).T, label=label, **style)
    draw_grid(ax)
