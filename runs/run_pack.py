"""A pack: the runs of a sweep's small cells, many to a file.

A file for every small run would cost as much as the run: HDF5 is a file's open and close, and a
flush to the disk. In a pack, runs whose arrays have the same names and shapes are stacked along
their first axis, a group for each kind; what did not come to a run has a group without arrays. The
file ends with its checksum, as a store's other files do. Where a store's packs lie, and what they
hold together, is in `runs.store_packs`.
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

from longwave.runs.hdf_contents import check_contents, own
from longwave.runs.run_file import as_json
from longwave.support.sealed_file import (
    DAMAGED,
    LINKED,
    LOG,
    NO_FILE,
    is_sealed,
    open_plain,
    write_sealed,
)
from longwave.support.user_files import reason_of

if TYPE_CHECKING:
    import h5py
    import xarray as xr
    from numpy.typing import NDArray

DONE, BLOWN_UP, REFUSED, FAILED = "done", "blown up", "refused", "failed"
"""How a cell ended: as asked, before its last time, with a scene that is not admissible, and by
what another attempt may not meet (no memory, a worker that was killed)."""

SETTLED = (DONE, BLOWN_UP, REFUSED)
"""Cells that another attempt would find as they are."""

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
"""What is told of cells only where some have it: unit and meaning."""

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
"""What a cell is told by: unit and meaning."""

RATES: Mapping[str, tuple[str, str]] = {
    "error": ("1", "growth rate off theory, over the largest"),
    "error_estimate": ("1", "estimated error of the rate by the run's steps, over the largest"),
}
"""What numbers of a cell mean that measures a growth rate: the largest is that in theory."""

TEXTS = ("key", "status", "message", "attributes")

COMPRESSED = 4096
"""Bytes of a run's array from which on it is compressed, a chunk for each run: with the level and
bytes shuffled, a snapshot of 3000 sites takes 0.7 ms and shrinks by a tenth to a half."""

LEVEL = 1


@dataclass(frozen=True)
class CellRecord:
    """A cell: the key of its scene, how it ended, in numbers and with its run if there is one."""

    key: str
    status: str
    message: str = ""
    numbers: Mapping[str, float] = field(default_factory=dict)
    run: xr.Dataset | None = None


@dataclass(frozen=True)
class CellTable:
    """Cells in columns: key, how each ended, its numbers, and where its run is.

    ``pack`` is a number of the pack, ``group`` and ``row`` a place in it; ``row`` is -1 where there
    is no run.
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

    def taken(self, chosen: NDArray[Any]) -> CellTable:
        """The cells at these places, or where it is true."""
        columns = {name: getattr(self, name)[chosen] for name in PLAIN}
        return CellTable(**columns, numbers={n: held[chosen] for n, held in self.numbers.items()})

    def record(self, place: int) -> CellRecord:
        """One of the cells, without its run."""
        numbers = {name: float(held[place]) for name, held in self.numbers.items()}
        key, status = (held[place].decode() for held in (self.key, self.status))
        return CellRecord(key, status, self.message[place], numbers)


PLAIN: Mapping[str, type | str] = {
    "key": "S40",
    "status": "S9",
    "message": object,
    "pack": np.int32,
    "group": np.int32,
    "row": np.int32,
}
"""The columns of a table beside its numbers: what their values are."""


def joined_tables(tables: Sequence[CellTable]) -> CellTable:
    """The cells of all tables; numbers that some do not have are NaN there."""
    columns = {
        name: np.concatenate([np.empty(0, kind), *(getattr(one, name) for one in tables)])
        for name, kind in PLAIN.items()
    }
    return CellTable(**columns, numbers=_joined_numbers([(t.numbers, len(t)) for t in tables]))


def _joined_numbers(
    parts: Sequence[tuple[Mapping[str, NDArray[np.float64]], int]],
) -> dict[str, NDArray[np.float64]]:
    """Columns one after the other, each part with its length; NaN where one has no such column."""
    names = {name for numbers, _ in parts for name in numbers}
    return {
        name: np.concatenate([held.get(name, np.full(size, np.nan)) for held, size in parts])
        for name in NUMBERS
        if name in names
    }


@dataclass(frozen=True)
class _Stack:
    """Cells whose runs have arrays of the same names, shapes and attributes, as a group holds them.

    ``arrays`` are of all runs, the cells along the first axis, each with the attributes that it has
    in the file.
    """

    texts: Mapping[str, Sequence[str]]
    numbers: Mapping[str, NDArray[np.float64]]
    arrays: Mapping[str, tuple[NDArray[Any], Mapping[str, Any]]]

    @staticmethod
    def of(alike: Sequence[CellRecord]) -> _Stack:
        """The cells of one `_kind`."""
        attributes = [{} if one.run is None else one.run.attrs for one in alike]
        texts = {
            "key": [one.key for one in alike],
            "status": [one.status for one in alike],
            "message": [one.message for one in alike],
            "attributes": [json.dumps(told, default=as_json) for told in attributes],
        }
        numbers = {
            name: np.array([float(one.numbers.get(name, np.nan)) for one in alike])
            for name in NUMBERS
            if name not in OPTIONAL or any(name in one.numbers for one in alike)
        }
        arrays = {}
        runs = [one.run for one in alike if one.run is not None]
        for label, variable in runs[0].variables.items() if runs else ():
            values = np.stack([np.asarray(run.variables[label].values) for run in runs])
            if values.dtype.kind == "U":
                values = np.char.encode(values, "utf-8")
            arrays[str(label)] = (
                values,
                {
                    "dims": json.dumps(variable.dims),
                    "coordinate": label in runs[0].coords,
                    "attributes": json.dumps(variable.attrs, default=as_json),
                },
            )
        return _Stack(texts, numbers, arrays)

    @staticmethod
    def read(group: Any) -> _Stack:
        """What a group of a pack holds."""
        inner = own(group, "arrays")
        arrays = {name: own(inner, name) for name in inner}
        return _Stack(
            {name: list(own(group, name).asstr()[()]) for name in TEXTS},
            {name: own(group, name)[()] for name in NUMBERS if name in group},
            {name: (held[()], dict(held.attrs)) for name, held in arrays.items()},
        )

    @property
    def kind(self) -> str:
        """What stacks that are joined have in common."""
        found = [
            (name, values.shape[1:], "S" if values.dtype.kind == "S" else values.dtype.str, told)
            for name, (values, told) in sorted(self.arrays.items())
        ]
        return repr(found)

    def write(self, group: Any) -> None:
        """Write it into an empty group."""
        import h5py

        for name, lines in self.texts.items():
            group.create_dataset(name, data=np.array(lines, object), dtype=h5py.string_dtype())
        for name, column in self.numbers.items():
            group.create_dataset(name, data=column)
        arrays = group.create_group("arrays")
        for name, (values, told) in self.arrays.items():
            packing: dict[str, Any] = {}
            if values[0].nbytes >= COMPRESSED:
                packing = {"compression": LEVEL, "shuffle": True, "chunks": (1, *values.shape[1:])}
            arrays.create_dataset(name, data=values, **packing).attrs.update(told)


def _joined(alike: Sequence[_Stack]) -> _Stack:
    """The cells of stacks of one kind."""
    texts = {name: [line for one in alike for line in one.texts[name]] for name in TEXTS}
    numbers = _joined_numbers([(one.numbers, len(one.texts["key"])) for one in alike])
    arrays = {
        name: (np.concatenate([one.arrays[name][0] for one in alike]), told)
        for name, (_, told) in alike[0].arrays.items()
    }
    return _Stack(texts, numbers, arrays)


def values_of(held: Any) -> Any:
    """What was put in: texts are held as bytes."""
    return np.char.decode(held, "utf-8") if held.dtype.kind == "S" else held


def write_pack(path: Path, records: Iterable[CellRecord]) -> None:
    """Write the records to a new file, whole or not at all. Raises OSError that names it."""
    write_sealed(path, pack_content(records), force=False)


def pack_content(records: Iterable[CellRecord]) -> bytes:
    """The bytes of a pack's file, without its seal."""
    kinds: dict[str, list[CellRecord]] = defaultdict(list)
    for record in records:
        kinds[_kind(record.run)].append(record)
    return _content(map(_Stack.of, kinds.values()))


def merged_content(packs: Iterable[tuple[Path, int]]) -> bytes:
    """The bytes of a pack of all that these packs hold, each with what `open_pack` takes.

    Raises as that does.
    """
    kinds: dict[str, list[_Stack]] = defaultdict(list)
    for path, untyped in packs:
        with open_pack(path, untyped) as file:
            for name in file:
                stack = _Stack.read(own(file, name))
                kinds[stack.kind].append(stack)
    return _content(map(_joined, kinds.values()))


def _content(stacks: Iterable[_Stack]) -> bytes:
    import h5py

    image = BytesIO()  # a full disk breaks no library then
    with h5py.File(image, "w") as file:
        for number, stack in enumerate(stacks):
            stack.write(file.create_group(str(number)))
    return image.getvalue()


def _kind(run: xr.Dataset | None) -> str:
    """What runs that are stacked have in common."""
    if run is None:
        return ""
    variables = run.variables.items()
    return repr([(n, v.dims, v.shape, v.dtype.str, n in run.coords, v.attrs) for n, v in variables])


YOUNG = 2 * 10**9
"""Nanoseconds in which a file may change again without a later time of change (a clock's tick, or
the second of some file systems): one that is younger is looked through at each opening."""

MOST_CHECKED = 4096
"""Packs of which it is remembered that they were looked through."""

_checked: dict[tuple[int, ...], None] = {}
"""Those packs, by file, size and times; the time of change is nobody's to choose."""


class DamagedPackError(ValueError):
    """A pack whose bytes are not those that were written, which the log was told."""


@contextmanager
def open_pack(path: Path, untyped: int = 1) -> Iterator[h5py.File]:
    """A pack, open to be read, whose bytes were looked through by this process.

    None of the last ``untyped`` names of its path may be a link.

    The file is opened once: what is checked is what is read. Raises FileNotFoundError where none
    is, as when it was merged since, DamagedPackError, and ValueError for what is no pack.
    """
    import h5py

    with _plain_pack(path, untyped) as stream:
        state = os.fstat(stream.fileno())
        stamp = state.st_dev, state.st_ino, state.st_size, state.st_mtime_ns, state.st_ctime_ns
        checked = stamp in _checked
        if not checked and not is_sealed(stream):
            LOG.warning(DAMAGED, path)
            raise DamagedPackError(f"{path} is damaged")
        try:
            file = h5py.File(stream)
        except OSError as error:
            raise ValueError(f"{path} is no pack ({reason_of(error)})") from None
        with file:
            if not checked:
                check_contents(file, state.st_size, deepest=2)
                if time.time_ns() - state.st_ctime_ns > YOUNG:
                    _checked[stamp] = None
                    for old in [*_checked][: max(0, len(_checked) - MOST_CHECKED)]:
                        del _checked[old]
            yield file


def _plain_pack(path: Path, untyped: int) -> BinaryIO:
    """The open file; DamagedPackError for a link or what is no file."""
    try:
        return open(open_plain(path, untyped=untyped), "rb")
    except FileNotFoundError:
        raise
    except OSError as error:
        if error.errno not in NO_FILE:
            raise
        LOG.warning(LINKED, path)
        raise DamagedPackError(f"{path} is a link, or no file") from None


def read_pack(path: Path, untyped: int = 1) -> CellTable:
    """What a pack holds, its runs left on the disk. Raises as `open_pack`."""
    try:
        with open_pack(path, untyped) as file:
            return joined_tables([_table(int(name), own(file, name)) for name in file])
    except (FileNotFoundError, DamagedPackError):
        raise
    except Exception as error:  # what the library raises for such a file is not documented
        raise ValueError(f"{path} is no pack ({reason_of(error)})") from None


def is_pack(path: Path, untyped: int = 1) -> bool:
    """Whether a pack can be read; FileNotFoundError where none is."""
    try:
        read_pack(path, untyped)
    except FileNotFoundError:
        raise
    except (ValueError, OSError):
        return False
    return True


def _table(number: int, group: Any) -> CellTable:
    columns = {name: own(group, name).asstr()[()] for name in TEXTS[:3]}
    count = len(columns["key"])
    rows = np.arange(count) if len(own(group, "arrays")) else np.full(count, -1)
    columns |= {"pack": np.zeros(count), "group": np.full(count, number), "row": rows}
    return checked_table(columns, group)


def checked_table(columns: Mapping[str, Any], numbers: Any) -> CellTable:
    """The table of columns, and of those of ``numbers``, that a file holds.

    Raises ValueError unless all are of one length and of what they should be.
    """
    count = len(columns["key"])
    made = {name: np.asarray(columns[name]).astype(kind) for name, kind in PLAIN.items()}
    held = {n: np.asarray(own(numbers, n)[()]).astype(np.float64) for n in NUMBERS if n in numbers}
    if any(column.shape != (count,) for column in (*made.values(), *held.values())):
        raise ValueError("its columns differ in length")
    for name in ("key", "status"):
        made[name].astype("U")  # which must be letters
    return CellTable(**made, numbers=held)


def check_keys(group: Any, rows: Sequence[int], keys: Sequence[str]) -> None:
    """Raise ValueError if rows of a pack's group are not those of these keys.

    The pack may be another one than when it was indexed. An empty key is any.
    """
    asked = [(row, key) for row, key in zip(rows, keys, strict=True) if key]
    if any(own(group, "key").asstr()[row] != key for row, key in asked):
        raise ValueError("it holds other runs than it did")


def load_row(path: Path, group: int, row: int, key: str = "", untyped: int = 1) -> xr.Dataset:
    """One of a pack's runs, which has the ``key`` if there is one, with the bits that it had.

    Raises as `open_pack`.
    """
    import xarray as xr

    with open_pack(path, untyped) as file:
        try:
            held_group = own(file, str(group))
            check_keys(held_group, [row], [key])
            data: dict[str, Any] = {}
            coordinates: dict[str, Any] = {}
            inner = own(held_group, "arrays")
            for name in inner:
                held = own(inner, name)
                found = data if not held.attrs["coordinate"] else coordinates
                texts = json.loads(held.attrs["attributes"])
                found[name] = (json.loads(held.attrs["dims"]), values_of(held[row]), texts)
            return xr.Dataset(data, coordinates, json.loads(own(held_group, "attributes")[row]))
        except Exception as error:  # see read_pack
            raise ValueError(
                f"a pack must hold whole runs, got {path}: {reason_of(error)}"
            ) from None
