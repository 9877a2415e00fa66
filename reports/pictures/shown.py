"""Figures and films that a notebook shows if they are the last value of a cell."""

from __future__ import annotations

from base64 import b64encode
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure

from longwave.reports.pictures.style import styled
from longwave.support.user_files import shown_path

SHARPNESS = 2
"""Image pixels per displayed notebook pixel (in each direction), for sharp dense screens."""

NOTEBOOK_DPI = 96.0
"""Pixels of a notebook for each inch of a figure."""

MOST_BYTES = 30_000_000
"""Largest film in bytes that a notebook embeds; for a larger one the path is shown."""


class ShownFigure(Figure):
    """A figure that a notebook shows without pyplot, whatever Matplotlib's backend is."""

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """Return the picture as PNG, and the size in pixels at which a notebook shows it."""
        buffer = BytesIO()
        with styled():
            self.savefig(buffer, format="png", dpi=SHARPNESS * NOTEBOOK_DPI)
        width, height = (round(NOTEBOOK_DPI * inches) for inches in self.get_size_inches())
        return buffer.getvalue(), {"width": width, "height": height}


@dataclass(frozen=True, repr=False)
class ShownFilm:
    """A film: its number of ``frames`` and the ``path`` of its file, None if it has no file.

    ``content`` has the bytes of a film without a file, and ``suffix`` its format.
    """

    frames: int
    path: Path | None
    content: bytes = b""
    suffix: str = ".gif"

    def __repr__(self) -> str:
        where = "in memory" if self.path is None else f"in {shown_path(self.path)}"
        return f"<Film of {self.frames} frames {where}>"

    def _repr_html_(self) -> str | None:
        """Return the film as HTML; None if the file is missing or too large (its path is shown)."""
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
