"""How figures look: sizes, fonts, and colours that colour-blind readers can tell apart."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

TEXT_WIDTH = 6.5
"""Width of the report's text, in inches; figures are drawn at the size at which they are set."""

NUMERICAL: dict[str, Any] = {"color": "blue", "linestyle": "-", "linewidth": 1.0}
"""The lattice's own strain, as in the paper."""

ANALYTICAL: dict[str, Any] = {"color": "red", "linestyle": "--", "linewidth": 1.0, "dashes": (4, 3)}
"""The mKdV wave, as in the paper."""

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
    "font.family": "STIXGeneral",
    "font.size": 10.0,
    "axes.titlesize": 10.0,
    "axes.labelsize": 10.0,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 9.0,
    "mathtext.fontset": "stix",
    "lines.markersize": 3.0,
    "lines.linewidth": 1.2,
    "axes.linewidth": 0.6,
    "legend.frameon": False,
    "pdf.fonttype": 42,
    "svg.hashsalt": "longwave",
    "savefig.dpi": 160,
}


_CHANGING = {".pdf": "CreationDate", ".svg": "Date"}
"""What a picture's metadata would say differently each time, by suffix."""


@contextmanager
def styled() -> Iterator[None]:
    """Draw with the report's settings, whatever the user's own are; nothing leaks out."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(_SETTINGS)
        yield


def save(figure: Figure, path: Path) -> Path:
    """Write the figure to the path, the same bytes for the same content; return the path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    undated = {_CHANGING.get(path.suffix.lower(), "Software"): None}
    figure.savefig(path, metadata=undated)
    return path
