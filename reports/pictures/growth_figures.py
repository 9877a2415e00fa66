"""Pictures of growth rates: over the carrier's wavenumber beside the modulation map, and of a run.

Rates that were measured where plane waves are stable in theory are hollow; carriers of which none
could be measured bear a cross on the axis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import CURVES

Array = NDArray[np.float64]

STABLE, UNKNOWN = "#d9d9d9", "#a6a6a6"
"""Behind wavenumbers of stable plane waves, and of those without an NLS equation."""

PANEL_HEIGHT = 2.3
"""Height in inches of a row's two panels."""

LEGEND_HEIGHT = 0.45
"""Height in inches of the legend."""

LEGEND_LETTERS = 88
"""In a line of the legend, with four curves side by side."""


@dataclass(frozen=True)
class GrowthCurve:
    """Rates at carriers ``k``, how far each may be off, rates in theory, and ``kappa``.

    NaN where there is no run: ``failed`` says whether there was an attempt. ``line`` is the key of
    its theory among the curves of the map.
    """

    label: str
    line: str
    k: Array
    rate: Array
    bars: Array
    theory: Array
    kappa: Array
    failed: NDArray[np.bool_]


@dataclass(frozen=True)
class ModulationMap:
    """Growth rates in theory: over ``k`` those of the measured kinds, by the ``line`` of what was
    measured, and over ``k`` and ``kappa`` those of all. ``product``: p q; NaN where there is no
    equation.
    """

    k: Array
    curves: Mapping[str, Array]
    product: Array
    kappa: Array
    rates: Array


@dataclass(frozen=True)
class GrowthPanel:
    """Measured rates beside the one map of all their cells, None if it cannot be derived."""

    title: str
    curves: Sequence[GrowthCurve]
    theory: ModulationMap | None


def growth_height(count: int) -> float:
    """Height in inches of that many rows."""
    return PANEL_HEIGHT * count + LEGEND_HEIGHT


def draw_growth(figure: FigureBase, panels: Sequence[GrowthPanel]) -> None:
    """Draw a row for each panel: rates over k, and the map of all perturbations."""
    grid = figure.subplots(len(panels), 2, squeeze=False, sharex=True)
    looks = _looks(panels)
    for (left, right), panel in zip(grid, panels, strict=True):
        left.set_title(panel.title, loc="left", parse_math=False)
        left.set_ylabel("growth rate in $T$")
        top = _set_rates(left, panel)
        _draw_rates(left, panel, looks)
        if panel.theory is None:
            right.set_visible(False)
            continue
        _draw_bands(left, panel, panel.theory, looks)
        _draw_map(figure, right, panel, top)
    for ax in grid[-1]:
        ax.set_xlabel("carrier wavenumber $k$")
        ax.set_xticks([0, np.pi / 2, np.pi], ["0", r"$\pi/2$", r"$\pi$"])
        ax.set_xlim(0.0, np.pi)
    columns = max(1, min(4, LEGEND_LETTERS // max(map(len, looks))) if any(looks) else 4)
    figure.legend(handles=_legend(panels, looks), loc="outside lower center", ncols=columns)


Looks = Mapping[str, Mapping[str, Any]]
"""Colours, lines and markers of curves by their labels, the same in all panels."""


def _looks(panels: Sequence[GrowthPanel]) -> Looks:
    labels = dict.fromkeys(curve.label for panel in panels for curve in panel.curves)
    return {label: CURVES[number % len(CURVES)] for number, label in enumerate(labels)}


def _theory_looks(panel: GrowthPanel, looks: Looks) -> dict[str, dict[str, Any]]:
    """Of each line of theory: black if it is the only one, else as the first curve it is of."""
    first: dict[str, str] = {}
    for curve in panel.curves:
        first.setdefault(curve.line, curve.label)
    if len(first) == 1:
        return {line: {"color": "black", "linestyle": "-"} for line in first}
    return {
        line: {key: looks[label][key] for key in ("color", "linestyle")}
        for line, label in first.items()
    }


def _draw_rates(ax: Axes, panel: GrowthPanel, looks: Looks) -> None:
    theory = _theory_looks(panel, looks)
    for curve in panel.curves:
        colour, marker = (looks[curve.label][key] for key in ("color", "marker"))
        grows = curve.theory > 0.0
        for inside, face in ((grows, colour), (~grows, "white")):
            ax.errorbar(
                curve.k[inside],
                curve.rate[inside],
                curve.bars[inside],
                linestyle="",
                color=colour,
                marker=marker,
                markersize=4.0,
                markerfacecolor=face,
                capsize=2.0,
                zorder=3,
            )
        ax.plot(curve.k[curve.failed], 0.0 * curve.k[curve.failed], "kx", markersize=5.0, zorder=4)
        if panel.theory is None:
            order = np.argsort(curve.k)
            ax.plot(curve.k[order], curve.theory[order], linewidth=1.0, **theory[curve.line])


def _draw_bands(ax: Axes, panel: GrowthPanel, found: ModulationMap, looks: Looks) -> None:
    """The theory's curves, and behind them where plane waves are stable or have no equation."""
    theory = _theory_looks(panel, looks)
    for line, curve in found.curves.items():
        ax.plot(found.k, curve, linewidth=1.0, **theory[line])
    for inside, colour in ((found.product <= 0, STABLE), (np.isnan(found.product), UNKNOWN)):
        ax.fill_between(
            *(found.k, 0.0, 1.0, inside),
            transform=ax.get_xaxis_transform(),
            color=colour,
            linewidth=0.0,
            zorder=0,
        )


def _set_rates(ax: Axes, panel: GrowthPanel) -> float:
    """Have the axis show all rates that were measured, and the theory there; its upper end.

    The theory's curve may go beyond any, beside a resonance.
    """
    parts = [part for c in panel.curves for part in (c.rate + c.bars, c.theory)]
    known = np.concatenate(parts)
    known = known[np.isfinite(known)]
    top = 1.1 * float(known.max()) if known.size and known.max() > 0.0 else 1.0
    ax.set_ylim(-0.08 * top, top)
    return top


def _draw_map(figure: FigureBase, ax: Axes, panel: GrowthPanel, top: float) -> None:
    """Rates of all perturbations in theory, and those measured as points in the same colours."""
    found = panel.theory
    assert found is not None
    ax.set_facecolor(STABLE)
    growing = np.ma.masked_where(~(found.rates > 0.0), found.rates)
    colours = Normalize(0.0, top)
    drawn = ax.pcolormesh(found.k, found.kappa, growing, norm=colours, rasterized=True)
    for curve in panel.curves:
        ax.scatter(
            *(curve.k, curve.kappa, 14.0),
            c=np.maximum(curve.rate, 0.0),
            norm=colours,
            edgecolors="white",
            linewidths=0.6,
            zorder=3,
        )
    ax.set_ylim(0.0, float(found.kappa[-1]))
    ax.set_ylabel(r"$\kappa$ of the perturbation")
    extend = "max" if np.nanmax(found.rates) > top else "neither"
    figure.colorbar(drawn, ax=ax, label="growth rate in $T$", extend=extend)


def _legend(panels: Sequence[GrowthPanel], looks: Looks) -> list[Line2D | Patch]:
    """Each curve's marker, over its line of theory where a panel has several."""
    handles: list[Line2D | Patch] = []
    several = [_theory_looks(p, looks) for p in panels if len({c.line for c in p.curves}) > 1]
    lines = {line: look for found in reversed(several) for line, look in found.items()}
    for label, curve in {c.label: c for panel in panels for c in panel.curves}.items():
        colour, marker = looks[label]["color"], looks[label]["marker"]
        line = lines.get(curve.line, {"color": colour, "linestyle": ""})
        face = {"marker": marker, "markerfacecolor": colour, "markeredgecolor": colour}
        handles.append(Line2D([], [], label=label or "lattice", **line, **face))
    bare = {"linestyle": "", "marker": "o", "color": "black", "markerfacecolor": "white"}
    handles += [
        Line2D([], [], label="the same, stable in theory", **bare),  # type: ignore[arg-type]
        Line2D([], [], color="black", linewidth=1.0, label="theory"),
        Patch(color=STABLE, label="stable in theory"),
    ]
    curves = [curve for panel in panels for curve in panel.curves]
    if any(np.any(curve.failed) for curve in curves):
        handles.append(Line2D([], [], linestyle="", marker="x", color="black", label="no run"))
    maps = [panel.theory for panel in panels if panel.theory is not None]
    if any(np.isnan(found.product).any() for found in maps):
        handles.append(Patch(color=UNKNOWN, label="no NLS equation"))
    return handles


SIZES_HEIGHT = 2.8
"""Height in inches of `draw_sideband_sizes`."""


def draw_sideband_sizes(
    figure: FigureBase, slow_times: Array, sizes: Array, theory: Array, verdict: str
) -> None:
    """The two waves beside a carrier over the slow time, in a logarithm, and in theory."""
    ax = figure.subplots()
    ax.semilogy(slow_times, sizes, label="lattice", **(CURVES[0] | {"linestyle": ""}))
    ax.semilogy(slow_times, theory, color="black", linewidth=1.0, label="theory, from the first")
    ax.set_xlabel("$T$")
    ax.set_ylabel("sidebands over carrier")
    ax.set_title(verdict, loc="left", parse_math=False, fontsize="small")
    ax.legend()
