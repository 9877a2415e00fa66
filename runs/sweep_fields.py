"""The fields of a sweep's runs as lazy arrays over all cells."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from xarray import Variable
from xarray.backends import BackendArray
from xarray.core import indexing

from longwave.runs.hdf_contents import local_member
from longwave.runs.run_file import load_run
from longwave.runs.run_pack import check_keys, decoded_values, open_pack
from longwave.runs.store_packs import PackedRun, link_free_parts, relocated_runs

RunLocation: TypeAlias = PackedRun | Path
"""Location of a cell's run: a row of a pack, or a file of its own."""


class FieldKind(NamedTuple):
    """Properties of a run's variable that must be equal in all runs to make one array of them."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: str
    is_coordinate: bool
    attributes: str


def _group_locations(locations: Mapping[int, RunLocation]) -> Sequence[dict[int, RunLocation]]:
    """Group cells by where their runs are stored: in a common group of a pack, or in a file."""
    groups: dict[object, dict[int, RunLocation]] = defaultdict(dict)
    for cell, location in locations.items():
        group = (location.pack, location.group) if isinstance(location, PackedRun) else location
        groups[group][cell] = location
    return list(groups.values())


def _field_kinds(location: RunLocation) -> Iterator[tuple[str, FieldKind]]:
    """Yield name and `FieldKind` of a run's variables, which are equal in all runs of a group."""
    for name, variable in load_location(location).variables.items():
        dims, attrs = tuple(map(str, variable.dims)), json.dumps(variable.attrs, sort_keys=True)
        layout = variable.shape, variable.dtype.str, dims == (name,), attrs
        yield str(name), FieldKind(dims, *layout)


def load_location(location: RunLocation) -> xr.Dataset:
    """Load the run of a cell from a pack or from a file of its own."""
    return location.load() if isinstance(location, PackedRun) else load_run(location, follow=False)


def _read_rows(field: str, locations: Iterable[RunLocation]) -> NDArray[Any]:
    """Read one variable of all runs of a group, stacked along a new first axis."""
    packed = [place for place in locations if isinstance(place, PackedRun)]
    if not packed:
        runs = (load_run(path, follow=False) for path in locations if isinstance(path, Path))
        return np.stack([run.variables[field].values for run in runs])
    try:
        with open_pack(packed[0].path, link_free_parts(packed[0].pack)) as file:
            group = local_member(file, str(packed[0].group))
            check_keys(group, [place.row for place in packed], [place.key for place in packed])
            array = local_member(local_member(group, "arrays"), field)
            return np.asarray(decoded_values(np.stack([array[place.row] for place in packed])))
    except FileNotFoundError:
        return np.stack([place.load().variables[field].values for place in relocated_runs(packed)])


class LazyField(BackendArray):
    """One variable of all runs, shape (*swept, *shape in a run), read from the store on demand.

    Cells without a run have NaN, or 0 in arrays of integers.
    """

    def __init__(
        self,
        field: str,
        locations: Mapping[int, RunLocation],
        swept: Sequence[int],
        kind: FieldKind,
    ) -> None:
        self._field, self._locations = field, locations
        self._swept, self._inner_shape = swept, kind.shape
        self.shape = (*swept, *kind.shape)
        self.dtype = np.dtype(kind.dtype)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """Return the values at an index of integers, slices and integer arrays."""
        support = indexing.IndexingSupport.OUTER
        return indexing.explicit_indexing_adapter(key, self.shape, support, self._read)

    def _read(self, key: tuple[Any, ...]) -> NDArray[Any]:
        cells = np.arange(int(np.prod(self._swept))).reshape(self._swept)
        swept_axes = len(self._swept)
        selected, inner_key = _index_axes(cells, key[:swept_axes]), key[swept_axes:]
        missing = np.nan if self.dtype.kind == "f" else 0
        rows = np.full((selected.size, *self._inner_shape), missing, self.dtype)
        positions = {int(cell): position for position, cell in enumerate(selected.ravel())}
        stored = {cell: self._locations[cell] for cell in positions if cell in self._locations}
        for group in _group_locations(stored):
            values = _read_rows(self._field, group.values())
            rows[[positions[cell] for cell in group]] = values
        selection = _index_axes(rows, (slice(None), *inner_key))
        return selection.reshape((*selected.shape, *selection.shape[1:]))


def _index_axes(values: NDArray[Any], key: tuple[Any, ...]) -> NDArray[Any]:
    """Index each axis independently (outer indexing); an integer removes its axis."""
    axis = 0
    for index in key:
        values = values[(slice(None),) * axis + (index,)]
        axis += not isinstance(index, int | np.integer)
    return values


def swept_fields(
    names: tuple[str, ...],
    shape: tuple[int, ...],
    locations: Mapping[int, RunLocation],
    reserved: Collection[str],
) -> Iterator[tuple[str, Variable, bool]]:
    """Yield (name, variable, whether it is a coordinate) for the fields of one shape in all runs.

    A coordinate with the same values in all runs remains a coordinate; another one becomes the
    variable ``cell_NAME``. A variable whose name is in ``reserved`` becomes ``run_NAME``.
    """
    kinds: dict[str, list[FieldKind]] = defaultdict(list)
    groups = _group_locations(locations)
    for cells in groups:
        for field, kind in _field_kinds(next(iter(cells.values()))):
            kinds[field].append(kind)
    for field, field_kinds in kinds.items():
        if len(field_kinds) < len(groups) or len(set(field_kinds)) > 1:
            continue
        kind = field_kinds[0]
        array = LazyField(field, locations, shape, kind)
        attrs = json.loads(kind.attributes)
        if kind.is_coordinate:
            same = _common_values(array, field, locations)
            if same is not None:
                yield field, Variable(kind.dims, same, attrs), True
                continue
        name = f"run_{field}" if field in reserved else field
        name = f"cell_{field}" if kind.is_coordinate else name
        lazy = indexing.LazilyIndexedArray(array)
        yield name, Variable((*names, *kind.dims), lazy, attrs), False


def _common_values(
    array: LazyField, field: str, locations: Mapping[int, RunLocation]
) -> NDArray[Any] | None:
    """Return the values of a coordinate if they are the same in all runs, else None."""
    first: NDArray[Any] | None = None
    for group in _group_locations(locations):
        values = _read_rows(field, group.values())
        first = values[0] if first is None else first
        expected = np.broadcast_to(first, values.shape)
        if not np.array_equal(values, expected, equal_nan=values.dtype.kind == "f"):
            return None
    return first
