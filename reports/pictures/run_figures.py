"""Pictures of a run beyond the paper's: spectra, with what is below trust."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import FigureBase
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import ANALYTICAL, NUMERICAL

Array = NDArray[np.float64]

SPECTRA_ACROSS, MOST_SPECTRA = 3, 6
"""Spectra side by side, and most of them."""

SPECTRUM_HEIGHT = 1.9
"""Height of a row of spectra, in inches."""

DECADES = 1.0
"""How far below the rounding the axis of amplitudes ends."""


@dataclass(frozen=True)
class SpectrumPanel:
    """Amplitudes of lattice and wave at one time over ``wavenumber`` (1/site).

    ``rounding``: the amplitude that rounding the strain to doubles has, on average. ``own``: what
    the run's own error is at most, None if it was not measured.
    """

    title: str
    wavenumber: Array
    lattice: Array
    wave: Array
    rounding: float
    own: float | None


def spectra_height(count: int) -> float:
    """Height in inches of that many spectra and their legend."""
    return SPECTRUM_HEIGHT * -(-count // SPECTRA_ACROSS) + 0.35


def draw_spectra(figure: FigureBase, panels: Sequence[SpectrumPanel]) -> None:
    """Draw one panel for each time, all with the same axes."""
    across = min(SPECTRA_ACROSS, len(panels))
    down = -(-len(panels) // across)
    grid = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    for ax, panel in zip(grid.flat, panels, strict=False):
        _draw_spectrum(ax, panel)
    grid[0, 0].set_ylim(*_amplitude_limits(panels))
    for ax in list(grid.flat)[len(panels) :]:
        ax.set_visible(False)
    for ax in list(grid.flat)[max(0, len(panels) - across) : len(panels)]:
        ax.set_xlabel("wavenumber  (1/site)")
        ax.tick_params(labelbottom=True)
    for ax in grid[:, 0]:
        ax.set_ylabel("amplitude of $y$")
    handles = {h.get_label(): h for h in grid[0, 0].get_legend_handles_labels()[0]}
    figure.legend(handles=list(handles.values()), loc="outside upper right", ncols=len(handles))


def _draw_spectrum(ax: Axes, panel: SpectrumPanel) -> None:
    lattice, wave = (
        np.where(np.isfinite(values) & (values > 0.0), values, np.nan)
        for values in (panel.lattice, panel.wave)
    )
    if np.isfinite([lattice, wave]).any():
        ax.set_yscale("log")
    ax.plot(panel.wavenumber, lattice, label="lattice", **NUMERICAL)
    ax.plot(panel.wavenumber, wave, label="wave", **ANALYTICAL)
    if panel.own is not None and np.isfinite(panel.own):
        ax.axhspan(0.0, panel.own, color="#E69F00", alpha=0.25, lw=0, label="own error, at most")
    rounding = panel.rounding if 0.0 < panel.rounding < np.inf else np.nan
    ax.axhline(rounding, color="black", linestyle=":", linewidth=0.8, label="rounding")
    ax.set_xlim(0.0, np.pi)
    ax.set_xticks([0.0, np.pi / 2, np.pi], ["0", r"$\pi/2$", r"$\pi$"])
    ax.set_title(panel.title, loc="left")


def _amplitude_limits(panels: Sequence[SpectrumPanel]) -> tuple[float, float]:
    """From below the rounding to above all amplitudes; some range where all is constant."""
    every = np.concatenate([part for p in panels for part in (p.lattice, p.wave)])
    every = every[np.isfinite(every) & (every > 0.0)]
    high = float(every.max()) if every.size else 1.0
    floors = [p.rounding for p in panels if 0.0 < p.rounding < high]
    low = min([*floors, 0.1 * high]) / 10.0**DECADES
    return low, 3.0 * high
