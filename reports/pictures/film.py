"""Films of a run: each frame the lattice against the wave at a time, in the moving frame.

Below it is the error against time, drawn as far as the film has come; of a chain on a bench, which
has no wave, it is the energy. A frame is an image, rows of
pixels of red, green and blue; `film_files.py` writes them.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import field_label, spread_limits
from longwave.reports.pictures.style import ANALYTICAL, LATTICE, WAVE, PowerTicks
from longwave.reports.pictures.style import BEADS as BEAD
from longwave.support.labelled_arrays import LabelledArrays

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

FILM_SIZE = (6.5, 3.9)
"""Of a frame, in inches."""

BEADS = 420
"""Most sites that are drawn as beads; of more the line alone can be seen."""

FILL, PAST = "#DDEFFA", "#BBBBBB"
"""The colours of what lies under the lattice, and of the error that is still to come."""

CONTOURS = 5
"""Lines of equal strain of the wave."""


class Film:
    """Frames of a placed run, one for each snapshot: time and error, and the strains of a subclass.

    The figure's layout is found once: every frame has the same places.
    """

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
        self._settle()

    def _begin(self) -> list[Artist]:
        """Draw the first frame's strains; return what moves."""
        raise NotImplementedError

    def _show(self, place: int) -> None:
        """Move the strains to those of a frame."""
        raise NotImplementedError

    def __len__(self) -> int:
        return len(self._times)

    def frame(self, place: int) -> Image:
        """The image of a frame."""
        self._show(place)
        self._text.set_text(self._clock[place])
        self._past.set_data(self._times[: place + 1], self._errors[: place + 1])
        self._now.set_data(self._times[place : place + 1], self._errors[place : place + 1])
        self._agg.restore_region(self._still)
        for artist in self._moving:
            assert artist.axes is not None
            artist.axes.draw_artist(artist)
        return np.asarray(self._agg.buffer_rgba())[:, :, :3].copy()

    def _draw_track(self) -> None:
        """The error over all times in grey, as far as the film has come in colour, and a dot."""
        ax, times = self._below, self._times
        ax.plot(times, self._errors, color=PAST, linewidth=1.0)
        (self._past,) = ax.plot([], [], color=LATTICE, linewidth=1.4)
        (self._now,) = ax.plot(
            [], [], color=WAVE, marker="o", markersize=4.5, linestyle="", clip_on=False
        )
        ax.set_xlim(*spread_limits([times]) if times.size < 2 else (times[0], times[-1]))
        ax.set_ylim(0.0, spread_limits([self._errors, np.zeros(1)])[1])
        ax.set_xlabel("$t$")
        ax.set_ylabel({"error": "rel. error"}.get(self._tracked, self._tracked))
        ax.locator_params(axis="y", nbins=3)
        ax.yaxis.set_major_formatter(PowerTicks())

    def _draw_clock(self) -> Artist:
        """The text in the corner."""
        box = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 2.0}
        look: dict[str, Any] = {"va": "top", "ha": "left", "fontsize": 11, "bbox": box}
        place = {"transform": self._ax.transAxes}
        self._text = self._ax.text(0.015, 0.97, self._clock[0], **place, **look)
        return self._text

    def _settle(self) -> None:
        """Find the layout, keep it, and draw once what does not move."""
        self._agg.draw()
        self.figure.set_layout_engine("none")
        for artist in self._moving:
            artist.set_animated(True)
        self._agg.draw()
        self._still = self._agg.copy_from_bbox(self.figure.bbox)


def clock(times: Array, errors: Array, tracked: str = "error") -> list[str]:
    """The time and the error of each frame, the time to the digits that the frames need."""
    step = float(np.min(np.diff(times))) if times.size > 1 else 1.0
    digits = max(0, min(6, 1 - int(np.floor(np.log10(step))))) if step < 10.0 else 0
    told = [f"{tracked} {error:.3f}" if np.isfinite(error) else f"no {tracked}" for error in errors]
    return [f"$t = {t:.{digits}f}$\n{error}" for t, error in zip(times, told, strict=True)]


class ChainFilm(Film):
    """The lattice as beads, filled down to the attribute ``level``, and the wave as a line."""

    def _begin(self) -> list[Artist]:
        run, ax = self._run, self._ax
        self._offset = run["offset"].values
        self._level = run.attrs.get("level", 0.0)
        beads = self._offset.shape[1] <= BEADS
        look: dict[str, Any] = BEAD if beads else {"color": LATTICE, "linewidth": 2.0}
        (self._body,) = ax.fill(*self._filled(0), color=FILL, linewidth=0.0)
        (self._beads,) = ax.plot(self._offset[0], self._strain[0], label="lattice", **look)
        (self._line,) = ax.plot(
            self._offset[0],
            self._wave[0],
            label=run.attrs["wave"],
            **ANALYTICAL | {"linewidth": 1.2},
        )
        ax.set_xlim(*self._common())
        ax.set_ylim(*spread_limits([self._strain, self._wave]))
        ax.set_xlabel(run.attrs.get("along", "$n - c\\,t$  (sites)"))
        ax.set_ylabel(run.attrs.get("drawn") or field_label(run))
        if run.attrs["wave"]:
            ax.legend(loc="upper right", handlelength=2.2)
        return [self._body, self._beads, self._line]

    def _show(self, place: int) -> None:
        self._body.set_xy(np.transpose(self._filled(place)))
        self._beads.set_data(self._offset[place], self._strain[place])
        self._line.set_data(self._offset[place], self._wave[place])

    def _filled(self, place: int) -> tuple[Array, Array]:
        """The outline of what lies between the lattice and the level."""
        offset = np.pad(self._offset[place], 1, "edge")
        return offset, np.pad(self._strain[place], 1, constant_values=self._level)

    def _common(self) -> tuple[float, float]:
        """The sites that all frames have, whatever part of a site the frame has moved."""
        first, last = self._offset[:, 0], self._offset[:, -1]
        left, right = float(first.max()), float(last.min())
        return (left, right) if left < right else (float(first[0]) - 0.5, float(last[0]) + 0.5)


class PlaneFilm(Film):
    """A map of the lattice's strain, with the wave's as dashed contour lines over it."""

    def _begin(self) -> list[Artist]:
        low, high = spread_limits([self._strain, self._wave])
        self._along, self._across = (
            np.asarray(self._run[name].values, dtype=float) for name in ("site", "row")
        )
        self._mesh = self._ax.pcolormesh(
            self._along, self._across, self._strain[0].T, cmap="viridis", vmin=low, vmax=high
        )
        self._levels = np.linspace(low, high, CONTOURS + 2)[1:-1]
        self._lines = self._contours(0)
        self._ax.set_xlabel("$n - c\\,t$  (cells)")
        self._ax.set_ylabel("$m$")
        self.figure.colorbar(self._mesh, ax=self._ax, label=field_label(self._run, "strain"))
        return [self._mesh, self._lines]

    def _show(self, place: int) -> None:
        self._mesh.set_array(self._strain[place].T)
        old, self._lines = self._lines, self._contours(place)
        self._moving[self._moving.index(old)] = self._lines
        old.remove()
        self._lines.set_animated(True)

    def _contours(self, place: int) -> Any:
        values = np.nan_to_num(self._wave[place].T)
        look: dict[str, Any] = {"colors": WAVE, "linestyles": "--", "linewidths": 0.9}
        return self._ax.contour(self._along, self._across, values, self._levels, **look)
