"""The space-time map: the strain over time, in the frame that moves with the sound."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure, FigureBase
from numpy.typing import NDArray

from reports.figures.style import TEXT_WIDTH

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
    figure.colorbar(drawn, ax=ax, label="$y_n$")


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
