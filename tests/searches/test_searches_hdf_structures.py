"""A small part of the search for hostile structures of HDF5, and the fault that it must see."""

from typing import Any

import pytest

from longwave.runs import hdf_contents
from searches import hdf_structures
from searches.hdf_structures import search


def test_no_structure_gives_foreign_bytes() -> None:
    seen, faults = search(20, 1)
    assert sum(seen.values()) == 20
    assert not faults


@pytest.mark.slow
def test_checks_that_a_name_switches_off_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """As they were: for a name of which the library's own is the beginning."""
    checked = hdf_contents._Look.array

    def unless_named(look: hdf_contents._Look, thing: Any) -> None:
        name = thing.attrs.get("NAME")
        if not (isinstance(name, bytes) and hdf_contents.UNREAD[:-1] in name):
            checked(look, thing)

    monkeypatch.setattr(hdf_contents._Look, "array", unless_named)
    monkeypatch.setattr(hdf_structures, "CHANGES", (hdf_structures.in_another_file,))
    _, faults = search(60, 3)
    assert any("bytes of another file" in fault for fault in faults)
