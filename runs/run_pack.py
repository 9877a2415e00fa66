"""Packs: the runs of a sweep's small cells, many to a file.

A file for every small run would cost as much as the run: HDF5 is a file's open and close, and a
flush to the disk. In a pack, runs whose arrays have the same names and shapes are stacked along
their first axis, a group for each kind; what did not come to a run has a group without arrays. The
file ends with its checksum, as a store's other files do.
"""

from __future__ import annotations

import json
import os
import uuid
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from io import BytesIO
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from longwave.runs.hdf_contents import check_contents
from longwave.runs.run_file import as_json
from longwave.support.sealed_file import LOG, check_no_link, is_whole, open_plain, write_sealed

if TYPE_CHECKING:
    import xarray as xr

PACKS, SUFFIX = "packs", ".h5"
"""The folder of a store for packs, and their suffix."""

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
class PackedRun:
    """Where a run is: file, group and row."""

    path: Path
    group: str
    row: int

    def load(self) -> xr.Dataset:
        """The run, with the bits that it had; ValueError where its pack holds none there."""
        try:
            return self._load()
        except Exception as error:  # see read_pack
            raise ValueError(f"a pack must hold whole runs, got {self.path}: {error}") from None

    def _load(self) -> xr.Dataset:
        import h5py
        import xarray as xr

        with h5py.File(self.path) as file:
            group = file[self.group]
            data: dict[str, Any] = {}
            coordinates: dict[str, Any] = {}
            for name, held in group["arrays"].items():
                found = data if not held.attrs["coordinate"] else coordinates
                texts = json.loads(held.attrs["attributes"])
                found[name] = (json.loads(held.attrs["dims"]), values_of(held[self.row]), texts)
            return xr.Dataset(data, coordinates, json.loads(group["attributes"][self.row]))


def values_of(held: Any) -> Any:
    """What was put in: texts are held as bytes."""
    return np.char.decode(held, "utf-8") if held.dtype.kind == "S" else held


def new_pack(folder: Path) -> Path:
    """A name for a further pack of the store in that folder; OSError if it is a link there."""
    check_no_link(folder / PACKS)
    return folder / PACKS / f"{uuid.uuid4().hex}{SUFFIX}"


def write_pack(path: Path, records: Iterable[CellRecord]) -> None:
    """Write the records to a new file, whole or not at all. Raises OSError that names it."""
    write_sealed(path, pack_content(records), force=False)


def pack_content(records: Iterable[CellRecord]) -> bytes:
    """The bytes of a pack's file, without its seal."""
    import h5py

    kinds: dict[str, list[CellRecord]] = defaultdict(list)
    for record in records:
        kinds[_kind(record.run)].append(record)

    image = BytesIO()  # a full disk breaks no library then
    with h5py.File(image, "w") as file:
        for number, alike in enumerate(kinds.values()):
            _write_group(file.create_group(str(number)), alike)
    return image.getvalue()


def _kind(run: xr.Dataset | None) -> str:
    """What runs that are stacked have in common."""
    if run is None:
        return ""
    variables = run.variables.items()
    return repr([(n, v.dims, v.shape, v.dtype.str, n in run.coords, v.attrs) for n, v in variables])


def _write_group(group: Any, alike: Sequence[CellRecord]) -> None:
    import h5py

    attributes = [{} if one.run is None else one.run.attrs for one in alike]
    texts = {
        "key": [one.key for one in alike],
        "status": [one.status for one in alike],
        "message": [one.message for one in alike],
        "attributes": [json.dumps(told, default=as_json) for told in attributes],
    }
    for name, lines in texts.items():
        group.create_dataset(name, data=np.array(lines, object), dtype=h5py.string_dtype())
    for name in NUMBERS:
        if name in OPTIONAL and not any(name in one.numbers for one in alike):
            continue
        group.create_dataset(name, data=[float(one.numbers.get(name, np.nan)) for one in alike])
    arrays = group.create_group("arrays")
    first = alike[0].run
    if first is None:
        return
    for label, variable in first.variables.items():
        runs = [one.run for one in alike if one.run is not None]
        values = np.stack([np.asarray(run.variables[label].values) for run in runs])
        if values.dtype.kind == "U":
            values = np.char.encode(values, "utf-8")
        packing: dict[str, Any] = {}
        if values[0].nbytes >= COMPRESSED:
            packing = {"compression": LEVEL, "shuffle": True, "chunks": (1, *values.shape[1:])}
        held = arrays.create_dataset(str(label), data=values, **packing)
        held.attrs["dims"] = json.dumps(variable.dims)
        held.attrs["coordinate"] = label in first.coords
        held.attrs["attributes"] = json.dumps(variable.attrs, default=as_json)


def read_pack(path: Path) -> list[tuple[CellRecord, PackedRun | None]]:
    """What a pack holds, its runs still on the disk; nothing of one that is damaged or no pack."""
    if not is_whole(path):
        return []
    try:
        return _records(path)
    except Exception as error:  # what the library raises for such a file is not documented
        LOG.warning("%s is no pack: it counts as missing (%s)", path, error)
        return []


def _records(path: Path) -> list[tuple[CellRecord, PackedRun | None]]:
    import h5py

    found: list[tuple[CellRecord, PackedRun | None]] = []
    with h5py.File(path) as file:
        check_contents(file, path.stat().st_size, deepest=2)
        for name, group in file.items():
            keys, states, messages = (group[text].asstr()[()] for text in TEXTS[:3])
            columns = {number: group[number][()] for number in NUMBERS if number in group}
            has_runs = len(group["arrays"]) > 0
            for row, (key, status, message) in enumerate(zip(keys, states, messages, strict=True)):
                numbers = {number: float(column[row]) for number, column in columns.items()}
                place = PackedRun(path, name, row) if has_runs else None
                found.append((CellRecord(key, status, message, numbers), place))
    return found


def packed_records(folder: Path) -> dict[str, tuple[CellRecord, PackedRun | None]]:
    """What the packs of the store in that folder hold, by key; of several attempts one that settled
    it, if one did with its run. Damaged packs count as missing."""
    found: dict[str, tuple[CellRecord, PackedRun | None]] = {}
    for path in _packs(folder):
        for record, place in read_pack(path):
            older = found.get(record.key)
            if older is None or (record.status in SETTLED and older[1] is None):
                found[record.key] = record, place
    return found


def packed_run(folder: Path, key: str) -> PackedRun | None:
    """The run of that key in a pack of the store in that folder; None if no whole pack has it.

    Keys stand in a pack as they are: the others need not be read as HDF5.
    """
    for path in _packs(folder):
        if _names(path, key.encode()):
            for record, place in read_pack(path):
                if record.key == key and place is not None:
                    return place
    return None


def _names(path: Path, key: bytes) -> bool:
    """Whether the bytes stand in a file, which is not taken into memory for that."""
    with open(open_plain(path), "rb") as stream:
        if os.fstat(stream.fileno()).st_size == 0:
            return False
        with mmap(stream.fileno(), 0, access=ACCESS_READ) as held:
            return held.find(key) >= 0


def _packs(folder: Path) -> list[Path]:
    packs = folder / PACKS
    found = () if packs.is_symlink() else packs.glob(f"[!.]*{SUFFIX}")
    return sorted(path for path in found if path.is_file() and not path.is_symlink())
