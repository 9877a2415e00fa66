"""Films of a run: each frame the lattice against the wave at a time, in the moving frame.

Below it is the error against time, drawn as far as the film has come. A frame is an image, rows of
pixels of red, green and blue; `film_files.py` writes them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import Snapshot, spread_limits

Array = NDArray[np.float64]
Image = NDArray[np.uint8]

FILM_SIZE = (6.5, 3.9)
"""Of a frame, in inches."""

BEADS = 420
"""Most sites that are drawn as beads; of more the line alone can be seen."""

LATTICE, WAVE, FILL, PAST = "#0072B2", "#D55E00", "#D3E6F1", "#BBBBBB"
"""Okabe and Ito's blue and vermilion, told apart by beads and dashes as well."""


class Film(Protocol):
    """What has frames that can be shown one after another."""

    def __len__(self) -> int:
        """The number of frames."""

    def frame(self, place: int) -> Image:
        """The image of a frame."""


@dataclass(frozen=True)
class FilmWords:
    """What a film says: its title, of lattice and wave what they are, and of the time what it is.

    ``clock`` holds one text for each frame, with mathematics in dollars; the title is plain.
    """

    title: str
    wave: str
    clock: Sequence[str]


class ChainFilm:
    """Snapshots of a chain, with their errors: the lattice as beads, the wave dashed on it.

    What is between the lattice and the ``level`` of its background is filled.
    """

    def __init__(
        self,
        snapshots: Sequence[Snapshot],
        errors: Array,
        words: FilmWords,
        dpi: float,
        level: float = 0.0,
    ) -> None:
        self._snapshots, self._words = list(snapshots), words
        self._canvas = _Canvas(dpi, words.title)
        self._ax, below = self._canvas.axes
        self._track = _ErrorTrack(below, np.array([s.time for s in snapshots]), errors)
        first = snapshots[0]
        beads: dict[str, Any] = {"marker": "o", "markersize": 3.0, "markeredgewidth": 0.0}
        look = beads if first.offset.size <= BEADS else {}
        self._level = level
        (self._body,) = self._ax.fill(*self._filled(first), color=FILL, linewidth=0.0)
        (self._lattice,) = self._ax.plot(
            first.offset, first.numerical, color=LATTICE, linewidth=0.9, label="lattice", **look
        )
        (self._wave,) = self._ax.plot(
            first.offset, first.analytical, color=WAVE, linewidth=1.5, dashes=(4, 2.5),
            label=words.wave,
        )  # fmt: skip
        self._ax.set_xlim(*_common(s.offset for s in snapshots))
        self._ax.set_ylim(
            *spread_limits([part for s in snapshots for part in (s.numerical, s.analytical)])
        )
        self._ax.set_xlabel("$n - c\\,t$  (sites)")
        self._ax.set_ylabel("$y_n$")
        self._ax.legend(loc="upper right", handlelength=2.2)
        self._clock = self._canvas.clock(self._ax, words.clock)
        moving = (self._body, self._lattice, self._wave, self._clock)
        self._canvas.settle(*moving, *self._track.moving)

    def __len__(self) -> int:
        return len(self._snapshots)

    def frame(self, place: int) -> Image:
        """The image of a frame."""
        shown = self._snapshots[place]
        self._body.set_xy(np.transpose(self._filled(shown)))
        self._lattice.set_data(shown.offset, shown.numerical)
        self._wave.set_data(shown.offset, shown.analytical)
        self._clock.set_text(self._words.clock[place])
        self._track.show(place)
        return self._canvas.image()

    def _filled(self, shown: Snapshot) -> tuple[Array, Array]:
        """The outline of what lies between the lattice and the level."""
        offset = np.concatenate([shown.offset[:1], shown.offset, shown.offset[-1:]])
        return offset, np.concatenate([[self._level], shown.numerical, [self._level]])


@dataclass(frozen=True)
class PlaneFrames:
    """Strains of lattice and wave on two axes: (frames, along, across), and where they are."""

    times: Array
    along: Array
    across: Array
    lattice: Array
    wave: Array


CONTOURS = 5
"""Lines of equal strain of the wave."""


class PlaneFilm:
    """A map of the lattice's strain, with the wave's as dashed contour lines over it."""

    def __init__(self, frames: PlaneFrames, errors: Array, words: FilmWords, dpi: float) -> None:
        self._frames, self._words = frames, words
        self._canvas = _Canvas(dpi, words.title)
        self._ax, below = self._canvas.axes
        self._track = _ErrorTrack(below, frames.times, errors)
        low, high = spread_limits([frames.lattice, frames.wave])
        self._mesh = self._ax.pcolormesh(
            frames.along, frames.across, frames.lattice[0].T, cmap="viridis", vmin=low, vmax=high
        )
        self._levels = np.linspace(low, high, CONTOURS + 2)[1:-1]
        self._lines = self._contours(0)
        self._ax.set_xlabel("$n - c\\,t$  (cells)")
        self._ax.set_ylabel("$m$")
        self._canvas.figure.colorbar(self._mesh, ax=self._ax, label="strain")
        self._clock = self._canvas.clock(self._ax, words.clock)
        self._canvas.settle(self._mesh, self._lines, self._clock, *self._track.moving)

    def __len__(self) -> int:
        return len(self._frames.times)

    def frame(self, place: int) -> Image:
        """The image of a frame."""
        self._mesh.set_array(self._frames.lattice[place].T)
        self._lines = self._canvas.replace(self._lines, self._contours(place))
        self._clock.set_text(self._words.clock[place])
        self._track.show(place)
        return self._canvas.image()

    def _contours(self, place: int) -> Any:
        values = np.nan_to_num(self._frames.wave[place].T)
        axes = self._frames.along, self._frames.across
        look: dict[str, Any] = {"colors": WAVE, "linestyles": "--", "linewidths": 0.9}
        return self._ax.contour(*axes, values, self._levels, **look)


class _ErrorTrack:
    """The error over all times in grey, as far as the film has come in colour, and a dot."""

    def __init__(self, ax: Axes, times: Array, errors: Array) -> None:
        self._times, self._errors = times, errors
        ax.plot(times, errors, color=PAST, linewidth=1.0)
        (self._past,) = ax.plot([], [], color=LATTICE, linewidth=1.4)
        (self._now,) = ax.plot(
            [], [], color=WAVE, marker="o", markersize=4.5, linestyle="", clip_on=False
        )
        ax.set_xlim(*spread_limits([times]) if times.size < 2 else (times[0], times[-1]))
        ax.set_ylim(0.0, spread_limits([errors, np.zeros(1)])[1])
        ax.set_xlabel("$t$")
        ax.set_ylabel("rel. error")
        ax.locator_params(axis="y", nbins=3)
        ax.ticklabel_format(axis="y", scilimits=(-3, 3), useMathText=True)

    @property
    def moving(self) -> tuple[Artist, ...]:
        """What changes from frame to frame."""
        return self._past, self._now

    def show(self, place: int) -> None:
        """Show the track up to a frame."""
        self._past.set_data(self._times[: place + 1], self._errors[: place + 1])
        self._now.set_data(self._times[place : place + 1], self._errors[place : place + 1])


class _Canvas:
    """A figure of two panels whose layout is found once: every frame has the same places."""

    def __init__(self, dpi: float, title: str) -> None:
        self.figure = Figure(FILM_SIZE, dpi=dpi, layout="constrained")
        self._agg = FigureCanvasAgg(self.figure)
        upper, below = self.figure.subplots(2, 1, height_ratios=(3.2, 1.0))
        for ax in (upper, below):
            ax.spines[["top", "right"]].set_visible(False)
        self.axes: tuple[Axes, Axes] = upper, below
        self.figure.suptitle(title, parse_math=False, fontsize="medium")

    def clock(self, ax: Axes, texts: Sequence[str]) -> Any:
        """The text in the corner."""
        box = {"facecolor": "white", "alpha": 0.75, "edgecolor": "none", "pad": 2.0}
        look: dict[str, Any] = {"va": "top", "ha": "left", "fontsize": 11, "bbox": box}
        return ax.text(0.015, 0.97, texts[0], transform=ax.transAxes, **look)

    def settle(self, *moving: Artist) -> None:
        """Find the layout, keep it, and draw once what does not move."""
        self._agg.draw()
        self.figure.set_layout_engine("none")
        self._moving = list(moving)
        for artist in moving:
            artist.set_animated(True)
        self._agg.draw()
        self._still = self._agg.copy_from_bbox(self.figure.bbox)

    def replace(self, old: Artist, new: Artist) -> Artist:
        """Let one moving artist take the place of another."""
        self._moving[self._moving.index(old)] = new
        old.remove()
        new.set_animated(True)
        return new

    def image(self) -> Image:
        """The figure's pixels as they are now."""
        self._agg.restore_region(self._still)
        for artist in self._moving:
            assert artist.axes is not None
            artist.axes.draw_artist(artist)
        return np.asarray(self._agg.buffer_rgba())[:, :, :3].copy()


def _common(offsets: Any) -> tuple[float, float]:
    """The range of sites that all frames have, whatever part of a site the frame has moved."""
    ends = [(float(offset[0]), float(offset[-1])) for offset in offsets]
    left, right = max(end[0] for end in ends), min(end[1] for end in ends)
    return (left, right) if left < right else (ends[0][0] - 0.5, ends[0][1] + 0.5)
