"""Figures of other lattices: waves against the lattice, rates, and where plane carriers grow."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure, FigureBase

from reports.figures.drawing import ANALYTICAL, CURVES, NUMERICAL, PANEL_HEIGHT, TEXT_WIDTH

if TYPE_CHECKING:
    import xarray as xr

    from verify.lattices.convergence import ErrorAt
    from verify.studies.modulation import ModulationPlane

ACROSS = 3
"""Times of a scene side by side."""


@dataclass(frozen=True)
class WaveRow:
    """A row of panels: some times of a scene's run, ``half_width`` cells to either side of c t."""

    run: xr.Dataset
    label: str
    half_width: int


def wave_figure(rows: Sequence[WaveRow]) -> Figure:
    """The lattice solid blue, the theory dashed red; a row's panels share their axes."""
    figure = Figure((TEXT_WIDTH, PANEL_HEIGHT * len(rows) + 0.35), layout="constrained")
    panels = figure.subplots(len(rows), ACROSS, squeeze=False)
    letters = map(chr, range(ord("A"), ord("Z") + 1))
    for row, axes in zip(rows, panels, strict=True):
        shown = row.run.sel(site=slice(-row.half_width, row.half_width))
        values = [shown[name].values for name in ("strain", "analytic")]
        low, high = float(np.min(values)), float(np.max(values))
        margin = 0.06 * (high - low)
        for place, ax in zip(middle_times(row.run), axes, strict=False):
            at = shown.isel(time=place)
            offset = at["n"].values - row.run.attrs["frame_speed"] * float(at["time"])
            ax.plot(offset, at["strain"], label="lattice", **NUMERICAL)
            ax.plot(offset, at["analytic"], label="theory", **ANALYTICAL)
            ax.set_title(
                f"({next(letters)})  {row.label}, $T={float(at['slow_time']):.3g}$", loc="left"
            )
            ax.set_xlim(offset[0], offset[-1])
            ax.set_ylim(low - margin, high + margin)
            ax.locator_params(axis="x", nbins=5)
            ax.tick_params(labelleft=ax is axes[0])
        axes[0].set_ylabel("strain")
    for ax in panels[-1]:
        ax.set_xlabel("$n - c\\,t$  (cells)")
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure


def middle_times(run: xr.Dataset) -> list[int]:
    """The places of ``ACROSS`` times: the first, the last and the middle ones between."""
    count = run.sizes["time"]
    return sorted({round(place) for place in np.linspace(0, count - 1, min(count, ACROSS))})


MAP_HEIGHT = 2.2
"""Height of a row of maps, in inches."""


def plane_wave_figure(run: xr.Dataset) -> Figure:
    """Heat maps of a run on two axes: the lattice's strain, and its difference from the theory."""
    places = middle_times(run)
    figure = Figure((TEXT_WIDTH, MAP_HEIGHT * 2 + 0.2), layout="constrained")
    panels = figure.subplots(2, len(places), squeeze=False, sharey=True)
    apart = abs(run["strain"] - run["analytic"])
    for axes, values, words, colours in (
        (panels[0], run["strain"], "strain", "viridis"),
        (panels[1], apart, "|lattice $-$ theory|", "cividis"),
    ):
        least, most = float(values.min()), float(values.max())
        for place, ax in zip(places, axes, strict=True):
            at = values.isel(time=place)
            drawn = ax.pcolormesh(
                run["site"], run["row"], at.values.T,
                cmap=colours, vmin=least, vmax=most, rasterized=True,
            )  # fmt: skip
            ax.set_title(f"$T={float(run['slow_time'][place]):.3g}$", loc="left")
        axes[0].set_ylabel("$m$")
        figure.colorbar(drawn, ax=list(axes), label=words)
    for ax in panels[-1]:
        ax.set_xlabel("$n - c\\,t$  (cells)")
    return figure


RATE_HEIGHT = 2.9
"""Height of the panels of errors over eps, in inches."""


def rate_figure(
    panels: Mapping[str, Mapping[str, Sequence[ErrorAt]]], powers: Sequence[float]
) -> Figure:
    """Errors over eps, both in logarithms, with the runs' own errors as bars.

    For each title its curves by label; a panel has a dotted line of its power of eps.
    """
    figure = Figure((TEXT_WIDTH, RATE_HEIGHT), layout="constrained")
    for ax, (title, curves), power in zip(
        figure.subplots(1, len(panels), squeeze=False)[0], panels.items(), powers, strict=True
    ):
        ax.set_title(title, loc="left")
        for place, (label, errors) in enumerate(curves.items()):
            _draw_errors(ax, label, errors, CURVES[place % len(CURVES)])
        _draw_power(ax, [point for errors in curves.values() for point in errors], power)
        ax.legend(fontsize=7.5, labelspacing=0.2, handlelength=2.2)
    return figure


def _draw_errors(
    ax: Axes, label: str, errors: Sequence[ErrorAt], look: Mapping[str, object]
) -> None:
    eps = [point.eps for point in errors]
    own = [min(point.discretisation, 0.99 * point.error) for point in errors]
    ax.errorbar(
        eps,
        [point.error for point in errors],
        own,
        label=label,
        capsize=2.0,
        **{**look, "linewidth": 1.0},
    )


def _draw_power(ax: Axes, points: Sequence[ErrorAt], power: float) -> None:
    """The line of slope ``power`` below all points, and ticks at round values of eps."""
    ax.set_xscale("log")
    ax.set_yscale("log")
    factor = 0.5 * min(point.error / point.eps**power for point in points)
    ends = np.array([min(p.eps for p in points), max(p.eps for p in points)])
    words = rf"$\propto\epsilon^{{{power:g}}}$"
    ax.plot(ends, factor * ends**power, color="black", linestyle=":", linewidth=1.0, label=words)
    ticks = [tick for tick in (0.02, 0.05, 0.1, 0.2, 0.3, 0.5) if ends[0] <= tick <= ends[1]]
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.set_xticks([], minor=True)
    ax.set_xlabel(r"$\epsilon$")
    ax.set_ylabel("sup error of the strain" if ax.get_subplotspec().is_first_col() else "")


DEFOCUSING = "#d9d9d9"
"""The colour of where plane waves are stable."""


def modulation_figure(plane: ModulationPlane) -> Figure:
    """Growth rate over wavenumber and K3; grey where p q < 0, a white line between."""
    figure = Figure((0.8 * TEXT_WIDTH, 3.0), layout="constrained")
    draw_modulation(figure, plane)
    return figure


def draw_modulation(figure: FigureBase, plane: ModulationPlane) -> None:
    """Draw the map into a figure."""
    ax = figure.subplots()
    unstable = plane.product > 0
    ax.pcolormesh(
        plane.wavenumbers, plane.quadratic, np.where(unstable, np.nan, 1.0),
        cmap=ListedColormap([DEFOCUSING]), rasterized=True,
    )  # fmt: skip
    drawn = ax.pcolormesh(
        plane.wavenumbers, plane.quadratic, np.where(unstable, plane.growth, np.nan),
        cmap="viridis", vmin=0.0, rasterized=True,
    )  # fmt: skip
    ax.contour(
        plane.wavenumbers, plane.quadratic, plane.product, [0.0], colors="black", linewidths=1.0
    )
    for words, inside in (("focusing, $pq>0$", unstable), ("defocusing, $pq<0$", ~unstable)):
        height, along = np.mean(np.argwhere(inside), axis=0).astype(int)
        colour = "white" if inside is unstable else "black"
        ax.text(
            plane.wavenumbers[along],
            plane.quadratic[height],
            words,
            color=colour,
            ha="center",
            va="center",
        )
    ax.set_xlabel("carrier wavenumber $k$")
    ax.set_ylabel("$K_3$")
    ax.set_xticks([0, np.pi / 2, np.pi], ["0", r"$\pi/2$", r"$\pi$"])
    figure.colorbar(drawn, ax=ax, label=r"growth rate in $T$ of $|A|=1$")
