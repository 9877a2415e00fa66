"""Growth rates: a sweep's over the carrier's wavenumber beside the map in theory, and a run's.

Rates that were measured where plane waves are stable in theory are hollow; carriers of which none
could be measured bear a cross on the axis.
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
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import FigureBase
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import CURVES

if TYPE_CHECKING:
    from longwave.scenes.scene import Scene

Array = NDArray[np.float64]

CARRIER = "envelope.k"
"""The field over which rates are drawn."""

NEEDED = (
    *("growth_rate", "growth_rate_error", "growth_rate_theory", "carrier_k"),
    "perturbation_kappa",
)
"""What a picture is made of, beside the cells' status."""

MOST_ROWS = 6
"""Rows in a picture, each with a map of its own."""

WAVENUMBERS, KAPPAS = 400, 120
"""Points of a map."""

BEYOND = 1.25
"""How far a map goes in kappa, in units of the largest that was run and grows."""

FREE = ("eps", "order", "tolerance")
"""Fields on which no theory depends; any other field may change a map."""

CHOSEN = ("parameters.share", "parameters.kappa")
"""Those on which a theory's curve depends, and its map does not."""

BARE = ("lattice", "envelope.branch")
"""Those whose values need no name."""


def growth_panels(data: xr.Dataset, most_curves: int) -> Sequence[GrowthPanel]:
    """The rates of a sweep's cells over k: a panel for each map, a curve for each other value.

    A map is of one lattice with its constants, branch and amplitude; what it does not depend on
    has panels of its own where that leaves one dimension for the curves. Raises ValueError in one
    line where the sweep is not over the carrier's k, or over too much.
    """
    along = _carrier_dimension(data)
    rows, lines = _rows_and_lines(data, along)
    _check_count(data, rows, MOST_ROWS, along)
    _check_count(data, lines, most_curves, along)
    dims = [*(str(name) for name in data["status"].dims if name != along), along]
    flat = data[["status", *NEEDED]].stack(cell=dims, create_index=False)
    parts = [part for _, part in _groups(flat, rows)]
    titles = _titles(parts, rows)
    return [_panel(title, part, lines) for title, part in zip(titles, parts, strict=True)]


def _rows_and_lines(data: xr.Dataset, along: str) -> tuple[list[str], list[str]]:
    """The coordinates that tell panels apart, and those that tell a panel's curves apart."""
    fields = {str(n): data[n].attrs["field"] for n in data.coords if "field" in data[n].attrs}
    swept = [name for name in fields if data[name].ndim == 1 and fields[name] != CARRIER]
    rows = [n for n in swept if not _is_free(data, fields[n]) and fields[n] not in CHOSEN]
    rest = [name for name in swept if name not in rows]
    lines = [n for n in rest if data[n].dims != (along,) or fields[n] in CHOSEN]
    others = list(dict.fromkeys(data[n].dims[0] for n in lines if data[n].dims != (along,)))
    if not rows and len(others) > 1:
        own = {name: [n for n in lines if data[n].dims == (name,)] for name in others}
        first = min(
            others,
            key=lambda name: (
                not any(fields[n] in CHOSEN for n in own[name]),
                all(data[n].dtype.kind in "fiu" for n in own[name]),
                data.sizes[name],
            ),
        )
        rows = own[first]
    return rows, [name for name in lines if name not in rows]


def _is_free(data: xr.Dataset, field: str) -> bool:
    """Whether no theory depends on a field; it does on eps where constants are small with it."""
    if field != "eps":
        return field in FREE
    told = [
        str(data[name].values.tolist()) for name in data.coords if data[name].dtype.kind in "UO"
    ]
    with suppress(ValueError, KeyError, TypeError):
        told.append(str(json.loads(data.attrs["sweep"])["scene"]["constants"]))
    return not any("eps" in one for one in told)


def _check_count(data: xr.Dataset, names: Sequence[str], most: int, along: str) -> None:
    """Refuse more rows, or more curves, than a picture holds."""
    if not names:
        return
    dims = list(dict.fromkeys(str(data[name].dims[0]) for name in names))
    found = {
        name: {_key(row) for row in zip(*_columns(data, names, name), strict=True)} for name in dims
    }
    count = math.prod(len(rows) for rows in found.values())
    if count <= most:
        return
    differing = [n for n in names if len(set(map(str, data[n].values.tolist()))) > 1]
    name = max(differing, key=lambda name: len(found[str(data[name].dims[0])]))
    alone = dims == [along] and count == data.sizes[along]
    remedy = "take --kind values" if alone else f"choose with --at {name}=VALUE"
    raise ValueError(
        f"{' and '.join(differing)} must have at most {most} values beside k, got {count} "
        f"({remedy})"
    )


def _columns(data: xr.Dataset, names: Sequence[str], dimension: str) -> list[list[Any]]:
    return [data[name].values.tolist() for name in names if data[name].dims == (dimension,)]


def _key(values: Sequence[Any]) -> tuple[str, ...]:
    return tuple(map(repr, values))


def _groups(flat: xr.Dataset, names: Sequence[str]) -> list[tuple[dict[str, Any], xr.Dataset]]:
    """The cells with the same values of these coordinates, in the order of the first of each."""
    columns = _columns(flat, names, "cell")
    found: dict[tuple[str, ...], list[int]] = {}
    for place in range(flat.sizes["cell"]):
        found.setdefault(_key([column[place] for column in columns]), []).append(place)
    return [
        ({n: c[at[0]] for n, c in zip(names, columns, strict=True)}, flat.isel(cell=at))
        for at in found.values()
    ]


def _carrier_dimension(data: xr.Dataset) -> str:
    fields = {str(n): data[n].attrs.get("field") for n in data.coords if data[n].ndim == 1}
    found = [name for name, field in fields.items() if field == CARRIER]
    if not found or not all(_is_number_of_cells(data, name) for name in NEEDED):
        swept = ", ".join(map(str, fields.values())) or "nothing"
        raise ValueError(
            f"growth_map must be of growth rates over {CARRIER}, got a sweep over {swept} (a scene "
            'with wave = "perturbed_plane", and its k in [grid])'
        )
    return str(data[found[0]].dims[0])


def _is_number_of_cells(data: xr.Dataset, name: str) -> bool:
    """Whether a data set, which may be any file's, has that number of each cell."""
    return name in data and data[name].dims == data["status"].dims and data[name].dtype.kind == "f"


def _titles(parts: Sequence[xr.Dataset], names: Sequence[str]) -> list[str]:
    """What tells panels apart; tables only where lattices, branches and numbers do not."""
    held = [{name: _first(part, name) for name in names} for part in parts]
    scalar = [str(name) for name in parts[0].coords if parts[0][name].ndim == 0]
    fields = {name: parts[0][name].attrs.get("field", name) for name in (*names, *scalar)}
    bare = [name for wanted in BARE for name in fields if fields[name] == wanted]
    short: list[dict[str, Any]] = []
    tables: list[dict[str, Any]] = []
    for own in held:
        entries = {name: _value(value) for name, value in own.items() if name not in bare}
        short.append({n: v for n, v in entries.items() if not isinstance(v, dict)})
        tables.append({k: v for e in entries.values() if isinstance(e, dict) for k, v in e.items()})
    prefixes = [", ".join(str(_first(part, name)) for name in bare) for part in parts]
    titles = _joined(prefixes, [_told(one) for one in _differing(short)])
    if len(set(titles)) < len(titles):
        titles = _joined(titles, [_told(one) for one in _differing(tables)])
    return titles


def _joined(before: Sequence[str], after: Sequence[str]) -> list[str]:
    return [", ".join(filter(None, both)) for both in zip(before, after, strict=True)]


def _first(part: xr.Dataset, name: str) -> Any:
    return part[name].values.ravel().tolist()[0]


def _differing(held: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Of tables of values those entries that are not the same in all."""
    names = dict.fromkeys(name for one in held for name in one)
    wanted = [name for name in names if len({repr(one.get(name)) for one in held}) > 1]
    return [{name: one[name] for name in wanted if name in one} for one in held]


def _told(values: Mapping[str, Any]) -> str:
    """Values with their names."""
    return ", ".join(
        f"{name} = {value:g}" if isinstance(value, int | float) else f"{name} = {value}"
        for name, value in values.items()
    )


def _panel(title: str, flat: xr.Dataset, lines: Sequence[str]) -> GrowthPanel:
    """A panel of cells that have one map."""
    chosen = [name for name in lines if flat[name].attrs.get("field") in CHOSEN]
    groups = _groups(flat, lines)
    curves = [
        _curve(_told(held), _told({name: held[name] for name in chosen}), part)
        for held, part in groups
    ]
    return GrowthPanel(title, curves, _theory([part for _, part in groups], curves))


def _curve(label: str, line: str, data: xr.Dataset) -> GrowthCurve:
    done = data["status"].values == "done"

    def column(name: str) -> Array:
        return np.where(done, np.asarray(data[name].values, dtype=np.float64), np.nan)

    asked = np.array([_number(value) for value in _asked(data)])
    return GrowthCurve(
        label,
        line,
        np.where(done, column("carrier_k"), asked),
        column("growth_rate"),
        column("growth_rate_error"),
        column("growth_rate_theory"),
        column("perturbation_kappa"),
        np.isin(data["status"].values, ("refused", "failed", "blown up")),
    )


def _asked(data: xr.Dataset) -> Sequence[Any]:
    fields = (c for c in data.coords if data[c].dims == ("cell",))
    found: list[Any] = next(
        data[c].values.tolist() for c in fields if data[c].attrs.get("field") == CARRIER
    )
    return found


def _number(value: float | str) -> float:
    """A wavenumber as a file says it; NaN for what is none."""
    from longwave.derive.algebra.formula_expression import exact_value

    try:
        return float(exact_value("k", value))
    except (ValueError, TypeError):
        return np.nan


def _theory(parts: Sequence[xr.Dataset], curves: Sequence[GrowthCurve]) -> ModulationMap | None:
    """The map of the cells' lattice; None where it has none, or is in a file of its own."""
    from longwave.scenes.modulation import scene_modulation
    from longwave.scenes.perturbed_plane import chosen_kappa
    from longwave.scenes.sideband_growth import plane_wave_numbers

    k = np.linspace(0.0, np.pi, WAVENUMBERS + 1)[1:]
    lines: dict[str, Array] = {}
    first = None
    for part, curve in zip(parts, curves, strict=True):
        if curve.line in lines:
            continue
        done = part["status"].values == "done"
        with suppress(ValueError):
            scene = _scene(part.isel(cell=int(np.argmax(done))))
            given = plane_wave_numbers(scene)
            first = first or (scene_modulation(scene, k, given["amplitude"]), given["amplitude"])
            grid, amplitude = first
            kappa = chosen_kappa(grid.p, grid.q, given)
            lines[curve.line] = _rates(grid.p, grid.q, amplitude, kappa)
    if first is None:
        return None
    grid, amplitude = first
    run = np.concatenate([curve.kappa for curve in curves])
    growing = run[np.concatenate([curve.theory for curve in curves]) > 0.0]
    shown = growing if growing.size else run[np.isfinite(run)]
    largest = float(np.max(shown, initial=0.0)) or 1.0
    kappas = np.linspace(0.0, BEYOND * largest, KAPPAS)
    rates = _rates(grid.p, grid.q, amplitude, kappas[:, None])
    return ModulationMap(k, lines, grid.product, kappas, rates)


def _rates(p: Array, q: Array, amplitude: float, kappa: Array | float) -> Array:
    """Growth rates in T of perturbations, 0 of those that do not grow."""
    from longwave.scenes.perturbed_plane import squared_rate

    with np.errstate(all="ignore"):
        return np.asarray(np.sqrt(np.maximum(squared_rate(p, q, amplitude, kappa), 0.0)))


def _scene(cell: xr.Dataset) -> Scene:
    """The scene of one cell; ValueError if the file does not hold it."""
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


def _value(held: Any) -> Any:
    """A field's value: lists and tables stand as JSON."""
    if isinstance(held, str) and held[:1] in ("[", "{"):
        return json.loads(held)
    return held


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


def draw_sideband_sizes(figure: FigureBase, run: xr.Dataset, verdict: str) -> None:
    """The two waves beside a carrier over the slow time, in a logarithm, and in theory."""
    ax, slow_times = figure.subplots(), run["slow_time"].values
    look = CURVES[0] | {"linestyle": ""}
    ax.semilogy(slow_times, run["sideband_size"].values, label="lattice", **look)
    theory = run["sideband_theory"].values
    ax.semilogy(slow_times, theory, color="black", linewidth=1.0, label="theory, from the first")
    ax.set_xlabel("$T$")
    ax.set_ylabel("sidebands over carrier")
    ax.set_title(verdict, loc="left", parse_math=False, fontsize="small")
    ax.legend()
