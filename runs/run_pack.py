"""A pack: many runs of small sweep cells in one HDF5 file.

Opening, closing and flushing a file for each small run would take as long as the run. In a pack,
runs whose arrays have the same names and shapes are stacked along a new first axis, one group for
each layout. Cells without a run are in a group without arrays. The file ends with its checksum, as
other files of a store do. `runs.store_packs` manages the packs of a store.
"""

from __future__ import annotations

import json
import os
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from longwave.runs.hdf_contents import check_contents, local_member
from longwave.runs.run_file import as_json
from longwave.support import sealed_file
from longwave.support.user_files import reason_of

if TYPE_CHECKING:
    import h5py
    import xarray as xr
    from numpy.typing import NDArray

DONE, BLOWN_UP, REFUSED, FAILED = "done", "blown up", "refused", "failed"
"""How a cell ended: completed; stopped by a blow-up; scene not admissible; or failed for a reason
that another attempt may not meet (no memory, worker killed)."""

FINAL = (DONE, BLOWN_UP, REFUSED)
"""Statuses of cells that are not run again, because the result would be the same."""

OPTIONAL: Mapping[str, tuple[str, str]] = {
    "last_peak": ("1", "largest force at the end, 1 at the start"),
    "last_energy": ("1", "energy about the crest at the end"),
    "last_delay": ("sites", "sites by which the crest is late at the end"),
    "growth_rate": ("1/slow time", "growth rate in T, on the lattice"),
    "growth_rate_error": ("1/slow time", "what the measured growth rate may be off"),
    "growth_rate_theory": ("1/slow time", "growth rate in T, by the envelope equation"),
    "carrier_k": ("1/site", "wavenumber of the carrier on the ring"),
    "perturbation_kappa": ("1/X", "wavenumber of the perturbation, in X"),
}
"""Name -> (unit, meaning) of the numbers that only some kinds of cells have."""

NUMBERS: Mapping[str, tuple[str, str]] = {
    "error": ("1", "largest relative sup error against the wave"),
    "own_error": ("1", "how far the run itself may be off, as part of error"),
    "error_estimate": ("1", "estimated sup error of the run, as in its scene's tolerance"),
    "steps": ("1", "time steps"),
    "sites": ("1", "sites, or cells of the lattice"),
    "force_evaluations": ("1", "force evaluations a site"),
    "seconds": ("s", "seconds of the run that is kept"),
    "planning_seconds": ("s", "seconds of the search for it"),
    **OPTIONAL,
}
"""Name -> (unit, meaning) of every number that is recorded for a cell."""

RATES: Mapping[str, tuple[str, str]] = {
    "error": ("1", "growth rate off theory, over the largest"),
    "error_estimate": ("1", "estimated error of the rate by the run's steps, over the largest"),
}
"""Name -> (unit, meaning) of the `NUMBERS` that mean something else for cells that measure a growth
rate; "the largest" is the largest rate in theory."""

TEXTS = ("key", "status", "message", "attributes")
"""Names of the arrays of texts in a group of a pack."""

MIN_COMPRESSED_BYTES = 4096
"""Size in bytes from which a run's array is compressed; each run is a chunk of its own."""

COMPRESSION_LEVEL = 1
"""Deflate level: with shuffled bytes, a snapshot of 3000 sites takes 0.7 ms and shrinks by a tenth
to a half."""


@dataclass(frozen=True)
class CellRecord:
    """One cell of a sweep: key of its scene, status, message, numbers, and the run, if any."""

    key: str
    status: str
    message: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict)
    run: xr.Dataset | None = None


@dataclass(frozen=True)
class CellTable:
    """Table of cells with columns: key, status, message, numbers, and the location of the run.

    ``pack`` is the index of the pack, ``group`` and ``row`` the position in it; ``row`` is -1 if
    there is no run.
    """

    key: NDArray[Any]
    status: NDArray[Any]
    message: NDArray[Any]
    pack: NDArray[Any]
    group: NDArray[Any]
    row: NDArray[Any]
    numbers: Mapping[str, NDArray[np.float64]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.key)

    def select(self, cells: NDArray[Any]) -> CellTable:
        """Return the cells at these indices, or where the mask is true."""
        columns = {name: getattr(self, name)[cells] for name in COLUMN_TYPES}
        numbers = {name: column[cells] for name, column in self.numbers.items()}
        return CellTable(**columns, numbers=numbers)

    def record(self, row: int) -> CellRecord:
        """Return one cell, without its run."""
        numbers = {name: float(column[row]) for name, column in self.numbers.items()}
        key, status = (column[row].decode() for column in (self.key, self.status))
        return CellRecord(key, status, self.message[row], numbers)


COLUMN_TYPES: Mapping[str, type | str] = {
    "key": "S40",
    "status": "S9",
    "message": object,
    "pack": np.int32,
    "group": np.int32,
    "row": np.int32,
}
"""Column of a `CellTable` -> NumPy type, except for the numbers, which are doubles."""


def concatenate_tables(tables: Sequence[CellTable]) -> CellTable:
    """Concatenate tables; numbers that a table does not have become NaN."""
    columns = {
        name: np.concatenate([np.empty(0, type_), *(getattr(table, name) for table in tables)])
        for name, type_ in COLUMN_TYPES.items()
    }
    numbers = _concatenate_numbers([(table.numbers, len(table)) for table in tables])
    return CellTable(**columns, numbers=numbers)


def _concatenate_numbers(
    parts: Sequence[tuple[Mapping[str, NDArray[np.float64]], int]],
) -> dict[str, NDArray[np.float64]]:
    """Concatenate (columns, length) pairs of numbers; a missing column gives NaN."""
    return {
        name: np.concatenate(
            [columns.get(name, np.full(length, np.nan)) for columns, length in parts]
        )
        for name in NUMBERS
        if any(name in columns for columns, _ in parts)
    }


@dataclass(frozen=True)
class _RunStack:
    """Cells whose runs have arrays of the same names, shapes and attributes: one group of a pack.

    ``arrays`` holds the values of all runs, with the cells along the first axis, and the array's
    attributes in the file.
    """

    texts: Mapping[str, Sequence[str]]
    numbers: Mapping[str, NDArray[np.float64]]
    arrays: Mapping[str, tuple[NDArray[Any], Mapping[str, Any]]]

    @staticmethod
    def of(records: Sequence[CellRecord]) -> _RunStack:
        """Stack the cells, whose runs have the same `_run_layout`."""
        attributes = [{} if record.run is None else record.run.attrs for record in records]
        texts = {
            "key": [record.key for record in records],
            "status": [record.status for record in records],
            "message": [record.message for record in records],
            "attributes": [json.dumps(attrs, default=as_json) for attrs in attributes],
        }
        numbers = {
            name: np.array([float(record.numbers.get(name, np.nan)) for record in records])
            for name in NUMBERS
            if name not in OPTIONAL or any(name in record.numbers for record in records)
        }
        arrays = {}
        runs = [record.run for record in records if record.run is not None]
        for label, variable in runs[0].variables.items() if runs else ():
            values = np.stack([np.asarray(run.variables[label].values) for run in runs])
            if values.dtype.kind == "U":
                values = np.char.encode(values, "utf-8")
            attrs = {"dims": json.dumps(variable.dims), "coordinate": label in runs[0].coords}
            attrs["attributes"] = json.dumps(variable.attrs, default=as_json)
            arrays[str(label)] = values, attrs
        return _RunStack(texts, numbers, arrays)

    @staticmethod
    def read(group: Any) -> _RunStack:
        """Read a stack from a group of a pack."""
        inner = local_member(group, "arrays")
        arrays = {name: local_member(inner, name) for name in inner}
        return _RunStack(
            {name: list(local_member(group, name).asstr()[()]) for name in TEXTS},
            {name: local_member(group, name)[()] for name in NUMBERS if name in group},
            {name: (array[()], dict(array.attrs)) for name, array in arrays.items()},
        )

    @property
    def layout(self) -> str:
        """Description of the arrays, which is equal for two stacks if they can be concatenated."""
        parts = [
            (name, values.shape[1:], "S" if values.dtype.kind == "S" else values.dtype.str, attrs)
            for name, (values, attrs) in sorted(self.arrays.items())
        ]
        return repr(parts)

    def write(self, group: Any) -> None:
        """Write the stack into an empty group."""
        import h5py

        for name, texts in self.texts.items():
            group.create_dataset(name, data=np.array(texts, object), dtype=h5py.string_dtype())
        for name, column in self.numbers.items():
            group.create_dataset(name, data=column)
        arrays = group.create_group("arrays")
        for name, (values, attrs) in self.arrays.items():
            options: dict[str, Any] = {"compression": COMPRESSION_LEVEL, "shuffle": True}
            options["chunks"] = (1, *values.shape[1:])
            options = options if values[0].nbytes >= MIN_COMPRESSED_BYTES else {}
            arrays.create_dataset(name, data=values, **options).attrs.update(attrs)


def _concatenate_stacks(stacks: Sequence[_RunStack]) -> _RunStack:
    """Concatenate stacks of equal layout."""
    texts = {name: [text for stack in stacks for text in stack.texts[name]] for name in TEXTS}
    numbers = _concatenate_numbers([(stack.numbers, len(stack.texts["key"])) for stack in stacks])
    arrays = {
        name: (np.concatenate([stack.arrays[name][0] for stack in stacks]), attrs)
        for name, (_, attrs) in stacks[0].arrays.items()
    }
    return _RunStack(texts, numbers, arrays)


def decoded_values(stored: Any) -> Any:
    """Return an array with its texts decoded; a pack stores them as UTF-8 bytes."""
    return np.char.decode(stored, "utf-8") if stored.dtype.kind == "S" else stored


def write_pack(path: Path, records: Iterable[CellRecord]) -> None:
    """Write the records to a new file, completely or not at all; an OSError names the file."""
    sealed_file.write_sealed(path, pack_content(records), force=False)


def pack_content(records: Iterable[CellRecord]) -> bytes:
    """Return the bytes of a pack's file, without its checksum."""
    layouts: dict[str, list[CellRecord]] = defaultdict(list)
    for record in records:
        layouts[_run_layout(record.run)].append(record)
    return _pack_bytes(map(_RunStack.of, layouts.values()))


def merged_content(packs: Iterable[tuple[Path, int]]) -> bytes:
    """Return the bytes of one pack with the cells of all ``packs``, given as (path, link_free)."""
    layouts: dict[str, list[_RunStack]] = defaultdict(list)
    for path, link_free in packs:
        with open_pack(path, link_free) as file:
            for name in file:
                stack = _RunStack.read(local_member(file, name))
                layouts[stack.layout].append(stack)
    return _pack_bytes(map(_concatenate_stacks, layouts.values()))


def _pack_bytes(stacks: Iterable[_RunStack]) -> bytes:
    import h5py

    image = BytesIO()  # in memory, so that a full disk cannot break HDF5
    with h5py.File(image, "w") as file:
        for number, stack in enumerate(stacks):
            stack.write(file.create_group(str(number)))
    return image.getvalue()


def _run_layout(run: xr.Dataset | None) -> str:
    """Return a text that is equal for runs that can be stacked."""
    if run is None:
        return ""
    return repr(
        [
            (name, v.dims, v.shape, v.dtype.str, name in run.coords, v.attrs)
            for name, v in run.variables.items()
        ]
    )


RECENT_CHANGE_NS = 2 * 10**9
"""Nanoseconds within which a file may change again without a new change time (a clock tick, or one
second on some file systems). A more recent file is checked at each opening."""

MAX_REMEMBERED = 4096
"""Largest number of checked packs that are remembered."""

_remembered: dict[tuple[int, ...], None] = {}
"""Packs that this process has checked, keyed by device, inode, size and times. (Users cannot set
the change time.)"""


class DamagedPackError(ValueError):
    """A pack whose checksum is wrong; a warning was logged."""


@contextmanager
def open_pack(path: Path, link_free: int = 1) -> Iterator[h5py.File]:
    """Open a pack for reading, after its checksum and contents were checked once by this process.

    The last ``link_free`` components of its path must not be links. The file is opened once, so
    that the checked bytes are the bytes that are read. Raises FileNotFoundError if there is no such
    pack, as after a merge; DamagedPackError; and ValueError if the file is not a pack.
    """
    import h5py

    with _open_unlinked(path, link_free) as stream:
        state = os.fstat(stream.fileno())
        stamp = state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns
        is_checked = stamp in _remembered
        if not is_checked and not sealed_file.is_sealed(stream):
            sealed_file.LOG.warning(sealed_file.DAMAGED, path)
            raise DamagedPackError(f"pack must have the right checksum, got {path}, damaged")
        try:
            file = h5py.File(stream)
        except OSError as error:
            raise ValueError(f"pack must be an HDF5 file, got {path}: {reason_of(error)}") from None
        with file:
            if not is_checked:
                check_contents(file, state.st_size, deepest=2)
                if time.time_ns() - state.st_ctime_ns > RECENT_CHANGE_NS:
                    _remembered[stamp] = None
                    for old in [*_remembered][: max(0, len(_remembered) - MAX_REMEMBERED)]:
                        del _remembered[old]
            yield file


def _open_unlinked(path: Path, link_free: int) -> BinaryIO:
    """Open a regular file; raise DamagedPackError for a link or anything else."""
    try:
        return open(sealed_file.open_plain(path, untyped=link_free), "rb")
    except FileNotFoundError:
        raise
    except OSError as error:
        if error.errno not in sealed_file.NO_FILE:
            raise
        sealed_file.LOG.warning(sealed_file.LINKED, path)
        raise DamagedPackError(f"pack must be a regular file, got {path}") from None


def read_pack(path: Path, link_free: int = 1) -> CellTable:
    """Return the table of a pack's cells, without loading runs. Raises as `open_pack`."""
    try:
        with open_pack(path, link_free) as file:
            tables = [_group_table(int(name), local_member(file, name)) for name in file]
            return concatenate_tables(tables)
    except (FileNotFoundError, DamagedPackError):
        raise
    except Exception as error:  # what the library raises for such a file is not documented
        raise ValueError(f"file must be a pack, got {path}: {reason_of(error)}") from None


def is_pack(path: Path, link_free: int = 1) -> bool:
    """Whether a pack can be read. Raises FileNotFoundError if there is no file."""
    try:
        read_pack(path, link_free)
    except FileNotFoundError:
        raise
    except (ValueError, OSError):
        return False
    return True


def _group_table(number: int, group: Any) -> CellTable:
    columns = {name: local_member(group, name).asstr()[()] for name in TEXTS[:3]}
    count = len(columns["key"])
    rows = np.arange(count) if len(local_member(group, "arrays")) else np.full(count, -1)
    columns |= {"pack": np.zeros(count), "group": np.full(count, number), "row": rows}
    return build_table(columns, group)


def build_table(columns: Mapping[str, Any], numbers: Any) -> CellTable:
    """Build a table from columns and a group of numbers; ValueError unless they have one length."""
    count = len(columns["key"])
    plain = {name: np.asarray(columns[name]).astype(type_) for name, type_ in COLUMN_TYPES.items()}
    number_columns = {
        name: np.asarray(local_member(numbers, name)[()]).astype(np.float64)
        for name in NUMBERS
        if name in numbers
    }
    if any(column.shape != (count,) for column in (*plain.values(), *number_columns.values())):
        raise ValueError(f"columns must have {count} rows, got other lengths")
    for name in ("key", "status"):
        plain[name].astype("U")  # raises if it is not ASCII
    return CellTable(**plain, numbers=number_columns)


def check_keys(group: Any, rows: Sequence[int], keys: Sequence[str]) -> None:
    """Raise ValueError if rows of a group do not have these keys; an empty key matches any row."""
    expected = [(row, key) for row, key in zip(rows, keys, strict=True) if key]
    if any(local_member(group, "key").asstr()[row] != key for row, key in expected):
        raise ValueError("pack must have the indexed keys, got others (it changed: open it again)")


def load_row(path: Path, group: int, row: int, key: str = "", link_free: int = 1) -> xr.Dataset:
    """Load one run of a pack, bit by bit; a nonempty ``key`` must be the row's. See `open_pack`."""
    import xarray as xr

    with open_pack(path, link_free) as file:
        try:
            pack_group = local_member(file, str(group))
            check_keys(pack_group, [row], [key])
            data: dict[str, Any] = {}
            coordinates: dict[str, Any] = {}
            inner = local_member(pack_group, "arrays")
            for name in inner:
                array = local_member(inner, name)
                target = coordinates if array.attrs["coordinate"] else data
                dims, attrs = (json.loads(array.attrs[key]) for key in ("dims", "attributes"))
                target[name] = dims, decoded_values(array[row]), attrs
            attrs = json.loads(local_member(pack_group, "attributes")[row])
            return xr.Dataset(data, coordinates, attrs)
        except Exception as error:  # see read_pack
            got = f"{path}: {reason_of(error)}"
            raise ValueError(f"pack must contain complete runs, got {got}") from None
