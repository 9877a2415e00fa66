"""Snapshots: the lattice's strain over the mKdV wave at a few times, panel by panel."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
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
    across = max(len(row) for row in rows)
    figure = Figure((TEXT_WIDTH, PANEL_HEIGHT * len(rows) + 0.35), layout="constrained")
    panels = figure.subplots(len(rows), across, squeeze=False)
    for place, (row, axes) in enumerate(zip(rows, panels, strict=True)):
        low, high = _limits(row)
        for column, (snapshot, ax) in enumerate(zip(row, axes, strict=True)):
            _draw(ax, snapshot, chr(ord("A") + place * across + column))
            ax.set_ylim(low, high)
            ax.tick_params(labelleft=column == 0)
        axes[0].set_ylabel("$y_n$")
    for ax in panels[-1]:
        ax.set_xlabel("$n - c\\,t$  (sites)")
    figure.legend(*panels[0][0].get_legend_handles_labels(), loc="outside upper right", ncols=2)
    return figure


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
