"""Pictures of a sweep: a number of each cell over the swept dimensions, and work against precision.

Of one dimension curves are drawn, of two a heat map, of three several; samples and realisations of
disorder are told by what they have in common. Of more dimensions, and of what has too many values
to be told apart, some are to be chosen: ``at`` says where. `sweep_drawing` draws them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from longwave.reports.pictures.growth_plotting import growth_map, growth_panels
from longwave.reports.pictures.style import Part
from longwave.reports.pictures.sweep_drawing import (
    SweptAxis,
    heat_maps,
    swept_curves,
    work_precision,
)
from longwave.reports.pictures.sweep_kinds import GROWTH_MAP, VALUES, WORK_PRECISION, Choice
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

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

OWN_ERRORS = {"error": "own_error", "growth_rate": "growth_rate_error"}
"""Numbers that have an error of their own, in their own units."""

WORK = ("tolerance", "scheme.step", "step", "lattice.order", "order", "scheme.name", "scheme")
"""Fields along which a run takes more work for less error: of two the first is drawn along."""

ENDED = ("done", "blown up")
"""Cells whose numbers are drawn."""

PULSE = ("last_peak", "last_energy")
"""What disorder left of a pulse, which is drawn before its error: a mere delay is one."""


def sweep_parts(data: xr.Dataset, kind: str | None, at: Choice, variable: str) -> list[Part]:
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
        return [growth_map(growth_panels(data, MOST_CURVES))]
    if "growth_rate" in data and variable == "error":
        with suppress(ValueError):
            return [growth_map(growth_panels(data, MOST_CURVES))]
    drawn = [name for name in PULSE if name in data and variable == "error"] + [variable]
    found = [] if data["status"].ndim == 0 else [values_part(data, name) for name in drawn]
    if work_dimension(data) is not None:
        with suppress(ValueError):
            found.append(work_part(data))
    return found or [values_part(data, variable)]


def chosen(data: xr.Dataset, at: Choice) -> xr.Dataset:
    """The cells where swept fields have these values, dimensions of one value left out.

    Raises ValueError in one line for a field that is not swept and a value that is not there.
    """
    for name, value in at.items():
        known = [str(field) for field in data.coords if data[field].ndim == 1]
        if name not in known:
            raise ValueError(
                f"at must name a swept field, got {shown(name)} ({one_of(name, known)})"
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
    known = _listed(list(dict.fromkeys(map(_text, held))))
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


def values_part(data: xr.Dataset, variable: str) -> Part:
    """A number of each cell over the dimensions that are left."""
    cells = _cells(data, variable)
    dims = [str(name) for name in cells.dims]
    if not dims:
        raise ValueError(
            f"a picture must be of two cells or more, got one cell (its {variable} is "
            f"{float(cells['value']):g}; sweep more values, or leave out an --at)"
        )
    repeats = _repeats(data, dims)
    drawn = [name for name in dims if name not in repeats]
    if len(dims) == 1 or (repeats and len(drawn) == 1):
        return _curves(data, cells, repeats, [])
    families = _families(data, drawn, bool(repeats))
    if len(drawn) == 2 and families:
        return _curves(data, cells, repeats, families)
    if len(drawn) in (2, 3) and not repeats:
        return _maps(data, cells)
    sizes = ", ".join(f"{data.sizes[name]} {name}" for name in dims)
    condition = (
        f"repeats must be over one or two dimensions, one of at most {MOST_CURVES} values"
        if repeats
        else "a picture must be of one to three dimensions"
    )
    raise ValueError(f"{condition}, got {sizes} (choose with --at NAME=VALUE)")


def _cells(data: xr.Dataset, variable: str) -> xr.Dataset:
    """Of each cell the ``value`` of a variable, its ``own`` error, and whether it is ``faulty``.

    NaN where it came to no end or is not known; faulty is what was run, to no good end or value.
    """
    values = _numbers(data, variable)
    settled = data["status"].isin(("done", "missing")) | np.isfinite(values)
    attrs = {"label": _label(variable, data[variable].attrs)}
    found = {"value": values, "own": _own_error(data, values), "faulty": ~settled}
    return xr.Dataset({name: part.variable for name, part in found.items()}, attrs=attrs)


def _numbers(data: xr.Dataset, variable: str, needed: bool = True) -> xr.DataArray:
    """A number of each cell that came to an end, NaN of the others; some if it is ``needed``."""
    dims = data["status"].dims
    known = [str(n) for n in data if data[n].dtype.kind in "fiu" and data[n].dims == dims]
    if variable not in known:
        raise ValueError(
            f"variable must be a number of each cell, got {shown(variable)} "
            f"({one_of(variable, known)})"
        )
    values = data[variable].astype(float)
    values = values.where(data["status"].isin(ENDED) & np.isfinite(values))
    if needed and not values.notnull().any():
        raise ValueError(
            f"{variable} must be a number in some cell, got none in {values.size} cells "
            "(see their status and message)"
        )
    return values


def _own_error(data: xr.Dataset, values: xr.DataArray) -> xr.DataArray:
    name = OWN_ERRORS.get(str(values.name))
    return data[name].astype(float) if name in data else xr.full_like(values, np.nan)


def _label(name: str, attrs: Mapping[str, Any]) -> str:
    told, units = attrs.get("long_name", ""), attrs.get("units", "1")
    words = told if 0 < len(told) <= LONGEST_LABEL else name.replace("_", " ")
    return words if units in ("1", "") else f"{words}  ({units})"


def _repeats(data: xr.Dataset, dims: Sequence[str]) -> list[str]:
    """The dimension of samples, or of realisations, along which nothing is drawn."""
    seeds = [n for n in dims if n in data.coords and data[n].attrs.get("field") == REALISATION]
    return [name for name in dims if name == SAMPLE] or seeds


def _families(data: xr.Dataset, drawn: Sequence[str], repeated: bool) -> list[str]:
    """The dimension with a curve for each value, if they are few.

    It is the one with texts, and of repeats, which have no heat map, else the smallest one.
    """
    found = [name for name in drawn if axis_of(data, name).is_text]
    if repeated and not found:
        found = sorted(drawn, key=lambda name: data.sizes[name])
    return found[:1] if found and data.sizes[found[0]] <= MOST_CURVES else []


def axis_of(data: xr.Dataset, name: str) -> SweptAxis:
    """A dimension as an axis; that of a list or sample by the field that tells its cells apart."""
    fields = [data[name]] if name in data.coords else []
    fields += [data[c] for c in data.coords if data[c].dims == (name,) and c != name]
    for field in fields:
        held = field.values
        if len({str(one) for one in held}) == held.size:
            told = TOLD.get(field.attrs.get("field", ""), str(field.name))
            numbers = held.dtype.kind in "fiu"
            return SweptAxis(told, held.astype(float if numbers else str).tolist())
    return SweptAxis(name, [float(place) for place in range(data.sizes[name])])


def _titles(axis: SweptAxis, bare: bool = False) -> list[str]:
    """Each value with the axis's name; texts that need none alone."""
    return [_text(v) if bare and axis.is_text else f"{axis.name} = {_text(v)}" for v in axis.values]


def _curves(
    data: xr.Dataset, cells: xr.Dataset, repeats: Sequence[str], families: Sequence[str]
) -> Part:
    """Curves along one dimension: one, one for each value of another, or of all repeats."""
    rest = [str(name) for name in cells.dims if name not in families]
    along = min(rest, key=lambda name: name in repeats)
    told = _own_told(cells)
    if len(rest) == 2:
        common, told = (_medians, BY_MEDIAN) if repeats == [SAMPLE] else (_means, BY_MEAN)
        counts = cells["value"].notnull().sum(repeats).values
        ends = dict.fromkeys(map(str, (counts[counts > 0].min(), counts.max())))
        told = told.format(" to ".join(ends))
        cells = common(cells, repeats[0]).assign(faulty=cells["faulty"].any(repeats))
    else:
        cells = cells.assign(low=cells["own"], high=cells["own"])
    axis, joined = axis_of(data, along), along not in repeats
    curves = {"": cells}
    if families:
        titles = _titles(axis_of(data, families[0]), bare=True)
        curves = {title: cells.isel({families[0]: i}) for i, title in enumerate(titles)}
    return swept_curves(axis, curves, joined, told)


BY_MEDIAN = "median of {}, bars to the quartiles"
BY_MEAN = "mean of {}, bars: standard error, band: standard deviation"
"""How repeats are told."""


def _own_told(cells: xr.Dataset) -> str:
    """How large the errors of the values themselves are, which may be too small to be seen."""
    size = abs(cells["value"])
    known = np.isfinite(cells["own"]) & (size > 0.0)
    if not known.any():
        return ""
    with np.errstate(all="ignore"):
        share = float((cells["own"] / size).where(known).max())
    return f"bars: own error, at most {float(f'{100.0 * share:.2g}'):g}% of the value"


def _medians(cells: xr.Dataset, repeats: str) -> xr.Dataset:
    """The median, and how far down and up the quartiles are."""
    known = cells["value"].notnull().any(repeats)
    values = cells["value"].where(known, 0.0).quantile([0.25, 0.5, 0.75], repeats).where(known)
    first, middle, third = (values.isel(quantile=place, drop=True) for place in range(3))
    found = {"value": middle, "low": middle - first, "high": third - middle}
    return xr.Dataset(found, attrs=cells.attrs)


def _means(cells: xr.Dataset, repeats: str) -> xr.Dataset:
    """The mean, its standard error down and up, and the standard deviation as ``band``."""
    values = cells["value"]
    count = values.notnull().sum(repeats)
    with np.errstate(all="ignore"):
        mean = values.sum(repeats) / count
        band = np.sqrt(((values - mean) ** 2).sum(repeats) / (count - 1))
        error = band / np.sqrt(count)
    found = {"value": mean, "low": error, "high": error, "band": band}
    return xr.Dataset(found, attrs=cells.attrs)


def _maps(data: xr.Dataset, cells: xr.Dataset) -> Part:
    """A heat map over two dimensions, or one for each value of the third."""
    names = [str(name) for name in cells.dims]
    over = ""
    if len(names) == 3:
        texts = [name for name in names if axis_of(data, name).is_text]
        over = (texts or sorted(names, key=lambda name: data.sizes[name]))[0]
        names.remove(over)
    if over and data.sizes[over] > MOST_MAPS:
        raise ValueError(
            f"{over} must have at most {MOST_MAPS} values for as many maps, got "
            f"{data.sizes[over]} (choose with --at {over}=VALUE)"
        )
    maps = {"": cells}
    if over:
        titles = _titles(axis_of(data, over))
        maps = {title: cells.isel({over: place}) for place, title in enumerate(titles)}
    axes = {name: axis_of(data, name) for name in names}
    return heat_maps(axes, maps)


def work_dimension(data: xr.Dataset) -> str | None:
    """The dimension along which more work is done, None if there is none."""
    names = [str(name) for name in data["status"].dims]
    fields = {data[n].attrs.get("field", n) if n in data.coords else n: n for n in names}
    return next((fields[field] for field in WORK if field in fields), None)


def work_part(data: xr.Dataset) -> Part:
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
    held = numbers["estimated"].notnull() | numbers["achieved"].notnull()
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
    titles = [_titles(axis_of(data, str(name))) for name in drawn.dims]
    curves = {
        ", ".join(title[i] for title, i in zip(titles, places, strict=True)): numbers.isel(
            dict(zip(drawn.dims, places, strict=True))
        )
        for places in np.argwhere(drawn.values).tolist()
    }
    return work_precision(curves, joined)


def _work_numbers(data: xr.Dataset) -> xr.Dataset:
    """The ``seconds`` and site ``updates`` of all cells, the errors that were ``estimated``, and
    those ``achieved`` against the wave with their ``own``."""
    seconds, evaluations, sites = (
        _numbers(data, name) for name in ("seconds", "force_evaluations", "sites")
    )
    estimated = _numbers(data, "error_estimate", needed=False)  # none where a step is stated
    achieved = _numbers(data, "error", needed=not estimated.notnull().any())
    return xr.Dataset(
        {
            "seconds": seconds,
            "updates": evaluations * sites,
            "estimated": estimated,
            "achieved": achieved,
            "own": _own_error(data, achieved),
        }
    )
