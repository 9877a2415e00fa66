"""Pictures of a sweep: a number of each cell over the swept dimensions, and work against precision.

Of one dimension curves are drawn, of two a heat map, of three several; samples and realisations of
disorder are told by what they have in common. Of more dimensions, and of what has too many values
to be told apart, some are to be chosen: ``at`` says where.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import FigureBase
from numpy.typing import NDArray

from longwave.reports.pictures.growth_figures import draw_growth, growth_height
from longwave.reports.pictures.growth_plotting import growth_panels
from longwave.reports.pictures.swept_figures import (
    CURVE_HEIGHT,
    HeatMap,
    SweptAxis,
    SweptCurve,
    WorkCurve,
    draw_heat_maps,
    draw_swept_curves,
    draw_work_precision,
    heat_height,
    work_height,
)
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


class WorkNumbers(NamedTuple):
    """What a `WorkCurve` has, of all cells."""

    seconds: xr.DataArray
    updates: xr.DataArray
    estimated: xr.DataArray
    achieved: xr.DataArray
    own: xr.DataArray


def _work_numbers(data: xr.Dataset) -> WorkNumbers:
    seconds, evaluations, sites = (
        _numbers(data, name) for name in ("seconds", "force_evaluations", "sites")
    )
    estimated = _ended(data, "error_estimate")  # none where a step is stated
    achieved = _ended(data, "error") if np.isfinite(estimated).any() else _numbers(data, "error")
    return WorkNumbers(seconds, evaluations * sites, estimated, achieved, _bars(data, achieved))


def _work_curves(
    data: xr.Dataset, numbers: WorkNumbers, drawn: xr.DataArray
) -> Iterator[WorkCurve]:
    names = [str(name) for name in drawn.dims]
    axes = {name: axis_of(data, name) for name in names}
    for places in np.argwhere(drawn.values):
        where = dict(zip(names, places.tolist(), strict=True))
        label = ", ".join(f"{axes[n].name} = {_text(axes[n].values[p])}" for n, p in where.items())
        yield WorkCurve(label, *(np.atleast_1d(part.isel(where).values) for part in numbers))
