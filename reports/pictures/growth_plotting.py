"""Growth rates of a sweep over the carrier's wavenumber beside the map in theory, and of a run.

Rates measured where plane waves are stable in theory have hollow markers. A carrier without any
measured rate has a cross on the axis.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import STABLE, WAVENUMBER_TICKS
from longwave.reports.pictures.style import CURVES, part

if TYPE_CHECKING:
    import xarray as xr

    from longwave.scenes.description.scene import Scene
    from longwave.support.labelled_arrays import LabelledArrays

Array = NDArray[np.float64]

CARRIER = "envelope.k"
"""Swept field along the x axis: the carrier's wavenumber k."""

RATE, RATE_ERROR, THEORY = "growth_rate", "growth_rate_error", "growth_rate_theory"
NEEDED = (RATE, RATE_ERROR, THEORY, "carrier_k", "perturbation_kappa")
"""Variables of the sweep that the picture requires, besides the status of the cells."""

MAX_ROWS = 6
"""Largest number of rows in a picture; each row has its own map."""

MAP_POINTS = 400
"""Number of points of a map along each axis: carrier k and perturbation kappa."""

KAPPA_MARGIN = 1.25
"""Upper end of a map's kappa axis, relative to the largest growing kappa that was run."""

NUMERICAL_FIELDS = ("eps", "order", "tolerance")
"""Swept fields that only affect the run's numerics, not the theoretical map of growth rates."""

PERTURBATION_FIELDS = ("parameters.share", "parameters.kappa")
"""Swept fields on which the theoretical curve depends, but not the map of growth rates."""

UNNAMED_FIELDS = ("lattice", "envelope.branch")
"""Swept fields whose values appear in titles without the field's name."""


def growth_panels(data: xr.Dataset, most_curves: int) -> Sequence[GrowthPanel]:
    """Return the panels of a sweep's growth rates over k: one for each map.

    A map is that of one lattice with its constants, branch and amplitude. A panel has a curve for
    each value of the other swept fields; some of these have their own panels if that leaves one
    dimension for the curves. Raises ValueError if the sweep is not over the carrier's k, or is over
    too many values.
    """
    along = _carrier_dimension(data)
    rows, lines = _rows_and_lines(data, along)
    _check_count(data, rows, MAX_ROWS, along)
    _check_count(data, lines, most_curves, along)
    dims = [*(str(name) for name in data["status"].dims if name != along), along]
    groups = [cells for _, cells in _groups(_cells(data, dims), rows)]
    titles = _titles(groups, rows)
    return [_panel(title, cells, lines) for title, cells in zip(titles, groups, strict=True)]


def _rows_and_lines(data: xr.Dataset, along: str) -> tuple[list[str], list[str]]:
    """Return the swept coordinates that tell panels apart, and those that tell curves apart.

    ``along`` is the dimension of the carrier's k.
    """
    fields = {str(n): data[n].attrs["field"] for n in data.coords if "field" in data[n].attrs}
    swept = [name for name in fields if data[name].ndim == 1 and fields[name] != CARRIER]
    chosen = [name for name in swept if fields[name] in PERTURBATION_FIELDS]
    free = [n for n in swept if _is_numerical(data, fields[n]) or n in chosen]
    rows = [name for name in swept if name not in free]
    lines = [name for name in free if data[name].dims != (along,) or name in chosen]
    others: dict[Any, list[str]] = {}
    for name in lines:
        if data[name].dims != (along,):
            others.setdefault(data[name].dims, []).append(name)

    def preference(names: Sequence[str]) -> tuple[bool, bool, int]:
        are_numbers = all(data[name].dtype.kind in "fiu" for name in names)
        return not set(names) & set(chosen), are_numbers, data[names[0]].size

    if not rows and len(others) > 1:
        rows = min(others.values(), key=preference)
    return rows, [name for name in lines if name not in rows]


def _is_numerical(data: xr.Dataset, field: str) -> bool:
    """Return whether a field only affects a run's numerics; not eps if a constant contains eps."""
    if field != "eps":
        return field in NUMERICAL_FIELDS
    columns = (data[name] for name in data.coords if data[name].dtype.kind in "UO")
    texts = [str(column.values.tolist()) for column in columns]
    with suppress(ValueError, KeyError, TypeError):
        texts.append(str(json.loads(data.attrs["sweep"])["scene"]["constants"]))
    return not any("eps" in text for text in texts)


def _check_count(data: xr.Dataset, names: Sequence[str], most: int, along: str) -> None:
    """Raise ValueError if the values of ``names`` need more than ``most`` rows or curves."""
    sizes: dict[str, int] = {}
    for dim in dict.fromkeys(str(data[name].dims[0]) for name in names):
        columns = [data[name].values.tolist() for name in names if data[name].dims == (dim,)]
        sizes[dim] = len(set(map(repr, zip(*columns, strict=True))))
    count = math.prod(sizes.values())
    if count <= most:
        return
    differing = [n for n in names if len(set(map(str, data[n].values.tolist()))) > 1]
    name = max(differing, key=lambda name: sizes[str(data[name].dims[0])])
    alone = list(sizes) == [along] and count == data.sizes[along]
    remedy = "take --kind values" if alone else f"choose with --at {name}=VALUE"
    raise ValueError(
        f"{' and '.join(differing)} must have at most {most} values beside k, got {count} "
        f"({remedy})"
    )


def _groups(cells: xr.Dataset, names: Sequence[str]) -> list[tuple[dict[str, Any], xr.Dataset]]:
    """Return (values by name, cells) for each group of cells with the same values of ``names``."""
    columns = {name: cells[name].values.tolist() for name in names}
    indices: dict[tuple[str, ...], list[int]] = {}
    for index in range(cells.sizes["cell"]):
        key = tuple(repr(column[index]) for column in columns.values())
        indices.setdefault(key, []).append(index)
    return [
        ({name: column[group[0]] for name, column in columns.items()}, cells.isel(cell=group))
        for group in indices.values()
    ]


def _carrier_dimension(data: xr.Dataset) -> str:
    """Return the dimension of the carrier's k. Raises ValueError if no field is k, or if a variable
    of `NEEDED` is missing or has other dimensions."""
    fields = {str(n): data[n].attrs.get("field") for n in data.coords if data[n].ndim == 1}
    names = [name for name, field in fields.items() if field == CARRIER]
    dims, variables = data["status"].dims, (data.get(name) for name in NEEDED)
    if not names or any(n is None or n.dims != dims or n.dtype.kind != "f" for n in variables):
        swept = ", ".join(map(str, fields.values())) or "nothing"
        raise ValueError(
            f"growth_map must be of growth rates over {CARRIER}, got a sweep over {swept} (a scene "
            'with wave = "perturbed_plane", and its k in [grid])'
        )
    return str(data[names[0]].dims[0])


def _cells(data: xr.Dataset, dims: Sequence[str]) -> xr.Dataset:
    """Return the variables of all cells in one dimension, NaN except for k where a cell has no run.
    It has the variables ``done``, and ``failed`` where an attempt to run had no result."""
    flat = data[["status", *NEEDED]].stack(cell=dims, create_index=False)
    done = flat["status"] == "done"
    coords = (flat[name] for name in flat.coords if flat[name].dims == ("cell",))
    carrier = next(column for column in coords if column.attrs.get("field") == CARRIER)
    numbers = flat[list(NEEDED)].where(done)
    wavenumbers = np.array([_number(value) for value in carrier.values.tolist()])
    numbers["carrier_k"] = numbers["carrier_k"].where(done, wavenumbers)
    failed = flat["status"].isin(("refused", "failed", "blown up"))
    return numbers.assign(done=done, failed=failed).assign_attrs(data.attrs)


def _titles(parts: Sequence[xr.Dataset], names: Sequence[str]) -> list[str]:
    """Return a title for each panel: those values of ``names`` that differ between the panels.

    Values that are tables are included only if the titles would be equal without them.
    """
    scalar = [str(name) for name in parts[0].coords if parts[0][name].ndim == 0]
    fields = {name: parts[0][name].attrs.get("field", name) for name in (*names, *scalar)}
    unnamed = [name for field in UNNAMED_FIELDS for name in fields if fields[name] == field]
    titles, short, tables = [], [], []
    for cells in parts:
        first = {name: cells[name].values.ravel().tolist()[0] for name in fields}
        titles.append(", ".join(str(first[name]) for name in unnamed))
        entries = {name: _value(first[name]) for name in names if name not in unnamed}
        short.append({n: v for n, v in entries.items() if not isinstance(v, dict)})
        tables.append({k: v for e in entries.values() if isinstance(e, dict) for k, v in e.items()})
    titles = _with_differences(titles, short)
    return titles if len(set(titles)) == len(titles) else _with_differences(titles, tables)


def _with_differences(titles: Sequence[str], tables: Sequence[dict[str, Any]]) -> list[str]:
    """Return each title followed by those entries of its table that differ between the tables."""
    names = dict.fromkeys(name for table in tables for name in table)
    differing = [name for name in names if len({repr(table.get(name)) for table in tables}) > 1]
    texts = (_assignments({n: table[n] for n in differing if n in table}) for table in tables)
    return [", ".join(filter(None, both)) for both in zip(titles, texts, strict=True)]


def _assignments(values: Mapping[str, Any]) -> str:
    """Return values with their names, such as "eps = 0.1, order = 2"."""
    return ", ".join(
        f"{name} = {value:g}" if isinstance(value, int | float) else f"{name} = {value}"
        for name, value in values.items()
    )


def _panel(title: str, cells: xr.Dataset, lines: Sequence[str]) -> GrowthPanel:
    """Return a panel of cells with the same map; coordinates ``lines`` tell its curves apart."""
    chosen = [name for name in lines if cells[name].attrs.get("field") in PERTURBATION_FIELDS]
    curves = []
    for values, curve in _groups(cells, lines):
        line = _assignments({name: values[name] for name in chosen})
        curves.append(curve.assign_attrs(label=_assignments(values), line=line))
    return GrowthPanel(title, curves, _theory(curves))


def _number(value: float | str) -> float:
    """Return a wavenumber written as number or expression in a file; NaN if it is not valid."""
    from longwave.derive.algebra.formula_expression import exact_value

    try:
        return float(exact_value("k", value))
    except (ValueError, TypeError):
        return np.nan


def _theory(curves: Sequence[xr.Dataset]) -> xr.Dataset | None:
    """Return the map in theory of the curves' lattice; None if no scene or map can be built.

    It has the growth ``rates`` over ``kappa`` and ``k``, the ``lines`` of rates over k for the
    measured kinds of perturbation, and the ``product`` p q of the NLS coefficients, NaN where there
    is no NLS equation.
    """
    from longwave.scenes.engines.sideband_growth import plane_wave_numbers
    from longwave.scenes.modulation import scene_modulation
    from longwave.scenes.starts.perturbed_plane import chosen_kappa

    k = np.linspace(0.0, np.pi, MAP_POINTS + 1)[1:]
    lines: dict[str, Array] = {}
    first = None
    for curve in curves:
        if curve.attrs["line"] in lines:
            continue
        with suppress(ValueError):
            scene = _scene(curve.isel(cell=int(np.argmax(curve["done"].values))))
            given = plane_wave_numbers(scene)
            first = first or (scene_modulation(scene, k, given["amplitude"]), given["amplitude"])
            grid, amplitude = first
            kappa = chosen_kappa(grid.p, grid.q, given)
            lines[curve.attrs["line"]] = _rates(grid.p, grid.q, amplitude, kappa)
    if first is None:
        return None
    grid, amplitude = first
    run, theory = (
        np.concatenate([curve[n].values for curve in curves])
        for n in ("perturbation_kappa", THEORY)
    )
    growing = run[theory > 0.0]
    kappas_run = growing if growing.size else run[np.isfinite(run)]
    largest = float(np.max(kappas_run, initial=0.0)) or 1.0
    kappas = np.linspace(0.0, KAPPA_MARGIN * largest, MAP_POINTS)
    rates = _rates(grid.p, grid.q, amplitude, kappas[:, None])
    import xarray as xr  # a sweep is one already

    variables: dict[str, Any] = {"lines": (("line", "k"), list(lines.values()))}
    variables |= {"product": ("k", grid.product), "rates": (("kappa", "k"), rates)}
    return xr.Dataset(variables, {"line": list(lines), "k": k, "kappa": kappas})


def _rates(p: Array, q: Array, amplitude: float, kappa: Array | float) -> Array:
    """Return growth rates in T of perturbations with wavenumber ``kappa`` by the NLS equation.

    ``p`` and ``q`` are its coefficients; the rate is 0 where a perturbation does not grow.
    """
    from longwave.scenes.starts.perturbed_plane import squared_rate

    with np.errstate(all="ignore"):
        return np.asarray(np.sqrt(np.maximum(squared_rate(p, q, amplitude, kappa), 0.0)))


def _scene(cell: xr.Dataset) -> Scene:
    """Return the scene of one cell; ValueError if the data set does not contain its sweep."""
    from longwave.runs.sweep_scene import changed_document, make_scene

    try:
        document = json.loads(cell.attrs["sweep"])["scene"]
        changes = {
            str(cell[name].attrs["field"]): _value(cell[name].item())
            for name in cell.coords
            if "field" in cell[name].attrs
        }
        return make_scene(changed_document(document, changes), "scene", Path())
    except (KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"sweep must hold its scene, got {error}") from None


def _value(value: Any) -> Any:
    """Return a field's value; lists and tables are parsed from JSON."""
    if isinstance(value, str) and value[:1] in ("[", "{"):
        return json.loads(value)
    return value


UNKNOWN = "#a6a6a6"
"""Colour of the carrier wavenumbers at which no NLS equation can be derived."""

LEGEND_LETTERS = 88
"""Number of letters that fit into a row of the legend, which has up to four entries."""


@dataclass(frozen=True)
class GrowthPanel:
    """A panel: measured rates, and the map in theory that all its cells share.

    Each curve has a ``label`` and the name of its ``line`` in theory. ``theory`` is the map, None
    if it cannot be derived.
    """

    title: str
    curves: Sequence[xr.Dataset]
    theory: xr.Dataset | None


@part(lambda panels: 2.3 * len(panels) + 0.45)
def growth_map(figure: FigureBase, panels: Sequence[GrowthPanel]) -> None:
    """Draw a row for each of `growth_panels`: rates over k, and the map of all perturbations."""
    grid = figure.subplots(len(panels), 2, squeeze=False, sharex=True)
    labels = dict.fromkeys(curve.attrs["label"] for panel in panels for curve in panel.curves)
    looks = {label: CURVES[index % len(CURVES)] for index, label in enumerate(labels)}
    for (left, right), panel in zip(grid, panels, strict=True):
        left.set_title(panel.title, loc="left", parse_math=False)
        left.set_ylabel("growth rate in $T$")
        top = _set_rates(left, panel)
        _draw_rates(left, panel, looks)
        if panel.theory is None:
            right.set_visible(False)
        else:
            _draw_map(figure, right, panel, top)
    for ax in grid[-1]:
        ax.set_xlabel("carrier wavenumber $k$")
        ax.set_xticks(*WAVENUMBER_TICKS)
        ax.set_xlim(0.0, np.pi)
    columns = max(1, min(4, LEGEND_LETTERS // max(map(len, looks))) if any(looks) else 4)
    figure.legend(handles=_legend(panels, looks), loc="outside lower center", ncols=columns)


Looks = Mapping[str, Mapping[str, Any]]
"""Curve label -> Matplotlib colour, line style and marker; the same in all panels."""


def _theory_looks(panel: GrowthPanel, looks: Looks) -> dict[str, dict[str, Any]]:
    """Return the look of each line in theory: that of its first curve, or black if it is alone."""
    first: dict[str, str] = {}
    for curve in panel.curves:
        first.setdefault(curve.attrs["line"], curve.attrs["label"])
    if len(first) == 1:
        return {line: {"color": "black", "linestyle": "-"} for line in first}
    return {
        line: {key: looks[label][key] for key in ("color", "linestyle")}
        for line, label in first.items()
    }


def _draw_rates(ax: Axes, panel: GrowthPanel, looks: Looks) -> None:
    """Draw measured rates and theoretical curves, on grey where plane carrier waves are stable."""
    theory = _theory_looks(panel, looks)
    for curve in panel.curves:
        colour, marker = (looks[curve.attrs["label"]][key] for key in ("color", "marker"))
        grows = curve[THEORY].values > 0.0
        look: dict[str, Any] = {"marker": marker, "markersize": 4.0, "color": colour, "zorder": 3}
        for inside, face in ((grows, colour), (~grows, "white")):
            k, rate, error = (curve[n].values[inside] for n in ("carrier_k", RATE, RATE_ERROR))
            ax.errorbar(k, rate, error, linestyle="", markerfacecolor=face, capsize=2.0, **look)
        failed = curve["carrier_k"].values[curve["failed"].values]
        ax.plot(failed, 0.0 * failed, "kx", markersize=5.0, zorder=4)
        if panel.theory is None:
            along = curve.sortby("carrier_k")
            look = theory[curve.attrs["line"]]
            ax.plot(along["carrier_k"].values, along[THEORY].values, linewidth=1.0, **look)
    if panel.theory is None:
        return
    k, product = panel.theory["k"].values, panel.theory["product"].values
    lines = panel.theory["lines"]
    for line, curve_of_line in zip(lines["line"].values.tolist(), lines.values, strict=True):
        ax.plot(k, curve_of_line, linewidth=1.0, **theory[line])
    for inside, colour in ((product <= 0, STABLE), (np.isnan(product), UNKNOWN)):
        look = {"transform": ax.get_xaxis_transform(), "color": colour, "zorder": 0}
        ax.fill_between(k, 0.0, 1.0, inside, linewidth=0.0, **look)


def _set_rates(ax: Axes, panel: GrowthPanel) -> float:
    """Set the limits of the rate axis to the measured rates and their theory; return the upper
    one. The curve in theory may exceed it next to a resonance."""
    known = np.concatenate([v for c in panel.curves for v in (c[RATE] + c[RATE_ERROR], c[THEORY])])
    known = known[np.isfinite(known)]
    top = 1.1 * float(known.max()) if known.size and known.max() > 0.0 else 1.0
    ax.set_ylim(-0.08 * top, top)
    return top


def _draw_map(figure: FigureBase, ax: Axes, panel: GrowthPanel, top: float) -> None:
    """Draw a map of theoretical rates, coloured from 0 to ``top``, and measured rates as points."""
    assert panel.theory is not None
    k, kappa, rates = (panel.theory[name].values for name in ("k", "kappa", "rates"))
    ax.set_facecolor(STABLE)
    colours = Normalize(0.0, top)
    growing = np.ma.masked_where(~(rates > 0.0), rates)
    extent: Any = (0.0, float(k[-1]), 0.0, float(kappa[-1]))
    image = ax.imshow(growing, norm=colours, extent=extent, origin="lower", aspect="auto")
    for curve in panel.curves:
        look: dict[str, Any] = {"norm": colours, "edgecolors": "white", "linewidths": 0.6}
        x, y = (curve[name].values for name in ("carrier_k", "perturbation_kappa"))
        ax.scatter(x, y, 14.0, c=np.maximum(curve[RATE].values, 0.0), zorder=3, **look)
    ax.set_ylim(0.0, float(kappa[-1]))
    ax.set_ylabel(r"$\kappa$ of the perturbation")
    extend = "max" if np.nanmax(rates) > top else "neither"
    figure.colorbar(image, ax=ax, label="growth rate in $T$", extend=extend)


def _legend(panels: Sequence[GrowthPanel], looks: Looks) -> list[Line2D | Patch]:
    """Return the legend's handles: for each curve its marker, drawn on its theoretical line."""
    handles: list[Line2D | Patch] = []
    several = [
        _theory_looks(p, looks) for p in panels if len({c.attrs["line"] for c in p.curves}) > 1
    ]
    lines = {
        line: look for looks_of_lines in reversed(several) for line, look in looks_of_lines.items()
    }
    for label, curve in {c.attrs["label"]: c for p in panels for c in p.curves}.items():
        colour, marker = looks[label]["color"], looks[label]["marker"]
        line = lines.get(curve.attrs["line"], {"color": colour, "linestyle": ""})
        face = {"marker": marker, "markerfacecolor": colour, "markeredgecolor": colour}
        handles.append(Line2D([], [], label=label or "lattice", **line, **face))
    bare = {"linestyle": "", "marker": "o", "color": "black", "markerfacecolor": "white"}
    handles += [
        Line2D([], [], label="the same, stable in theory", **bare),  # type: ignore[arg-type]
        Line2D([], [], color="black", linewidth=1.0, label="theory"),
        Patch(color=STABLE, label="stable in theory"),
    ]
    curves = [curve for panel in panels for curve in panel.curves]
    if any(curve["failed"].any() for curve in curves):
        handles.append(Line2D([], [], linestyle="", marker="x", color="black", label="no run"))
    maps = [panel.theory for panel in panels if panel.theory is not None]
    if any(theory["product"].isnull().any() for theory in maps):
        handles.append(Patch(color=UNKNOWN, label="no NLS equation"))
    return handles


@part(2.8)
def sideband_sizes(figure: FigureBase, run: LabelledArrays, verdict: str) -> None:
    """Draw measured and theoretical sidebands over slow time, relative to the carrier.

    The text ``verdict`` is the title.
    """
    ax, slow_times = figure.subplots(), run["slow_time"].values
    look = CURVES[0] | {"linestyle": ""}
    ax.semilogy(slow_times, run["sideband_size"].values, label="lattice", **look)
    theory = run["sideband_theory"].values
    ax.semilogy(slow_times, theory, color="black", linewidth=1.0, label="theory, from the first")
    ax.set(xlabel="$T$", ylabel="sidebands over carrier")
    ax.set_title(verdict, loc="left", parse_math=False, fontsize="small")
    ax.legend()
