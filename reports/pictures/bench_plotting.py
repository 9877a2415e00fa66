"""A chain on a bench: what its sensors read, the energies of its modes, its cells at some times."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from longwave.reports.pictures.drawing import CURVES, even_places, part
from longwave.scenes.bench import OF_MEANS

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import FigureBase

MOST_LINES = len(CURVES)
"""Lines in a panel; of more some are drawn, evenly."""

PANEL = 1.9
"""Height of a panel in inches."""


def _readings(data: xr.Dataset) -> list[str]:
    names = map(str, data.data_vars)
    return [name for name in names if name.startswith("sensor_") and not name.endswith(OF_MEANS)]


@part(lambda data: 0.4 + PANEL * len(_readings(data)))
def sensor_readings(figure: FigureBase, data: xr.Dataset) -> None:
    """What each sensor read over time, a panel for each thing that was read."""
    names = _readings(data)
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for ax, name in zip(panels, names, strict=True):
        _lines(ax, data, name, "sensor", "cell {}")
    panels[-1].set_xlabel("$t$")


@part(0.4 + 1.4 * PANEL)
def mode_energies(figure: FigureBase, data: xr.Dataset) -> None:
    """The energies of the modes over time."""
    ax = figure.subplots()
    _lines(ax, data, "mode_energy", "mode", "mode {}")
    ax.set_xlabel("$t$")


@part(0.4 + 1.4 * PANEL)
def cells_at_times(figure: FigureBase, data: xr.Dataset) -> None:
    """The displacement of all cells at some times."""
    ax = figure.subplots()
    _lines(ax, data, "displacement", "time", "$t = {:g}$", along="cell")
    ax.set_xlabel("$n$")


def _lines(
    ax: object, data: xr.Dataset, name: str, each: str, label: str, along: str = "time"
) -> None:
    """A line for each place on a dimension; of several fields or bonds the first."""
    first = dict.fromkeys(set(data[name].dims) - {each, along}, 0)
    values = data[name].isel(first)
    bars = data[f"{name}_error"].isel(first) if f"{name}_error" in data else None
    axis = data[along].values if along in data.coords else np.arange(data.sizes[along])
    for count, place in enumerate(even_places(data.sizes[each], MOST_LINES)):
        look = {key: value for key, value in CURVES[count].items() if key != "marker"}
        line = values.isel({each: place}).transpose(along)
        if bars is not None:
            half = bars.isel({each: place}).transpose(along)
            ax.fill_between(axis, line - half, line + half, color=look["color"], alpha=0.2)  # type: ignore[attr-defined]
        ax.plot(axis, line, label=label.format(data[each].values[place]), **look)  # type: ignore[attr-defined]
    ax.set_ylabel(f"{values.attrs['long_name']}", fontsize="small")  # type: ignore[attr-defined]
    ax.legend(fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))  # type: ignore[attr-defined]
