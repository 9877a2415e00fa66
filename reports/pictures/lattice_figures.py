"""Figures of other lattices: waves against the lattice, rates, and where plane carriers grow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure, FigureBase
from numpy.typing import NDArray

from longwave.reports.pictures import drawing
from longwave.reports.pictures.style import CURVES, page_width, part

if TYPE_CHECKING:
    from longwave.scenes.convergence import ConvergencePoint
    from longwave.scenes.modulation import ModulationGrid
    from longwave.support.labelled_arrays import Labelled, LabelledArrays

Array = NDArray[np.float64]

MAX_TIMES = 3
"""Largest number of snapshots of a scene that are drawn side by side."""


def even_times(run: Labelled) -> list[int]:
    """Return the indices of at most `MAX_TIMES` evenly spaced times, first and last included."""
    return drawing.even_indices(run.sizes["time"], MAX_TIMES)


@part(4.6)
def strain_maps(figure: FigureBase, run: LabelledArrays) -> None:
    """Draw heat maps of strain and of lattice minus theory; titles state the numerical error."""
    places = even_times(run)
    panels = figure.subplots(2, len(places), squeeze=False, sharey=True)
    strain = run["strain"].values
    difference = strain - run["analytic"].values
    ends = float(np.fmin.reduce(strain, axis=None)), float(np.fmax.reduce(strain, axis=None))
    largest = float(np.fmax.reduce(np.abs(difference), axis=None))
    for axes, values, label, colours, (least, most) in (
        (panels[0], strain, drawing.field_label(run, "strain"), "viridis", ends),
        (panels[1], difference, "lattice $-$ theory", "PuOr", (-largest, largest)),
    ):
        for place, ax in zip(places, axes, strict=True):
            image = ax.pcolormesh(
                run["site"].values, run["row"].values, values[place].T,
                cmap=colours, vmin=least, vmax=most, rasterized=True,
            )  # fmt: skip
            ax.set_title(f"$T={float(run['slow_time'].values[place]):.3g}$", loc="left")
            own = float(run["own"].values[place]) if "own" in run else np.nan
            if values is difference and np.isfinite(own):
                ax.set_title(f"own error {drawing.error_text(own)}", loc="right", fontsize=7.0)
        axes[0].set_ylabel("$m$")
        figure.colorbar(image, ax=list(axes), label=label)
    for ax in panels[-1]:
        ax.set_xlabel("$n - c\\,t$  (cells)")


RATE_HEIGHT, RATES_ACROSS = 2.3, 2
"""Height in inches of a row of panels of errors over eps, and number of panels in a row."""

MIN_TICK_DISTANCE = 0.2
"""Least distance of two printed values of eps, as a fraction of the axis's length."""


def rate_figure(panels: Mapping[float, Mapping[str, Sequence[ConvergencePoint]]]) -> Figure:
    """Return a log-log figure of errors over eps, with the runs' numerical errors as bars.

    ``panels`` maps the power of eps of a panel's dotted line to the panel's curves by label.
    """
    down = -(-len(panels) // RATES_ACROSS)
    figure = Figure((page_width(), RATE_HEIGHT * down), layout="constrained")
    grid = figure.subplots(down, RATES_ACROSS, squeeze=False)
    for ax, (power, curves) in zip(grid.flat, panels.items(), strict=False):
        for place, (label, errors) in enumerate(curves.items()):
            _draw_errors(ax, label, errors, CURVES[place % len(CURVES)])
        _draw_power(ax, [point for errors in curves.values() for point in errors], power)
        ax.legend(fontsize=7.5, labelspacing=0.3, loc="center left", bbox_to_anchor=(1.0, 0.5))
    for ax in list(grid.flat)[len(panels) :]:
        ax.set_visible(False)
    for ax in grid[:, 0]:
        ax.set_ylabel("sup error")
    for ax in grid[-1]:
        ax.set_xlabel(r"$\epsilon$")
    return figure


def _draw_errors(
    ax: Axes, label: str, errors: Sequence[ConvergencePoint], look: Mapping[str, Any]
) -> None:
    eps = [point.eps for point in errors]
    own = [min(point.discretisation, 0.99 * point.error) for point in errors]
    heights = [point.error for point in errors]
    ax.errorbar(eps, heights, own, label=label, capsize=2.0, **{**look, "linewidth": 1.0})


def _draw_power(ax: Axes, points: Sequence[ConvergencePoint], power: float) -> None:
    """Set log-log axes, draw a line of slope ``power`` below all points, and set ticks of eps."""
    ax.set(xscale="log", yscale="log")
    factor = 0.5 * min(point.error / point.eps**power for point in points)
    ends = np.array([min(p.eps for p in points), max(p.eps for p in points)])
    label = rf"$\propto\epsilon^{{{power:g}}}$"
    ax.plot(ends, factor * ends**power, color="black", linestyle=":", linewidth=1.0, label=label)
    ticks: list[float] = []
    least_ratio = (ends[1] / ends[0]) ** MIN_TICK_DISTANCE
    for tick in (0.02, 0.05, 0.1, 0.2, 0.3, 0.5):
        is_apart = not ticks or tick / ticks[-1] > least_ratio
        if ends[0] <= tick <= ends[1] and is_apart:
            ticks.append(tick)
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.set_xticks([], minor=True)


def modulation_figure(grid: ModulationGrid, quadratic: Array) -> Figure:
    """Return a figure of growth rates over k and K3 (``quadratic``), grey if p q < 0 (stable)."""
    figure = Figure((0.8 * page_width(), 3.0), layout="constrained")
    ax = figure.subplots()
    unstable = grid.product > 0
    stable = np.where(unstable, np.nan, 1.0)
    ax.pcolormesh(grid.k, quadratic, stable, cmap=ListedColormap([drawing.STABLE]), rasterized=True)
    growth = np.where(unstable, grid.growth_rate, np.nan)
    image = ax.pcolormesh(grid.k, quadratic, growth, vmin=0.0, rasterized=True)
    ax.contour(grid.k, quadratic, grid.product, [0.0], colors="black", linewidths=1.0)
    for text, inside, colour in (
        ("focusing, $pq>0$", unstable, "white"),
        ("defocusing, $pq<0$", ~unstable, "black"),
    ):
        x, y = (float(np.mean(axis[inside])) for axis in (grid.k, quadratic))
        ax.text(x, y, text, color=colour, ha="center", va="center")
    ax.set(xlabel="carrier wavenumber $k$", ylabel="$K_3$")
    ax.set_xticks(*drawing.WAVENUMBER_TICKS)
    figure.colorbar(image, ax=ax, label=r"growth rate in $T$ of $|A|=1$")
    return figure
