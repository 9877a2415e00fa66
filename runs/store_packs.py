"""The packs of a store: what they hold together, by key, and how many small ones become few.

An index beside the packs holds their tables: at the next start only packs that are new are opened.
It is made of the packs alone, and again whenever it is not there. Packs of a few cells are merged
while a sweep runs, so that a million cells leave some hundred files.
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

from longwave.runs.hdf_contents import check_contents
from longwave.runs.run_pack import (
    PLAIN,
    REFUSED,
    SETTLED,
    CellRecord,
    CellTable,
    DamagedPackError,
    checked_table,
    is_pack,
    joined_tables,
    load_row,
    merged_content,
    read_pack,
)
from longwave.support.atomic_file import not_stale
from longwave.support.file_lock import locked
from longwave.support.request_limits import current_limits
from longwave.support.sealed_file import LOG, check_no_link, read_sealed, write_sealed
from longwave.support.user_files import reason_of

if TYPE_CHECKING:
    import xarray as xr

PACKS, SUFFIX, INDEX, LOCK = "packs", ".h5", "index", "merge.lock"
"""The folder of a store for packs, their suffix, and the files beside them."""

WORTH_AN_INDEX = 16
"""New packs from which on the index is written anew: they are read in some 50 ms."""

FAN, ABOUT, LARGEST = 32, 8, 2**25
"""Packs that are merged when there are so many that differ by less than a factor ``ABOUT``, which
one pack of them is beyond; and the bytes of the largest that come of it. From some 15 kB on a byte
is written again three times at most."""


class PackStamp(NamedTuple):
    """By what a pack that changed is known; none does that was left alone."""

    size: int
    changed: int


def new_pack(folder: Path) -> Path:
    """A name for a further pack of the store in that folder; OSError if a link is there.

    Packs lie in 256 folders by the first letters of their names.
    """
    name = uuid.uuid4().hex
    place = folder / PACKS / name[:2]
    check_no_link(folder / PACKS)
    place.mkdir(parents=True, exist_ok=True)
    check_no_link(place)
    return place / f"{name}{SUFFIX}"


@dataclass(frozen=True)
class PackedRun:
    """Where a run is: the store's folder, the pack in it, its group and row there, and the key."""

    folder: Path
    pack: str
    group: int
    row: int
    key: str = ""

    @property
    def path(self) -> Path:
        """The pack's file."""
        return self.folder / PACKS / self.pack

    @property
    def untyped(self) -> int:
        """How many of the last names of its path nobody has typed."""
        return untyped_names(self.pack)

    def load(self) -> xr.Dataset:
        """The run, with the bits that it had; ValueError where its pack holds none there."""
        try:
            return self._row()
        except FileNotFoundError:
            (place,) = moved([self])
            return place._row()
        except ValueError:
            forget_index(self.folder)
            raise

    def _row(self) -> xr.Dataset:
        return load_row(self.path, self.group, self.row, self.key, self.untyped)


def untyped_names(pack: str) -> int:
    """How many of the last names of a pack's path nobody has typed: all within the store.

    >>> untyped_names("ab/p.h5")
    3
    """
    return 2 + pack.count("/")


def moved(places: Sequence[PackedRun]) -> list[PackedRun]:
    """Where runs of one store are whose packs were merged since; ValueError where there is none."""
    index, found = pack_index(places[0].folder), []
    for place in places:
        held = index.get(place.key)
        if held is None or held[1] is None:
            raise ValueError(f"a pack must hold whole runs, got none: {place.path} is gone")
        found.append(held[1])
    return found


class PackIndex:
    """What a store's packs hold, by key; of several attempts one that settled it with its run.

    ``table`` has a row for each key, sorted by it; ``packs`` are their names by the numbers there.
    """

    def __init__(self, folder: Path, packs: Sequence[str], table: CellTable) -> None:
        self.folder, self.packs = folder, packs
        settled = np.isin(table.status, [status.encode() for status in SETTLED])
        rank = np.where(table.row >= 0, 0, np.where(settled, 1, 2))
        order = np.lexsort((rank, table.key))
        _, first = np.unique(table.key[order], return_index=True)
        self.table = table.taken(order[first])
        refused = self.table.status == REFUSED.encode()
        self._settled = refused | (settled[order[first]] & (self.table.row >= 0))

    def __len__(self) -> int:
        return len(self.table)

    def row(self, key: str) -> int | None:
        """The row of a key in the table; None if no pack has it."""
        asked = key.encode()
        place = int(np.searchsorted(self.table.key, asked))
        found = place < len(self.table) and self.table.key[place] == asked
        return place if found else None

    def settles(self, key: str) -> bool:
        """Whether a cell is not run again: there is its run, or that it has none."""
        row = self.row(key)
        return row is not None and bool(self._settled[row])

    def place(self, row: int) -> PackedRun | None:
        """Where the run of a row in the table is."""
        table = self.table
        if table.row[row] < 0:
            return None
        held = int(table.group[row]), int(table.row[row]), table.key[row].decode()
        return PackedRun(self.folder, self.packs[table.pack[row]], *held)

    def get(self, key: str) -> tuple[CellRecord, PackedRun | None] | None:
        """The cell of a key, and where its run is if there is one."""
        row = self.row(key)
        return None if row is None else (self.table.record(row), self.place(row))


def pack_index(folder: Path) -> PackIndex:
    """What the packs of the store in that folder hold; damaged ones count as missing.

    The index there is brought up to date if many packs are new.
    """
    known = _kept_index(folder)
    old = len(known)
    bad, gone = set[tuple[str, PackStamp]](), set[tuple[str, PackStamp]]()
    while True:
        here = _packs(folder)
        for name, stamp in here.items():
            if known.get(name, (None,))[0] != stamp and (name, stamp) not in bad:
                try:
                    known[name] = stamp, read_pack(folder / PACKS / name, untyped_names(name))
                except FileNotFoundError:  # it was merged in between, into one to be listed
                    if (name, stamp) not in gone:
                        gone.add((name, stamp))
                        break
                    bad.add((name, stamp))  # and is listed again: the listing is an old one
                except DamagedPackError:
                    bad.add((name, stamp))
                except (ValueError, OSError) as error:
                    LOG.warning("%s: it counts as missing", error)
                    bad.add((name, stamp))
        else:
            break
    known = {name: held for name, held in known.items() if name in here and held[0] == here[name]}
    names = list(known)
    tables = [
        replace(table, pack=np.full(len(table), number, np.int32))
        for number, (_, table) in enumerate(known.values())
    ]
    table = joined_tables(tables)
    if abs(len(known) - old) >= WORTH_AN_INDEX:
        with suppress(OSError):  # one that may only be read serves as well
            stamps = [(name, *stamp) for name, (stamp, _) in known.items()]
            write_sealed(folder / PACKS / INDEX, _index_content(stamps, table), durable=False)
    return PackIndex(folder, names, table)


def _index_content(stamps: Sequence[tuple[str, int, int]], table: CellTable) -> bytes:
    import h5py

    image = BytesIO()
    with h5py.File(image, "w") as file:
        kind = h5py.string_dtype()
        file.create_dataset("packs", data=np.array([json.dumps(stamps)], object), dtype=kind)
        for name in PLAIN:
            told = {"dtype": kind} if name == "message" else {}
            file.create_dataset(name, data=getattr(table, name), **told)
        numbers = file.create_group("numbers")
        for name, column in table.numbers.items():
            numbers.create_dataset(name, data=column)
    return image.getvalue()


def _kept_index(folder: Path) -> dict[str, tuple[PackStamp, CellTable]]:
    """The packs and their tables as they were when the index was written; nothing without one."""
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
                for name, kind in PLAIN.items()
            }
            table = checked_table(columns, file["numbers"])
        ends = np.searchsorted(table.pack, np.arange(len(packs) + 1))
        if np.any(np.diff(table.pack) < 0) or ends[0] != 0 or ends[-1] != len(table):
            raise ValueError("its rows are of other packs")
    except Exception as error:  # see run_pack.read_pack
        LOG.warning("%s is no index: it is made anew (%s)", path, reason_of(error))
        return {}
    parts = (np.arange(*pair) for pair in pairwise(ends))
    return {
        name: (stamp, table.taken(part)) for (name, stamp), part in zip(packs, parts, strict=True)
    }


def forget_index(folder: Path) -> None:
    """Have all packs looked at when the store is opened next."""
    with suppress(OSError):
        (folder / PACKS / INDEX).unlink()


def _packs(folder: Path) -> dict[str, PackStamp]:
    """The packs there by name, sorted, without following links; one of many names has one."""
    found: dict[str, PackStamp] = {}
    packs = folder / PACKS
    if not_stale(packs.is_symlink):
        return found
    _list(packs, "", found, set())
    return dict(sorted(found.items()))


def _list(
    folder: Path, inside: str, found: dict[str, PackStamp], seen: set[tuple[int, int]]
) -> None:
    """Add the packs of a folder; ``seen`` are files of several names."""
    with suppress(FileNotFoundError, NotADirectoryError), os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.startswith(".") or entry.is_symlink():
                continue
            if entry.is_dir():
                if not inside and len(entry.name) == 2:
                    _list(folder / entry.name, f"{entry.name}/", found, seen)
            elif entry.name.endswith(SUFFIX):
                with suppress(FileNotFoundError):
                    told = not_stale(partial(entry.stat, follow_symlinks=False))
                    if told.st_nlink > 1:  # hard links cost nothing, and reading each does
                        if (told.st_dev, told.st_ino) in seen:
                            continue
                        seen.add((told.st_dev, told.st_ino))
                    found[inside + entry.name] = PackStamp(told.st_size, told.st_mtime_ns)


def merge_packs(folder: Path) -> None:
    """Merge packs of about one size where there are many; what they hold is always in one of them.

    Whoever has read which packs there are finds some gone, and looks again. Raises OSError where
    nothing can be written.
    """
    with locked(folder / PACKS / LOCK):
        held = ((size, name) for name, (size, _) in _packs(folder).items() if size < LARGEST / 2)
        for alike in _alike(sorted(held)):
            for names in _parts(alike):
                _merge(folder, names)


def _alike(packs: Sequence[tuple[int, str]]) -> Iterator[Sequence[tuple[int, str]]]:
    """Packs of about one size, of those sorted by it, where there are as many as are merged."""
    begin = 0
    while begin < len(packs):
        end = bisect(packs, (ABOUT * packs[begin][0], ""))
        if end - begin >= FAN:
            yield packs[begin:end]
            begin = end
        else:
            begin += 1


def _parts(alike: Sequence[tuple[int, str]]) -> Iterator[list[str]]:
    """The packs in parts of no more than the largest size, each of several."""
    part: list[str] = []
    total = 0
    for size, name in alike:
        if total + size > LARGEST:
            if len(part) > 1:
                yield part
            part, total = [], 0
        part.append(name)
        total += size
    if len(part) > 1:
        yield part


def _merge(folder: Path, names: Sequence[str]) -> None:
    """Write one pack of these, and remove them when it is on the disk; damaged ones stay."""
    paths = {folder / PACKS / name: untyped_names(name) for name in names}
    try:
        whole = [(path, untyped) for path, untyped in paths.items() if is_pack(path, untyped)]
        content = merged_content(whole)
    except FileNotFoundError:  # another process merged it, where files have no locks
        return
    write_sealed(new_pack(folder), content, force=False)
    for path, _ in whole:
        with suppress(OSError):
            path.unlink()
