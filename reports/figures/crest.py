"""The crest track: where the crest is and how high, against time."""

import xarray as xr
from matplotlib.figure import FigureBase

from reports.figures.style import CURVES

CREST_HEIGHT = 2.0
"""Height of the two panels, in inches."""

LABELS = {"crest_position": "crest at $n - c\\,t$  (sites)", "crest_strain": "$y$ at the crest"}


def draw_crest(figure: FigureBase, run: xr.Dataset) -> None:
    """Draw the crest's position and strain as points: a crest may give way to another one."""
    for ax, (name, label), look in zip(
        figure.subplots(1, len(LABELS)), LABELS.items(), CURVES, strict=False
    ):
        values = run[name]
        (time,) = values.dims
        ax.plot(values[time], values, color=look["color"], linestyle="", marker=".")
        ax.set_xlabel("$t$")
        ax.set_ylabel(label)
        ax.locator_params(axis="x", nbins=6)
        ax.ticklabel_format(axis="y", scilimits=(-3, 3), useMathText=True)
