"""Films of a run: each frame compares the lattice with the wave at a time, in the moving frame.

Below is the error over time, drawn up to the frame's time; a chain on a bench has no wave, and its
energy is drawn in place of the error. A frame is an image: rows of pixels of red, green and blue.
`film_files.py` writes the files.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import MOVING, field_label, spread_limits
from longwave.reports.pictures.style import ANALYTICAL, BEADS, LATTICE, WAVE, PowerTicks
from longwave.support.labelled_arrays import LabelledArrays

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

FILM_SIZE = (6.5, 3.9)
"""Width and height of a frame in inches."""

MAX_BEADS = 420
"""Most sites that are drawn as beads; more are drawn as a line."""

FILL_COLOUR, CURVE_COLOUR = "#DDEFFA", "#BBBBBB"
"""Colours of the area below the lattice's strain, and of the error curve at all times."""

CONTOUR_LINES = 5
"""Number of contour lines of the wave's strain."""


class Film:
    """Frames in one layout, one for each snapshot of a placed run; subclasses draw the strains."""

    def __init__(self, run: LabelledArrays, title: str, dpi: float) -> None:
        self._run = run
        self._times, self._errors, self._strain, self._wave = (
            np.asarray(run[name].values, dtype=float)
            for name in ("time", "error", "strain", "analytic")
        )
        self._tracked = run.attrs.get("tracked", "error")
        self._clock = clock(self._times, self._errors, self._tracked)
        self.figure = Figure(FILM_SIZE, dpi=dpi, layout="constrained")
        self._agg = FigureCanvasAgg(self.figure)
        self._ax, self._below = self.figure.subplots(2, 1, height_ratios=(3.2, 1.0))
        for ax in (self._ax, self._below):
            ax.spines[["top", "right"]].set_visible(False)
            ax.tick_params(which="both", top=False, right=False)
        self.figure.suptitle(title, parse_math=False, fontsize="medium")
        self._draw_track()
        self._moving = [*self._begin(), self._draw_clock(), self._past, self._now]
        self._fix_layout()

    def _begin(self) -> list[Artist]:
        """Draw the strains of the first frame; return the artists that change between frames."""
        raise NotImplementedError

    def _show(self, index: int) -> None:
        """Update the drawn strains to those of the frame ``index``."""
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self._times)

    def frame(self, index: int) -> Image:
        """Return the image of a frame, an array of shape (height, width, 3)."""
        self._show(index)
        self._text.set_text(self._clock[index])
        self._past.set_data(self._times[: index + 1], self._errors[: index + 1])
        self._now.set_data(self._times[index : index + 1], self._errors[index : index + 1])
        self._agg.restore_region(self._still)
        for artist in self._moving:
            assert artist.axes is not None
            artist.axes.draw_artist(artist)
        return np.asarray(self._agg.buffer_rgba())[:, :, :3].copy()

    def _draw_track(self) -> None:
        """Draw the error at all times in grey, and create the line and dot that mark the frame."""
        ax, times = self._below, self._times
        ax.plot(times, self._errors, color=CURVE_COLOUR, linewidth=1.0)
        (self._past,) = ax.plot([], [], color=LATTICE, linewidth=1.4)
        dot: dict[str, Any] = {"marker": "o", "markersize": 4.5, "linestyle": ""}
        (self._now,) = ax.plot([], [], color=WAVE, clip_on=False, **dot)
        ax.set_xlim(*spread_limits([times]) if times.size < 2 else (times[0], times[-1]))
        ax.set_ylim(0.0, spread_limits([self._errors, np.zeros(1)])[1])
        ax.set(xlabel="$t$", ylabel={"error": "rel. error"}.get(self._tracked, self._tracked))
        ax.locator_params(axis="y", nbins=3)
        ax.yaxis.set_major_formatter(PowerTicks())

    def _draw_clock(self) -> Artist:
        """Draw the text in the corner: the time and the error."""
        box = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 2.0}
        look: dict[str, Any] = {"va": "top", "ha": "left", "fontsize": 11, "bbox": box}
        anchor = {"transform": self._ax.transAxes}
        self._text = self._ax.text(0.015, 0.97, self._clock[0], **anchor, **look)
        return self._text

    def _fix_layout(self) -> None:
        """Compute the layout, fix it, and draw the artists that do not change between frames."""
        self._agg.draw()
        self.figure.set_layout_engine("none")
        for artist in self._moving:
            artist.set_animated(True)
        self._agg.draw()
        self._still = self._agg.copy_from_bbox(self.figure.bbox)


def clock(times: Array, errors: Array, tracked: str = "error") -> list[str]:
    """Return the text of each frame: its time, with as many digits as the step needs, and error."""
    step = float(np.min(np.diff(times))) if times.size > 1 else 1.0
    digits = max(0, min(6, 1 - int(np.floor(np.log10(step))))) if step < 10.0 else 0
    texts = (f"{tracked} {e:.3f}" if np.isfinite(e) else f"no {tracked}" for e in errors)
    return [f"$t = {t:.{digits}f}$\n{text}" for t, text in zip(times, texts, strict=True)]


class ChainFilm(Film):
    """A film of a chain: the lattice as beads, filled to the attribute ``level``, and the wave."""

    def _begin(self) -> list[Artist]:
        run, ax = self._run, self._ax
        self._offset = run["offset"].values
        self._level = run.attrs.get("level", 0.0)
        are_beads = self._offset.shape[1] <= MAX_BEADS
        look: dict[str, Any] = BEADS if are_beads else {"color": LATTICE, "linewidth": 2.0}
        (self._body,) = ax.fill(*self._filled(0), color=FILL_COLOUR, linewidth=0.0)
        (self._beads,) = ax.plot(self._offset[0], self._strain[0], label="lattice", **look)
        wave, look = run.attrs["wave"], ANALYTICAL | {"linewidth": 1.2}
        (self._line,) = ax.plot(self._offset[0], self._wave[0], label=wave, **look)
        ax.set(xlim=self._common(), ylim=spread_limits([self._strain, self._wave]))
        ax.set_xlabel(run.attrs.get("along", MOVING))
        ax.set_ylabel(run.attrs.get("drawn") or field_label(run))
        if run.attrs["wave"]:
            ax.legend(loc="upper right", handlelength=2.2)
        return [self._body, self._beads, self._line]

    def _show(self, index: int) -> None:
        self._body.set_xy(np.transpose(self._filled(index)))
        self._beads.set_data(self._offset[index], self._strain[index])
        self._line.set_data(self._offset[index], self._wave[index])

    def _filled(self, index: int) -> tuple[Array, Array]:
        """Return x and y of the outline of the area between the lattice's strain and ``level``."""
        offset = np.pad(self._offset[index], 1, "edge")
        return offset, np.pad(self._strain[index], 1, constant_values=self._level)

    def _common(self) -> tuple[float, float]:
        """Return the range of offsets n - c t that all frames contain."""
        first, last = self._offset[:, 0], self._offset[:, -1]
        left, right = float(first.max()), float(last.min())
        return (left, right) if left < right else (float(first[0]) - 0.5, float(last[0]) + 0.5)


class PlaneFilm(Film):
    """A film on two axes: a map of the lattice's strain under dashed contours of the wave's."""

    def _begin(self) -> list[Artist]:
        low, high = spread_limits([self._strain, self._wave])
        self._along, self._across = (
            np.asarray(self._run[name].values, dtype=float) for name in ("site", "row")
        )
        self._mesh = self._ax.pcolormesh(
            self._along, self._across, self._strain[0].T, cmap="viridis", vmin=low, vmax=high
        )
        self._levels = np.linspace(low, high, CONTOUR_LINES + 2)[1:-1]
        self._lines = self._contours(0)
        self._ax.set(xlabel="$n - c\\,t$  (cells)", ylabel="$m$")
        self.figure.colorbar(self._mesh, ax=self._ax, label=field_label(self._run, "strain"))
        return [self._mesh, self._lines]

    def _show(self, index: int) -> None:
        self._mesh.set_array(self._strain[index].T)
        old, self._lines = self._lines, self._contours(index)
        self._moving[self._moving.index(old)] = self._lines
        old.remove()
        self._lines.set_animated(True)

    def _contours(self, index: int) -> Any:
        values = np.nan_to_num(self._wave[index].T)
        look: dict[str, Any] = {"colors": WAVE, "linestyles": "--", "linewidths": 0.9}
        return self._ax.contour(self._along, self._across, values, self._levels, **look)
