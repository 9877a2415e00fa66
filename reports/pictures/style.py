"""The style of all pictures: sizes, fonts, colours, and writing to files.

Colour-blind readers can distinguish the colours.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Concatenate, ParamSpec, cast

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure, FigureBase
from matplotlib.text import Text
from matplotlib.ticker import ScalarFormatter

from longwave.support.atomic_file import write_atomically

Arguments = ParamSpec("Arguments")

TEXT_WIDTH = 6.5
"""Width of the report's text, in inches; figures are drawn at the size at which they appear."""

WIDTHS = {1: 3.4, 2: 7.0}
"""Widths of pictures for one column and for two columns of a journal, in inches."""

LATTICE, WAVE, OWN = "#56B4E9", "#D55E00", "#E69F00"
"""Colours of the lattice, the wave in theory and a run's numerical error in all pictures."""

NUMERICAL: dict[str, Any] = {"color": LATTICE, "linestyle": "-", "linewidth": 2.6}
"""Line style of the lattice's strain: broad, so that it remains visible under a thin line."""

BEADS: dict[str, Any] = {"color": LATTICE, "linestyle": "", "marker": "o", "markersize": 3.6}
BEADS |= {"markeredgewidth": 0.5, "markeredgecolor": "#0072B2"}
"""Look of the lattice's strain where single values can be distinguished: each is a bead."""

ANALYTICAL: dict[str, Any] = {"color": WAVE, "linestyle": "-", "linewidth": 0.9}
"""Line style of the wave in theory."""

BEADS_AN_INCH = 22.0
"""Largest number of values per inch that are drawn as separate beads."""

CURVES: tuple[dict[str, Any], ...] = (
    {"color": "#0072B2", "linestyle": "-", "marker": "o"},
    {"color": "#D55E00", "linestyle": "--", "marker": "s"},
    {"color": "#009E73", "linestyle": "-.", "marker": "^"},
    {"color": "#CC79A7", "linestyle": ":", "marker": "D"},
    {"color": "#000000", "linestyle": (0, (5, 1)), "marker": "v"},
    {"color": "#56B4E9", "linestyle": (0, (3, 1, 1, 1)), "marker": "P"},
    {"color": "#E69F00", "linestyle": (0, (1, 1)), "marker": "X"},
    {"color": "#999999", "linestyle": (0, (8, 2)), "marker": "*"},
)
"""Colours of Okabe and Ito, each with its own line style and marker."""

_SETTINGS: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.labelsize": 9.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "legend.handlelength": 1.8,
    "lines.markersize": 3.0,
    "lines.linewidth": 1.2,
    "axes.linewidth": 0.6,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "svg.hashsalt": "longwave",
    "savefig.dpi": 200,
}

_FONTS: Mapping[str, dict[str, Any]] = {
    "times": {"font.family": ["STIXGeneral"], "mathtext.fontset": "stix"},
    "tex": {
        "font.family": ["cmr10", "STIXGeneral"],
        "mathtext.fontset": "cm",
        "axes.formatter.use_mathtext": True,
    },
}
"""Matplotlib font settings: "times" as in journals (searchable Unicode), "tex" as in TeX."""

_FAMILIES = "STIXGeneral, 'STIX Two Text', 'Times New Roman', Times, serif"
"""CSS font families for the text of an SVG; a browser uses the first that it has."""

_NOT_IN_TEX = re.compile(r'[<>_|{}"\\$]')
"""Pattern of characters that TeX's text fonts show as other characters."""


@dataclass(frozen=True)
class Part:
    """A part of a figure: its height in inches, and the function that draws it."""

    height: float
    draw: Callable[[FigureBase], None]

    def figure(self, width: float | None = None) -> Figure:
        """Return a figure of this part alone, ``width`` inches wide, by default as `styled` set."""
        figure = Figure((width or page_width(), self.height), layout="constrained")
        self.draw(figure)
        return figure


def part(
    height: float | Callable[..., float],
) -> Callable[[Callable[Concatenate[FigureBase, Arguments], None]], Callable[Arguments, Part]]:
    """Return a decorator by which a function that draws on a figure returns a `Part` instead.

    ``height``, in inches, may be a function of the drawing function's other arguments.
    """

    def declare(
        draw: Callable[Concatenate[FigureBase, Arguments], None],
    ) -> Callable[Arguments, Part]:
        @wraps(draw)
        def build(*arguments: Arguments.args, **options: Arguments.kwargs) -> Part:
            inches = height(*arguments, **options) if callable(height) else height

            def draw_on(figure: FigureBase) -> None:
                draw(figure, *arguments, **options)
                _leave_out_spines(figure)

            return Part(inches, draw_on)

        return build

    return declare


def _leave_out_spines(figure: FigureBase) -> None:
    """Exclude spines from the layout computation, which takes a sixth less time without them. The
    spines lie within the axes, as ticks point inwards."""
    for ax in cast(Figure, figure).axes:  # a SubFigure has axes, too
        for side in _SIDES & ax.spines.keys():
            ax.spines[side].set_in_layout(False)


_SIDES = {"left", "right", "bottom", "top"}


class PowerTicks(ScalarFormatter):
    """Tick labels without their common power of ten, which stands at the end of the axis.

    Powers between ``least`` and ``most`` are written out. The power is mathematics; the digits are
    text, which is drawn in a tenth of the time. TeX's fonts have no minus sign in text, so there
    the digits are mathematics, too.
    """

    def __init__(self, least: int = -3, most: int = 3) -> None:
        super().__init__(useMathText=True)
        self.set_powerlimits((least, most))
        self._has_text = not mpl.rcParams["axes.formatter.use_mathtext"]

    def __call__(self, x: float, pos: int | None = None) -> str:
        """Return the label of a tick."""
        label = str(super().__call__(x, pos))
        if not self._has_text:
            return label
        return label.removeprefix(r"$\mathdefault{").removesuffix("}$")


_CHANGING = {".pdf": "CreationDate", ".svg": "Date"}
"""File suffix -> metadata entry that would differ each time a picture is written."""


@contextmanager
def styled(width: float = WIDTHS[2], font: str = "times") -> Iterator[None]:
    """Draw in this context with the settings of all pictures; the user's own are restored after it.

    ``width`` is that of the page's text in inches, ``font`` that of the text around the picture:
    "times", or "tex" for Computer Modern.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS | _FONTS[font] | {"figure.figsize": (width, 3.0)})
        yield


def page_width() -> float:
    """Return the width of the page's text in inches, as `styled` set it."""
    return float(mpl.rcParams["figure.figsize"][0])


def save(figure: Figure, path: Path) -> Path:
    """Write the figure to the path, with the same bytes for the same content; return the path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    if "cmr10" in mpl.rcParams["font.family"]:
        _set_in_tex(figure)
    write_atomically(path, lambda draft: _write(figure, draft), durable=False)
    return path


def _write(figure: Figure, path: Path) -> None:
    suffix = path.suffix.lower()
    if suffix == ".png":
        _write_pixels(figure, path)
        return
    figure.savefig(path, metadata={_CHANGING[suffix]: None})
    if suffix == ".svg":
        text = path.read_text(encoding="utf-8").replace("'STIXGeneral'", _FAMILIES)
        path.write_text(_with_numbered_clips(text), encoding="utf-8")


def _write_pixels(figure: Figure, path: Path) -> None:
    """Write a PNG in one drawing, which computes the layout as well; `savefig` would draw twice."""
    canvas, dpi = figure.canvas, figure.dpi
    try:
        figure.dpi = mpl.rcParams["savefig.dpi"]
        FigureCanvasAgg(figure).print_png(path, metadata={"Software": None})
    finally:
        figure.dpi = dpi
        figure.set_canvas(canvas)


def _set_in_tex(figure: Figure) -> None:
    """Replace characters in a figure's texts that TeX's text fonts lack by mathematics."""
    for text in figure.findobj(Text):
        words = text.get_text()
        parts = words.split("$") if text.get_parse_math() else [words]
        if any(map(_NOT_IN_TEX.search, parts[::2])):
            parts[::2] = [_NOT_IN_TEX.sub(_as_mathematics, part) for part in parts[::2]]
            text.set_text("$".join(parts))
            text.set_parse_math(True)


def _as_mathematics(found: re.Match[str]) -> str:
    """Return the Matplotlib markup for a character matched by `_NOT_IN_TEX`."""
    return {"$": r"\$", "\\": r"$\backslash$", '"': "''"}.get(
        found[0], rf"$\{found[0]}$" if found[0] in "_{}" else f"${found[0]}$"
    )


def _with_numbered_clips(text: str) -> str:
    """Return an SVG's text with numbered clipping paths. Matplotlib names them after the last bits
    of a layout, which differ between drawings."""
    for index, name in enumerate(re.findall(r'<clipPath id="(p[0-9a-f]{10})">', text)):
        text = text.replace(name, f"clip{index}")
    return text
