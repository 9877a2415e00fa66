"""Error curves: the relative sup error of one or more runs against time."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure, FigureBase
from numpy.typing import NDArray

from reports.figures.style import CURVES, TEXT_WIDTH

ERROR_HEIGHT = 2.0
"""Height of a panel of error curves, in inches."""


@dataclass(frozen=True)
class ErrorCurve:
    """The relative sup error at each of the times; `label` may hold mathematics in dollars."""

    label: str
    times: NDArray[np.float64]
    errors: NDArray[np.float64]


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
        _draw(ax, curves)


def _draw(ax: Axes, curves: Sequence[ErrorCurve]) -> None:
    """Draw the curves of one panel through all their points, without markers."""
    for curve, look in zip(curves, CURVES, strict=False):
        ax.plot(curve.times, curve.errors, label=curve.label, **look | {"marker": ""})
    ax.set_xlabel("$t$")
    ax.set_ylabel(r"$L^\infty_\epsilon$")
    ax.set_ylim(bottom=0)
    ax.locator_params(axis="x", nbins=6)
    ax.ticklabel_format(axis="y", scilimits=(-3, 3), useMathText=True)
    ax.legend()
