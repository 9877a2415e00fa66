"""Pictures of a chain on a bench: sensor readings and spectra, energies, fluxes and cells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import add_legend, even_indices
from longwave.reports.pictures.style import CURVES, part
from longwave.scenes.description.bench import MEAN_SUFFIXES
from longwave.support.labelled_arrays import select

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

    from longwave.support.labelled_arrays import LabelledArrays, LabelledValues

Array = NDArray[np.float64]

MAX_LINES = len(CURVES)
"""Largest number of lines in a panel; of more lines, an evenly spaced selection is drawn."""

PANEL_HEIGHT = 1.9
"""Height of a panel in inches."""

MIN_READINGS = 32
"""Fewest evenly spaced readings for which a spectrum is drawn."""

MIN_RATIO_AMPLITUDE = 1e-2
"""Fraction of the first sensor's largest amplitude below which ratios to it are not drawn."""

BALANCE = ("energy", "work", "heat")
"""Variables of the energy balance."""


def _readings(data: LabelledArrays) -> list[str]:
    return [
        name for name in data if name.startswith("sensor_") and not name.endswith(MEAN_SUFFIXES)
    ]


@part(lambda data: 0.4 + PANEL_HEIGHT * len(_readings(data)))
def sensor_readings(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the readings of each sensor over time, in one panel for each quantity."""
    _line_panels(figure, data, _readings(data), "sensor", "cell {}")


@part(0.4 + 1.4 * PANEL_HEIGHT)
def energy_balance(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the energy, and the work of walls and forces and the heat since the start, over time."""
    ax = figure.subplots()
    for name, look in zip(BALANCE, CURVES, strict=False):
        label = data[name].attrs["long_name"]
        ax.plot(data["time"].values, data[name].values, label=label, **look | {"marker": ""})
    ax.set(xlabel="$t$", ylabel=f"energy ({data['energy'].attrs['units']})")
    ax.legend()


@part(0.4 + 2 * PANEL_HEIGHT)
def fluxes(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the power through bonds over time, and the energy transmitted up to each time."""
    _line_panels(figure, data, ("flux", "transmitted"), "cut", "right of cell {}")


def has_spectra(data: LabelledArrays) -> bool:
    """Return whether a run has at least `MIN_READINGS` evenly spaced times, as spectra require."""
    gaps = np.diff(data["time"].values)
    return gaps.size >= MIN_READINGS and bool(np.ptp(gaps) <= 1e-6 * gaps.max())


def amplitude_spectra(times: Array, values: Array) -> tuple[Array, Array]:
    """Return angular frequencies and the sensors' amplitudes at them, of shape (frequency, sensor).

    ``values`` are readings of shape (time, sensor). Their weighted mean is subtracted and Hann's
    window applied, scaled such that a sine keeps its amplitude.
    """
    window = np.sin(np.pi * np.arange(times.size) / times.size)[:, np.newaxis] ** 2
    window /= window.sum()
    spectrum = np.fft.rfft(window * (values - np.sum(window * values, axis=0)), axis=0)
    return 2.0 * np.pi * np.fft.rfftfreq(times.size, times[1] - times[0]), 2.0 * np.abs(spectrum)


@part(0.4 + 2 * PANEL_HEIGHT)
def sensor_spectra(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw each sensor's amplitude over frequency, and its ratio to the first sensor's."""
    name = _readings(data)[0]
    frequencies, amplitudes = _visible_part(
        *amplitude_spectra(data["time"].values, _first_series(data[name], "time", "sensor"))
    )
    first = amplitudes[:, :1]
    is_significant = first > MIN_RATIO_AMPLITUDE * first[1:].max()
    with np.errstate(invalid="ignore", divide="ignore"):
        ratios = np.where(is_significant, amplitudes / first, np.nan)
    cells, attributes = data["sensor"].values, data[name].attrs
    panels = figure.subplots(min(cells.size, 2), 1, sharex=True, squeeze=False)[:, 0]
    panels[0].set_ylabel(f"amplitude of {attributes['long_name']}\n({attributes['units']})")
    for curve, index in zip(CURVES, even_indices(cells.size, MAX_LINES), strict=False):
        look = curve | {"marker": ""}
        panels[0].plot(frequencies[1:], amplitudes[1:, index], **look)
        if index:
            panels[1].plot(frequencies, ratios[:, index], **look | {"marker": "."})
            panels[1].set_ylabel(f"ratio to cell {cells[0]}")
    panels[-1].set_xlabel(r"frequency $\omega$  (per lattice time)")
    panels[0].set_xlim(0.0, frequencies[-1])
    for ax in panels:
        if any(np.fmax.reduce(line.get_ydata(), initial=0.0) > 0.0 for line in ax.lines):
            ax.set_yscale("log")
        low, high = ax.get_ylim()
        if low > 0.0 and high < 30.0 * low:  # powers of ten alone would say little
            ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            ax.yaxis.set_major_formatter("{x:g}")
            ax.yaxis.set_minor_formatter(NullFormatter())
    figure.align_ylabels(panels)
    _name_lines(figure, panels[0], data, "sensor", "cell {}")


MIN_VISIBLE_AMPLITUDE = 1e-5
"""Amplitude, relative to the largest, below which the highest frequencies are not drawn."""


def _visible_part(frequencies: Array, amplitudes: Array) -> tuple[Array, Array]:
    """Return frequencies and amplitudes up to just past the last visible amplitude."""
    largest = amplitudes[1:].max(axis=1)
    end = 2 + int(np.flatnonzero(largest >= MIN_VISIBLE_AMPLITUDE * largest.max())[-1])
    return frequencies[:end], amplitudes[:end]


@part(0.4 + 1.4 * PANEL_HEIGHT)
def mode_energies(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the energies of the modes over time."""
    _line_panels(figure, data, ("mode_energy",), "mode", "mode {}")


@part(0.4 + 1.4 * PANEL_HEIGHT)
def cells_at_times(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the displacement over the cells, one line for each of at most `MAX_LINES` times."""
    _line_panels(figure, data, ("displacement",), "time", "$t = {:g}$", along="cell", x="$n$")


def _line_panels(
    figure: FigureBase,
    data: LabelledArrays,
    names: Sequence[str],
    each: str,
    label: str,
    along: str = "time",
    x: str = "$t$",
) -> None:
    """Draw a panel for each variable in ``names``, a line for each index of dimension ``each``.

    The lines run over dimension ``along``, whose axis label is ``x``; ``label`` names the lines.
    """
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for ax, name in zip(panels, names, strict=True):
        _lines(ax, data, name, each, along)
    panels[-1].set_xlabel(x)
    _name_lines(figure, panels[0], data, each, label)


def _first_series(values: LabelledValues, *dimensions: str) -> Array:
    """Return values over ``dimensions``, at index 0 of all other dimensions (fields or bonds)."""
    first = select(values, dict.fromkeys(set(values.dims) - set(dimensions), 0))
    return np.transpose(first.values, [first.dims.index(name) for name in dimensions])


def _lines(ax: Axes, data: LabelledArrays, name: str, each: str, along: str) -> None:
    """Draw a variable over ``along``, one line per index of dimension ``each``. Of several fields
    or bonds the first is drawn. A variable NAME_error adds a band to the line."""
    values = _first_series(data[name], each, along)
    bars = _first_series(data[f"{name}_error"], each, along) if f"{name}_error" in data else None
    axis = data[along].values if along in data else np.arange(values.shape[1])
    for curve, index in zip(CURVES, even_indices(len(values), MAX_LINES), strict=False):
        look = {key: value for key, value in curve.items() if key != "marker"}
        line = values[index]
        if bars is not None:
            half = bars[index]
            ax.fill_between(axis, line - half, line + half, color=look["color"], alpha=0.2)
        ax.plot(axis, line, **look)
    ax.margins(x=0.0)
    ax.set_ylabel(data[name].attrs["long_name"])


def _name_lines(figure: FigureBase, ax: Axes, data: LabelledArrays, each: str, label: str) -> None:
    """Draw one legend above all panels, which names each line by its coordinate ``each``."""
    for line, index in zip(ax.lines, even_indices(data.sizes[each], MAX_LINES), strict=True):
        line.set_label(label.format(data[each].values[index]))
    add_legend(figure, {str(line.get_label()): line for line in ax.lines})
