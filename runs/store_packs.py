"""The packs of a store as one table by key, its index file, and the merging of small packs.

The index file holds the tables of all packs, so that only new packs are opened at the next start.
It is derived from the packs alone and rebuilt if it is missing. Packs of a few cells are merged
while a sweep runs, so that a million cells end in a few hundred files.
"""

from __future__ import annotations

import json
import os
import uuid
from bisect import bisect
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from longwave.runs import run_pack
from longwave.runs.hdf_contents import check_contents
from longwave.support.atomic_file import not_stale
from longwave.support.file_lock import locked
from longwave.support.request_limits import current_limits
from longwave.support.sealed_file import LOG, check_no_link, read_sealed, write_sealed
from longwave.support.user_files import reason_of

if TYPE_CHECKING:
    import xarray as xr

PACKS, SUFFIX, INDEX, LOCK = "packs", ".h5", "index", "merge.lock"
"""Folder of a store's packs, suffix of a pack, and names of the index and the lock."""

INDEXED_CHANGES = 16
"""Number of added or removed packs from which a new index is written; reading 16 takes 50 ms."""

MERGED_COUNT, SIZE_RATIO, MOST_BYTES = 32, 8, 2**25
"""Merging rules: packs are merged once 32 of them have sizes within a factor of 8, and no merged
pack exceeds 2**25 bytes. Beyond about 15 kB each byte is rewritten at most three times."""


class PackStamp(NamedTuple):
    """Size and modification time of a pack, by which a changed pack is recognised."""

    size: int
    changed: int


def new_pack(folder: Path) -> Path:
    """Return a new path for a pack of the store in ``folder``, and create its parent folder.

    Packs are spread over 256 subfolders by the first letters of their names. Raises OSError if one
    of the folders is a link.
    """
    name = uuid.uuid4().hex
    subfolder = folder / PACKS / name[:2]
    check_no_link(folder / PACKS)
    subfolder.mkdir(parents=True, exist_ok=True)
    check_no_link(subfolder)
    return subfolder / f"{name}{SUFFIX}"


@dataclass(frozen=True)
class PackedRun:
    """Location of a run: the store's folder, the pack, group and row in it, and the run's key."""

    folder: Path
    pack: str
    group: int
    row: int
    key: str = ""

    @property
    def path(self) -> Path:
        """Path of the pack."""
        return self.folder / PACKS / self.pack

    def load(self) -> xr.Dataset:
        """Load the run, bit by bit as it was saved; raise ValueError if its pack lacks it."""
        try:
            return self._load_row()
        except FileNotFoundError:
            (location,) = relocated_runs([self])
            return location._load_row()
        except ValueError:
            with suppress(OSError):  # without the index, all packs are read when opened next
                (self.folder / PACKS / INDEX).unlink()
            raise

    def _load_row(self) -> xr.Dataset:
        link_free = link_free_parts(self.pack)
        return run_pack.load_row(self.path, self.group, self.row, self.key, link_free)


def link_free_parts(pack: str) -> int:
    """Return how many last components of a pack's path lie inside the store and must not be links.

    >>> link_free_parts("ab/p.h5")
    3
    """
    return 2 + pack.count("/")


def relocated_runs(runs: Sequence[PackedRun]) -> list[PackedRun]:
    """Return the current locations of one store's runs after merges; ValueError if one is gone."""
    index, relocated = pack_index(runs[0].folder), []
    for run in runs:
        entry = index.get(run.key)
        if entry is None or entry[1] is None:
            raise ValueError(f"pack must exist, got none: {run.path} is gone (run the sweep again)")
        relocated.append(entry[1])
    return relocated


class PackIndex:
    """Index of a store's packs by key; if a cell was tried several times, a result with a run wins.

    ``table`` has one row for each key and is sorted by key; ``packs`` are the names to which the
    numbers in its column ``pack`` refer.
    """

    def __init__(self, folder: Path, packs: Sequence[str], table: run_pack.CellTable) -> None:
        self.folder, self.packs = folder, packs
        is_final = np.isin(table.status, [status.encode() for status in run_pack.FINAL])
        rank = np.where(table.row >= 0, 0, np.where(is_final, 1, 2))
        order = np.lexsort((rank, table.key))
        _, first = np.unique(table.key[order], return_index=True)
        self.table = table.select(order[first])
        refused = self.table.status == run_pack.REFUSED.encode()
        self._settled = refused | (is_final[order[first]] & (self.table.row >= 0))

    def __len__(self) -> int:
        return len(self.table)

    def row(self, key: str) -> int | None:
        """Return the row of a key in the table; None if no pack has the key."""
        encoded = key.encode()
        position = int(np.searchsorted(self.table.key, encoded))
        is_present = position < len(self.table) and self.table.key[position] == encoded
        return position if is_present else None

    def settles(self, key: str) -> bool:
        """Whether the cell ``key`` need not be run: its run is stored, or its scene was refused."""
        row = self.row(key)
        return row is not None and bool(self._settled[row])

    def location(self, row: int) -> PackedRun | None:
        """Return the location of the run in a row of the table; None if the cell has no run."""
        table = self.table
        if table.row[row] < 0:
            return None
        position = int(table.group[row]), int(table.row[row]), table.key[row].decode()
        return PackedRun(self.folder, self.packs[table.pack[row]], *position)

    def get(self, key: str) -> tuple[run_pack.CellRecord, PackedRun | None] | None:
        """Return the cell of a key and the location of its run, if there is one."""
        row = self.row(key)
        return None if row is None else (self.table.record(row), self.location(row))


def pack_index(folder: Path) -> PackIndex:
    """Return the index of a store's undamaged packs; rewrite its file if many packs are new."""
    entries = _read_index(folder)
    indexed_count = len(entries)
    unreadable, vanished = set[tuple[str, PackStamp]](), set[tuple[str, PackStamp]]()
    while True:
        listed = _list_packs(folder)
        for name, stamp in listed.items():
            if entries.get(name, (None,))[0] != stamp and (name, stamp) not in unreadable:
                try:
                    entries[name] = (
                        stamp,
                        run_pack.read_pack(folder / PACKS / name, link_free_parts(name)),
                    )
                except FileNotFoundError:  # merged meanwhile: list again to find the merged pack
                    if (name, stamp) not in vanished:
                        vanished.add((name, stamp))
                        break
                    unreadable.add((name, stamp))  # listed a second time: the listing is outdated
                except run_pack.DamagedPackError:
                    unreadable.add((name, stamp))
                except (ValueError, OSError) as error:
                    LOG.warning("%s: its runs count as missing", error)
                    unreadable.add((name, stamp))
        else:
            break
    entries = {
        name: entry
        for name, entry in entries.items()
        if name in listed and entry[0] == listed[name]
    }
    names = list(entries)
    tables = [
        replace(table, pack=np.full(len(table), number, np.int32))
        for number, (_, table) in enumerate(entries.values())
    ]
    table = run_pack.concatenate_tables(tables)
    if abs(len(entries) - indexed_count) >= INDEXED_CHANGES:
        with suppress(OSError):  # a read-only store works without an index
            stamps = [(name, *stamp) for name, (stamp, _) in entries.items()]
            write_sealed(folder / PACKS / INDEX, _index_content(stamps, table), durable=False)
    return PackIndex(folder, names, table)


def _index_content(stamps: Sequence[tuple[str, int, int]], table: run_pack.CellTable) -> bytes:
    import h5py

    image = BytesIO()
    with h5py.File(image, "w") as file:
        kind = h5py.string_dtype()
        file.create_dataset("packs", data=np.array([json.dumps(stamps)], object), dtype=kind)
        for name in run_pack.COLUMN_TYPES:
            options = {"dtype": kind} if name == "message" else {}
            file.create_dataset(name, data=getattr(table, name), **options)
        numbers = file.create_group("numbers")
        for name, column in table.numbers.items():
            numbers.create_dataset(name, data=column)
    return image.getvalue()


def _read_index(folder: Path) -> dict[str, tuple[PackStamp, run_pack.CellTable]]:
    """Return the packs recorded in the index file, with stamp and table; empty without an index."""
    import h5py

    path = folder / PACKS / INDEX
    content = read_sealed(path, current_limits().memory_bytes, untyped=2)
    if content is None:
        return {}
    try:
        with h5py.File(BytesIO(content)) as file:
            check_contents(file, len(content), deepest=1)
            packs = [
                (str(name), PackStamp(int(size), int(changed)))
                for name, size, changed in json.loads(file["packs"].asstr()[0])
            ]
            columns = {
                name: file[name].asstr()[()] if kind is object else file[name][()]
                for name, kind in run_pack.COLUMN_TYPES.items()
            }
            table = run_pack.build_table(columns, file["numbers"])
        ends = np.searchsorted(table.pack, np.arange(len(packs) + 1))
        if np.any(np.diff(table.pack) < 0) or ends[0] != 0 or ends[-1] != len(table):
            raise ValueError("rows must be sorted by pack, got another order or number")
    except Exception as error:  # see run_pack.read_pack
        LOG.warning("%s is not an index and is rebuilt (%s)", path, reason_of(error))
        return {}
    parts = (np.arange(*pair) for pair in pairwise(ends))
    return {
        name: (stamp, table.select(part)) for (name, stamp), part in zip(packs, parts, strict=True)
    }


def _list_packs(folder: Path) -> dict[str, PackStamp]:
    """Return the packs in the folder, sorted by name; ignore links and repeated hard links."""
    listed: dict[str, PackStamp] = {}
    pack_folder = folder / PACKS
    if not_stale(pack_folder.is_symlink):
        return listed
    _list_folder(pack_folder, "", listed, set())
    return dict(sorted(listed.items()))


def _list_folder(
    folder: Path, prefix: str, listed: dict[str, PackStamp], known_files: set[tuple[int, int]]
) -> None:
    """Add the packs of a folder to ``listed``; a file with several hard links is added once.

    ``known_files`` collects the device and inode of files with several hard links.
    """
    with suppress(FileNotFoundError, NotADirectoryError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(".") or entry.is_symlink():
                continue
            if entry.is_dir():
                if not prefix and len(entry.name) == 2:
                    _list_folder(folder / entry.name, f"{entry.name}/", listed, known_files)
            elif entry.name.endswith(SUFFIX):
                with suppress(FileNotFoundError):
                    status = not_stale(partial(entry.stat, follow_symlinks=False))
                    if status.st_nlink > 1:  # many hard links to one large pack are read once
                        if (status.st_dev, status.st_ino) in known_files:
                            continue
                        known_files.add((status.st_dev, status.st_ino))
                    listed[prefix + entry.name] = PackStamp(status.st_size, status.st_mtime_ns)


def merge_packs(folder: Path) -> None:
    """Merge packs of similar size where there are many. Every cell is in some pack at all times.

    A process that has listed the packs before may find some gone, and must list them again. Raises
    OSError if nothing can be written.
    """
    with locked(folder / PACKS / LOCK):
        sizes = (
            (size, name) for name, (size, _) in _list_packs(folder).items() if size < MOST_BYTES / 2
        )
        for similar in _similar_packs(sorted(sizes)):
            for names in _size_limited_parts(similar):
                _merge(folder, names)


def _similar_packs(packs: Sequence[tuple[int, str]]) -> Iterator[Sequence[tuple[int, str]]]:
    """Yield groups of packs of similar size, large enough to merge; ``packs`` is sorted by size."""
    begin = 0
    while begin < len(packs):
        end = bisect(packs, (SIZE_RATIO * packs[begin][0], ""))
        if end - begin >= MERGED_COUNT:
            yield packs[begin:end]
            begin = end
        else:
            begin += 1


def _size_limited_parts(packs: Sequence[tuple[int, str]]) -> Iterator[list[str]]:
    """Yield the names of packs in groups of two or more with at most `MOST_BYTES` together."""
    part: list[str] = []
    total = 0
    for size, name in packs:
        if total + size > MOST_BYTES:
            if len(part) > 1:
                yield part
            part, total = [], 0
        part.append(name)
        total += size
    if len(part) > 1:
        yield part


def _merge(folder: Path, names: Sequence[str]) -> None:
    """Write the packs ``names`` as one pack, then delete them; damaged packs are left alone."""
    paths = {folder / PACKS / name: link_free_parts(name) for name in names}
    try:
        intact = [
            (path, link_free)
            for path, link_free in paths.items()
            if run_pack.is_pack(path, link_free)
        ]
        content = run_pack.merged_content(intact)
    except FileNotFoundError:  # without working locks, another process may have merged it
        return
    write_sealed(new_pack(folder), content, force=False)
    for path, _ in intact:
        with suppress(OSError):
            path.unlink()
