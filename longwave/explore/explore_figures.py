"""The page's pictures: lattice against wave at one time, maps of all times, error against time."""

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

TIME = "#333333"
"""The colour of the time."""

MARGIN = 0.06
"""Free space about curves, as a share of their extent."""

TOOLS = "xpan,xwheel_zoom,box_zoom,reset,save"


def palette(name: str) -> Sequence[str]:
    """The 256 colours of one of matplotlib's maps."""
    return [to_hex(colour) for colour in matplotlib.colormaps[name](np.linspace(0.0, 1.0, 256))]


def extent(*values: Array) -> tuple[float, float]:
    """The ends of an axis that holds all finite values."""
    low = min(float(np.nanmin(part)) for part in values)
    high = max(float(np.nanmax(part)) for part in values)
    margin = MARGIN * (high - low) or 1.0
    return low - margin, high + margin


class Picture:
    """One picture, with a line at the slow time that the profile shows, if it has an axis of it."""

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

    def reach(self, x: tuple[float, float], y: tuple[float, float]) -> None:
        """Let the axes go between these ends, also when the picture is reset."""
        for axis, (low, high) in ((self.picture.x_range, x), (self.picture.y_range, y)):
            axis.update(start=low, end=high, reset_start=low, reset_end=high)

    def mark_time(self, dimension: str, colour: str) -> None:
        """Add the line of the time, along the width or the height."""
        self.now = Span(dimension=dimension, line_color=colour, line_width=1.5, line_dash=[4, 3])
        self.picture.add_layout(self.now)

    def at(self, T: float) -> None:
        """Mark a slow time."""
        self.now.location = T


class Profile(Picture):
    """Lattice and wave at one time, on axes that stay the same at all times."""

    def __init__(self) -> None:
        label = "X = \u03b5 (n \u2212 c t), in the frame that moves along"
        super().__init__(330, label, css_classes=["profile"])
        self.source.data = {"X": [], "lattice": [], "wave": []}
        for name, look in (
            ("lattice", {"color": LATTICE, "width": 5.0}),
            ("wave", {"color": WAVE, "width": 1.5}),
        ):
            self.picture.line("X", name, source=self.source, legend_label=name, **look)
        self.picture.legend.background_fill_alpha = 0.7
        self.picture.legend.click_policy = "hide"

    def show(self, found: Comparison) -> None:
        """Fit the axes to all times of a comparison."""
        self.reach((float(found.X.min()), float(found.X.max())), extent(found.lattice, found.wave))
        self.picture.yaxis.axis_label = f"{found.field}, in {unit(found)}"

    def show_frame(self, found: Comparison, frame: int) -> None:
        """Draw one time."""
        self.source.data = {name: getattr(found, name)[frame] for name in ("X", "lattice", "wave")}


class SpaceTimeMap(Picture):
    """A map over X and slow time, with a line at the time that the profile shows."""

    def __init__(self, title: str, colours: str, symmetric: bool) -> None:
        super().__init__(300, "X", title=title)
        self.symmetric = symmetric
        self.source.data = {"image": [], "x": [], "y": [], "dw": [], "dh": []}
        self.mapper = LinearColorMapper(palette=palette(colours), low=0, high=1)
        self.picture.image("image", "x", "y", "dw", "dh", source=self.source,
                           color_mapper=self.mapper)  # fmt: skip
        self.picture.add_layout(ColorBar(color_mapper=self.mapper, width=12), "right")
        self.mark_time("width", TIME if symmetric else "#ffffff")
        self.picture.yaxis.axis_label = "slow time T"

    def show(self, found: Comparison, values: Array) -> None:
        """Draw values (time, cell)."""
        image = found.columns(values)
        low, high = float(image.min()), float(image.max())
        if self.symmetric:
            high = max(abs(low), abs(high)) or 1.0
            low = -high
        self.mapper.update(low=low, high=high if high > low else low + 1.0)
        T, X = found.slow_times, found.X
        x, y = float(X.min()), float(T[0])
        dw, dh = float(X.max()) - x, float(T[-1]) - y or 1.0
        self.source.data = {"image": [image], "x": [x], "y": [y], "dw": [dw], "dh": [dh]}
        self.reach((x, x + dw), (y, y + dh))


class ErrorPicture(Picture):
    """The largest difference against slow time, with the band of the run's own error."""

    def __init__(self) -> None:
        super().__init__(240, "slow time T")
        self.source.data = {"T": [], "error": [], "low": [], "high": []}
        self.picture.varea("T", "low", "high", source=self.source, color=LATTICE, alpha=0.25,
                           legend_label="the run's own error")  # fmt: skip
        self.picture.line("T", "error", source=self.source, color=LATTICE, width=2,
                          legend_label="largest difference")  # fmt: skip
        self.mark_time("height", TIME)
        self.picture.legend.location = "top_left"
        self.picture.legend.background_fill_alpha = 0.7

    def show(self, found: Comparison) -> None:
        """Draw a comparison's errors."""
        T, error = found.slow_times, found.errors
        low, high = np.maximum(error - found.estimate, 0.0), error + found.estimate
        self.source.data = {"T": T, "error": error, "low": low, "high": high}
        top = 1.15 * float(np.nanmax(high)) or 1.0
        begin, end = float(T[0]), float(T[-1]) if T[-1] > T[0] else float(T[0]) + 1.0
        self.reach((begin, end), (0.0, top))
        self.picture.yaxis.axis_label = f"in {unit(found)}"
