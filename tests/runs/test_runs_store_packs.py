"""Catches: a cell lost by merging or by the index, a pack opened needlessly, a wrong index used."""

from __future__ import annotations

import errno
import io
import os
from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from threading import Thread
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr

from longwave.runs import run_pack, run_store, store_packs, sweep_fields
from longwave.runs import sweep as sweep_module
from longwave.runs.run_pack import CellRecord, pack_content, write_pack
from longwave.runs.run_store import RunStore
from longwave.runs.store_packs import (
    INDEX,
    INDEXED_CHANGES,
    MERGED_COUNT,
    MOST_BYTES,
    PACKS,
    merge_packs,
    new_pack,
    pack_index,
)
from longwave.runs.sweep import run_sweep
from longwave.runs.sweep_cost import expected_sweep_cost
from longwave.runs.sweep_dataset import sweep_dataset
from longwave.runs.sweep_file import sweep_of
from longwave.support.processes import LocalWorkers
from longwave.support.sealed_file import read_sealed, write_sealed


def a_run(number: int) -> xr.Dataset:
    """Return a run, of three layouts in turn, with texts of different lengths and a NaN."""
    size = (3, 700, 0)[number % 3]
    texts = ["é" * (1 + number % 4)] * 2
    values = np.full(size, number / 3.0)
    values[: size // 2] = np.nan
    return xr.Dataset(
        {"values": ("x", values), "texts": ("y", texts), "many": (("y", "x"), np.ones((2, size)))},
        {"y": [1, 2]},
        {"number": number, "title": f"é {number}"},
    )


def records(first: int, count: int) -> Iterator[CellRecord]:
    for number in range(first, first + count):
        key = f"{number:040x}"
        if number % 5 == 4:
            yield CellRecord(key, "refused", f"no {number}")
        else:
            numbers = {"error": float(number)} | ({"last_peak": 0.5} if number % 7 == 0 else {})
            yield CellRecord(key, "done", "", numbers, a_run(number))


def fill(folder: Path, packs: int, cells: int = 3, first: int = 0) -> None:
    for number in range(packs):
        write_pack(new_pack(folder), records(first + number * cells, cells))


def check(folder: Path, count: int) -> None:
    """Check that every cell is stored and unchanged."""
    index = pack_index(folder)
    assert len(index) == count
    for record in records(0, count):
        stored_values = index.get(record.key)
        assert stored_values is not None
        found, place = stored_values
        assert (found.status, found.message) == (record.status, record.message)
        for name in ("error", "last_peak"):
            assert found.numbers.get(name, np.nan) == pytest.approx(
                record.numbers.get(name, np.nan), abs=0, nan_ok=True
            )
        assert index.settles(record.key)
        assert (place is None) == (record.run is None)
        if place is not None and record.run is not None:
            xr.testing.assert_identical(place.load(), record.run)
    assert index.get("f" * 40) is None
    assert not index.settles("f" * 40)


def files(folder: Path) -> list[Path]:
    return sorted(path for path in (folder / PACKS).rglob("*.h5"))


@pytest.mark.slow
def test_packs_lie_in_folders_and_are_found(tmp_path: Path) -> None:
    fill(tmp_path, 3)
    check(tmp_path, 9)
    assert all(path.parent.parent == tmp_path / PACKS for path in files(tmp_path))
    write_pack(tmp_path / PACKS / "older.h5", records(9, 2))
    check(tmp_path, 11)
    assert not (tmp_path / PACKS / INDEX).exists()
    fill(tmp_path, INDEXED_CHANGES, first=11)
    check(tmp_path, 11 + 3 * INDEXED_CHANGES)
    assert (tmp_path / PACKS / INDEX).exists()


@pytest.mark.slow
def test_with_an_index_only_new_packs_are_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path, INDEXED_CHANGES)
    before = pack_index(tmp_path)
    opened: list[Path] = []
    read = run_pack.read_pack

    def counted(path: Path, untyped: int) -> Any:
        opened.append(path)
        return read(path, untyped)

    monkeypatch.setattr(run_pack, "read_pack", counted)
    assert len(pack_index(tmp_path)) == len(before)
    assert opened == []
    fill(tmp_path, 2, first=3 * INDEXED_CHANGES)
    assert len(pack_index(tmp_path)) == len(before) + 6
    assert len(opened) == 2
    check(tmp_path, len(before) + 6)
    for path in opened[:2]:
        path.unlink()
    check(tmp_path, len(before))


def test_a_changed_pack_is_read_again_and_a_damaged_one_is_ignored(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    fill(tmp_path, INDEXED_CHANGES)
    pack_index(tmp_path)
    path, stored_values = files(tmp_path)[0], len(pack_index(tmp_path))
    content = path.read_bytes()
    path.write_bytes(content[:-90] + bytes([content[-90] ^ 1]) + content[-89:])
    assert len(pack_index(tmp_path)) == stored_values - 3
    assert "damaged" in caplog.text


def test_a_run_damaged_after_indexing_is_run_again(tmp_path: Path) -> None:
    """A disk error, for example, leaves the times of files unchanged."""
    fill(tmp_path, INDEXED_CHANGES)
    pack_index(tmp_path)
    run_pack._remembered.clear()
    stored_values = pack_index(tmp_path).get(f"{0:040x}")
    assert stored_values is not None
    assert stored_values[1] is not None
    path = stored_values[1].path
    output, content = path.stat(), path.read_bytes()
    path.write_bytes(content[:-90] + bytes([content[-90] ^ 1]) + content[-89:])
    os.utime(path, ns=(output.st_atime_ns, output.st_mtime_ns))
    assert pack_index(tmp_path).settles(stored_values[0].key)
    with pytest.raises(ValueError, match="damaged"):
        stored_values[1].load()
    assert not pack_index(tmp_path).settles(stored_values[0].key)


def _other_length(file: Any) -> None:
    rows = file["row"][()][:-1]
    del file["row"]
    file["row"] = rows


def _other_pack(file: Any) -> None:
    file["pack"][-1] = 999


def _no_order(file: Any) -> None:
    file["pack"][0] = 1


def _no_column(file: Any) -> None:
    del file["key"]


def _a_claim(file: Any) -> None:
    del file["row"]
    file.create_dataset("row", shape=(10**9,), dtype="i4", chunks=(1000,))


def _a_link(file: Any) -> None:
    del file["row"]
    file["row"] = h5py.ExternalLink("other.h5", "/row")


def _no_letters(file: Any) -> None:
    file["status"][0] = b"\xff"


def _a_square(file: Any) -> None:
    values = file["numbers"]["error"][()]
    del file["numbers"]["error"]
    file["numbers"]["error"] = np.stack([values, values], axis=1)


def _texts_for_numbers(file: Any) -> None:
    del file["numbers"]["error"]
    file["numbers"]["error"] = np.full(len(file["row"]), b"x")


@pytest.mark.slow
@pytest.mark.parametrize(
    "attack",
    [
        _other_length,
        _other_pack,
        _no_order,
        _no_column,
        _a_claim,
        _a_link,
        _no_letters,
        _a_square,
        _texts_for_numbers,
    ],
)
def test_a_wrong_index_is_rebuilt(
    attack: Callable[[Any], None], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    fill(tmp_path, INDEXED_CHANGES, cells=2)
    pack_index(tmp_path)
    path = tmp_path / PACKS / INDEX
    content = read_sealed(path)
    assert content is not None
    image = io.BytesIO(content)
    with h5py.File(image, "r+") as file:
        attack(file)
    write_sealed(path, image.getvalue())
    found = pack_index(tmp_path)
    assert all(found.settles(record.key) for record in records(0, 2 * INDEXED_CHANGES))
    assert "is not an index" in caplog.text
    path.write_bytes(b"anything")
    check(tmp_path, 2 * INDEXED_CHANGES)


@pytest.mark.parametrize("column", ["error", "status", "message", "key"])
def test_a_pack_with_a_shorter_column_is_not_read(column: str, tmp_path: Path) -> None:
    image = io.BytesIO(pack_content(records(0, 3)))
    with h5py.File(image, "r+") as file:
        stored_values = file["0"][column][()][:-1]
        del file["0"][column]
        kind = {} if column == "error" else {"dtype": h5py.string_dtype()}
        file["0"].create_dataset(column, data=stored_values, **kind)
    write_sealed(new_pack(tmp_path), image.getvalue())
    assert len(pack_index(tmp_path)) == 0


def test_an_outdated_listing_ends_the_search(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A network file system may list a deleted pack for a while."""
    fill(tmp_path, 3)
    listed = store_packs._list_packs(tmp_path)
    files(tmp_path)[0].unlink()
    monkeypatch.setattr(store_packs, "_list_packs", lambda _: listed)
    assert len(pack_index(tmp_path)) == 6


@pytest.mark.slow
def test_merged_packs_have_the_same_runs(tmp_path: Path) -> None:
    fill(tmp_path, MERGED_COUNT + 5)
    merge_packs(tmp_path)
    left = files(tmp_path)
    assert len(left) < 6
    check(tmp_path, 3 * (MERGED_COUNT + 5))
    merge_packs(tmp_path)
    assert files(tmp_path) == left
    assert [path.name for path in (tmp_path / PACKS).iterdir() if path.is_file()] == []


@pytest.mark.slow
def test_few_packs_and_large_packs_are_not_merged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill(tmp_path, MERGED_COUNT - 1)
    before = files(tmp_path)
    merge_packs(tmp_path)
    assert files(tmp_path) == before
    fill(tmp_path, 1)
    monkeypatch.setattr(store_packs, "MOST_BYTES", before[0].stat().st_size)
    merge_packs(tmp_path)
    assert set(before) <= set(files(tmp_path))
    monkeypatch.setattr(store_packs, "MOST_BYTES", MOST_BYTES)
    merge_packs(tmp_path)
    assert len(files(tmp_path)) < MERGED_COUNT


@pytest.mark.slow
def test_a_damaged_pack_is_not_merged_and_not_removed(tmp_path: Path) -> None:
    fill(tmp_path, MERGED_COUNT + 2)
    bad = files(tmp_path)[7]
    bad.write_bytes(bad.read_bytes()[:-1])
    merge_packs(tmp_path)
    assert bad in files(tmp_path)
    assert len(files(tmp_path)) < 6
    assert len(pack_index(tmp_path)) == 3 * (MERGED_COUNT + 1)


@pytest.mark.slow
def test_a_location_from_before_a_merge_still_loads_the_run(tmp_path: Path) -> None:
    fill(tmp_path, MERGED_COUNT + 2)
    stored_values = pack_index(tmp_path).get(f"{8:040x}")
    assert stored_values is not None
    place = stored_values[1]
    assert place is not None
    merge_packs(tmp_path)
    assert not place.path.exists()
    xr.testing.assert_identical(place.load(), a_run(8))
    fields = sweep_fields._read_rows("values", [place])
    np.testing.assert_array_equal(fields, [a_run(8)["values"].values])
    for path in files(tmp_path):
        path.unlink()
    with pytest.raises(ValueError, match="is gone"):
        place.load()


@pytest.mark.slow
def test_readers_miss_nothing_while_packs_are_merged(tmp_path: Path) -> None:
    fill(tmp_path, MERGED_COUNT, cells=2)
    ended: list[int] = []

    def merge() -> None:
        for turn in range(1, 5):
            merge_packs(tmp_path)
            fill(tmp_path, MERGED_COUNT, cells=2, first=2 * MERGED_COUNT * turn)
        ended.append(1)

    writer = Thread(target=merge)
    writer.start()
    while not ended and writer.is_alive():
        index = pack_index(tmp_path)
        assert all(index.settles(f"{number:040x}") for number in range(2 * MERGED_COUNT))
    writer.join()
    check(tmp_path, 10 * MERGED_COUNT)


@pytest.mark.slow
def test_two_concurrent_merges_lose_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without working locks, one finds packs gone, or merges the same ones."""
    monkeypatch.setattr(store_packs, "locked", lambda *_: nullcontext())
    merged = run_pack.merged_content
    depth: list[int] = []

    def slow(packs: Any) -> bytes:
        content = merged(packs)
        if not depth:
            depth.append(1)
            merge_packs(tmp_path)
        return content

    monkeypatch.setattr(run_pack, "merged_content", slow)
    fill(tmp_path, MERGED_COUNT + 2)
    merge_packs(tmp_path)
    check(tmp_path, 3 * (MERGED_COUNT + 2))


def test_links_among_packs_are_not_followed(tmp_path: Path) -> None:
    fill(tmp_path / "other", 2)
    (tmp_path / "store" / PACKS).mkdir(parents=True)
    (tmp_path / "store" / PACKS / "ab").symlink_to(files(tmp_path / "other")[0].parent)
    (tmp_path / "store" / PACKS / "x.h5").symlink_to(files(tmp_path / "other")[0])
    assert len(pack_index(tmp_path / "store")) == 0
    (tmp_path / "linked").mkdir()
    (tmp_path / "linked" / PACKS).symlink_to(tmp_path / "other" / PACKS)
    assert len(pack_index(tmp_path / "linked")) == 0
    with pytest.raises(OSError, match="must not be a link"):
        new_pack(tmp_path / "linked")


def test_a_pack_with_many_hard_links_is_read_once(tmp_path: Path) -> None:
    """Catches: one reading for each hard link to a pack."""
    fill(tmp_path, 2)
    before = len(pack_index(tmp_path))
    first = files(tmp_path)[0]
    for number in range(50):
        os.link(first, first.with_name(f"{number}.h5"))
    found = pack_index(tmp_path)
    assert len(found.packs) == 2
    assert len(found) == before


def test_an_index_larger_than_the_memory_is_rebuilt(tmp_path: Path) -> None:
    """Catches: a sparse file, which takes no space on the disk, read as a whole."""
    fill(tmp_path, 2)
    before = len(pack_index(tmp_path))
    with (tmp_path / PACKS / INDEX).open("wb") as stream:
        stream.truncate(2**42)
    assert len(pack_index(tmp_path)) == before


def test_a_finished_attempt_takes_precedence_over_a_failed_one(tmp_path: Path) -> None:
    key = "a" * 40
    for status, run in (("failed", None), ("done", a_run(1)), ("failed", None), ("refused", None)):
        write_pack(new_pack(tmp_path), [CellRecord(key, status, status, run=run)])
        stored_values = pack_index(tmp_path).get(key)
        assert stored_values is not None
        assert stored_values[0].status == (
            "failed"
            if run is None and status == "failed" and not pack_index(tmp_path).settles(key)
            else "done"
        )


SCENE = {
    "wave": "soliton_sech",
    "eps": 0.1,
    "t0": 0,
    "snapshots": [0, 1],
    "curve_points": 2,
    "tolerance": 1e-3,
    "lattice": {"K2": 1, "K4": 1},
    "parameters": {"A": 1},
    "domain": {"compared": 20},
}


@pytest.mark.slow
def test_a_large_sweep_opens_no_missing_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 2000 cells 1990 are stored; the others are found to be missing from a listing."""
    heights = {"from": 0.5, "to": 1, "count": 2000}
    sweep, store = sweep_of({"scene": SCENE, "grid": {"parameters.A": heights}}), RunStore(tmp_path)
    run = xr.Dataset({"error": ("time", [0.0])})
    keys = [store.key(sweep.scene(number)) for number in range(1990)]
    for first in range(0, 1990, 100):
        cells = [CellRecord(key, "done", "", {"error": 0.5}, run) for key in keys[first:][:100]]
        write_pack(new_pack(tmp_path), cells)
    looked: list[Path] = []
    whole = run_store.is_whole

    def counted(path: Path) -> bool:
        looked.append(path)
        return whole(path)

    monkeypatch.setattr(run_store, "is_whole", counted)
    assert expected_sweep_cost(sweep, store, store.stored_runs()).missing < 100
    workers = LocalWorkers(1)
    try:
        state = run_sweep(sweep, store, workers)
    finally:
        workers.stop()
    assert (state.stored, state.done, state.faults) == (1990, 10, 0)
    found = sweep_dataset(sweep, store, fields=False)
    assert (found.status == "done").all()
    assert (found.error.values[:1990] == 0.5).all()
    assert found.key.values[5] == keys[5]
    assert looked == []


@pytest.mark.slow
def test_packs_are_merged_during_a_sweep_if_the_disk_allows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    heights = {"from": 0.5, "to": 1, "count": 12}
    sweep = sweep_of({"scene": SCENE, "grid": {"parameters.A": heights}})
    for module in (store_packs, sweep_module):
        monkeypatch.setattr(module, "MERGED_COUNT", 4)
    monkeypatch.setattr(sweep_module._Dispatch, "_size", lambda _: 1)

    def full(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "no space")

    for name, write, fewest, most in (("a", full, 12, 12), ("b", write_sealed, 1, 6)):
        monkeypatch.setattr(store_packs, "write_sealed", write)
        workers = LocalWorkers(1)
        try:
            state = run_sweep(sweep, RunStore(tmp_path / name), workers)
        finally:
            workers.stop()
        assert (state.done, state.faults) == (12, 0)
        assert fewest <= len(files(tmp_path / name)) <= most
        assert len(pack_index(tmp_path / name)) == 12


def test_packs_of_equal_layout_become_one_group(tmp_path: Path) -> None:
    """Even if only some have certain numbers."""
    run = xr.Dataset({"a": ("x", [1.0, 2.0])})
    for number in range(MERGED_COUNT):
        some = {"last_peak": 1.0} if number % 2 else {}
        content = pack_content([CellRecord(f"{number:040x}", "done", "", some, run)])
        write_sealed(new_pack(tmp_path), content)
    merge_packs(tmp_path)
    (pack,) = files(tmp_path)
    with run_pack.open_pack(pack) as file:
        assert list(file) == ["0"]
        assert np.isnan(file["0"]["last_peak"][()]).sum() == MERGED_COUNT // 2
