"""Pictures of a sweep: a number of each cell over the swept dimensions, and work against precision.

Of one dimension curves are drawn, of two a heat map, of three several; samples and realisations of
disorder are told by what they have in common. Of more dimensions, and of what has too many values
to be told apart, some are to be chosen: ``at`` says where.

An axis is a swept dimension: numbers in their places, evenly spaced ones in the logarithm on a
logarithmic axis, or texts side by side. Cells without a value are grey; those that were run and
came to no end bear a cross; those whose value has a large error of its own are hatched.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import FigureBase
from matplotlib.patches import Patch
from matplotlib.ticker import NullFormatter
from numpy.typing import NDArray

from longwave.reports.pictures.drawing import CURVES, time_edges
from longwave.reports.pictures.growth_plotting import draw_growth, growth_height, growth_panels
from longwave.support.user_files import shown

Array = NDArray[np.float64]

SAMPLE = "sample"
"""The dimension of a random sample."""

REALISATION = "disorder.seed"
"""The field whose values are realisations of one disorder."""

MOST_CURVES, MOST_MAPS = 8, 12
"""Curves that colours tell apart, and heat maps on one page."""

LONGEST_LABEL = 50
"""Characters of a long name that an axis has room for."""

MOST_LISTED = 20
"""Values that an error lists."""

TOLD = {"scheme.name": "scheme", "domain.kind": "domain", "disorder.of": "disorder of"}
"""How fields are called in pictures whose last part says nothing alone."""

BARS = {"error": "own_error", "growth_rate": "growth_rate_error"}
"""Numbers that have an error of their own, in their own units."""

WORK = ("tolerance", "scheme.step", "step", "lattice.order", "order", "scheme.name", "scheme")
"""Fields along which a run takes more work for less error: of two the first is drawn along."""

ENDED = ("done", "blown up")
"""Cells whose numbers are drawn."""

Choice = Mapping[str, str | float]


def is_sweep(data: xr.Dataset) -> bool:
    """Whether a data set is the result of a sweep."""
    return "sweep" in data.attrs and "status" in data


def chosen(data: xr.Dataset, at: Choice) -> xr.Dataset:
    """The cells where swept fields have these values, dimensions of one value left out.

    Raises ValueError in one line for a field that is not swept and a value that is not there.
    """
    for name, value in at.items():
        known = [str(field) for field in data.coords if data[field].ndim == 1]
        if name not in known:
            raise ValueError(
                f"at must name a swept field, got {shown(name)} (one of {', '.join(known)})"
            )
        column = data[name]
        data = data.isel({column.dims[0]: _places(name, column.values, value)})
    return data.squeeze()


def _places(name: str, held: NDArray[Any], value: str | float) -> list[int]:
    """Where a field has that value, or else the one that is printed so."""
    for read in (str, _text):
        places = [place for place, one in enumerate(held) if _same(one, value, read)]
        found = list(dict.fromkeys(str(held[place]) for place in places))
        if len(found) > 1 and read is _text:
            raise ValueError(
                f"{name} must tell one value, got {shown(value)} (one of {_listed(found)})"
            )
        if places:
            return places
    known = _listed(list(dict.fromkeys(_text(one) for one in held)))
    raise ValueError(f"{name} must be one of its values, got {shown(value)} (one of {known})")


def _same(held: object, value: str | float, read: Callable[[object], str]) -> bool:
    try:
        return bool(np.isclose(float(read(held)), float(value), rtol=1e-9, atol=0.0))
    except (TypeError, ValueError):
        return str(held) == str(value)


def _listed(texts: Sequence[str]) -> str:
    return ", ".join(texts[:MOST_LISTED]) + (", ..." if len(texts) > MOST_LISTED else "")


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, int | float | np.number) else str(value)


@dataclass(frozen=True)
class SweepPart:
    """A part of a figure: its height in inches, and what draws it."""

    height: float
    draw: Callable[[FigureBase], None]


PULSE = ("last_peak", "last_energy")
"""What disorder left of a pulse, which is drawn before its error: a mere delay is one."""

VALUES, WORK_PRECISION, GROWTH_MAP = "values", "work_precision", "growth_map"
SWEEP_PICTURES = (VALUES, WORK_PRECISION, GROWTH_MAP)
"""The kinds of pictures of a sweep."""


def sweep_parts(
    data: xr.Dataset, kind: str | None, at: Choice, variable: str
) -> Sequence[SweepPart]:
    """The pictures of that kind, or all, of the cells that are ``at`` these values.

    Raises ValueError in one line: what was chosen, what there is nothing of, and what is too much
    for a picture.
    """
    data = chosen(data, at)
    if kind == VALUES:
        return [values_part(data, variable)]
    if kind == WORK_PRECISION:
        return [work_part(data)]
    if kind == GROWTH_MAP:
        return [growth_part(data)]
    if "growth_rate" in data and variable == "error":
        with suppress(ValueError):
            return [growth_part(data)]
    drawn = [name for name in PULSE if name in data and variable == "error"] + [variable]
    found = [] if data["status"].ndim == 0 else [values_part(data, name) for name in drawn]
    if work_dimension(data) is not None:
        with suppress(ValueError):
            found.append(work_part(data))
    return found or [values_part(data, variable)]


def growth_part(data: xr.Dataset) -> SweepPart:
    """Growth rates over the carrier's wavenumber beside the map of them in theory."""
    panels = growth_panels(data, MOST_CURVES)
    return SweepPart(growth_height(len(panels)), lambda figure: draw_growth(figure, panels))


def values_part(data: xr.Dataset, variable: str) -> SweepPart:
    """A number of each cell over the dimensions that are left."""
    values = _numbers(data, variable)
    if not values.dims:
        raise ValueError(
            f"a picture must be of two cells or more, got one cell (its {variable} is "
            f"{float(values):g}; sweep more values, or leave out an --at)"
        )
    repeats = _repeats(data, values)
    drawn = [str(name) for name in values.dims if name not in repeats]
    if len(values.dims) == 1 or (repeats and len(drawn) == 1):
        return _curves(data, values, [])
    families = _families(data, values, drawn, bool(repeats))
    if len(drawn) == 2 and families:
        return _curves(data, values, families)
    if len(drawn) in (2, 3) and not repeats:
        return _maps(data, values)
    sizes = ", ".join(f"{size} {name}" for name, size in values.sizes.items())
    condition = (
        f"repeats must be over one or two dimensions, one of at most {MOST_CURVES} values"
        if repeats
        else "a picture must be of one to three dimensions"
    )
    raise ValueError(f"{condition}, got {sizes} (choose with --at NAME=VALUE)")


def _repeats(data: xr.Dataset, values: xr.DataArray) -> list[str]:
    """The dimension of samples, or of realisations, along which nothing is drawn."""
    names = [str(name) for name in values.dims]
    seeds = [n for n in names if n in data.coords and data[n].attrs.get("field") == REALISATION]
    return [name for name in names if name == SAMPLE] or seeds


def _numbers(data: xr.Dataset, variable: str) -> xr.DataArray:
    """A number of each cell that came to an end, NaN of the others."""
    values = _ended(data, variable)
    if not np.isfinite(values).any():
        raise ValueError(
            f"{variable} must be a number in some cell, got none in {values.size} cells "
            "(see their status and message)"
        )
    return values


def _ended(data: xr.Dataset, variable: str) -> xr.DataArray:
    known = [
        str(n) for n in data if data[n].dtype.kind in "fiu" and data[n].dims == data.status.dims
    ]
    if variable not in known:
        raise ValueError(
            f"variable must be a number of each cell, got {shown(variable)} (one of "
            f"{', '.join(known)})"
        )
    ended = np.isin(data["status"].values, ENDED)
    values = data[variable].astype(float)
    return values.where(ended & np.isfinite(values))


def _families(
    data: xr.Dataset, values: xr.DataArray, drawn: Sequence[str], repeated: bool
) -> list[str]:
    """The dimension with a curve for each value, if they are few.

    It is the one with texts, and of repeats, which have no heat map, else the smallest one.
    """
    found = [name for name in drawn if axis_of(data, name).is_text]
    if repeated and not found:
        found = sorted(drawn, key=lambda name: values.sizes[name])
    return found[:1] if found and values.sizes[found[0]] <= MOST_CURVES else []


def axis_of(data: xr.Dataset, name: str) -> SweptAxis:
    """A dimension as an axis; that of a list or sample by the field that tells its cells apart."""
    fields = [data[name]] if name in data.coords else []
    fields += [data[c] for c in data.coords if data[c].dims == (name,) and c != name]
    for field in fields:
        held = field.values
        if len({str(one) for one in held}) == held.size:
            told = TOLD.get(field.attrs.get("field", ""), str(field.name))
            if held.dtype.kind in "fiu":
                return SweptAxis(told, [float(one) for one in held])
            return SweptAxis(told, [str(one) for one in held])
    return SweptAxis(name, [float(place) for place in range(data.sizes[name])])


def _curves(data: xr.Dataset, values: xr.DataArray, families: Sequence[str]) -> SweepPart:
    """Curves along one dimension: one, one for each value of another, or of all repeats."""
    repeats = _repeats(data, values)
    rest = [str(name) for name in values.dims if name not in families]
    along = min(rest, key=lambda name: name in repeats)
    what, bars, faulty = _label(data, values), _bars(data, values), _faulty(data, values)
    told, common = _own_told(values, bars), _median if repeats == [SAMPLE] else _mean

    def curve(label: str, where: Mapping[str, int]) -> SweptCurve:
        found, its, ends = (part.isel(where) for part in (values, bars, faulty))
        if len(rest) == 2:
            ends = ends.any(repeats[0])
            return common(label, found.transpose(repeats[0], along).values, ends.values)
        return SweptCurve(label, found.values, np.array([its.values, its.values]), ends.values)

    if families:
        family = axis_of(data, families[0])
        said = "" if family.is_text else f"{family.name} = "
        labels = [f"{said}{_text(one)}" for one in family.values]
        curves = [curve(label, {families[0]: place}) for place, label in enumerate(labels)]
    else:
        curves = [curve("", {})]
    if len(rest) == 2:
        told = (BY_MEAN if common is _mean else BY_MEDIAN).format(_counted(values, repeats[0]))
    axis, joined = axis_of(data, along), along not in repeats
    return SweepPart(
        CURVE_HEIGHT, lambda figure: draw_swept_curves(figure, axis, curves, what, joined, told)
    )


def _faulty(data: xr.Dataset, values: xr.DataArray) -> xr.DataArray:
    """The cells that were run, came to no good end and have no value."""
    status = data["status"].values
    settled = np.isin(status, ("done", "missing")) | np.isfinite(values.values)
    return xr.DataArray(~settled, dims=values.dims)


def _counted(values: xr.DataArray, repeats: str) -> str:
    """Of how many repeats there are values, where there are any."""
    counts = np.isfinite(values.transpose(repeats, ...).values).sum(axis=0)
    low, high = counts[counts > 0].min(), counts.max()
    return f"{high}" if low == high else f"{low} to {high}"


BY_MEDIAN = "median of {}, bars to the quartiles"
BY_MEAN = "mean of {}, bars: standard error, band: standard deviation"
"""How repeats are told."""


def _own_told(values: xr.DataArray, bars: xr.DataArray) -> str:
    """How large the errors of the values themselves are, which may be too small to be seen."""
    known = np.isfinite(bars.values) & (np.abs(values.values) > 0.0)
    if not known.any():
        return ""
    with np.errstate(over="ignore"):
        share = float(np.max(bars.values[known] / np.abs(values.values[known])))
    percent = float(f"{100.0 * share:.2g}")
    return f"bars: own error, at most {percent:g}% of the value"


def _bars(data: xr.Dataset, values: xr.DataArray) -> xr.DataArray:
    """The errors of the values themselves, NaN where they are not known."""
    own = BARS.get(str(values.name))
    return data[own].astype(float) if own in data else xr.full_like(values, np.nan)


def _median(label: str, values: Array, faulty: NDArray[np.bool_]) -> SweptCurve:
    """The median over the first axis, with bars to the quartiles."""
    known = np.isfinite(values).any(axis=0)
    low, middle, high = np.full((3, known.size), np.nan)
    low[known], middle[known], high[known] = np.nanquantile(
        values[:, known], (0.25, 0.5, 0.75), axis=0
    )
    return SweptCurve(label, middle, np.array([middle - low, high - middle]), faulty)


def _mean(label: str, values: Array, faulty: NDArray[np.bool_]) -> SweptCurve:
    """The mean over the first axis, its standard error as bars, the standard deviation as band."""
    count = np.sum(np.isfinite(values), axis=0)
    with np.errstate(all="ignore"):
        mean = np.nansum(values, axis=0) / count
        spread = np.sqrt(np.nansum((values - mean) ** 2, axis=0) / (count - 1))
        error = spread / np.sqrt(count)
    return SweptCurve(label, mean, np.array([error, error]), faulty, spread)


def _maps(data: xr.Dataset, values: xr.DataArray) -> SweepPart:
    """A heat map over two dimensions, or one for each value of the third."""
    names = [str(name) for name in values.dims]
    texts = [name for name in names if axis_of(data, name).is_text]
    over = (
        (texts or sorted(names, key=lambda name: values.sizes[name]))[:1] if len(names) == 3 else []
    )
    if over and values.sizes[over[0]] > MOST_MAPS:
        raise ValueError(
            f"{over[0]} must have at most {MOST_MAPS} values for as many maps, got "
            f"{values.sizes[over[0]]} (choose with --at {over[0]}=VALUE)"
        )
    x, y = (name for name in names if name not in over)
    faulty = _faulty(data, values).transpose(*over, x, y)
    bars = _bars(data, values).transpose(*over, x, y).values
    values = values.transpose(*over, x, y)
    if over:
        titles = [
            f"{axis_of(data, over[0]).name} = {_text(v)}" for v in axis_of(data, over[0]).values
        ]
        held = zip(titles, values.values, faulty.values, bars, strict=True)
        maps = [HeatMap(*each) for each in held]
    else:
        maps = [HeatMap("", values.values, faulty.values, bars)]
    axes, what = (axis_of(data, x), axis_of(data, y)), _label(data, values)
    return SweepPart(
        heat_height(len(maps)), lambda figure: draw_heat_maps(figure, axes, maps, what)
    )


def _label(data: xr.Dataset, values: xr.DataArray) -> str:
    name = str(values.name)
    told, units = data[name].attrs.get("long_name", ""), data[name].attrs.get("units", "1")
    words = told if 0 < len(told) <= LONGEST_LABEL else name.replace("_", " ")
    return words if units in ("1", "") else f"{words}  ({units})"


def work_dimension(data: xr.Dataset) -> str | None:
    """The dimension along which more work is done, None if there is none."""
    names = [str(name) for name in data["status"].dims]
    fields = {data[n].attrs.get("field", n) if n in data.coords else n: n for n in names}
    return next((fields[field] for field in WORK if field in fields), None)


def work_part(data: xr.Dataset) -> SweepPart:
    """Errors against work along the tolerance, step or order, a curve for each other cell.

    Texts, such as schemes, have a curve each where they are few.
    """
    along = work_dimension(data)
    if along is None:
        raise ValueError(
            f"work_precision must have a sweep over one of tolerance, order, scheme, step, got "
            f"{', '.join(map(str, data['status'].dims)) or 'one cell'} (sweep the tolerance)"
        )
    numbers = _work_numbers(data)
    held = numbers.estimated.notnull() | numbers.achieved.notnull()
    others = [str(name) for name in held.dims if name != along]
    joined = not axis_of(data, along).is_text
    if not joined and int(held.sum()) <= MOST_CURVES:
        others = [str(name) for name in held.dims]
    drawn = held.any([name for name in held.dims if name not in others])
    count = int(drawn.sum())
    if count > MOST_CURVES:
        raise ValueError(
            f"work_precision must have at most {MOST_CURVES} curves, got {count} "
            f"(choose with --at {others[0]}=VALUE)"
        )
    curves = list(_work_curves(data, numbers, drawn))
    return SweepPart(
        work_height(curves), lambda figure: draw_work_precision(figure, curves, joined)
    )


def _work_numbers(data: xr.Dataset) -> xr.Dataset:
    """What a `WorkCurve` has, of all cells, in the order of its fields."""
    seconds, evaluations, sites = (
        _numbers(data, name) for name in ("seconds", "force_evaluations", "sites")
    )
    estimated = _ended(data, "error_estimate")  # none where a step is stated
    achieved = _ended(data, "error") if np.isfinite(estimated).any() else _numbers(data, "error")
    return xr.Dataset(
        {
            "seconds": seconds,
            "updates": evaluations * sites,
            "estimated": estimated,
            "achieved": achieved,
            "own": _bars(data, achieved),
        }
    )


def _work_curves(data: xr.Dataset, numbers: xr.Dataset, drawn: xr.DataArray) -> Iterator[WorkCurve]:
    names = [str(name) for name in drawn.dims]
    axes = {name: axis_of(data, name) for name in names}
    for places in np.argwhere(drawn.values):
        where = dict(zip(names, places.tolist(), strict=True))
        label = ", ".join(f"{axes[n].name} = {_text(axes[n].values[p])}" for n, p in where.items())
        yield WorkCurve(
            label, *(np.atleast_1d(numbers[part].isel(where).values) for part in numbers)
        )


CURVE_HEIGHT, HEAT_HEIGHT = 3.2, 2.7
"""Height of a panel of curves, and of a row of heat maps, in inches."""

HEAT_ACROSS = 3
"""Heat maps side by side."""

WIDE = 30.0
"""Ratio of the largest to the smallest of positive values from which colours are logarithmic."""

EMPTY = "#d9d9d9"
"""The colour of a cell without a value."""

LETTERS = {"eps": r"$\epsilon$", "kappa": r"$\kappa$", "alpha": r"$\alpha$", "beta": r"$\beta$"}
"""How names of fields are written where they are Greek."""

LETTER = re.compile("[A-Za-z](_?[0-9A-Za-z])?")
"""Names that are one letter, with or without an index."""

LONGEST_TICK, LONGEST_BESIDE, LONGEST_ABOVE = 16, 24, 80
"""Characters of a text beside a tick, and in a legend beside a picture, as in the
title of a map, or above it."""

CUT = "..."
"""What stands for the middle of a longer one."""


@dataclass(frozen=True)
class SweptAxis:
    """A swept dimension: its name, and its numbers or texts in the order of the cells."""

    name: str
    values: Sequence[float] | Sequence[str]

    @property
    def is_text(self) -> bool:
        """Whether the values are texts, which have no distance."""
        return any(isinstance(value, str) for value in self.values)

    @property
    def places(self) -> Array:
        """Where the values are on the axis."""
        if self.is_text:
            return np.arange(len(self.values), dtype=float)
        return np.asarray(self.values, dtype=float)

    @property
    def is_logarithmic(self) -> bool:
        """Whether the values are more evenly spaced in their logarithms than themselves."""
        places = np.sort(self.places)
        if self.is_text or places.size < 3 or places[0] <= 0.0 or places[-1] < 4.0 * places[0]:
            return False
        plain, logs = np.diff(places), np.diff(np.log(places))
        return bool(np.std(logs) / np.mean(logs) < np.std(plain) / np.mean(plain))

    @property
    def edges(self) -> Array:
        """Edges half way between the places, which must be in order."""
        if self.is_logarithmic:
            return np.exp(time_edges(np.log(self.places)))
        return time_edges(self.places)


@dataclass(frozen=True)
class SweptCurve:
    """Values along an axis, and their ``bars``, (2, values): how far down and up; NaN for none.

    Where one is missing because what was run came to no end, it is ``faulty``. ``band`` is how far
    what they are the mean of is spread, on either side.
    """

    label: str
    values: Array
    bars: Array
    faulty: NDArray[np.bool_]
    band: Array | None = None

    @property
    def crosses(self) -> NDArray[np.bool_]:
        """Where a cross stands for the value."""
        return self.faulty & ~np.isfinite(self.values)


def draw_swept_curves(
    figure: FigureBase,
    axis: SweptAxis,
    curves: Sequence[SweptCurve],
    what: str,
    joined: bool = True,
    told: str = "",
) -> None:
    """Draw curves over a swept dimension, in logarithms where their values are wide.

    Points are ``joined`` by lines where the axis has numbers. What is ``told`` stands above.
    """
    ax = figure.subplots()
    logarithmic = _is_wide(np.concatenate([curve.values for curve in curves]))
    drawn, rows = [], 0
    for number, curve in enumerate(curves):
        look: dict[str, Any] = CURVES[number % len(CURVES)] | {"markersize": 4.0}
        if axis.is_text or not joined:
            look["linestyle"] = ""
        aside = BESIDE * (number - (len(curves) - 1) / 2) if axis.is_text else 0.0
        places = axis.places + aside
        if np.isfinite(curve.values).any():
            drawn.append((_draw_curve(ax, places, curve, look, logarithmic), curve.label))
        if curve.crosses.any():
            sign = _draw_crosses(ax, places[curve.crosses], rows, look["color"])
            rows += 1
            if not np.isfinite(curve.values).any():
                drawn.append((sign, curve.label))
    if logarithmic:
        ax.set_yscale("log")
    else:
        ax.ticklabel_format(axis="y", useOffset=False)
    _leave_room(ax, rows)
    _set_axis(ax, axis, "x")
    ax.set_ylabel(what)
    ax.set_title("; ".join(filter(None, (told, NO_RESULT if rows else ""))), loc="left")
    ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)
    if len(curves) > 1:
        legend = ax.legend(*zip(*drawn, strict=True), loc="center left", bbox_to_anchor=(1.0, 0.5))
        _plain_legend(legend, LONGEST_BESIDE)


BESIDE = 0.1
"""How far points of several curves stand beside each other at a text."""

NO_RESULT = "\N{MULTIPLICATION SIGN}: no result"
"""What the crosses at the lower edge of curves are."""


def _draw_curve(
    ax: Axes, places: Array, curve: SweptCurve, look: dict[str, Any], logarithmic: bool
) -> Any:
    """Draw the values with their bars and band; return what stands in a legend."""
    order = np.argsort(places, kind="stable")
    places, values, bars = places[order], curve.values[order], curve.bars[:, order]
    if logarithmic:
        bars[0] = np.minimum(bars[0], 0.99 * values)
    known = bars if np.isfinite(bars).any() else None
    sign = ax.errorbar(places, values, known, capsize=3.0, **look)
    if curve.band is not None:
        band = np.nan_to_num(curve.band[order])
        if not look["linestyle"]:
            wide = {"color": look["color"], "alpha": 0.2, "linewidth": 8.0}
            ax.vlines(places, values - band, values + band, **wide)
        else:
            ends = values - band, values + band
            ax.fill_between(places, *ends, color=look["color"], alpha=0.2, linewidth=0.0)
    return sign


ROW = 0.04
"""Height of a row of crosses, in the height of the axes."""


def _draw_crosses(ax: Axes, places: Array, row: int, colour: str) -> Any:
    """Crosses in a row at the lower edge; return what stands in a legend."""
    heights, transform = np.full(places.size, ROW * (row + 0.5)), ax.get_xaxis_transform()
    (sign,) = ax.plot(places, heights, "x", color=colour, markersize=5.0, transform=transform)
    return sign


def _leave_room(ax: Axes, rows: int) -> None:
    """Move the values out of the way of that many rows of crosses, which are on grey."""
    if rows:
        share, scale = ROW * rows, ax.yaxis.get_transform()
        low, high = scale.transform(np.array(ax.get_ylim()))
        ends = np.array([low - share / (1.0 - share) * (high - low), low])
        bottom, top = scale.inverted().transform(ends).tolist()
        ax.set_ylim(bottom=bottom)
        ax.axhspan(bottom, top, color=EMPTY, linewidth=0.0, zorder=0.0)


@dataclass(frozen=True)
class HeatMap:
    """Values over two axes, (x, y), NaN where there is none; ``faulty`` cells came to no end.

    ``bars`` are errors of the values themselves, NaN where they are not known.
    """

    title: str
    values: Array
    faulty: NDArray[np.bool_]
    bars: Array

    @property
    def is_unsure(self) -> NDArray[np.bool_]:
        """Where a value's own error is more than the share ``UNSURE`` of it."""
        large = np.nan_to_num(self.bars) > UNSURE * np.abs(np.nan_to_num(self.values))
        return np.asarray(large & np.isfinite(self.values))


UNSURE = 0.1
"""Of a value in a heat map: it is hatched where its own error is more."""

HATCH = "////"


def heat_height(count: int) -> float:
    """Height in inches of that many heat maps."""
    return HEAT_HEIGHT * -(-count // HEAT_ACROSS) + (0.6 if count == 1 else 0.0)


def draw_heat_maps(
    figure: FigureBase, axes: tuple[SweptAxis, SweptAxis], maps: Sequence[HeatMap], what: str
) -> None:
    """Draw maps with the same axes and the same colours."""
    across = min(HEAT_ACROSS, len(maps))
    grid = figure.subplots(-(-len(maps) // across), across, squeeze=False, sharex=True, sharey=True)
    norm = _colours(np.concatenate([found.values.ravel() for found in maps]))
    orders = [np.argsort(axis.places, kind="stable") for axis in axes]
    x, y = (
        SweptAxis(axis.name, [axis.values[place] for place in order])
        for axis, order in zip(axes, orders, strict=True)
    )
    for ax, found in zip(grid.flat, maps, strict=False):
        held = (found.values, found.faulty, found.is_unsure)
        values, faulty, unsure = (part[np.ix_(*orders)].T for part in held)
        ax.set_facecolor(EMPTY)
        shown = np.ma.masked_invalid(values)
        drawn = ax.pcolormesh(x.edges, y.edges, shown, cmap="viridis", norm=norm, rasterized=True)
        rows, columns = np.nonzero(faulty)
        ax.plot(x.places[columns], y.places[rows], "x", color="black", markersize=4.0)
        dark = np.asarray(norm(shown) < DARK)
        _hatch(ax, x.edges, y.edges, unsure & dark, "white")
        _hatch(ax, x.edges, y.edges, unsure & ~dark, "black")
        ax.set_title(_short(found.title, LONGEST_BESIDE), loc="left", parse_math=False)
        _set_axis(ax, x, "x")
        _set_axis(ax, y, "y")
    for ax in list(grid.flat)[len(maps) :]:
        ax.set_visible(False)
    for ax in list(grid.flat)[: max(0, len(maps) - across)]:
        ax.set_xlabel("")
    for ax in list(grid.flat)[max(0, len(maps) - across) : len(maps)]:
        ax.tick_params(labelbottom=True)
    for ax in grid[:, 1:].flat:
        ax.set_ylabel("")
    figure.colorbar(drawn, ax=list(grid.flat), label=what)
    if any(np.isfinite(found.bars).any() for found in maps):
        some = any(found.is_unsure.any() for found in maps)
        look = {"hatch": HATCH} if some else {"alpha": 0.0}
        told = f"own error {'above' if some else 'nowhere above'} {UNSURE:.0%} of the value"
        sign = Patch(facecolor="none", edgecolor="black", linewidth=0.0, label=told, **look)
        figure.legend(handles=[sign], loc="outside lower left")


DARK = 0.6
"""Of the range of colours, below which they are dark: hatches are white there, else black."""


def _hatch(ax: Axes, x: Array, y: Array, cells: NDArray[np.bool_], colour: str) -> None:
    """Hatch the cells, (y, x), between the edges."""
    corners = [
        [(x[j], y[i]), (x[j + 1], y[i]), (x[j + 1], y[i + 1]), (x[j], y[i + 1])]
        for i, j in np.argwhere(cells)
    ]
    if corners:
        ax.add_collection(
            PolyCollection(corners, facecolor="none", edgecolor=colour, linewidth=0.0, hatch=HATCH)
        )


@dataclass(frozen=True)
class WorkCurve:
    """Errors at growing work: estimated ones, and achieved ones against the wave, of one family.

    ``own`` are errors of the achieved ones themselves, NaN where they are not known.
    """

    label: str
    seconds: Array
    updates: Array
    estimated: Array
    achieved: Array
    own: Array


WORK_HEIGHT = 3.0
"""Height of the panels of work against precision, in inches."""

LONGEST_IN_TWO = 50
"""Characters of the longest text of a legend in two columns above a picture."""

OF_ESTIMATE, OF_WAVE = "estimated", "relative to the wave"


def work_columns(curves: Sequence[WorkCurve]) -> int:
    """Columns of the legend above the panels of work against precision."""
    longest = max((len(curve.label) for curve in curves), default=0)
    return 2 if longest + len(f": {OF_WAVE}") <= LONGEST_IN_TWO else 1


def work_height(curves: Sequence[WorkCurve]) -> float:
    """Height in inches of the panels of work against precision with their legend."""
    return WORK_HEIGHT + 0.4 * len(curves) / work_columns(curves)


def draw_work_precision(
    figure: FigureBase, curves: Sequence[WorkCurve], joined: bool = True
) -> None:
    """Errors against work, both in logarithms: seconds, and site updates, which repeat exactly.

    Estimates are ``joined``, and where there are none what was achieved.
    """
    panels = figure.subplots(1, 2, sharey=True)
    for number, curve in enumerate(curves):
        look: dict[str, Any] = CURVES[number % len(CURVES)] | {"markersize": 4.0}
        look |= {} if joined else {"linestyle": ""}
        for ax, work in zip(panels, (curve.seconds, curve.updates), strict=True):
            name = f"{curve.label}: " if curve.label else ""
            achieved = look | {"markerfacecolor": "none"}
            if np.isfinite(curve.estimated).any():
                ax.loglog(work, _positive(curve.estimated), label=f"{name}{OF_ESTIMATE}", **look)
                achieved["linestyle"] = ""
            values = _positive(curve.achieved)
            if np.isfinite(values).any():
                ax.loglog(work, values, label=f"{name}{OF_WAVE}", **achieved)
            low = np.maximum(values - curve.own, 0.01 * values)
            ax.vlines(work, low, values + curve.own, color=look["color"], linewidth=1.0)
    along = {
        "seconds of the run": np.concatenate([curve.seconds for curve in curves]),
        "site updates": np.concatenate([curve.updates for curve in curves]),
    }
    for ax, (words, done) in zip(panels, along.items(), strict=True):
        ax.set_xlabel(words)
        ax.xaxis.set_minor_formatter(NullFormatter())
        known = done[np.isfinite(done)]
        if known.size and known.max() < 1.1 * known.min():  # the same work in all cells
            ax.set_xlim(known.min() / 2.0, 2.0 * known.max())
        low, high = ax.get_xlim()
        if high < 10.0 * low:  # no power of ten may be among them
            ticks = np.geomspace(low, high, 5)[1::2]
            ax.set_xticks(ticks, [f"{tick:.3g}" for tick in ticks])
        ax.grid(visible=True, which="major", linewidth=0.3, alpha=0.5)
    panels[0].set_ylabel("error")
    handles, labels = panels[0].get_legend_handles_labels()
    above = figure.legend(handles, labels, loc="outside upper center", ncols=work_columns(curves))
    _plain_legend(above, LONGEST_ABOVE)


def _positive(values: Array) -> Array:
    return np.where(values > 0.0, values, np.nan)


def _plain_legend(legend: Any, longest: int) -> None:
    """Show texts of a file as they are, if they are not longer than that."""
    for text in legend.get_texts():
        text.set_parse_math(False)
        text.set_text(_short(text.get_text(), longest))


def _short(text: str, longest: int) -> str:
    """A text with its middle left out if it is longer: texts of one axis may begin alike."""
    if len(text) <= longest:
        return text
    half = (longest - len(CUT)) // 2
    return f"{text[:half].rstrip()}{CUT}{text[-half:].lstrip()}"


def _is_wide(values: Array) -> bool:
    known = values[np.isfinite(values)]
    return known.size > 1 and known.min() > 0.0 and known.max() >= WIDE * known.min()


def _colours(values: Array) -> Normalize:
    """Logarithmic colours for wide positive values; some range where all are equal."""
    known = values[np.isfinite(values)]
    if not known.size:
        return Normalize(0.0, 1.0)
    low, high = float(known.min()), float(known.max())
    if _is_wide(values):
        return LogNorm(low, high)
    return Normalize(low, high) if low < high else Normalize(low - 0.5, low + 0.5)


def _set_axis(ax: Axes, axis: SweptAxis, letter: str) -> None:
    """Name an axis, and put its ticks at the values where they are few or texts."""
    label = LETTERS.get(axis.name, f"${axis.name}$" if LETTER.fullmatch(axis.name) else axis.name)
    getattr(ax, f"set_{letter}label")(label, parse_math=label.startswith("$"))
    set_ticks = getattr(ax, f"set_{letter}ticks")
    if axis.is_text:
        texts = [_short(str(value), LONGEST_TICK) for value in axis.values]
        set_ticks(axis.places, texts, parse_math=False, rotation=30 if letter == "x" else 0)
    elif axis.is_logarithmic:
        getattr(ax, f"set_{letter}scale")("log")
        ticks = axis.places[:: -(-len(axis.places) // MOST_TICKS)]
        set_ticks(ticks, [_plain(tick) for tick in ticks])
        set_ticks([], minor=True)


def _plain(value: float) -> str:
    """Three digits of a number, and all of a long one that has no power of ten."""
    return f"{value:.0f}" if 1e3 <= value < 1e7 else f"{value:.3g}"


MOST_TICKS = 6
"""Ticks of a logarithmic axis, which has them at its values."""
