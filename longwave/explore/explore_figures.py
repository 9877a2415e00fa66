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

if TYPE_CHECKING:
    from longwave.explore.exploration_run import Array, Comparison

LATTICE, WAVE, TIME = "#0072B2", "#D55E00", "#333333"
"""Colours that are told apart with any colour vision: of the lattice, the wave and the time."""

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


class Profile:
    """Lattice and wave at one time, on axes that stay the same at all times."""

    def __init__(self) -> None:
        self.source = ColumnDataSource({"X": [], "lattice": [], "wave": []})
        self.picture = figure(
            height=330, sizing_mode="stretch_width", tools=TOOLS, css_classes=["profile"],
            x_range=Range1d(-1, 1), y_range=Range1d(-1, 1),
        )  # fmt: skip
        self.picture.line(
            "X", "lattice", source=self.source, color=LATTICE, width=2, legend_label="lattice"
        )
        self.picture.line(
            "X", "wave", source=self.source, color=WAVE, width=2, line_dash=[6, 4],
            legend_label="wave",
        )  # fmt: skip
        self.picture.xaxis.axis_label = "X = \u03b5 (n \u2212 c t), in the frame that moves along"
        self.picture.legend.background_fill_alpha = 0.7
        self.picture.legend.click_policy = "hide"
        _plain(self.picture)

    def show(self, found: Comparison) -> None:
        """Fit the axes to all times of a comparison."""
        for axis, (low, high) in (
            (self.picture.x_range, (float(found.X.min()), float(found.X.max()))),
            (self.picture.y_range, extent(found.lattice, found.wave)),
        ):
            axis.update(start=low, end=high, reset_start=low, reset_end=high)
        self.picture.yaxis.axis_label = f"strain, in {unit(found)}"

    def at(self, found: Comparison, frame: int) -> None:
        """Draw one time."""
        self.source.data = {
            "X": found.X[frame],
            "lattice": found.lattice[frame],
            "wave": found.wave[frame],
        }


class SpaceTimeMap:
    """A map over X and slow time, with a line at the time that the profile shows."""

    def __init__(self, title: str, colours: str, symmetric: bool) -> None:
        self.symmetric = symmetric
        self.source = ColumnDataSource({"image": [], "x": [], "y": [], "dw": [], "dh": []})
        self.mapper = LinearColorMapper(palette=palette(colours), low=0, high=1)
        self.picture = figure(
            height=300, sizing_mode="stretch_width", tools=TOOLS, title=title,
            x_range=Range1d(-1, 1), y_range=Range1d(0, 1),
        )  # fmt: skip
        self.picture.image("image", "x", "y", "dw", "dh", source=self.source,
                           color_mapper=self.mapper)  # fmt: skip
        self.picture.add_layout(ColorBar(color_mapper=self.mapper, width=12), "right")
        self.now = Span(dimension="width", line_width=1.5, line_dash=[4, 3])
        self.now.line_color = TIME if symmetric else "#ffffff"
        self.picture.add_layout(self.now)
        self.picture.xaxis.axis_label = "X"
        self.picture.yaxis.axis_label = "slow time T"
        _plain(self.picture)

    def show(self, found: Comparison, values: Array) -> None:
        """Draw values (time, cell)."""
        image = found.columns(values)
        low, high = float(image.min()), float(image.max())
        if self.symmetric:
            high = max(abs(low), abs(high)) or 1.0
            low = -high
        self.mapper.update(low=low, high=high if high > low else low + 1.0)
        T, X = found.slow_times, found.X
        box = {"x": float(X.min()), "y": float(T[0])}
        box |= {"dw": float(X.max()) - box["x"], "dh": float(T[-1]) - box["y"] or 1.0}
        self.source.data = {"image": [image], **{key: [value] for key, value in box.items()}}
        for axis, start, width in (
            (self.picture.x_range, box["x"], box["dw"]),
            (self.picture.y_range, box["y"], box["dh"]),
        ):
            axis.update(start=start, end=start + width, reset_start=start, reset_end=start + width)

    def at(self, T: float) -> None:
        """Mark a slow time."""
        self.now.location = T


class ErrorPicture:
    """The largest difference against slow time, with the band of the run's own error."""

    def __init__(self) -> None:
        self.source = ColumnDataSource({"T": [], "error": [], "low": [], "high": []})
        self.picture = figure(height=240, sizing_mode="stretch_width", tools=TOOLS,
                              x_range=Range1d(0, 1), y_range=Range1d(0, 1))  # fmt: skip
        self.picture.varea("T", "low", "high", source=self.source, color=LATTICE, alpha=0.25,
                           legend_label="the run's own error")  # fmt: skip
        self.picture.line("T", "error", source=self.source, color=LATTICE, width=2,
                          legend_label="largest difference")  # fmt: skip
        self.now = Span(dimension="height", line_color=TIME, line_width=1.5, line_dash=[4, 3])
        self.picture.add_layout(self.now)
        self.picture.xaxis.axis_label = "slow time T"
        self.picture.legend.location = "top_left"
        self.picture.legend.background_fill_alpha = 0.7
        _plain(self.picture)

    def show(self, found: Comparison) -> None:
        """Draw a comparison's errors."""
        T, error = found.slow_times, found.errors
        low, high = np.maximum(error - found.estimate, 0.0), error + found.estimate
        self.source.data = {"T": T, "error": error, "low": low, "high": high}
        top = 1.15 * float(np.nanmax(high)) or 1.0
        self.picture.y_range.update(start=0.0, end=top, reset_start=0.0, reset_end=top)
        begin, end = float(T[0]), float(T[-1]) if T[-1] > T[0] else float(T[0]) + 1.0
        self.picture.x_range.update(start=begin, end=end, reset_start=begin, reset_end=end)
        self.picture.yaxis.axis_label = f"in {unit(found)}"

    def at(self, T: float) -> None:
        """Mark a slow time."""
        self.now.location = T


def _plain(picture: Any) -> None:
    """One look for all pictures."""
    picture.toolbar.logo = None
    picture.toolbar.autohide = True
    picture.outline_line_color = None
    picture.background_fill_color = "#ffffff"
    picture.border_fill_color = "#ffffff"
    picture.grid.grid_line_color = "#e8ecf0"
    for axis in picture.axis:
        axis.axis_line_color = "#98a4b0"
        axis.major_tick_line_color = axis.minor_tick_line_color = "#98a4b0"
        axis.axis_label_text_font_style = "normal"
        axis.axis_label_text_color = axis.major_label_text_color = "#33404d"
