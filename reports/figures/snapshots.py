"""Snapshots: the lattice's strain over the mKdV wave at a few times, panel by panel."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from numpy.typing import NDArray

from reports.figures.style import ANALYTICAL, NUMERICAL, TEXT_WIDTH

PANEL_HEIGHT = 1.55
"""Height of one row of panels, in inches."""

Sites = NDArray[np.float64]


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


def snapshot_figure(rows: Sequence[Sequence[Snapshot]]) -> Figure:
    """Draw one panel per snapshot, one row per run; panels are lettered (A), (B), ... ."""
    figure = Figure((TEXT_WIDTH, snapshot_height(len(rows))), layout="constrained")
    draw_snapshot_panels(figure, rows)
    return figure


def snapshot_height(rows: int) -> float:
    """Height in inches of that many rows of panels and their legend."""
    return PANEL_HEIGHT * rows + 0.35


def draw_snapshot_panels(figure: FigureBase, rows: Sequence[Sequence[Snapshot]]) -> None:
    """Draw the panels of `snapshot_figure` into a figure; shorter rows end in empty places."""
    across = max(len(row) for row in rows)
    panels = figure.subplots(len(rows), across, squeeze=False)
    letters = map(chr, range(ord("A"), ord("Z") + 1))
    for row, axes in zip(rows, panels, strict=True):
        low, high = _limits(row)
        for column, (snapshot, ax) in enumerate(zip(row, axes, strict=False)):
            _draw(ax, snapshot, next(letters))
            ax.set_ylim(low, high)
            ax.tick_params(labelleft=column == 0)
        axes[0].set_ylabel("$y_n$")
        for ax in axes[len(row) :]:
            ax.set_visible(False)
    for ax in panels[-1]:
        ax.set_xlabel("$n - c\\,t$  (sites)")
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper right", ncols=2)


def _draw(ax: Axes, snapshot: Snapshot, letter: str) -> None:
    """Draw one panel: the numerical strain solid blue, the analytical one dashed red on it."""
    ax.plot(snapshot.offset, snapshot.numerical, label="lattice", **NUMERICAL)
    ax.plot(snapshot.offset, snapshot.analytical, label="mKdV wave", **ANALYTICAL)
    ax.set_title(rf"({letter})  $\epsilon={snapshot.eps:g}$, $t={snapshot.time:g}$", loc="left")
    ax.set_xlim(snapshot.offset[0], snapshot.offset[-1])
    ax.locator_params(axis="x", nbins=5)


def _limits(row: Sequence[Snapshot]) -> tuple[float, float]:
    """Return the strain axis that all panels of a row share."""
    values = np.concatenate([part for s in row for part in (s.numerical, s.analytical)])
    low, high = float(values.min()), float(values.max())
    margin = 0.06 * (high - low)
    return low - margin, high + margin
