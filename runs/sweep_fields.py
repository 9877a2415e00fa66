"""The fields of a sweep's runs as arrays over all its cells, read when they are used."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from xarray import Variable
from xarray.backends import BackendArray
from xarray.core import indexing

from longwave.runs.hdf_contents import own
from longwave.runs.run_file import load_run
from longwave.runs.run_pack import check_keys, open_pack, values_of
from longwave.runs.store_packs import PackedRun, moved

Place: TypeAlias = PackedRun | Path
"""Where a cell's run is: in a pack, or a file of its own."""


class FieldKind(NamedTuple):
    """What must be alike for runs' variables to be one array."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: str
    is_coordinate: bool
    attributes: str


def _groups(places: Mapping[int, Place]) -> Sequence[dict[int, Place]]:
    """The cells whose runs lie in one group of a pack, or in a file of their own."""
    found: dict[object, dict[int, Place]] = defaultdict(dict)
    for cell, place in places.items():
        group = (place.pack, place.group) if isinstance(place, PackedRun) else place
        found[group][cell] = place
    return list(found.values())


def _kinds(place: Place) -> Iterator[tuple[str, FieldKind]]:
    """The variables of the runs in one place, by one of them."""
    run = place.load() if isinstance(place, PackedRun) else load_run(place, follow=False)
    for name, variable in run.variables.items():
        dims, told = tuple(map(str, variable.dims)), json.dumps(variable.attrs, sort_keys=True)
        held = variable.shape, variable.dtype.str, dims == (name,), told
        yield str(name), FieldKind(dims, *held)


def _rows(field: str, places: Iterable[Place]) -> NDArray[Any]:
    """The values of a variable of all runs in one group, stacked."""
    packed = [place for place in places if isinstance(place, PackedRun)]
    if not packed:
        runs = (load_run(path, follow=False) for path in places if isinstance(path, Path))
        return np.stack([run.variables[field].values for run in runs])
    try:
        with open_pack(packed[0].path, packed[0].untyped) as file:
            group = own(file, str(packed[0].group))
            check_keys(group, [place.row for place in packed], [place.key for place in packed])
            held = own(own(group, "arrays"), field)
            return np.asarray(values_of(np.stack([held[place.row] for place in packed])))
    except FileNotFoundError:
        return np.stack([place.load().variables[field].values for place in moved(packed)])


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
        for inside in _groups(known):
            values = _rows(self._field, inside.values())
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
    for cells in groups:
        for field, kind in _kinds(next(iter(cells.values()))):
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
    for inside in _groups(places):
        values = _rows(field, inside.values())
        first = values[0] if first is None else first
        same = np.broadcast_to(first, values.shape)
        if not np.array_equal(values, same, equal_nan=values.dtype.kind == "f"):
            return None
    return first
