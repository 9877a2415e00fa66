"""A sweep's results as one data set over the swept dimensions; fields are read lazily."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from longwave.runs.run_file import SWEPT, file_content, load_run
from longwave.runs.run_pack import FINAL, NUMBERS, OPTIONAL, RATES, REFUSED, CellRecord
from longwave.runs.run_store import RunStore
from longwave.runs.sweep_cells import record_of
from longwave.runs.sweep_fields import RunLocation, load_location, swept_fields
from longwave.runs.sweep_file import CASE, RESERVED_NAMES, SAMPLE, Sweep
from longwave.support.atomic_file import write_atomically

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from longwave.scenes.description.scene import Scene

MISSING = "missing"
"""Status of a cell that has not been run."""


class _StoredCells:
    """Contents of a store for some cells of a sweep.

    ``_rows`` are rows in the table of the store's packs, -1 if no pack has the run. ``_others`` has
    the record, and the file if there is one, of other cells that were run. All remaining cells are
    missing.
    """

    def __init__(self, sweep: Sweep, numbers: Sequence[int], store: RunStore) -> None:
        self._store, self._stored = store, store.stored_runs()
        self._keys = np.full(len(numbers), "", object)
        self._rows = np.full(len(numbers), -1)
        self._others: dict[int, tuple[CellRecord, Path | None]] = {}
        for cell, number in enumerate(numbers):
            try:
                scene = sweep.scene(number)
            except ValueError as error:
                self._others[cell] = CellRecord("", REFUSED, " ".join(str(error).split())), None
            else:
                self._find(cell, scene)

    def _find(self, cell: int, scene: Scene) -> None:
        """Find the run or the record of a cell."""
        self._keys[cell] = key = self._store.key(scene)
        packs = self._stored.packs
        row = packs.row(key)
        if row is not None and packs.table.row[row] >= 0:
            self._rows[cell] = row
            return
        record = None if row is None else packs.table.record(row)
        path = self._stored.file(key)
        if path is not None and (record is None or record.status not in FINAL):
            record = record_of(key, scene, load_run(path, follow=False))
        if record is not None:
            self._others[cell] = record, path

    def text_columns(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """Yield the columns status, message and key."""
        is_packed, table = self._rows >= 0, self._stored.packs.table
        rows = self._rows[is_packed]
        status, message = (np.full(len(self._rows), text, object) for text in (MISSING, ""))
        status[is_packed] = table.status[rows].astype("U9")
        message[is_packed] = table.message[rows]
        for cell, (record, _) in self._others.items():
            status[cell], message[cell] = record.status, record.message
        yield from {"status": status, "message": message, "key": self._keys}.items()

    def numbers(self) -> Mapping[str, NDArray[np.float64]]:
        """Return the columns of `NUMBERS`, NaN for a cell without the number."""
        columns = {name: np.full(len(self._rows), np.nan) for name in NUMBERS}
        is_packed = self._rows >= 0
        for name, column in self._stored.packs.table.numbers.items():
            columns[name][is_packed] = column[self._rows[is_packed]]
        for cell, (record, _) in self._others.items():
            for name, value in record.numbers.items():
                columns[name][cell] = value
        return columns

    def locations(self) -> Mapping[int, RunLocation]:
        """Return the location of the run of each cell that has one."""
        files = {cell: path for cell, (_, path) in self._others.items() if path is not None}
        packed = {
            int(cell): self._stored.packs.location(self._rows[cell])
            for cell in np.flatnonzero(self._rows >= 0)
        }
        return files | {cell: location for cell, location in packed.items() if location is not None}


def sweep_dataset(sweep: Sweep, store: RunStore, fields: bool = True) -> xr.Dataset:
    """Return the results of a sweep as one data set.

    The dimensions are the swept ones; a list has the dimension ``case`` and a random sample
    ``sample``, along which the swept fields are coordinates. Variables: ``status`` of each cell
    (done, blown up, refused, failed, missing), ``message``, ``key`` and the numbers of
    `runs.run_pack.NUMBERS`. With ``fields``, the data set also has those variables of the runs that
    have the same shape in all cells; they are read from the store on demand and are NaN, or 0 for
    integers, where there is no run. `cell_run` loads the whole run of one cell.
    """
    cells = _StoredCells(sweep, range(len(sweep)), store)
    names, shape = tuple(dimension.name for dimension in sweep.dimensions), sweep.shape
    data: dict[str, Any] = {
        name: (names, column.reshape(shape), attrs)
        for name, column, attrs in _number_columns(cells.numbers())
    }
    data |= {name: (names, texts.reshape(shape)) for name, texts in cells.text_columns()}
    coordinates: dict[str, Any] = {}
    swept = [field for dimension in sweep.dimensions for field in dimension.fields]
    for dimension in sweep.dimensions:
        columns = zip(*dimension.rows, strict=True)
        for field, column in zip(dimension.fields, columns, strict=True):
            is_shared = dimension.name in (CASE, SAMPLE)
            name = _short_name(field, swept) if is_shared else dimension.name
            coordinates[name] = (dimension.name, _coordinate_values(column), {"field": field})
    if fields:
        reserved = {*names, *data, *coordinates}
        run_fields = swept_fields(names, shape, cells.locations(), reserved)
        for name, variable, is_coordinate in run_fields:
            (coordinates if is_coordinate else data)[name] = variable
    attributes = {"title": sweep.title or sweep.name, SWEPT: sweep.json()}
    return xr.Dataset(data, coordinates, attributes | {"store": str(store.folder)})


def _number_columns(
    columns: Mapping[str, NDArray[np.float64]],
) -> Iterator[tuple[str, NDArray[np.float64], dict[str, str]]]:
    """Yield name, values and attributes of each number of the cells."""
    has_error = np.isfinite(columns["error"])
    of_rates = has_error.any() and np.isfinite(columns["growth_rate"][has_error]).all()
    for name, (unit, meaning) in ({**NUMBERS, **RATES} if of_rates else NUMBERS).items():
        if not (name in OPTIONAL and np.isnan(columns[name]).all()):
            yield name, columns[name], {"long_name": meaning, "units": unit}


def _short_name(field: str, fields: Sequence[str]) -> str:
    """Return the last part of a field's dotted name, if that is unique and not reserved."""
    last = field.rpartition(".")[2]
    homonyms = [other for other in fields if other.rpartition(".")[2] == last]
    return last if len(homonyms) == 1 and last not in RESERVED_NAMES else field.replace(".", "_")


def _coordinate_values(column: Sequence[Any]) -> NDArray[Any]:
    """Return numbers as an array of numbers; any other values as texts, lists as JSON."""
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in column):
        return np.array(column)
    texts = [value if isinstance(value, str) else json.dumps(value) for value in column]
    return np.array(texts, dtype=object)


def cell_run(sweep: Sweep, store: RunStore, **indices: int) -> xr.Dataset:
    """Return the run of the cell at these indices; ValueError if they or the run do not exist."""
    names = [dimension.name for dimension in sweep.dimensions]
    if set(indices) != set(names):
        got = ", ".join(indices) or "none"
        raise ValueError(f"indices must name {', '.join(names)}, got {got}")
    try:
        number = int(np.ravel_multi_index([indices[name] for name in names], sweep.shape))
    except ValueError:
        sizes = " x ".join(map(str, sweep.shape))
        raise ValueError(f"indices must lie in {sizes} cells, got {indices}") from None
    cell = _StoredCells(sweep, [number], store)
    location = cell.locations().get(0)
    if location is None:
        (_, status), (_, message), _ = cell.text_columns()
        raise ValueError(f"cell {indices} must have a run, got none: {message[0] or status[0]}")
    return load_location(location)


def write_sweep(sweep: Sweep, store: RunStore, path: str | Path, force: bool = True) -> xr.Dataset:
    """Write the sweep's data set, without the runs' fields, as NetCDF-4; return it."""
    dataset = sweep_dataset(sweep, store, fields=False)
    content = file_content(dataset)
    write_atomically(Path(path), lambda draft: draft.write_bytes(content), force)
    return dataset
