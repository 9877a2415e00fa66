"""Files of hostile structure, as runs, packs and checkpoints: no foreign byte, little memory.

Each file is built from a whole one by a few changes of structure. In HDF5 these are arrays in other
files, virtual ones, filters, links of all kinds, fill values of arrays of any size, texts of any
length, names and attributes that h5netcdf knows; in a checkpoint they are changes of its JSON. A
reader must give what was written, or refuse in one line, without a warning. Prints what it found;
the exit status is 1 if there is anything.

    python -m searches.hdf_structures [--count 20000] [--seed 0]
"""

from __future__ import annotations

import argparse
import json
import logging
import shutil
import sys
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

import h5py
import numpy as np
import xarray as xr
from numpy.typing import NDArray

from longwave.runs.run_file import load_run, save_run
from longwave.runs.run_pack import DONE, CellRecord, load_row, read_pack, write_pack
from longwave.runs.store_packs import PACKS, pack_index
from longwave.support.checkpoint import LOOP, CheckpointFolder, Memory
from longwave.support.plain_data import HEAD
from longwave.support.sealed_file import LOG, SEAL_LENGTH, write_sealed
from searches.fuzz_mutations import change_json, few
from searches.peak_memory import peak_bytes, reset_peak

SECRET = 666.0
"""The value that stands in files that nobody named."""

SECONDS, MEGABYTES = 5.0, 200.0
MOST_CHANGES, MOST_LINKS = 3, 500

TEXT = h5py.string_dtype()
NAMES = (
    b"This is a netCDF dimension but not a netCDF variable",
    b"This is a netCDF dimension but not a netCDF variable.",
    b"This is a netCDF dimension but not a netCDF variable.        12",
    b"x",
    b"",
)
LISTS = ("DIMENSION_LIST", "REFERENCE_LIST")
ATTRIBUTES = ("NAME", "CLASS", "DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Dimid", "units")

Change = Callable[[Any, Random, Path], None]
Reader = Callable[[Path], list[NDArray[Any]]]

STAMP, TASK = "stamp", "task"
"""Run and loop of the checkpoints."""


def _groups(file: Any) -> list[Any]:
    found = [file["/"]]
    file.visititems(lambda _, thing: found.append(thing) if isinstance(thing, h5py.Group) else None)
    return found


def _arrays(file: Any) -> list[Any]:
    found: list[Any] = []
    file.visititems(lambda _, t: found.append(t) if isinstance(t, h5py.Dataset) else None)
    return found


class _Place(NamedTuple):
    """Place for a new array, and the attributes of the array that was there."""

    group: Any
    name: str
    shape: tuple[int, ...]
    attributes: dict[str, Any]


def _place(file: Any, random: Random) -> _Place:
    """Choose a new place, or often that of an array, which is removed."""
    arrays = _arrays(file)
    if not arrays or random.random() < 0.2:
        name = f"new{random.randrange(10**6)}"
        return _Place(random.choice(_groups(file)), name, (random.randint(1, 9),), {})
    old = random.choice(arrays)
    attributes = {key: old.attrs[key] for key in old.attrs if key not in LISTS}
    place = _Place(old.parent, old.name.rpartition("/")[2], old.shape or (1,), attributes)
    del place.group[place.name]
    return place


def in_another_file(file: Any, random: Random, secret: Path) -> None:
    """Add an array whose bytes stand in a file of the reader's."""
    group, name, shape, attributes = _place(file, random)
    size = 8 * int(np.prod(shape))
    external = [(str(secret), random.choice((0, 8)), size)]
    _finish(group.create_dataset(name, shape, "f8", external=external), attributes, random)


def virtual(file: Any, random: Random, secret: Path) -> None:
    """Add an array that is made of one in another file."""
    group, name, shape, attributes = _place(file, random)
    layout = h5py.VirtualLayout(shape, "f8")
    layout[...] = h5py.VirtualSource(secret.with_suffix(".h5"), "a", shape)
    _finish(group.create_virtual_dataset(name, layout), attributes, random)


def linked(file: Any, random: Random, secret: Path) -> None:
    """Add a link to another file, another place, or the same object under another name."""
    group, name, *_ = _place(file, random)
    things = [*_arrays(file), *_groups(file)]
    group[name] = random.choice(
        (
            h5py.ExternalLink(secret.with_suffix(".h5"), "a"),
            h5py.SoftLink("/"),
            h5py.SoftLink("/nowhere"),
            random.choice(things),
        )
    )


def linked_often(file: Any, random: Random, _: Path) -> None:
    """Add the same groups in a group, each with the same arrays."""
    group, arrays = random.choice(_groups(file)), _arrays(file)
    count = random.choice((2, MOST_LINKS))
    for number in range(count if arrays else 0):
        group[f"array{number}"] = arrays[0]
        if group.name != "/":
            group.parent[f"{10 + number}"] = group


def filled(file: Any, random: Random, _: Path) -> None:
    """Add an array of any size that was never written."""
    group, name, shape, attributes = _place(file, random)
    shape = (*shape[:-1], 10 ** random.randint(1, 11))
    kind = random.choice(("f8", "i1", TEXT, "S8"))
    value = random.choice((None, 60_000 * "x")) if kind == TEXT else None
    chunks = tuple(min(n, 10**5) for n in shape)
    _finish(
        group.create_dataset(name, shape, kind, chunks=chunks, fillvalue=value), attributes, random
    )


def filtered(file: Any, random: Random, _: Path) -> None:
    """Add an array packed by filters, once or upon each other."""
    group, name, shape = _place(file, random)[:3]
    plan = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plan.set_chunk(tuple(min(n, 1000) for n in shape))
    for _round in range(random.randint(1, 3)):
        random.choice((lambda: plan.set_deflate(9), plan.set_shuffle, plan.set_fletcher32))()
    space = h5py.h5s.create_simple(shape)
    h5py.h5d.create(group.id, name.encode(), h5py.h5t.NATIVE_DOUBLE, space, plan)


def of_another_kind(file: Any, random: Random, _: Path) -> None:
    """Add records, references, lists, texts of any length, or opaque bytes."""
    group, name, shape, attributes = _place(file, random)
    kinds = (
        np.dtype([("x", "f8"), ("y", TEXT)]), h5py.ref_dtype, h5py.vlen_dtype("f8"), TEXT,
        np.dtype("V16"), np.dtype("c16"), np.dtype("S100000"), np.dtype("f2"), np.dtype("?"),
    )  # fmt: skip
    _finish(group.create_dataset(name, shape, random.choice(kinds)), attributes, random)


def attributed(file: Any, random: Random, _: Path) -> None:
    """Add an attribute that the libraries know, of another kind, or a long one."""
    thing = random.choice([*_arrays(file), *_groups(file)])
    value: Any = random.choice(
        (np.bytes_(random.choice(NAMES)), 1, 1e300, np.zeros(1000), 1000 * "x", h5py.Empty("f8"))
    )
    name = random.choice((*ATTRIBUTES, f"other{random.randrange(100)}"))
    if random.random() < 0.2:
        thing.attrs.create(name, 1000 * ["x"], dtype=TEXT)
    else:
        thing.attrs[name] = value


def grouped(file: Any, random: Random, _: Path) -> None:
    """Add groups in groups."""
    group = random.choice(_groups(file))
    for _round in range(random.choice((1, 3, 50))):
        group = group.create_group(f"group{random.randrange(10**6)}")


CHANGES: tuple[Change, ...] = (
    in_another_file, virtual, linked, linked_often, filled, filtered, of_another_kind, attributed,
    grouped,
)  # fmt: skip


def _finish(array: Any, attributes: dict[str, Any], random: Random) -> None:
    """Give an array the attributes ``kept``, and a name that h5netcdf may know."""
    if random.random() < 0.8:
        array.attrs.update(attributes)
    if random.random() < 0.5:
        name = random.choice(NAMES)
        if random.random() < 0.5 and array.shape:
            array.make_scale(name)
        array.attrs["NAME"] = np.bytes_(name)


def _run() -> xr.Dataset:
    return xr.Dataset(
        {"strain": (("time", "site"), np.ones((2, 3)))},
        {"time": [0.0, 1.0], "site": np.arange(3)},
        {"scene": "none"},
    )


def _values(run: xr.Dataset) -> list[NDArray[Any]]:
    return [variable.values for variable in run.variables.values()]


def _read_run(path: Path) -> list[NDArray[Any]]:
    return _values(load_run(path))


def _read_pack(path: Path) -> list[NDArray[Any]]:
    table = read_pack(path)
    rows = zip(table.group.tolist(), table.row.tolist(), strict=True)
    return [v for group, row in rows if row >= 0 for v in _values(load_row(path, group, row))]


def _read_index(path: Path) -> list[NDArray[Any]]:
    index = pack_index(path.parents[1])
    places = [cell for key in ("k0", "k1") if (cell := index.get(key)) is not None]
    return [v for _, place in places if place is not None for v in _values(place.load())]


def _read_checkpoint(path: Path) -> list[NDArray[Any]]:
    keeper = CheckpointFolder(path.parent, STAMP)
    keeper.tell(path.stem)
    memory = keeper.read(path.stem, TASK)
    return [] if memory is None else [v for v in memory.values() if isinstance(v, np.ndarray)]


def _memory() -> Memory:
    state = np.ones((2, 3))
    return {"seconds": 1.0, "state": state, "steps": [1, (2, 3j)], "last": state[0, 0], "at": "x"}


def wholes(folder: Path) -> dict[str, tuple[Path, Reader]]:
    """Return the whole files of each kind, with their readers."""
    store = folder / "store"
    pack, run = store / PACKS / "0.h5", folder / "run.nc"
    save_run(_run(), run)
    pack.parent.mkdir(parents=True)
    write_pack(pack, [CellRecord(f"k{number}", DONE, run=_run()) for number in range(2)])
    CheckpointFolder(folder / "checkpoint", STAMP).write("1", TASK, _memory())
    return {
        "run": (run, _read_run),
        "pack": (pack, _read_pack),
        "pack of a store": (pack, _read_index),
        "checkpoint": (folder / "checkpoint" / f"1{LOOP}", _read_checkpoint),
    }


def _changed_checkpoint(whole: Path, path: Path, random: Random) -> str:
    """Write a checkpoint with its JSON changed, or how long that is said to be."""
    content = whole.read_bytes()[:-SEAL_LENGTH]
    end = HEAD + int.from_bytes(content[:HEAD], "little")
    tree, count = json.loads(content[HEAD:end]), few(random)
    for _ in range(count):
        tree = change_json(random, tree)
    text = json.dumps(tree).encode()
    length = random.choice((*6 * (len(text),), 0, end, 2**62))
    write_sealed(path, b"".join([length.to_bytes(HEAD, "little"), text, content[end:]]))
    return f"{count} changes of JSON"


def changed(whole: Path, path: Path, random: Random, secret: Path) -> str:
    """Write the file with some changes; return their names."""
    if whole.suffix == LOOP:
        return _changed_checkpoint(whole, path, random)
    sealed = whole.suffix == ".h5"
    content = whole.read_bytes()
    path.write_bytes(content[:-SEAL_LENGTH] if sealed else content)
    names = []
    with h5py.File(path, "r+") as file:
        for _ in range(random.randint(1, MOST_CHANGES)):
            change = random.choice(CHANGES)
            try:
                change(file, random, secret)
            except (ValueError, OSError, TypeError, RuntimeError, KeyError):
                continue  # the library refuses to write that
            names.append(change.__name__)
    if sealed:
        write_sealed(path, path.read_bytes())
    return ", ".join(names)


def fault(path: Path, read: Reader) -> str:
    """Return the fault in reading a file, in words; "" if there is none."""
    reset_peak()
    begin, before = time.perf_counter(), peak_bytes()
    with warnings.catch_warnings(record=True) as warned:
        warnings.simplefilter("always")
        try:
            values = read(path)
        except (ValueError, OSError, MemoryError) as error:
            values, message = [], str(error)
            if "\n" in message or len(message) > 2000:
                return f"an error of several lines: {message[:80]!r}"
        except Exception as error:
            return f"{type(error).__name__}: {error}"
    if any(v.dtype.kind == "f" and np.any(v == SECRET) for v in values):
        return "bytes of another file"
    if (seconds := time.perf_counter() - begin) > SECONDS:
        return f"{seconds:.1f} s"
    if (more := (peak_bytes() - before) / 1e6) > MEGABYTES + sum(v.nbytes for v in values) / 1e6:
        return f"{more:.0f} MB"
    return f"a warning: {warned[0].message}" if warned else ""


def search(count: int, seed: int) -> tuple[Counter[str], list[str]]:
    """Count how often each kind was read or refused; return also the numbered faults."""
    random = Random(seed)
    counts: Counter[str] = Counter()
    faults = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        secret = folder / "secret"
        secret.write_bytes(np.full(10**4, SECRET).tobytes())
        with h5py.File(secret.with_suffix(".h5"), "w") as file:
            file["a"] = np.full(100, SECRET)
        kinds = wholes(folder)
        for number in range(count):
            kind, (whole, read) = random.choice([*kinds.items()])
            place = folder / f"{number}"
            path = place / (f"{PACKS}/0.h5" if "store" in kind else whole.name)
            path.parent.mkdir(parents=True)
            names = changed(whole, path, random, secret)
            found = fault(path, read)
            counts[kind] += 1
            if found:
                faults.append(f"{kind} {number} of seed {seed} ({names}): {found}")
            shutil.rmtree(place)
    return counts, faults


def main() -> int:
    """Print what was found; return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--count", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    LOG.setLevel(logging.ERROR)
    counts, faults = search(given.count, given.seed)
    print(*faults, f"{len(faults)} faults in {dict(counts)}", sep="\n")
    return bool(faults)


if __name__ == "__main__":
    sys.exit(main())
