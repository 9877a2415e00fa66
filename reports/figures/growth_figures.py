"""Pictures of growth rates: over the carrier's wavenumber beside the modulation map, and of a run.

Rates that were measured where plane waves are stable in theory are hollow; carriers of which none
could be measured bear a cross on the axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from reports.figures.drawing import CURVES

Array = NDArray[np.float64]

STABLE, UNKNOWN = "#d9d9d9", "#a6a6a6"
"""Behind wavenumbers of stable plane waves, and of those without an NLS equation."""

PANEL_HEIGHT = 2.3
"""Height in inches of a lattice's two panels."""

LEGEND_HEIGHT = 0.45
"""Height in inches of the legend."""


@dataclass(frozen=True)
class GrowthCurve:
    """Rates at carriers ``k``, how far each may be off, rates in theory, and ``kappa``.

    NaN where there is no run: ``failed`` says whether there was an attempt.
    """

    label: str
    k: Array
    rate: Array
    bars: Array
    theory: Array
    kappa: Array
    failed: NDArray[np.bool_]


@dataclass(frozen=True)
class ModulationMap:
    """Growth rates in theory: over ``k`` those of the measured kind, a row for each that differs,
    and over ``k`` and ``kappa`` those of all. ``product``: p q; NaN where there is no equation.
    """

    k: Array
    curves: Sequence[Array]
    product: Array
    kappa: Array
    rates: Array


@dataclass(frozen=True)
class GrowthPanel:
    """A lattice's measured rates beside its map, None if it cannot be derived."""

    title: str
    curves: Sequence[GrowthCurve]
    theory: ModulationMap | None


def growth_height(count: int) -> float:
    """Height in inches of that many lattices."""
    return PANEL_HEIGHT * count + LEGEND_HEIGHT


def draw_growth(figure: FigureBase, panels: Sequence[GrowthPanel]) -> None:
    """Draw a row for each lattice: rates over k, and the map of all perturbations."""
    grid = figure.subplots(len(panels), 2, squeeze=False, sharex=True)
    for (left, right), panel in zip(grid, panels, strict=True):
        left.set_title(panel.title, loc="left", parse_math=False)
        left.set_ylabel("growth rate in $T$")
        top = _set_rates(left, panel)
        _draw_rates(left, panel)
        if panel.theory is None:
            right.set_visible(False)
            continue
        _draw_bands(left, panel.theory)
        _draw_map(figure, right, panel, top)
    for ax in grid[-1]:
        ax.set_xlabel("carrier wavenumber $k$")
        ax.set_xticks([0, np.pi / 2, np.pi], ["0", r"$\pi/2$", r"$\pi$"])
        ax.set_xlim(0.0, np.pi)
    figure.legend(handles=_legend(panels), loc="outside lower center", ncols=4)


def _draw_rates(ax: Axes, panel: GrowthPanel) -> None:
    for number, curve in enumerate(panel.curves):
        colour, marker = (CURVES[number % len(CURVES)][key] for key in ("color", "marker"))
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
            ax.plot(curve.k[order], curve.theory[order], color="black", linewidth=1.0)


def _draw_bands(ax: Axes, found: ModulationMap) -> None:
    """The theory's curves, and behind them where plane waves are stable or have no equation."""
    for curve in found.curves:
        ax.plot(found.k, curve, color="black", linewidth=1.0)
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
    figure.colorbar(drawn, ax=ax, label="growth rate in $T$")


def _legend(panels: Sequence[GrowthPanel]) -> list[Line2D | Patch]:
    handles: list[Line2D | Patch] = []
    labels = {curve.label: number for p in panels for number, curve in enumerate(p.curves)}
    for label, number in labels.items():
        look = {key: CURVES[number % len(CURVES)][key] for key in ("color", "marker")}
        handles.append(Line2D([], [], linestyle="", label=label or "lattice", **look))
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
