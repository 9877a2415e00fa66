"""Catches: a file of a few bytes that takes the memory, or that names other files of its reader."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5netcdf
import h5py
import numpy as np
import pytest
import xarray as xr

from longwave.runs import hdf_contents, load_run, run_file, run_pack, save_run
from longwave.runs.hdf_contents import MOST_SHRUNK
from longwave.runs.run_pack import DONE, CellRecord, load_row, read_pack, write_pack
from longwave.runs.store_packs import PACKS, pack_index
from longwave.support.sealed_file import write_sealed

TEXT = h5py.string_dtype()


def a_fill_value(file: Any, _: Path) -> None:
    file.create_dataset("a", 10**4, TEXT, chunks=(100,), fillvalue=60_000 * "x")


def a_fill_value_in_two_directions(file: Any, _: Path) -> None:
    file.create_dataset("a", (100, 100), TEXT, chunks=(10, 10), fillvalue=60_000 * "x")


def one_text_at_many_places(file: Any, path: Path) -> None:
    """Each place is 16 bytes, which say where in the file its letters are."""
    texts = file.create_dataset("a", 4000, TEXT, fillvalue="")
    texts[0] = 60_000 * "x"
    place = texts.id.get_offset()
    file.close()
    held = path.read_bytes()
    same = 4000 * held[place : place + 16]
    path.write_bytes(held[:place] + same + held[place + len(same) :])


def one_chunk(file: Any, _: Path) -> None:
    file.create_dataset("a", (4,), "f8", chunks=(2**27,), maxshape=(None,))


def filters_upon_filters(file: Any, _: Path) -> None:
    made = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    made.set_chunk((1000,))
    made.set_deflate(9)
    made.set_deflate(9)
    h5py.h5d.create(file.id, b"a", h5py.h5t.NATIVE_DOUBLE, h5py.h5s.create_simple((1000,)), made)


def other_files(file: Any, path: Path) -> None:
    secret = path.with_name("secret")
    secret.write_bytes(bytes(range(16)))
    file.create_dataset("a", (2,), "f8", external=[(str(secret), 0, 16)])


def a_virtual_array(file: Any, path: Path) -> None:
    with h5py.File(path.with_name("other.h5"), "w") as other:
        other["b"] = [1.0, 2.0]
    layout = h5py.VirtualLayout((2,), "f8")
    layout[:] = h5py.VirtualSource(path.with_name("other.h5"), "b", (2,))
    file.create_virtual_dataset("a", layout)


def an_external_link(file: Any, path: Path) -> None:
    with h5py.File(path.with_name("other.h5"), "w") as other:
        other["b"] = [1.0, 2.0]
    file["a"] = h5py.ExternalLink("other.h5", "b")


def a_soft_link(file: Any, _: Path) -> None:
    file["b"] = [1.0]
    file["a"] = h5py.SoftLink("/b")


def records(file: Any, _: Path) -> None:
    file["a"] = np.zeros(2, [("x", "f8"), ("y", "i4")])


def objects(file: Any, _: Path) -> None:
    file["a"] = [1.0]
    file.create_dataset("b", data=np.array([file["a"].ref], object), dtype=h5py.ref_dtype)


def groups(file: Any, _: Path) -> None:
    file.create_group("b").create_group("c")


def a_long_attribute(file: Any, _: Path) -> None:
    file["a"] = [1.0]
    file["a"].attrs.create("many", 4000 * ["x"], dtype=TEXT)


UNREAD = b"This is a netCDF dimension but not a netCDF variable"
"""What the netCDF library writes into the name of an array without values, but for its dot."""


def unread(attack: Callable[[Any, Path], None], end: bytes) -> Callable[[Any, Path], None]:
    """The same attack under a name that says, almost or exactly, that the array is not read."""

    def named(file: Any, path: Path) -> None:
        attack(file, path)
        if file:
            file["a"].attrs["NAME"] = np.bytes_(UNREAD + end)

    named.__name__ = f"{attack.__name__}_unread{end.decode()}"
    return named


def many_names(file: Any, _: Path) -> None:
    """So many groups with so many arrays are all the same ones."""
    arrays = file.create_group("0/arrays") if "0" not in file else file["0/arrays"]
    first = arrays.create_dataset("a", data=[1.0])
    for number in range(1, 300):
        arrays[f"a{number}"] = first
    for number in range(1, 300):
        file[str(number)] = file["0"]


def two_names(file: Any, _: Path) -> None:
    file["a"] = [1.0]
    file["b"] = file["a"]


ATTACKS = [
    *(
        (unread(attack, end), said)
        for attack, said in (
            (other_files, "in other files"),
            (a_virtual_array, "in other files"),
            (filters_upon_filters, "filters"),
            (records, "no numbers"),
        )
        for end in (b"", b".")
    ),
    (unread(a_fill_value, b""), "are claimed to be in"),
    (unread(one_chunk, b""), "are claimed to be in"),
    (two_names, "two names"),
    (a_fill_value, "are claimed to be in"),
    (a_fill_value_in_two_directions, "texts"),
    (one_text_at_many_places, "are claimed to be in"),
    (one_chunk, "are claimed to be in"),
    (filters_upon_filters, "filters"),
    (other_files, "in other files"),
    (a_virtual_array, "in other files"),
    (an_external_link, "a link"),
    (a_soft_link, "a link"),
    (records, "no numbers"),
    (objects, "no numbers"),
    (groups, "a group"),
    (a_long_attribute, "4000 texts"),
]


@pytest.mark.parametrize(("attack", "said"), ATTACKS, ids=[each.__name__ for each, _ in ATTACKS])
def test_what_no_run_has_is_refused_before_it_is_read(
    attack: Callable[[Any, Path], None], said: str, tmp_path: Path
) -> None:
    path = tmp_path / "run.nc"
    with h5py.File(path, "w") as file:
        attack(file, path)
    assert path.stat().st_size < 350_000
    with pytest.raises(ValueError, match=rf"^run must be a whole NetCDF-4 [^\n]*{said}[^\n]*$"):
        load_run(path)


def test_many_texts_attributes_and_variables_of_ones_own_are_read(tmp_path: Path) -> None:
    """More texts than the file could hold if each were all of it, empty ones, one that is long."""
    texts = [f"text {number}" for number in range(5 * MOST_SHRUNK)]
    made = xr.Dataset(
        {"texts": ("cell", texts), "square": (("x", "y"), [["a", ""], ["c", 1000 * "d"]])}
        | {f"v{number}": ("x", [1.0, 2.0], {"units": "1", "empty": ""}) for number in range(40)},
        attrs={"long": 10**5 * "x", "none": "", "list": [1, "a"]},
    )
    save_run(made, tmp_path / "run.nc")
    found = load_run(tmp_path / "run.nc")
    assert found.attrs == made.attrs
    assert found["texts"].values.tolist() == texts
    assert found["square"].values.tolist() == made["square"].values.tolist()
    assert found["v39"].attrs == made["v39"].attrs


@pytest.mark.parametrize(
    "attack",
    [
        a_fill_value,
        other_files,
        an_external_link,
        records,
        two_names,
        unread(other_files, b"."),
        unread(a_fill_value, b"."),
    ],
)
def test_packs_are_looked_through_as_well(
    attack: Callable[[Any, Path], None], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    whole = tmp_path / PACKS / "a.h5"
    whole.parent.mkdir()
    run = xr.Dataset({"a": ("x", [1.0, 2.0])})
    write_pack(whole, [CellRecord("key", DONE, run=run)])
    assert len(pack_index(tmp_path)) == 1
    image = io.BytesIO(whole.read_bytes())
    with h5py.File(image, "r+") as file:
        attack(file["0"], tmp_path / PACKS / "b.h5")
    whole.unlink()
    write_sealed(tmp_path / PACKS / "b.h5", image.getvalue())
    assert not len(pack_index(tmp_path))
    assert "is no pack" in caplog.text
    assert "it counts as missing" in caplog.text


def test_a_pack_of_many_names_is_refused_at_once(tmp_path: Path) -> None:
    """Catches: n groups times n arrays looked through one after the other."""
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        many_names(file, tmp_path)
    path = tmp_path / "a.h5"
    write_sealed(path, image.getvalue())
    seen = []
    look = hdf_contents._Look.attributes
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            hdf_contents._Look, "attributes", lambda self, thing: seen.append(look(self, thing))
        )
        with pytest.raises(ValueError, match="two names"):
            read_pack(path)
    assert len(seen) < 10


def test_an_array_for_a_dimension_is_as_long_as_it_says(tmp_path: Path) -> None:
    """Its values are never read, and a chain of many cells has no coordinate."""
    path = tmp_path / "run.nc"
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"site": 10**9}
        file.attrs["scene"] = "none"
    assert load_run(path).attrs["scene"] == "none"


def foreign(path: Path) -> None:
    """Write a run that is not the reader's."""
    save_run(xr.Dataset({"a": ("x", [666.0, 666.0])}), path)


def test_what_was_looked_through_is_what_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a file that is opened again by its name, which is another's by then."""
    path, other = tmp_path / "run.nc", tmp_path / "other.nc"
    save_run(xr.Dataset({"a": ("x", [1.0, 2.0])}), path)
    foreign(other)

    def swapped(*given: Any, **more: Any) -> None:
        hdf_contents.check_contents(*given, **more)
        if other.exists():
            other.replace(path)

    monkeypatch.setattr(run_file, "check_contents", swapped)
    assert load_run(path)["a"].values.tolist() == [1.0, 2.0]
    assert load_run(path)["a"].values.tolist() == [666.0, 666.0]


def test_a_pack_is_the_one_that_was_looked_through(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a check that is remembered for a name, a size and a time that anybody can set."""
    runs = [xr.Dataset({"a": ("x", [value, 2.0])}) for value in (1.0, 3.0)]
    paths = [tmp_path / "a.h5", tmp_path / "b.h5"]
    for path, run in zip(paths, runs, strict=True):
        write_pack(path, [CellRecord("key", DONE, run=run)])
    assert load_row(paths[0], 0, 0)["a"].values[0] == 1.0
    told = paths[0].stat()
    content = paths[1].read_bytes()
    assert len(content) == told.st_size
    paths[1].write_bytes(content[:-90] + bytes([content[-90] ^ 1]) + content[-89:])
    os.utime(paths[1], ns=(told.st_atime_ns, told.st_mtime_ns))
    paths[1].replace(paths[0])
    with pytest.raises(ValueError, match="damaged"):
        load_row(paths[0], 0, 0)

    write_pack(paths[1], [CellRecord("key", DONE, run=runs[1])])
    paths[0].unlink()
    write_pack(paths[0], [CellRecord("key", DONE, run=runs[0])])
    opened = run_pack.open_whole

    def swapped(path: Path, *given: Any) -> Any:
        found = opened(path, *given)
        paths[1].replace(paths[0])
        return found

    with monkeypatch.context() as patch:
        patch.setattr(run_pack, "open_whole", swapped)
        assert load_row(paths[0], 0, 0)["a"].values[0] == 1.0
    assert load_row(paths[0], 0, 0)["a"].values[0] == 3.0
