"""The style of all pictures: widths, letters, colours, and how they are written to files.

Colours can be told apart by colour-blind readers.
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

Shown = ParamSpec("Shown")

TEXT_WIDTH = 6.5
"""Width of the report's text, in inches; figures are drawn at the size at which they are set."""

WIDTHS = {1: 3.4, 2: 7.0}
"""Widths of pictures for one column and two columns of a journal, in inches."""

LATTICE, WAVE, OWN = "#56B4E9", "#D55E00", "#E69F00"
"""The colours of the lattice, the wave in theory and a run's own error, everywhere."""

NUMERICAL: dict[str, Any] = {"color": LATTICE, "linestyle": "-", "linewidth": 2.6}
"""The lattice's own strain: a broad line, which a thin one on it does not hide."""

BEADS: dict[str, Any] = {
    "color": LATTICE,
    "linestyle": "",
    "marker": "o",
    "markersize": 3.6,
    "markeredgewidth": 0.5,
    "markeredgecolor": "#0072B2",
}
"""The same where its values can be told apart: each is a bead."""

ANALYTICAL: dict[str, Any] = {"color": WAVE, "linestyle": "-", "linewidth": 0.9}
"""The wave in theory."""

BEADS_AN_INCH = 22.0
"""Most values in an inch of a picture that are beads."""

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
"""Okabe and Ito's colours, told apart by line and marker as well."""

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
"""The letters of journals, which are Unicode and can be searched in a picture, and those of TeX."""

_FAMILIES = "STIXGeneral, 'STIX Two Text', 'Times New Roman', Times, serif"
"""What a browser shows the text of an SVG in: the first of these that it has."""

_NOT_IN_TEX = re.compile(r'[<>_|{}"\\$]')
"""Characters that TeX's letters have in other places."""


@dataclass(frozen=True)
class Part:
    """A part of a figure: its height in inches, and what draws it."""

    height: float
    draw: Callable[[FigureBase], None]

    def figure(self, width: float | None = None) -> Figure:
        """The part alone, as a figure of that width in inches; by default that of the style."""
        made = Figure((width or page_width(), self.height), layout="constrained")
        self.draw(made)
        return made


def part(
    height: float | Callable[..., float],
) -> Callable[[Callable[Concatenate[FigureBase, Shown], None]], Callable[Shown, Part]]:
    """Let the function below, which draws on a figure, return the `Part` that does so.

    The ``height``, in inches, may be a function of what is shown.
    """

    def declare(draw: Callable[Concatenate[FigureBase, Shown], None]) -> Callable[Shown, Part]:
        @wraps(draw)
        def made(*shown: Shown.args, **words: Shown.kwargs) -> Part:
            inches = height(*shown, **words) if callable(height) else height

            def draw_on(figure: FigureBase) -> None:
                draw(figure, *shown, **words)
                _leave_out_spines(figure)

            return Part(inches, draw_on)

        return made

    return declare


def _leave_out_spines(figure: FigureBase) -> None:
    """Have the search for the layout measure no spines, which takes a sixth of its time.

    Ticks point inwards, so that the four spines of axes end where the axes do.
    """
    for ax in cast(Figure, figure).axes:  # SubFigure has them, too
        for side in _SIDES & ax.spines.keys():
            ax.spines[side].set_in_layout(False)


_SIDES = {"left", "right", "bottom", "top"}


class PowerTicks(ScalarFormatter):
    """Labels of ticks less a power of ten, where it is not between two, which stands at the axis.

    The power is mathematics and the digits are text, which is set in a tenth of the time; TeX's
    letters have no minus sign in text, there digits are mathematics as well.
    """

    def __init__(self, least: int = -3, most: int = 3) -> None:
        super().__init__(useMathText=True)
        self.set_powerlimits((least, most))
        self._has_text = not mpl.rcParams["axes.formatter.use_mathtext"]

    def __call__(self, x: float, pos: int | None = None) -> str:
        """The label of a tick."""
        label = str(super().__call__(x, pos))
        if not self._has_text:
            return label
        return label.removeprefix(r"$\mathdefault{").removesuffix("}$")


_CHANGING = {".pdf": "CreationDate", ".svg": "Date"}
"""What a picture's metadata would say differently each time, by suffix."""


@contextmanager
def styled(width: float = WIDTHS[2], font: str = "times") -> Iterator[None]:
    """Draw with the settings of all pictures, whatever the user's own are; nothing leaks out.

    ``width`` is that of a page's text in inches, ``font`` the letters that stand around the
    picture: "times", or "tex" for what is set in Computer Modern.
    """
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS | _FONTS[font] | {"figure.figsize": (width, 3.0)})
        yield


def page_width() -> float:
    """The width in inches of what is drawn now."""
    return float(mpl.rcParams["figure.figsize"][0])


def save(figure: Figure, path: Path) -> Path:
    """Write the figure to the path, the same bytes for the same content; return the path."""
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
        text = path.read_text(encoding="utf-8")
        text = text.replace("'STIXGeneral'", _FAMILIES)
        path.write_text(_with_numbered_clips(text), encoding="utf-8")


def _write_pixels(figure: Figure, path: Path) -> None:
    """Write a PNG by one drawing, which lays the figure out as well: `savefig` draws it twice."""
    canvas, dpi = figure.canvas, figure.dpi
    try:
        figure.dpi = mpl.rcParams["savefig.dpi"]
        FigureCanvasAgg(figure).print_png(path, metadata={"Software": None})
    finally:
        figure.dpi = dpi
        figure.set_canvas(canvas)


def _set_in_tex(figure: Figure) -> None:
    """Set what TeX's letters lack outside of mathematics as mathematics."""
    for text in figure.findobj(Text):
        words = text.get_text()
        parts = words.split("$") if text.get_parse_math() else [words]
        if any(map(_NOT_IN_TEX.search, parts[::2])):
            parts[::2] = [_NOT_IN_TEX.sub(_as_mathematics, part) for part in parts[::2]]
            text.set_text("$".join(parts))
            text.set_parse_math(True)


def _as_mathematics(found: re.Match[str]) -> str:
    """One such character in mathematics."""
    return {"$": r"\$", "\\": r"$\backslash$", '"': "''"}.get(
        found[0], rf"$\{found[0]}$" if found[0] in "_{}" else f"${found[0]}$"
    )


def _with_numbered_clips(text: str) -> str:
    """A picture whose clipping paths are numbered: Matplotlib names them after the last bits of a
    layout, which differ from one drawing to the next."""
    for place, name in enumerate(re.findall(r'<clipPath id="(p[0-9a-f]{10})">', text)):
        text = text.replace(name, f"clip{place}")
    return text
