"""Figures of the explorer's page: lattice and wave at one time, maps over all times, the error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from bokeh.models import ColorBar, ColumnDataSource, LinearColorMapper, Range1d, Span
from bokeh.plotting import figure
from matplotlib.colors import to_hex

from longwave.explore.explore_text import unit
from longwave.reports.pictures.style import LATTICE, WAVE

if TYPE_CHECKING:
    from longwave.explore.exploration_run import Array, Comparison

TIME_COLOUR = "#333333"
"""Colour of the line that marks the current time."""

MARGIN_FRACTION = 0.06
"""Free space around curves, as a fraction of their range."""

TOOLS = "xpan,xwheel_zoom,box_zoom,reset,save"
"""Bokeh's tools of every figure."""


def palette(name: str) -> Sequence[str]:
    """Return 256 colours of a matplotlib colour map."""
    return [to_hex(colour) for colour in matplotlib.colormaps[name](np.linspace(0.0, 1.0, 256))]


def extent(*values: Array) -> tuple[float, float]:
    """Return the ends of an axis that contains all finite values."""
    low = min(float(np.nanmin(array)) for array in values)
    high = max(float(np.nanmax(array)) for array in values)
    margin = MARGIN_FRACTION * (high - low) or 1.0
    return low - margin, high + margin


class Picture:
    """A figure, with a line at the current slow time if one of its axes is the slow time."""

    def __init__(self, height: int, x_label: str, **options: Any) -> None:
        self.source = ColumnDataSource()
        self.picture: Any = figure(
            height=height, sizing_mode="stretch_width", tools=TOOLS,
            x_range=Range1d(0, 1), y_range=Range1d(0, 1), **options,
        )  # fmt: skip
        self.picture.xaxis.axis_label = x_label
        self.picture.toolbar.logo = None
        self.picture.toolbar.autohide = True
        self.picture.outline_line_color = None
        self.picture.background_fill_color = self.picture.border_fill_color = "#ffffff"
        self.picture.grid.grid_line_color = "#e8ecf0"
        for axis in self.picture.axis:
            axis.axis_line_color = "#98a4b0"
            axis.major_tick_line_color = axis.minor_tick_line_color = "#98a4b0"
            axis.axis_label_text_font_style = "normal"
            axis.axis_label_text_color = axis.major_label_text_color = "#33404d"

    def set_ranges(self, x: tuple[float, float], y: tuple[float, float]) -> None:
        """Set the ranges of both axes, also for a reset of the figure."""
        for axis, (low, high) in ((self.picture.x_range, x), (self.picture.y_range, y)):
            axis.update(start=low, end=high, reset_start=low, reset_end=high)

    def add_time_line(self, dimension: str, colour: str) -> None:
        """Add the dashed line at the current time; ``dimension`` "width" makes it horizontal."""
        look: dict[str, Any] = {"line_color": colour, "line_width": 1.5, "line_dash": [4, 3]}
        self.time_line = Span(dimension=dimension, **look)
        self.picture.add_layout(self.time_line)

    def set_time(self, T: float) -> None:
        """Move the time line to slow time T."""
        self.time_line.location = T


class Profile(Picture):
    """Lattice and wave at one time, on axes that are the same at all times."""

    def __init__(self) -> None:
        label = "X = \u03b5 (n \u2212 c t), in the frame that moves along"
        super().__init__(330, label, css_classes=["profile"])
        self.source.data = {"X": [], "lattice": [], "wave": []}
        for name, style in (
            ("lattice", {"color": LATTICE, "width": 5.0}),
            ("wave", {"color": WAVE, "width": 1.5}),
        ):
            self.picture.line("X", name, source=self.source, legend_label=name, **style)
        self.picture.legend.background_fill_alpha = 0.7
        self.picture.legend.click_policy = "hide"

    def show(self, comparison: Comparison) -> None:
        """Fit the axes to all times of a comparison."""
        ends = float(comparison.X.min()), float(comparison.X.max())
        self.set_ranges(ends, extent(comparison.lattice, comparison.wave))
        self.picture.yaxis.axis_label = f"{comparison.field}, in {unit(comparison)}"

    def show_frame(self, comparison: Comparison, frame: int) -> None:
        """Draw lattice and wave at one time."""
        names = ("X", "lattice", "wave")
        self.source.data = {name: getattr(comparison, name)[frame] for name in names}


class SpaceTimeMap(Picture):
    """A map over X and slow time, with a line at the current time."""

    def __init__(self, title: str, colours: str, symmetric: bool) -> None:
        super().__init__(300, "X", title=title)
        self.symmetric = symmetric
        self.source.data = {"image": [], "x": [], "y": [], "dw": [], "dh": []}
        self.mapper = LinearColorMapper(palette=palette(colours), low=0, high=1)
        self.picture.image("image", "x", "y", "dw", "dh", source=self.source,
                           color_mapper=self.mapper)  # fmt: skip
        self.picture.add_layout(ColorBar(color_mapper=self.mapper, width=12), "right")
        self.add_time_line("width", TIME_COLOUR if symmetric else "#ffffff")
        self.picture.yaxis.axis_label = "slow time T"

    def show(self, comparison: Comparison, values: Array) -> None:
        """Draw values of shape (time, cell)."""
        image = comparison.columns(values)
        low, high = float(image.min()), float(image.max())
        if self.symmetric:
            high = max(abs(low), abs(high)) or 1.0
            low = -high
        self.mapper.update(low=low, high=high if high > low else low + 1.0)
        T, X = comparison.slow_times, comparison.X
        x, y = float(X.min()), float(T[0])
        dw, dh = float(X.max()) - x, float(T[-1]) - y or 1.0
        self.source.data = {"image": [image], "x": [x], "y": [y], "dw": [dw], "dh": [dh]}
        self.set_ranges((x, x + dw), (y, y + dh))


class ErrorPicture(Picture):
    """Largest difference against slow time, with a band for the run's numerical error."""

    def __init__(self) -> None:
        super().__init__(240, "slow time T")
        self.source.data = {"T": [], "error": [], "low": [], "high": []}
        self.picture.varea("T", "low", "high", source=self.source, color=LATTICE, alpha=0.25,
                           legend_label="the run's own error")  # fmt: skip
        self.picture.line("T", "error", source=self.source, color=LATTICE, width=2,
                          legend_label="largest difference")  # fmt: skip
        self.add_time_line("height", TIME_COLOUR)
        self.picture.legend.location = "top_left"
        self.picture.legend.background_fill_alpha = 0.7

    def show(self, comparison: Comparison) -> None:
        """Draw the errors of a comparison."""
        T, error = comparison.slow_times, comparison.errors
        low, high = np.maximum(error - comparison.estimate, 0.0), error + comparison.estimate
        self.source.data = {"T": T, "error": error, "low": low, "high": high}
        top = 1.15 * float(np.nanmax(high)) or 1.0
        begin, end = float(T[0]), float(T[-1]) if T[-1] > T[0] else float(T[0]) + 1.0
        self.set_ranges((begin, end), (0.0, top))
        self.picture.yaxis.axis_label = f"in {unit(comparison)}"
