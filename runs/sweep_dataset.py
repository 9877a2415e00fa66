"""A sweep's results: one data set with the swept dimensions, its fields read when they are used."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from longwave.runs.run_file import SWEPT, file_content, load_run
from longwave.runs.run_pack import (
    NUMBERS,
    OPTIONAL,
    RATES,
    REFUSED,
    SETTLED,
    CellRecord,
    PackedRun,
    packed_records,
)
from longwave.runs.run_store import RunStore
from longwave.runs.sweep_cells import record_of
from longwave.runs.sweep_fields import Place, swept_fields
from longwave.runs.sweep_file import CASE, SAMPLE, TAKEN, Sweep
from longwave.support.atomic_file import write_atomically

if TYPE_CHECKING:
    from numpy.typing import NDArray

MISSING = "missing"
"""The status of a cell that was not run yet."""


def _found(
    sweep: Sweep,
    number: int,
    store: RunStore,
    packed: Mapping[str, tuple[CellRecord, PackedRun | None]],
) -> tuple[CellRecord, Place | None]:
    try:
        scene = sweep.scene(number)
    except ValueError as error:
        return CellRecord("", REFUSED, " ".join(str(error).split())), None
    key = store.key(scene)
    record, place = packed.get(key, (None, None))
    if record is not None and place is not None:
        return record, place
    path = store.find(scene)
    if path is not None and (record is None or record.status not in SETTLED):
        record = record_of(key, scene, load_run(path))
    return record or CellRecord(key, MISSING), path


def sweep_dataset(sweep: Sweep, store: RunStore, fields: bool = True) -> xr.Dataset:
    """The sweep as one data set.

    Its dimensions are the swept ones; a list has ``case``, a random sample ``sample``, along which
    the fields are coordinates. Variables: ``status`` of each cell (done, blown up, refused, failed,
    missing), ``message``, ``key`` and the numbers of `runs.run_pack.NUMBERS`. With ``fields`` also
    those of the runs that have one shape in all cells, which are read from the store when they are
    used; NaN, or 0, where there is no run. `cell_run` reads the whole run of one cell.
    """
    packed = packed_records(store.folder)
    cells = [_found(sweep, number, store, packed) for number in range(len(sweep))]
    records = [record for record, _ in cells]
    places = {number: place for number, (_, place) in enumerate(cells) if place is not None}
    names, shape = tuple(d.name for d in sweep.dimensions), sweep.shape
    data: dict[str, Any] = {
        name: (names, column.reshape(shape), told)
        for name, column, told in _number_columns(records)
    }
    for name in ("status", "message", "key"):
        texts = np.array([getattr(record, name) for record in records], dtype=object)
        data[name] = (names, texts.reshape(shape))
    coordinates: dict[str, Any] = {}
    swept = [field for dimension in sweep.dimensions for field in dimension.fields]
    for dimension in sweep.dimensions:
        columns = zip(*dimension.rows, strict=True)
        for field, column in zip(dimension.fields, columns, strict=True):
            alone = dimension.name not in (CASE, SAMPLE)
            name = dimension.name if alone else _short(field, swept)
            coordinates[name] = (dimension.name, _values(column), {"field": field})
    if fields:
        taken = {*names, *data, *coordinates}
        for name, variable, is_coordinate in swept_fields(names, shape, places, taken):
            (coordinates if is_coordinate else data)[name] = variable
    attributes = {
        "title": sweep.title or sweep.name,
        SWEPT: sweep.json(),
        "store": str(store.folder),
    }
    return xr.Dataset(data, coordinates, attributes)


def _number_columns(
    records: Sequence[CellRecord],
) -> Iterator[tuple[str, NDArray[np.float64], dict[str, str]]]:
    """The numbers of all cells: name, values, and what they are."""
    columns = {
        name: np.array([record.numbers.get(name, np.nan) for record in records], dtype=np.float64)
        for name in NUMBERS
    }
    judged = np.isfinite(columns["error"])
    of_rates = judged.any() and np.isfinite(columns["growth_rate"][judged]).all()
    for name, (unit, meaning) in ({**NUMBERS, **RATES} if of_rates else NUMBERS).items():
        if not (name in OPTIONAL and np.isnan(columns[name]).all()):
            yield name, columns[name], {"long_name": meaning, "units": unit}


def _short(field: str, fields: Sequence[str]) -> str:
    """The last part of a field's name, where no other field has it."""
    last = field.rpartition(".")[2]
    alike = [other for other in fields if other.rpartition(".")[2] == last]
    return last if len(alike) == 1 and last not in TAKEN else field.replace(".", "_")


def _values(column: Sequence[Any]) -> NDArray[Any]:
    """Numbers where all are, else texts; a list stands as JSON."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in column):
        return np.array(column)
    texts = [value if isinstance(value, str) else json.dumps(value) for value in column]
    return np.array(texts, dtype=object)


def cell_run(sweep: Sweep, store: RunStore, **indices: int) -> xr.Dataset:
    """The run of the cell with these indices along the swept dimensions.

    Raises ValueError in one line for indices that are none, and where there is no run.
    """
    names = [dimension.name for dimension in sweep.dimensions]
    if set(indices) != set(names):
        raise ValueError(
            f"indices must be of {', '.join(names)}, got {', '.join(indices) or 'none'}"
        )
    try:
        number = int(np.ravel_multi_index([indices[name] for name in names], sweep.shape))
    except ValueError:
        sizes = " x ".join(map(str, sweep.shape))
        raise ValueError(f"indices must lie in {sizes} cells, got {indices}") from None
    record, place = _found(sweep, number, store, packed_records(store.folder))
    if place is None:
        raise ValueError(
            f"cell {indices} must have a run, got none: {record.message or record.status}"
        )
    return place.load() if isinstance(place, PackedRun) else load_run(place)


def write_sweep(sweep: Sweep, store: RunStore, path: str | Path, force: bool = True) -> xr.Dataset:
    """Write the sweep's data set, without the runs' fields, as NetCDF-4; return it.

    Raises OSError that names the file.
    """
    found = sweep_dataset(sweep, store, fields=False)
    content = file_content(found)
    write_atomically(Path(path), lambda draft: draft.write_bytes(content), force)
    return found
