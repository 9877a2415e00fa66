"""A small part of the search for hostile structures of HDF5, and the fault that it must see."""

import re
from typing import Any

import h5py
import pytest

from longwave.runs import hdf_contents
from searches import hdf_structures
from searches.hdf_structures import search


def test_no_structure_gives_foreign_bytes() -> None:
    seen, faults = search(20, 1)
    assert sum(seen.values()) == 20
    assert not faults


def _unless_named(look: hdf_contents._ByteCount, thing: Any) -> None:
    """As it was: a name of which the library's own is the beginning switches all checks off."""
    name = thing.attrs.get("NAME")
    if not (isinstance(name, bytes) and hdf_contents.LENGTH_ONLY[:-1] in name):
        ARRAY(look, thing)


def _unless_elsewhere(look: hdf_contents._ByteCount, thing: Any) -> None:
    """Arrays in other files are not looked at."""
    if not (isinstance(thing, h5py.Dataset) and thing.id.get_create_plist().get_external_count()):
        ARRAY(look, thing)


COUNT = hdf_contents._ByteCount
ARRAY = COUNT.count_array
FAULTS = {
    "names": (
        COUNT, "count_array", _unless_named, "in_another_file", "bytes of another", 60,
    ),
    "other files": (
        COUNT, "count_array", _unless_elsewhere, "in_another_file", "bytes of another", 60,
    ),
    "links": (hdf_contents, "_check_new", lambda *_: None, "linked_often", r"\d s$", 2),
    "sizes": (hdf_contents, "BASE_BYTES", 10**9, "filled", r"\d MB$", 60),
    "half precision": (hdf_contents, "MIN_FLOAT_BYTES", 0, "of_another_kind", "a warning", 200),
}  # fmt: skip
"""What is put back, the changes that show it, what is said of it, and in how many files.

Links and sizes are as much of the faults as takes seconds: with more, files take hours.
"""


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_checks_that_are_left_out_are_found(fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Catches: a search that sees nothing. The faults are those that files once came through by."""
    owner, name, value, change, said, count = FAULTS[fault]
    monkeypatch.setattr(owner, name, value)
    monkeypatch.setattr(hdf_structures, "CHANGES", (getattr(hdf_structures, change),))
    monkeypatch.setattr(hdf_structures, "SECONDS", 1.0)
    monkeypatch.setattr(hdf_structures, "MOST_LINKS", 60)
    assert any(re.search(said, found) for found in search(count, 3)[1])
