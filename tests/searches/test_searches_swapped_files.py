"""Few calls of every reader whose file is swapped meanwhile, and faults that are to be seen."""

from __future__ import annotations

import os
import re
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import pytest

from longwave.cli import verdict_lines
from longwave.runs import run_file, run_pack
from longwave.support import checkpoint, sealed_file, user_files
from longwave.support.compiled import kernel_folder
from searches import swapped_files
from searches.swap_readers import READERS
from searches.swapped_files import search

CALLS = 10

WRONG = re.compile("foreign bytes|no content that was there")

MOST_CALLS, MOST_SECONDS = 10**6, 300.0
"""In which a fault is found on any machine; it takes seconds at most."""


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_no_reader_gives_foreign_bytes(reader: str) -> None:
    found = search(reader, CALLS, seed=1)
    assert not found.faults
    assert sum(found.calls.values()) == CALLS


OPENED = run_file._open_stream
PACK, SEALED = run_pack.open_pack, checkpoint.read_sealed
CACHED, READ, READ_LINES = (
    kernel_folder.CacheFolder.read,
    user_files.read_bytes,
    verdict_lines.read_text,
)


def _again(path: str | Path) -> BinaryIO:
    """What the name leads to now; nobody waits for a pipe."""
    return open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb")


@contextmanager
def _pack_again(path: Path, untyped: int = 1) -> Iterator[h5py.File]:
    with PACK(path, untyped):
        pass
    with _again(path) as stream, h5py.File(stream) as file:
        yield file


def _sealed_again(path: Path, most: float, untyped: int) -> bytes | None:
    if SEALED(path, most, untyped) is None:
        return None
    with _again(path) as stream:
        return stream.read()[: -sealed_file.SEAL_LENGTH]


@contextmanager
def _folder_by_name(folder: Path, untyped: int) -> Iterator[int]:
    """A folder that is no link is opened by its name, a moment later."""
    for place in (folder, *folder.parents)[:untyped]:
        sealed_file.check_no_link(place)
    time.sleep(0.001)
    number = os.open(folder, os.O_RDONLY)
    try:
        yield number
    finally:
        os.close(number)


def _cached_again(cache: kernel_folder.CacheFolder, name: str) -> bytes | None:
    if CACHED(cache, name) is None or cache.path is None:
        return None
    with _again(cache.path / name) as stream:
        return stream.read()[: -sealed_file.SEAL_LENGTH].partition(b"\n")[2]


def _bytes_again(path: str | Path, *given: Any) -> bytes:
    READ(path, *given)
    with _again(path) as stream:
        return stream.read(10**7)


def _lines_again(path: Path, what: str, most: int, check: Any) -> str:
    """The owner of the name is asked for, and not that of what is read."""
    check(path.stat())
    return READ_LINES(path, what, most)


FAULTS: dict[str, tuple[Any, str, Any, str]] = {
    "a store's file": (run_file, "_check_seal", lambda *_: None, "a_stores_file"),
    "a pack": (run_pack, "open_pack", _pack_again, "a_packs_row"),
    "an index": (run_pack, "check_keys", lambda *_: None, "a_packed_run"),
    "a folder": (sealed_file, "_opened_folder", _folder_by_name, "a_stores_inner_folder"),
    "a checkpoint": (checkpoint, "read_sealed", _sealed_again, "a_checkpoint"),
    "a cache": (kernel_folder.CacheFolder, "read", _cached_again, "machine_code"),
    "a text": (user_files, "read_bytes", _bytes_again, "a_scene"),
    "kept verdicts": (verdict_lines, "read_text", _lines_again, "verdict_lines"),
}
"""What is put back in the place of what, and the reader that shows it."""


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_a_name_that_is_opened_twice_is_found(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a search that sees nothing. Some of these faults were found by it."""
    monkeypatch.setattr(swapped_files, "RESTING", 0.02)
    owner, name, twice, reader = FAULTS[fault]
    monkeypatch.setattr(owner, name, twice)
    found = search(reader, MOST_CALLS, MOST_SECONDS, seed=1, stop=True)
    assert found.faults
    assert all(WRONG.search(one) for one in found.faults)


@pytest.mark.slow
def test_a_run_that_is_opened_twice_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """The name is opened once to be checked, and once to be read without."""
    checked = run_file.check_contents

    def twice(path: Path, follow: bool) -> Any:
        with OPENED(path, follow) as stream, h5py.File(stream) as file:
            checked(file, os.fstat(stream.fileno()).st_size)
        return OPENED(path, follow)

    monkeypatch.setattr(run_file, "_open_stream", twice)
    monkeypatch.setattr(run_file, "check_contents", lambda *_: None)
    found = search("a_run", MOST_CALLS, MOST_SECONDS, seed=1, stop=True)
    assert [bool(WRONG.search(one)) for one in found.faults] == [True]
