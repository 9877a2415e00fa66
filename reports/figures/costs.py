"""What accuracy costs: digits or errors against seconds, on logarithmic axes but for digits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from reports.figures.style import CURVES, TEXT_WIDTH

LEGEND = 4
"""Most entries of the legend side by side."""

PANEL_HEIGHT = 1.8
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
    panels: Sequence[CostPanel], axes: CostAxes, across: int = 3, height: float = PANEL_HEIGHT
) -> Figure:
    """Draw the panels, ``across`` in a row of that height, with the same axes and one legend."""
    across = min(across, len(panels))
    down = -(-len(panels) // across)
    figure = Figure((TEXT_WIDTH, height * down + 0.4), layout="constrained")
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    looks = dict(zip(_labels(panels), CURVES, strict=False))
    for panel, ax in zip(panels, grid.flat, strict=False):
        _draw(ax, panel, looks)
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


def _draw(ax: Axes, panel: CostPanel, looks: Mapping[str, dict[str, object]]) -> None:
    """Draw one panel; points that are not finite and positive are left out."""
    for label, points in panel.curves.items():
        values = np.array([p for p in points if min(p) > 0 and np.all(np.isfinite(p))])
        style = dict(looks[label], markersize=4.0)
        ax.loglog(*values.reshape(-1, 2).T, label=label, **style)
    ax.set_title(panel.title, loc="left")
    ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)
