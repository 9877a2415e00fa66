"""Pictures and films that show themselves where they are the last line of a notebook's cell."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure

from longwave.reports.pictures.style import styled
from longwave.support.user_files import shown_path

SHARPNESS = 2
"""Pixels of a picture for each that a notebook shows it on: for dense screens."""

NOTEBOOK_DPI = 96.0
"""Pixels of a notebook for an inch of a figure."""

MOST_BYTES = 30_000_000
"""Of a film that is put into a notebook; of a larger one the path is shown."""


class ShownFigure(Figure):
    """A figure that a notebook shows, without pyplot and whatever its backend is."""

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """The picture, and the size at which a notebook shows it."""
        held = BytesIO()
        with styled():
            self.savefig(held, format="png", dpi=SHARPNESS * NOTEBOOK_DPI)
        width, height = (round(NOTEBOOK_DPI * inches) for inches in self.get_size_inches())
        return held.getvalue(), {"width": width, "height": height}


@dataclass(frozen=True, repr=False)
class ShownFilm:
    """A film: how many ``frames`` it has, and the ``path`` of its file, None if it has none.

    ``content`` are the bytes of a film without a file, whose suffix is ``suffix``.
    """

    frames: int
    path: Path | None
    content: bytes = b""
    suffix: str = ".gif"

    def __repr__(self) -> str:
        where = "in memory" if self.path is None else f"in {shown_path(self.path)}"
        return f"<Film of {self.frames} frames {where}>"

    def _repr_html_(self) -> str | None:
        """The film itself; None, so that its path is shown, if it is gone or large."""
        try:
            content = self.path.read_bytes() if self.path else self.content
        except OSError:
            return None
        if len(content) > MOST_BYTES:
            return None
        suffix = self.path.suffix.lower() if self.path else self.suffix
        data = b64encode(content).decode("ascii")
        if suffix == ".gif":
            return f'<img alt="film" src="data:image/gif;base64,{data}">'
        return f'<video controls loop autoplay muted src="data:video/mp4;base64,{data}"></video>'
