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
"""The field over which rates are drawn."""

RATE, BARS, THEORY = "growth_rate", "growth_rate_error", "growth_rate_theory"
NEEDED = (RATE, BARS, THEORY, "carrier_k", "perturbation_kappa")
"""What a picture is made of, beside the cells' status."""

MOST_ROWS = 6
"""Rows in a picture, each with a map of its own."""

WAVENUMBERS, KAPPAS = 400, 400
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
    parts = [part for _, part in _groups(_cells(data, dims), rows)]
    titles = _titles(parts, rows)
    return [_panel(title, part, lines) for title, part in zip(titles, parts, strict=True)]


def _rows_and_lines(data: xr.Dataset, along: str) -> tuple[list[str], list[str]]:
    """The coordinates that tell panels apart, and those that tell a panel's curves apart."""
    fields = {str(n): data[n].attrs["field"] for n in data.coords if "field" in data[n].attrs}
    swept = [name for name in fields if data[name].ndim == 1 and fields[name] != CARRIER]
    rows = [n for n in swept if not _is_free(data, fields[n]) and fields[n] not in CHOSEN]
    rest = [name for name in swept if name not in rows]
    lines = [n for n in rest if data[n].dims != (along,) or fields[n] in CHOSEN]
    others: dict[Any, list[str]] = {}
    for name in lines:
        if data[name].dims != (along,):
            others.setdefault(data[name].dims, []).append(name)
    if not rows and len(others) > 1:
        rows = min(
            others.values(),
            key=lambda own: (
                not any(fields[n] in CHOSEN for n in own),
                all(data[n].dtype.kind in "fiu" for n in own),
                data[own[0]].size,
            ),
        )
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
    found: dict[str, int] = {}
    for dim in dict.fromkeys(str(data[name].dims[0]) for name in names):
        columns = [data[name].values.tolist() for name in names if data[name].dims == (dim,)]
        found[dim] = len(set(map(repr, zip(*columns, strict=True))))
    count = math.prod(found.values())
    if count <= most:
        return
    differing = [n for n in names if len(set(map(str, data[n].values.tolist()))) > 1]
    name = max(differing, key=lambda name: found[str(data[name].dims[0])])
    alone = list(found) == [along] and count == data.sizes[along]
    remedy = "take --kind values" if alone else f"choose with --at {name}=VALUE"
    raise ValueError(
        f"{' and '.join(differing)} must have at most {most} values beside k, got {count} "
        f"({remedy})"
    )


def _groups(cells: xr.Dataset, names: Sequence[str]) -> list[tuple[dict[str, Any], xr.Dataset]]:
    """The cells with the same values of these coordinates, in the order of the first of each."""
    columns = [cells[name].values.tolist() for name in names]
    found: dict[tuple[str, ...], list[int]] = {}
    for place in range(cells.sizes["cell"]):
        found.setdefault(tuple(repr(column[place]) for column in columns), []).append(place)
    return [
        ({n: c[at[0]] for n, c in zip(names, columns, strict=True)}, cells.isel(cell=at))
        for at in found.values()
    ]


def _carrier_dimension(data: xr.Dataset) -> str:
    """The dimension of the carrier's k, if the cells, of any file, have all that is drawn."""
    fields = {str(n): data[n].attrs.get("field") for n in data.coords if data[n].ndim == 1}
    found = [name for name, field in fields.items() if field == CARRIER]
    dims, own = data["status"].dims, (data.get(name) for name in NEEDED)
    if not found or any(n is None or n.dims != dims or n.dtype.kind != "f" for n in own):
        swept = ", ".join(map(str, fields.values())) or "nothing"
        raise ValueError(
            f"growth_map must be of growth rates over {CARRIER}, got a sweep over {swept} (a scene "
            'with wave = "perturbed_plane", and its k in [grid])'
        )
    return str(data[found[0]].dims[0])


def _cells(data: xr.Dataset, dims: Sequence[str]) -> xr.Dataset:
    """The numbers of all cells in a row, NaN but for k where there is no run; whether it is
    ``done``, and whether an attempt ``failed``."""
    flat = data[["status", *NEEDED]].stack(cell=dims, create_index=False)
    done = flat["status"] == "done"
    coords = (flat[name] for name in flat.coords if flat[name].dims == ("cell",))
    asked = next(held for held in coords if held.attrs.get("field") == CARRIER)
    numbers = flat[list(NEEDED)].where(done)
    wavenumbers = np.array([_number(value) for value in asked.values.tolist()])
    numbers["carrier_k"] = numbers["carrier_k"].where(done, wavenumbers)
    failed = flat["status"].isin(("refused", "failed", "blown up"))
    return numbers.assign(done=done, failed=failed).assign_attrs(data.attrs)


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


def _panel(title: str, cells: xr.Dataset, lines: Sequence[str]) -> GrowthPanel:
    """A panel of cells that have one map."""
    chosen = [name for name in lines if cells[name].attrs.get("field") in CHOSEN]
    curves = [
        part.assign_attrs(label=_told(held), line=_told({name: held[name] for name in chosen}))
        for held, part in _groups(cells, lines)
    ]
    return GrowthPanel(title, curves, _theory(curves))


def _number(value: float | str) -> float:
    """A wavenumber as a file says it; NaN for what is none."""
    from longwave.derive.algebra.formula_expression import exact_value

    try:
        return float(exact_value("k", value))
    except (ValueError, TypeError):
        return np.nan


def _theory(curves: Sequence[xr.Dataset]) -> xr.Dataset | None:
    """The map of the cells' lattice; None where it has none, or is in a file of its own.

    Growth ``rates`` over ``kappa`` and ``k``, those of each ``line`` of measured kinds over k, and
    the ``product`` p q, NaN where there is no equation.
    """
    from longwave.scenes.engines.sideband_growth import plane_wave_numbers
    from longwave.scenes.modulation import scene_modulation
    from longwave.scenes.starts.perturbed_plane import chosen_kappa

    k = np.linspace(0.0, np.pi, WAVENUMBERS + 1)[1:]
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
    shown = growing if growing.size else run[np.isfinite(run)]
    largest = float(np.max(shown, initial=0.0)) or 1.0
    kappas = np.linspace(0.0, BEYOND * largest, KAPPAS)
    rates = _rates(grid.p, grid.q, amplitude, kappas[:, None])
    import xarray as xr  # a sweep is one already

    return xr.Dataset(
        {
            "lines": (("line", "k"), list(lines.values())),
            "product": ("k", grid.product),
            "rates": (("kappa", "k"), rates),
        },
        {"line": list(lines), "k": k, "kappa": kappas},
    )


def _rates(p: Array, q: Array, amplitude: float, kappa: Array | float) -> Array:
    """Growth rates in T of perturbations, 0 of those that do not grow."""
    from longwave.scenes.starts.perturbed_plane import squared_rate

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


UNKNOWN = "#a6a6a6"
"""The colour of where plane waves have no NLS equation."""

LEGEND_LETTERS = 88
"""In a line of the legend, with four curves side by side."""


@dataclass(frozen=True)
class GrowthPanel:
    """Measured rates, curves with a ``label`` and the ``line`` of theory that is theirs, beside the
    one map of all their cells, None if it cannot be derived."""

    title: str
    curves: Sequence[xr.Dataset]
    theory: xr.Dataset | None


@part(lambda panels: 2.3 * len(panels) + 0.45)
def growth_map(figure: FigureBase, panels: Sequence[GrowthPanel]) -> None:
    """A row for each of `growth_panels`: rates over k, and the map of all perturbations."""
    grid = figure.subplots(len(panels), 2, squeeze=False, sharex=True)
    labels = dict.fromkeys(curve.attrs["label"] for panel in panels for curve in panel.curves)
    looks = {label: CURVES[place % len(CURVES)] for place, label in enumerate(labels)}
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
"""Colours, lines and markers of curves by their labels, the same in all panels."""


def _theory_looks(panel: GrowthPanel, looks: Looks) -> dict[str, dict[str, Any]]:
    """Of each line of theory: black if it is the only one, else as the first curve it is of."""
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
    """The measured rates and the theory's curves, on grey where plane waves are stable."""
    theory = _theory_looks(panel, looks)
    for curve in panel.curves:
        colour, marker = (looks[curve.attrs["label"]][key] for key in ("color", "marker"))
        grows = curve[THEORY].values > 0.0
        for inside, face in ((grows, colour), (~grows, "white")):
            part = curve.isel(cell=inside)
            look: dict[str, Any] = {
                "marker": marker,
                "markersize": 4.0,
                "markerfacecolor": face,
                "zorder": 3,
            }
            places, rates, bars = (part[name].values for name in ("carrier_k", RATE, BARS))
            ax.errorbar(places, rates, bars, linestyle="", color=colour, capsize=2.0, **look)
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
    """Have the axis show all rates that were measured, and the theory there; its upper end.

    The theory's curve may go beyond any, beside a resonance.
    """
    parts = [part for c in panel.curves for part in (c[RATE] + c[BARS], c[THEORY])]
    known = np.concatenate(parts)
    known = known[np.isfinite(known)]
    top = 1.1 * float(known.max()) if known.size and known.max() > 0.0 else 1.0
    ax.set_ylim(-0.08 * top, top)
    return top


def _draw_map(figure: FigureBase, ax: Axes, panel: GrowthPanel, top: float) -> None:
    """Rates of all perturbations in theory, and those measured as points in the same colours."""
    assert panel.theory is not None
    k, kappa, rates = (panel.theory[name].values for name in ("k", "kappa", "rates"))
    ax.set_facecolor(STABLE)
    colours = Normalize(0.0, top)
    growing = np.ma.masked_where(~(rates > 0.0), rates)
    extent: Any = (0.0, float(k[-1]), 0.0, float(kappa[-1]))
    drawn = ax.imshow(growing, norm=colours, extent=extent, origin="lower", aspect="auto")
    for curve in panel.curves:
        look: dict[str, Any] = {
            "norm": colours,
            "edgecolors": "white",
            "linewidths": 0.6,
            "zorder": 3,
        }
        places, heights, rate = (
            curve[name].values for name in ("carrier_k", "perturbation_kappa", RATE)
        )
        ax.scatter(places, heights, 14.0, c=np.maximum(rate, 0.0), **look)
    ax.set_ylim(0.0, float(kappa[-1]))
    ax.set_ylabel(r"$\kappa$ of the perturbation")
    extend = "max" if np.nanmax(rates) > top else "neither"
    figure.colorbar(drawn, ax=ax, label="growth rate in $T$", extend=extend)


def _legend(panels: Sequence[GrowthPanel], looks: Looks) -> list[Line2D | Patch]:
    """Each curve's marker, over its line of theory where a panel has several."""
    handles: list[Line2D | Patch] = []
    several = [
        _theory_looks(p, looks) for p in panels if len({c.attrs["line"] for c in p.curves}) > 1
    ]
    lines = {line: look for found in reversed(several) for line, look in found.items()}
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
    if any(found["product"].isnull().any() for found in maps):
        handles.append(Patch(color=UNKNOWN, label="no NLS equation"))
    return handles


@part(2.8)
def sideband_sizes(figure: FigureBase, run: LabelledArrays, verdict: str) -> None:
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
