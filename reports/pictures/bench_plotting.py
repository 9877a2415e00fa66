"""Pictures of a chain on a bench: sensor readings and spectra, energies, fluxes and cells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import add_legend, even_places
from longwave.reports.pictures.style import CURVES, part
from longwave.scenes.description.bench import MEAN_SUFFIXES
from longwave.support.labelled_arrays import select

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import FigureBase

    from longwave.support.labelled_arrays import LabelledArrays, LabelledValues

Array = NDArray[np.float64]

MOST_LINES = len(CURVES)
"""Most lines in a panel; of more lines, evenly spaced ones are drawn."""

PANEL = 1.9
"""Height of a panel in inches."""

LEAST_READINGS = 32
"""Fewest evenly spaced readings for which a spectrum is drawn."""

LEAST_POWER = 1e-2
"""Least amplitude of the first sensor at which ratios are drawn.

It is in units of the largest amplitude of the other sensors.
"""

BALANCE = ("energy", "work", "heat")


def _readings(data: LabelledArrays) -> list[str]:
    return [
        name for name in data if name.startswith("sensor_") and not name.endswith(MEAN_SUFFIXES)
    ]


@part(lambda data: 0.4 + PANEL * len(_readings(data)))
def sensor_readings(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the readings of each sensor over time, in one panel for each quantity."""
    names = _readings(data)
    panels = figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0]
    for ax, name in zip(panels, names, strict=True):
        _lines(ax, data, name, "sensor")
    panels[-1].set_xlabel("$t$")
    _name_lines(figure, panels[0], data, "sensor", "cell {}")


@part(0.4 + 1.4 * PANEL)
def energy_balance(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the energy, and the work of walls and forces and the heat since the start, over time."""
    ax = figure.subplots()
    for name, look in zip(BALANCE, CURVES, strict=False):
        label = data[name].attrs["long_name"]
        ax.plot(data["time"].values, data[name].values, label=label, **look | {"marker": ""})
    ax.set_xlabel("$t$")
    ax.set_ylabel(f"energy ({data['energy'].attrs['units']})")
    ax.legend()


@part(0.4 + 2 * PANEL)
def fluxes(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the power through bonds over time, and the energy transmitted until then."""
    panels = figure.subplots(2, 1, sharex=True)
    for ax, name in zip(panels, ("flux", "transmitted"), strict=True):
        _lines(ax, data, name, "cut")
    panels[-1].set_xlabel("$t$")
    _name_lines(figure, panels[0], data, "cut", "right of cell {}")


def has_spectra(data: LabelledArrays) -> bool:
    """Return whether there are `LEAST_READINGS` times or more, evenly spaced, as for a spectrum."""
    gaps = np.diff(data["time"].values)
    return gaps.size >= LEAST_READINGS and bool(np.ptp(gaps) <= 1e-6 * gaps.max())


def amplitude_spectra(times: Array, values: Array) -> tuple[Array, Array]:
    """Return angular frequencies and the sensors' amplitudes at them, of shape (frequency, sensor).

    ``values`` are readings of shape (time, sensor). Their weighted mean is subtracted and Hann's
    window applied, scaled such that a sine keeps its amplitude.
    """
    window = np.sin(np.pi * np.arange(times.size) / times.size)[:, np.newaxis] ** 2
    window /= window.sum()
    spectrum = np.fft.rfft(window * (values - np.sum(window * values, axis=0)), axis=0)
    return 2.0 * np.pi * np.fft.rfftfreq(times.size, times[1] - times[0]), 2.0 * np.abs(spectrum)


@part(0.4 + 2 * PANEL)
def sensor_spectra(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw each sensor's amplitude over frequency, and its ratio to the first sensor's."""
    name = _readings(data)[0]
    frequencies, amplitudes = _visible_part(
        *amplitude_spectra(data["time"].values, _first_series(data[name], "time", "sensor"))
    )
    first = amplitudes[:, :1]
    is_significant = first > LEAST_POWER * first[1:].max()
    with np.errstate(invalid="ignore", divide="ignore"):
        ratios = np.where(is_significant, amplitudes / first, np.nan)
    cells, attributes = data["sensor"].values, data[name].attrs
    panels = figure.subplots(min(cells.size, 2), 1, sharex=True, squeeze=False)[:, 0]
    panels[0].set_ylabel(f"amplitude of {attributes['long_name']}\n({attributes['units']})")
    for count, index in enumerate(even_places(cells.size, MOST_LINES)):
        look = CURVES[count] | {"marker": ""}
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


LEAST_VISIBLE = 1e-5
"""Share of the largest amplitude below which the last frequencies are cut off."""


def _visible_part(frequencies: Array, amplitudes: Array) -> tuple[Array, Array]:
    """Return the spectra up to the last frequency with a visible amplitude (`LEAST_VISIBLE`)."""
    largest = amplitudes[1:].max(axis=1)
    end = 2 + int(np.flatnonzero(largest >= LEAST_VISIBLE * largest.max())[-1])
    return frequencies[:end], amplitudes[:end]


@part(0.4 + 1.4 * PANEL)
def mode_energies(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the energies of the modes over time."""
    ax = figure.subplots()
    _lines(ax, data, "mode_energy", "mode")
    ax.set_xlabel("$t$")
    _name_lines(figure, ax, data, "mode", "mode {}")


@part(0.4 + 1.4 * PANEL)
def cells_at_times(figure: FigureBase, data: LabelledArrays) -> None:
    """Draw the displacement of all cells at some times."""
    ax = figure.subplots()
    _lines(ax, data, "displacement", "time", along="cell")
    ax.set_xlabel("$n$")
    _name_lines(figure, ax, data, "time", "$t = {:g}$")


def _first_series(values: LabelledValues, *dimensions: str) -> Array:
    """Return values over ``dimensions``, at index 0 of all other dimensions (fields or bonds)."""
    first = select(values, dict.fromkeys(set(values.dims) - set(dimensions), 0))
    return np.transpose(first.values, [first.dims.index(name) for name in dimensions])


def _lines(ax: Axes, data: LabelledArrays, name: str, each: str, along: str = "time") -> None:
    """Draw a line over ``along`` for each index of the dimension ``each``.

    Of several fields or bonds the first is drawn. A variable NAME_error adds a band to the line.
    """
    values = _first_series(data[name], each, along)
    bars = _first_series(data[f"{name}_error"], each, along) if f"{name}_error" in data else None
    axis = data[along].values if along in data else np.arange(values.shape[1])
    for count, index in enumerate(even_places(len(values), MOST_LINES)):
        look = {key: value for key, value in CURVES[count].items() if key != "marker"}
        line = values[index]
        if bars is not None:
            half = bars[index]
            ax.fill_between(axis, line - half, line + half, color=look["color"], alpha=0.2)
        ax.plot(axis, line, **look)
    ax.margins(x=0.0)
    ax.set_ylabel(f"{data[name].attrs['long_name']}")


def _name_lines(figure: FigureBase, ax: Axes, data: LabelledArrays, each: str, label: str) -> None:
    """Draw one legend above all panels, which names each line by its coordinate ``each``."""
    for line, place in zip(ax.lines, even_places(data.sizes[each], MOST_LINES), strict=True):
        line.set_label(label.format(data[each].values[place]))
    add_legend(figure, {str(line.get_label()): line for line in ax.lines})
