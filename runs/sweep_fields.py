"""The fields of a sweep's runs as arrays over all its cells, read when they are used."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from xarray import Variable
from xarray.backends import BackendArray
from xarray.core import indexing

from longwave.runs.run_file import load_run
from longwave.runs.run_pack import PackedRun, values_of

Place: TypeAlias = PackedRun | Path
"""Where a cell's run is: in a pack, or a file of its own."""


class FieldKind(NamedTuple):
    """What must be alike for runs' variables to be one array."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: str
    is_coordinate: bool
    attributes: str


Group: TypeAlias = "tuple[Path, str]"


def _groups(places: Mapping[int, Place]) -> Mapping[Group, dict[int, int]]:
    """Files and their groups, each with the cells that are there and their rows."""
    found: dict[Group, dict[int, int]] = defaultdict(dict)
    for cell, place in places.items():
        if isinstance(place, PackedRun):
            found[place.path, place.group][cell] = place.row
        else:
            found[place, ""][cell] = 0
    return found


def _kinds(group: Group, row: int) -> Iterator[tuple[str, FieldKind]]:
    """The variables of the runs in one place, by one of them."""
    run = PackedRun(*group, row).load() if group[1] else load_run(group[0])
    for name, variable in run.variables.items():
        dims, told = tuple(map(str, variable.dims)), json.dumps(variable.attrs, sort_keys=True)
        held = variable.shape, variable.dtype.str, dims == (name,), told
        yield str(name), FieldKind(dims, *held)


def _rows(group: Group, field: str, rows: Sequence[int]) -> NDArray[Any]:
    """The values of a variable in these rows, stacked."""
    path, name = group
    if not name:
        return np.asarray(load_run(path).variables[field].values)[None]
    import h5py

    with h5py.File(path) as file:
        held = file[name]["arrays"][field]
        return np.asarray(values_of(np.stack([held[row] for row in rows])))


class FieldOfCells(BackendArray):
    """One variable of all runs, (*swept, *own); what is asked for is read from the store.

    Cells without a run have NaN, or 0 where numbers are whole.
    """

    def __init__(
        self, field: str, places: Mapping[int, Place], swept: tuple[int, ...], kind: FieldKind
    ) -> None:
        self._field, self._places, self._swept, self._own = field, places, swept, kind.shape
        self.shape = (*swept, *kind.shape)
        self.dtype = np.dtype(kind.dtype)

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        """The values under a key of whole numbers, slices and arrays of numbers."""
        support = indexing.IndexingSupport.OUTER
        return indexing.explicit_indexing_adapter(key, self.shape, support, self._read)

    def _read(self, key: tuple[Any, ...]) -> NDArray[Any]:
        cells = np.arange(int(np.prod(self._swept))).reshape(self._swept)
        count = len(self._swept)
        wanted, own = _outer(cells, key[:count]), key[count:]
        empty = np.nan if self.dtype.kind == "f" else 0
        flat = np.full((wanted.size, *self._own), empty, self.dtype)
        asked = {int(cell): place for place, cell in enumerate(wanted.ravel())}
        known = {cell: self._places[cell] for cell in asked if cell in self._places}
        for group, inside in _groups(known).items():
            values = _rows(group, self._field, list(inside.values()))
            flat[[asked[cell] for cell in inside]] = values
        inner = _outer(flat, (slice(None), *own))
        return inner.reshape((*wanted.shape, *inner.shape[1:]))


def _outer(values: NDArray[Any], key: tuple[Any, ...]) -> NDArray[Any]:
    """Each axis indexed by itself; an axis with a single number goes."""
    axis = 0
    for index in key:
        values = values[(slice(None),) * axis + (index,)]
        axis += not isinstance(index, int | np.integer)
    return values


def swept_fields(
    names: tuple[str, ...],
    shape: tuple[int, ...],
    places: Mapping[int, Place],
    taken: Collection[str],
) -> Iterator[tuple[str, Variable, bool]]:
    """The variables that all runs have in one shape, and whether each is a coordinate.

    A coordinate that is the same in all runs stays one; one that is not is called ``cell_NAME``,
    and what is ``taken`` ``run_NAME``.
    """
    kinds: dict[str, list[FieldKind]] = defaultdict(list)
    groups = _groups(places)
    for group, cells in groups.items():
        for field, kind in _kinds(group, min(cells.values())):
            kinds[field].append(kind)
    for field, found in kinds.items():
        if len(found) < len(groups) or len(set(found)) > 1:
            continue
        kind = found[0]
        array = FieldOfCells(field, places, shape, kind)
        told = json.loads(kind.attributes)
        if kind.is_coordinate:
            same = _common(array, field, places)
            if same is not None:
                yield field, Variable(kind.dims, same, told), True
                continue
        name = f"run_{field}" if field in taken else field
        name = f"cell_{field}" if kind.is_coordinate else name
        lazy = indexing.LazilyIndexedArray(array)
        yield name, Variable((*names, *kind.dims), lazy, told), False


def _common(array: FieldOfCells, field: str, places: Mapping[int, Place]) -> NDArray[Any] | None:
    """The values of a coordinate if all runs have the same ones."""
    first: NDArray[Any] | None = None
    for group, inside in _groups(places).items():
        values = _rows(group, field, list(inside.values()))
        first = values[0] if first is None else first
        same = np.broadcast_to(first, values.shape)
        if not np.array_equal(values, same, equal_nan=values.dtype.kind == "f"):
            return None
    return first
