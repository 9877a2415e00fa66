"""Pictures of a sweep: a variable over the swept dimensions, and work against precision.

One dimension is drawn as curves, two as a heat map, three as several heat maps; samples and
realisations of disorder are drawn by their median or mean. For more dimensions, or too many values
for a picture, ``at`` must choose cells. `sweep_drawing` draws the pictures.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from longwave.reports.pictures import sweep_drawing
from longwave.reports.pictures.growth_plotting import growth_map, growth_panels
from longwave.reports.pictures.style import Part
from longwave.reports.pictures.sweep_kinds import GROWTH_MAP, VALUES, WORK_PRECISION, Choice
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

SAMPLE = "sample"
"""Name of the dimension of a sweep's random samples."""

REALISATION = "disorder.seed"
"""Swept field whose values number the realisations of one disorder."""

MAX_CURVES, MAX_MAPS = 8, 12
"""Largest number of curves in a picture (the number of colours), and of heat maps on a page."""

MAX_LABEL_CHARACTERS = 50
"""Largest length of a variable's long name as an axis label; else its short name is used."""

MAX_LISTED_VALUES = 20
"""Largest number of values that an error message lists."""

FIELD_NAMES = {"scheme.name": "scheme", "domain.kind": "domain", "disorder.of": "disorder of"}
"""Dotted field -> its name in pictures, if the last part of the field is not clear alone."""

OWN_ERRORS = {"error": "own_error", "growth_rate": "growth_rate_error"}
"""Variable of a sweep -> the variable with its numerical error, in the same units."""

WORK = ("tolerance", "scheme.step", "step", "lattice.order", "order", "scheme.name", "scheme")
"""Fields that trade work for accuracy; the first that is swept is the dimension of work."""

ENDED = ("done", "blown up")
"""Statuses of the cells whose numbers are drawn: those with a run."""

PULSE = ("last_peak", "last_energy")
"""Variables drawn in preference to a pulse's error, which is large even for a mere delay."""


def sweep_parts(data: xr.Dataset, kind: str | None, at: Choice, variable: str) -> list[Part]:
    """Return the pictures of that kind, by default all, of the cells with the values in ``at``.

    Raises ValueError for an invalid choice, for a sweep that has nothing to draw, and for too many
    values in a picture.
    """
    data = chosen(data, at)
    if kind == VALUES:
        return [values_part(data, variable)]
    if kind == WORK_PRECISION:
        return [work_part(data)]
    if kind == GROWTH_MAP:
        return [growth_map(growth_panels(data, MAX_CURVES))]
    if "growth_rate" in data and variable == "error":
        with suppress(ValueError):
            return [growth_map(growth_panels(data, MAX_CURVES))]
    variables = [name for name in PULSE if name in data and variable == "error"] + [variable]
    parts = [] if data["status"].ndim == 0 else [values_part(data, name) for name in variables]
    if work_dimension(data) is not None:
        with suppress(ValueError):
            parts.append(work_part(data))
    return parts or [values_part(data, variable)]


def chosen(data: xr.Dataset, at: Choice) -> xr.Dataset:
    """Return the cells with the values in ``at`` of swept fields, without dimensions of one value.

    Raises ValueError for a field that is not swept and for a value that does not occur.
    """
    for name, value in at.items():
        known = [str(field) for field in data.coords if data[field].ndim == 1]
        if name not in known:
            got = f"{shown(name)} ({one_of(name, known)})"
            raise ValueError(f"at must name a swept field, got {got}")
        column = data[name]
        data = data.isel({column.dims[0]: _matching(name, column.values, value)})
    return data.squeeze()


def _matching(name: str, values: NDArray[Any], value: str | float) -> list[int]:
    """Return the indices of values equal to ``value``, or else of values with its printed text.

    Raises ValueError if there is none, or if several different values have that text.
    """
    for as_text in (str, _text):
        indices = [index for index, entry in enumerate(values) if _same(entry, value, as_text)]
        matches = list(dict.fromkeys(str(values[index]) for index in indices))
        if len(matches) > 1 and as_text is _text:
            got = f"{shown(value)} (one of {_listed(matches)})"
            raise ValueError(f"{name} must match one value, got {got}")
        if indices:
            return indices
    known = _listed(list(dict.fromkeys(map(_text, values))))
    raise ValueError(f"{name} must be one of its values, got {shown(value)} (one of {known})")


def _same(entry: object, value: str | float, as_text: Callable[[object], str]) -> bool:
    try:
        return bool(np.isclose(float(as_text(entry)), float(value), rtol=1e-9, atol=0.0))
    except (TypeError, ValueError):
        return str(entry) == str(value)


def _listed(texts: Sequence[str]) -> str:
    return ", ".join([*texts[:MAX_LISTED_VALUES], *["..."] * (len(texts) > MAX_LISTED_VALUES)])


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, int | float | np.number) else str(value)


def values_part(data: xr.Dataset, variable: str) -> Part:
    """Return a picture of a variable over its 1 to 3 swept dimensions; ValueError for more."""
    cells = _cells(data, variable)
    dims = [str(name) for name in cells.dims]
    if not dims:
        raise ValueError(
            f"a picture must be of two cells or more, got one cell (its {variable} is "
            f"{float(cells['value']):g}; sweep more values, or leave out an --at)"
        )
    repeats = _repeats(data, dims)
    plotted = [name for name in dims if name not in repeats]
    if len(dims) == 1 or (repeats and len(plotted) == 1):
        return _curves(data, cells, repeats, [])
    families = _families(data, plotted, bool(repeats))
    if len(plotted) == 2 and families:
        return _curves(data, cells, repeats, families)
    if len(plotted) in (2, 3) and not repeats:
        return _maps(data, cells)
    sizes = ", ".join(f"{data.sizes[name]} {name}" for name in dims)
    condition = "a picture must be of one to three dimensions"
    if repeats:
        condition = (
            f"repeats must be over one or two dimensions, one of at most {MAX_CURVES} values"
        )
    raise ValueError(f"{condition}, got {sizes} (choose with --at NAME=VALUE)")


def _cells(data: xr.Dataset, variable: str) -> xr.Dataset:
    """Return each cell's ``value`` of a variable, ``own`` numerical error, and whether ``faulty``.

    A value is NaN if the cell has no result or the value is not known. A cell is faulty if it was
    run without a usable value.
    """
    values = _numbers(data, variable)
    settled = data["status"].isin(("done", "missing")) | np.isfinite(values)
    attrs = {"label": _label(variable, data[variable].attrs)}
    variables = {"value": values, "own": _own_error(data, values), "faulty": ~settled}
    return xr.Dataset({name: part.variable for name, part in variables.items()}, attrs=attrs)


def _numbers(data: xr.Dataset, variable: str, needed: bool = True) -> xr.DataArray:
    """Return a variable of the ended cells, NaN elsewhere; ValueError if ``needed`` and all NaN."""
    dims = data["status"].dims
    known = [str(n) for n in data if data[n].dtype.kind in "fiu" and data[n].dims == dims]
    if variable not in known:
        got = f"{shown(variable)} ({one_of(variable, known)})"
        raise ValueError(f"variable must be a number of each cell, got {got}")
    values = data[variable].astype(float)
    values = values.where(data["status"].isin(ENDED) & np.isfinite(values))
    if needed and not values.notnull().any():
        got = f"none in {values.size} cells (see their status and message)"
        raise ValueError(f"{variable} must be a number in some cell, got {got}")
    return values


def _own_error(data: xr.Dataset, values: xr.DataArray) -> xr.DataArray:
    name = OWN_ERRORS.get(str(values.name))
    return data[name].astype(float) if name in data else xr.full_like(values, np.nan)


def _label(name: str, attrs: Mapping[str, Any]) -> str:
    long_name, units = attrs.get("long_name", ""), attrs.get("units", "1")
    text = long_name if 0 < len(long_name) <= MAX_LABEL_CHARACTERS else name.replace("_", " ")
    return text if units in ("1", "") else f"{text}  ({units})"


def _repeats(data: xr.Dataset, dims: Sequence[str]) -> list[str]:
    """Return the dimension of samples, or of realisations of disorder, as a list; empty if none."""
    seeds = [n for n in dims if n in data.coords and data[n].attrs.get("field") == REALISATION]
    return [name for name in dims if name == SAMPLE] or seeds


def _families(data: xr.Dataset, drawn: Sequence[str], repeated: bool) -> list[str]:
    """Return the dimension with a curve for each value, as a list; empty for too many values.

    The dimension whose values are texts is taken. If none is, and values are ``repeated`` (heat
    maps cannot show repeats), the shortest dimension of ``drawn`` is taken.
    """
    families = [name for name in drawn if axis_of(data, name).is_text]
    if repeated and not families:
        families = sorted(drawn, key=lambda name: data.sizes[name])
    return families[:1] if families and data.sizes[families[0]] <= MAX_CURVES else []


def axis_of(data: xr.Dataset, name: str) -> sweep_drawing.SweptAxis:
    """Return a dimension as an axis: a field with distinct values along it, or else 0, 1, 2, ..."""
    fields = [data[name]] if name in data.coords else []
    fields += [data[c] for c in data.coords if data[c].dims == (name,) and c != name]
    for field in fields:
        values = field.values
        if len({str(entry) for entry in values}) == values.size:
            name_on_axis = FIELD_NAMES.get(field.attrs.get("field", ""), str(field.name))
            numbers = values.dtype.kind in "fiu"
            return sweep_drawing.SweptAxis(
                name_on_axis, values.astype(float if numbers else str).tolist()
            )
    return sweep_drawing.SweptAxis(name, [float(place) for place in range(data.sizes[name])])


def _titles(axis: sweep_drawing.SweptAxis, bare: bool = False) -> list[str]:
    """Return a title for each value of an axis: "name = value", or the text alone if ``bare``."""
    return [_text(v) if bare and axis.is_text else f"{axis.name} = {_text(v)}" for v in axis.values]


def _curves(
    data: xr.Dataset, cells: xr.Dataset, repeats: Sequence[str], families: Sequence[str]
) -> Part:
    """Return curves along a dimension: one, or one for each value of the dimension ``families``.

    If ``repeats`` names a dimension, the curves show medians or means over it.
    """
    rest = [str(name) for name in cells.dims if name not in families]
    along = min(rest, key=lambda name: name in repeats)
    caption = _error_caption(cells)
    if len(rest) == 2:
        common, caption = (_medians, BY_MEDIAN) if repeats == [SAMPLE] else (_means, BY_MEAN)
        counts = cells["value"].notnull().sum(repeats).values
        ends = dict.fromkeys(map(str, (counts[counts > 0].min(), counts.max())))
        caption = caption.format(" to ".join(ends))
        cells = common(cells, repeats[0]).assign(faulty=cells["faulty"].any(repeats))
    else:
        cells = cells.assign(low=cells["own"], high=cells["own"])
    axis, joined = axis_of(data, along), along not in repeats
    curves = {"": cells}
    if families:
        titles = _titles(axis_of(data, families[0]), bare=True)
        curves = {title: cells.isel({families[0]: i}) for i, title in enumerate(titles)}
    return sweep_drawing.swept_curves(axis, curves, joined, caption)


BY_MEDIAN = "median of {}, bars to the quartiles"
"""Caption of curves over random samples; the braces stand for the number of samples."""

BY_MEAN = "mean of {}, bars: standard error, band: standard deviation"
"""Caption of curves over realisations of disorder; the braces stand for their number."""


def _error_caption(cells: xr.Dataset) -> str:
    """Return a caption with the largest relative numerical error: its bars may be invisible."""
    size = abs(cells["value"])
    known = np.isfinite(cells["own"]) & (size > 0.0)
    if not known.any():
        return ""
    with np.errstate(all="ignore"):
        largest = float((cells["own"] / size).where(known).max())
    return f"bars: own error, at most {float(f'{100.0 * largest:.2g}'):g}% of the value"


def _medians(cells: xr.Dataset, repeats: str) -> xr.Dataset:
    """Return the median over repeats, and its distances ``low`` and ``high`` to the quartiles."""
    known = cells["value"].notnull().any(repeats)
    values = cells["value"].where(known, 0.0).quantile([0.25, 0.5, 0.75], repeats).where(known)
    first, middle, third = (values.isel(quantile=place, drop=True) for place in range(3))
    variables = {"value": middle, "low": middle - first, "high": third - middle}
    return xr.Dataset(variables, attrs=cells.attrs)


def _means(cells: xr.Dataset, repeats: str) -> xr.Dataset:
    """Return the mean over repeats, its standard error, and the standard deviation as ``band``."""
    values = cells["value"]
    count = values.notnull().sum(repeats)
    with np.errstate(all="ignore"):
        mean = values.sum(repeats) / count
        band = np.sqrt(((values - mean) ** 2).sum(repeats) / (count - 1))
        error = band / np.sqrt(count)
    variables = {"value": mean, "low": error, "high": error, "band": band}
    return xr.Dataset(variables, attrs=cells.attrs)


def _maps(data: xr.Dataset, cells: xr.Dataset) -> Part:
    """Return a heat map over two dimensions, or one map for each value of a third dimension."""
    names = [str(name) for name in cells.dims]
    over = ""
    if len(names) == 3:
        texts = [name for name in names if axis_of(data, name).is_text]
        over = (texts or sorted(names, key=lambda name: data.sizes[name]))[0]
        names.remove(over)
    if over and data.sizes[over] > MAX_MAPS:
        got = f"{data.sizes[over]} (choose with --at {over}=VALUE)"
        raise ValueError(f"{over} must have at most {MAX_MAPS} values for as many maps, got {got}")
    maps = {"": cells}
    if over:
        titles = _titles(axis_of(data, over))
        maps = {title: cells.isel({over: index}) for index, title in enumerate(titles)}
    return sweep_drawing.heat_maps({name: axis_of(data, name) for name in names}, maps)


def work_dimension(data: xr.Dataset) -> str | None:
    """Return the dimension of the first swept field of `WORK`; None if no such field is swept."""
    names = [str(name) for name in data["status"].dims]
    fields = {data[n].attrs.get("field", n) if n in data.coords else n: n for n in names}
    return next((fields[field] for field in WORK if field in fields), None)


def work_part(data: xr.Dataset) -> Part:
    """Return a picture of errors against work along the tolerance, step or order.

    There is a curve for each combination of the other dimensions' values. Texts along the dimension
    of work, such as schemes, have a curve each if they are few.
    """
    along = work_dimension(data)
    if along is None:
        raise ValueError(
            f"work_precision must have a sweep over one of tolerance, order, scheme, step, got "
            f"{', '.join(map(str, data['status'].dims)) or 'one cell'} (sweep the tolerance)"
        )
    numbers = _work_numbers(data)
    has_errors = numbers["estimated"].notnull() | numbers["achieved"].notnull()
    others = [str(name) for name in has_errors.dims if name != along]
    joined = not axis_of(data, along).is_text
    if not joined and int(has_errors.sum()) <= MAX_CURVES:
        others = [str(name) for name in has_errors.dims]
    drawn = has_errors.any([name for name in has_errors.dims if name not in others])
    count = int(drawn.sum())
    if count > MAX_CURVES:
        got = f"{count} (choose with --at {others[0]}=VALUE)"
        raise ValueError(f"work_precision must have at most {MAX_CURVES} curves, got {got}")
    titles = [_titles(axis_of(data, str(name))) for name in drawn.dims]
    curves = {}
    for indices in np.argwhere(drawn.values).tolist():
        label = ", ".join(title[i] for title, i in zip(titles, indices, strict=True))
        curves[label] = numbers.isel(dict(zip(drawn.dims, indices, strict=True)))
    return sweep_drawing.work_precision(curves, joined)


def _work_numbers(data: xr.Dataset) -> xr.Dataset:
    """Return the ``seconds``, site ``updates`` and errors of all cells. The errors are
    ``estimated``, and ``achieved`` against the wave with their ``own`` errors."""
    work = {name: _numbers(data, name) for name in ("seconds", "force_evaluations", "sites")}
    updates = work["force_evaluations"] * work["sites"]
    estimated = _numbers(data, "error_estimate", needed=False)  # none where a step is stated
    achieved = _numbers(data, "error", needed=not estimated.notnull().any())
    errors = {"estimated": estimated, "achieved": achieved, "own": _own_error(data, achieved)}
    return xr.Dataset({"seconds": work["seconds"], "updates": updates, **errors})
