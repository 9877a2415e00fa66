"""A sweep's results: one data set with the swept dimensions, its fields read when they are used."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from longwave.runs.run_file import SWEPT, file_content, load_run
from longwave.runs.run_pack import NUMBERS, OPTIONAL, RATES, REFUSED, SETTLED, CellRecord
from longwave.runs.run_store import RunStore
from longwave.runs.store_packs import PackedRun
from longwave.runs.sweep_cells import record_of
from longwave.runs.sweep_fields import Place, swept_fields
from longwave.runs.sweep_file import CASE, SAMPLE, TAKEN, Sweep
from longwave.support.atomic_file import write_atomically

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from longwave.scenes.description.scene import Scene

MISSING = "missing"
"""The status of a cell that was not run yet."""


class _Cells:
    """What a store holds of some cells of a sweep.

    ``rows`` are those in the table of the store's packs, -1 where no pack has the run; ``others``
    have a record and, if there is one, a file; the rest is missing.
    """

    def __init__(self, sweep: Sweep, numbers: Sequence[int], store: RunStore) -> None:
        self._store, self._held = store, store.held()
        self._keys = np.full(len(numbers), "", object)
        self._rows = np.full(len(numbers), -1)
        self._others: dict[int, tuple[CellRecord, Path | None]] = {}
        for cell, number in enumerate(numbers):
            try:
                scene = sweep.scene(number)
            except ValueError as error:
                self._others[cell] = CellRecord("", REFUSED, " ".join(str(error).split())), None
            else:
                self._look(cell, scene)

    def _look(self, cell: int, scene: Scene) -> None:
        """Find the run of a cell, or what it came to."""
        self._keys[cell] = key = self._store.key(scene)
        packs = self._held.packs
        row = packs.row(key)
        if row is not None and packs.table.row[row] >= 0:
            self._rows[cell] = row
            return
        record = None if row is None else packs.table.record(row)
        path = self._held.file(key)
        if path is not None and (record is None or record.status not in SETTLED):
            record = record_of(key, scene, load_run(path, follow=False))
        if record is not None:
            self._others[cell] = record, path

    def texts(self) -> Iterator[tuple[str, NDArray[Any]]]:
        """How the cells ended, what is told of that, and their keys."""
        inside, table = self._rows >= 0, self._held.packs.table
        rows = self._rows[inside]
        status, message = (np.full(len(self._rows), text, object) for text in (MISSING, ""))
        status[inside] = table.status[rows].astype("U9")
        message[inside] = table.message[rows]
        for cell, (record, _) in self._others.items():
            status[cell], message[cell] = record.status, record.message
        yield from {"status": status, "message": message, "key": self._keys}.items()

    def numbers(self) -> Mapping[str, NDArray[np.float64]]:
        """The columns of `NUMBERS`, NaN where a cell has none."""
        columns = {name: np.full(len(self._rows), np.nan) for name in NUMBERS}
        inside = self._rows >= 0
        for name, column in self._held.packs.table.numbers.items():
            columns[name][inside] = column[self._rows[inside]]
        for cell, (record, _) in self._others.items():
            for name, value in record.numbers.items():
                columns[name][cell] = value
        return columns

    def places(self) -> Mapping[int, Place]:
        """Where the runs are of the cells that have one."""
        files = {cell: path for cell, (_, path) in self._others.items() if path is not None}
        packed = {
            int(cell): self._held.packs.place(self._rows[cell])
            for cell in np.flatnonzero(self._rows >= 0)
        }
        return files | {cell: place for cell, place in packed.items() if place is not None}


def sweep_dataset(sweep: Sweep, store: RunStore, fields: bool = True) -> xr.Dataset:
    """The sweep as one data set.

    Its dimensions are the swept ones; a list has ``case``, a random sample ``sample``, along which
    the fields are coordinates. Variables: ``status`` of each cell (done, blown up, refused, failed,
    missing), ``message``, ``key`` and the numbers of `runs.run_pack.NUMBERS`. With ``fields`` also
    those of the runs that have one shape in all cells, which are read from the store when they are
    used; NaN, or 0, where there is no run. `cell_run` reads the whole run of one cell.
    """
    cells = _Cells(sweep, range(len(sweep)), store)
    names, shape = tuple(d.name for d in sweep.dimensions), sweep.shape
    data: dict[str, Any] = {
        name: (names, column.reshape(shape), told)
        for name, column, told in _number_columns(cells.numbers())
    }
    data |= {name: (names, texts.reshape(shape)) for name, texts in cells.texts()}
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
        for name, variable, is_coordinate in swept_fields(names, shape, cells.places(), taken):
            (coordinates if is_coordinate else data)[name] = variable
    attributes = {
        "title": sweep.title or sweep.name,
        SWEPT: sweep.json(),
        "store": str(store.folder),
    }
    return xr.Dataset(data, coordinates, attributes)


def _number_columns(
    columns: Mapping[str, NDArray[np.float64]],
) -> Iterator[tuple[str, NDArray[np.float64], dict[str, str]]]:
    """The numbers of all cells: name, values, and what they are."""
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
    cell = _Cells(sweep, [number], store)
    place = cell.places().get(0)
    if place is None:
        (_, status), (_, message), _ = cell.texts()
        raise ValueError(f"cell {indices} must have a run, got none: {message[0] or status[0]}")
    return place.load() if isinstance(place, PackedRun) else load_run(place, follow=False)


def write_sweep(sweep: Sweep, store: RunStore, path: str | Path, force: bool = True) -> xr.Dataset:
    """Write the sweep's data set, without the runs' fields, as NetCDF-4; return it.

    Raises OSError that names the file.
    """
    found = sweep_dataset(sweep, store, fields=False)
    content = file_content(found)
    write_atomically(Path(path), lambda draft: draft.write_bytes(content), force)
    return found
