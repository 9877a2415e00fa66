"""Catches: a file of a few bytes that fills the memory, or makes its reader open other files."""

from __future__ import annotations

import io
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import xarray as xr

from longwave.runs import load_run, run_file, run_pack, save_run
from longwave.runs.hdf_contents import MAX_COMPRESSION
from longwave.runs.run_pack import DONE, CellRecord, load_row, pack_content, write_pack
from longwave.runs.store_packs import PACKS, pack_index
from longwave.support.sealed_file import write_sealed

TEXT = h5py.string_dtype()


def a_fill_value(file: Any, _: Path) -> None:
    file.create_dataset("a", 10**4, TEXT, chunks=(100,), fillvalue=60_000 * "x")


def a_fill_value_in_two_directions(file: Any, _: Path) -> None:
    file.create_dataset("a", (100, 100), TEXT, chunks=(10, 10), fillvalue=60_000 * "x")


def one_text_at_many_places(file: Any, path: Path) -> None:
    """Each reference has 16 bytes with the position of its letters in the file."""
    texts = file.create_dataset("a", 4000, TEXT, fillvalue="")
    texts[0] = 60_000 * "x"
    place = texts.id.get_offset()
    file.close()
    stored_values = path.read_bytes()
    same = 4000 * stored_values[place : place + 16]
    path.write_bytes(stored_values[:place] + same + stored_values[place + len(same) :])


def one_chunk(file: Any, _: Path) -> None:
    file.create_dataset("a", (4,), "f8", chunks=(2**27,), maxshape=(None,))


def filters_upon_filters(file: Any, _: Path) -> None:
    result = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    result.set_chunk((1000,))
    result.set_deflate(9)
    result.set_deflate(9)
    h5py.h5d.create(file.id, b"a", h5py.h5t.NATIVE_DOUBLE, h5py.h5s.create_simple((1000,)), result)


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


NAMES = (
    b"This is a netCDF dimension but not a netCDF variable",
    b"This is a netCDF dimension but not a netCDF variable.         1",
)
"""What h5netcdf takes for an ordinary array, and for the length of a dimension."""


def other_files_under_a_name(file: Any, path: Path) -> None:
    """The name of a length must not disable the check: data in other files are never read."""
    other_files(file, path)
    file["a"].attrs["NAME"] = np.bytes_(NAMES[0])


def other_files_as_a_length(file: Any, path: Path) -> None:
    other_files(file, path)
    file["a"].make_scale(NAMES[1])


def a_fill_value_under_a_name(file: Any, _: Path) -> None:
    file.create_dataset("a", 10**9, "f8", chunks=(10**5,), fillvalue=1.0)
    file["a"].attrs["NAME"] = np.bytes_(NAMES[1])


def texts_as_a_length(file: Any, _: Path) -> None:
    file.create_dataset("a", 10**4, TEXT, chunks=(100,), fillvalue=60_000 * "x")
    file["a"].make_scale(NAMES[1])


def two_names(file: Any, _: Path) -> None:
    file["a"] = [1.0]
    file["b"] = file["a"]


def texts_as_dimensions(file: Any, _: Path) -> None:
    """HDF5 would read it into the memory of one reference and crash the process."""
    file["a"] = [1.0]
    file["a"].attrs.create("DIMENSION_LIST", 1000 * ["x"], dtype=TEXT)


def dimensions_of_another_array(file: Any, _: Path) -> None:
    file["x"] = [1.0]
    file["x"].make_scale("x")
    file["a"] = np.zeros((1, 1, 1))
    for place in range(3):
        file["a"].dims[place].attach_scale(file["x"])
    saved = file["a"].attrs["DIMENSION_LIST"]
    file["b"] = [1.0]
    file["b"].attrs.create("DIMENSION_LIST", saved, dtype=h5py.vlen_dtype(h5py.ref_dtype))


def numbers_as_references(file: Any, _: Path) -> None:
    file["a"] = [1.0]
    file["a"].make_scale("a")
    file["a"].attrs["REFERENCE_LIST"] = np.zeros(1000)


def a_long_class(file: Any, _: Path) -> None:
    file["a"] = [1.0]
    file["a"].attrs["CLASS"] = np.array([b"DIMENSION_SCALE"] * 9)


def half_precision(file: Any, _: Path) -> None:
    file["a"] = np.zeros(2, "f2")


def _padded(file: Any, change: Callable[[Any], None]) -> None:
    """Write an array of three numbers with dimension x, and a dimension of length 10^9."""
    file.create_dataset("long", 10**9, "i1", chunks=(10**5,))
    file["long"].make_scale(NAMES[1])
    file["x"] = [1.0, 2.0, 3.0]
    file["x"].make_scale("x")
    change(file)


def one_number_of_two_dimensions(file: Any, _: Path) -> None:
    """Coordinates name their dimensions by numbers; the last one in the file counts."""

    def change(file: Any) -> None:
        for name in ("long", "x"):
            file[name].attrs["_Netcdf4Dimid"] = np.int32(0)
        file["x"].attrs["_Netcdf4Coordinates"] = np.array([0], np.int32)
        file.move("long", "zlong")

    _padded(file, change)


def a_dimension_that_is_longer(file: Any, _: Path) -> None:
    def change(file: Any) -> None:
        file["a"] = [1.0, 2.0, 3.0]
        file["a"].dims[0].attach_scale(file["long"])

    _padded(file, change)


ATTACKS = [
    (a_fill_value, "bytes in memory"),
    (a_fill_value_in_two_directions, "texts"),
    (one_text_at_many_places, "bytes in memory"),
    (one_chunk, "bytes in memory"),
    (filters_upon_filters, "filters"),
    (other_files, "got another file"),
    (a_virtual_array, "got another file"),
    (an_external_link, "must be a hard link"),
    (a_soft_link, "must be a hard link"),
    (records, "must be numbers or texts"),
    (objects, "must be numbers or texts"),
    (groups, "got a group"),
    (a_long_attribute, "got 4000"),
    (other_files_under_a_name, "got another file"),
    (other_files_as_a_length, "got another file"),
    (a_fill_value_under_a_name, "bytes in memory"),
    (texts_as_a_length, "bytes in memory"),
    (two_names, "must have one name"),
    (texts_as_dimensions, "DIMENSION_LIST must describe the dimensions of /a"),
    (dimensions_of_another_array, "DIMENSION_LIST must describe the dimensions of /b"),
    (numbers_as_references, "REFERENCE_LIST must describe the dimensions of /a"),
    (a_long_class, "CLASS must describe the dimensions of /a"),
    (half_precision, "4 bytes, got 2"),
    (one_number_of_two_dimensions, "its dimensions"),
    (a_dimension_that_is_longer, "its dimensions"),
]


@pytest.mark.parametrize(("attack", "message"), ATTACKS, ids=[each.__name__ for each, _ in ATTACKS])
def test_contents_that_no_run_has_are_refused_before_reading(
    attack: Callable[[Any, Path], None], message: str, tmp_path: Path
) -> None:
    path = tmp_path / "run.nc"
    with h5py.File(path, "w") as file:
        attack(file, path)
    assert path.stat().st_size < 350_000
    with pytest.raises(ValueError, match=rf"^run must be a whole NetCDF-4 [^\n]*{message}[^\n]*$"):
        load_run(path)


def test_many_texts_attributes_and_variables_are_accepted(tmp_path: Path) -> None:
    """More texts than fit if each were as long as the file, some empty and one long."""
    texts = [f"text {number}" for number in range(5 * MAX_COMPRESSION)]
    result = xr.Dataset(
        {"texts": ("cell", texts), "square": (("x", "y"), [["a", ""], ["c", 1000 * "d"]])}
        | {f"v{number}": ("x", [1.0, 2.0], {"units": "1", "empty": ""}) for number in range(40)},
        attrs={"long": 10**5 * "x", "none": "", "list": [1, "a"]},
    )
    save_run(result, tmp_path / "run.nc")
    found = load_run(tmp_path / "run.nc")
    assert found.attrs == result.attrs
    assert found["texts"].values.tolist() == texts
    assert found["square"].values.tolist() == result["square"].values.tolist()
    assert found["v39"].attrs == result["v39"].attrs


@pytest.mark.parametrize("attack", [a_fill_value, other_files, an_external_link, records])
def test_packs_are_checked_as_well(
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
    assert "must be a pack" in caplog.text
    assert "its runs count as missing" in caplog.text


def test_the_length_of_a_dimension_may_be_large(tmp_path: Path) -> None:
    """An array that only stores a length is never read, so it does not count."""
    path = tmp_path / "run.nc"
    with h5py.File(path, "w") as file:
        file.create_dataset("x", 10**9, ">f4", chunks=(10**5,))
        file["x"].make_scale(NAMES[1])
        file["a"] = 1.0
    assert float(load_run(path)["a"]) == 1.0


@pytest.mark.parametrize("name", NAMES)
def test_a_pack_with_an_external_array_is_refused(name: bytes, tmp_path: Path) -> None:
    """A pack is read without h5netcdf, so no array is exempt as a length."""
    path = tmp_path / "p.pack"
    write_pack(path, [CellRecord("k", DONE, run=xr.Dataset({"a": ("x", [1.0, 2.0])}))])
    secret = tmp_path / "secret"
    secret.write_bytes(np.array([[3.0, 4.0]]).tobytes())
    image = io.BytesIO(path.read_bytes())
    with h5py.File(image, "r+") as file:
        [group] = file.values()
        attributes = dict(group["arrays/a"].attrs)
        del group["arrays/a"]
        result = group["arrays"].create_dataset("a", (1, 2), "f8", external=[(str(secret), 0, 16)])
        result.attrs.update(attributes)
        result.attrs["NAME"] = np.bytes_(name)
    write_sealed(path, image.getvalue())
    with pytest.raises(ValueError, match="got another file"):
        load_row(path, 0, 0)


def test_groups_of_a_pack_with_shared_arrays_are_refused_at_once(tmp_path: Path) -> None:
    """Checked one by one, 300 groups with 300 arrays took 15 s."""
    image = io.BytesIO()
    with h5py.File(image, "w") as file:
        first = file.create_group("0").create_group("arrays")
        for number in range(300):
            first[f"a{number}"] = [1.0]
        for number in range(1, 300):
            file.create_group(f"{number}")["arrays"] = first
    path = tmp_path / "p.pack"
    write_sealed(path, image.getvalue())
    with pytest.raises(ValueError, match="must have one name"):
        load_row(path, 0, 0)


def _a_run(value: float) -> xr.Dataset:
    return xr.Dataset({"a": ("x", [value, value])})


@pytest.mark.parametrize("kind", ["run", "pack"])
def test_the_checked_file_is_read_even_if_its_name_is_replaced(
    kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a file that is opened by name twice, once to check it and once to read it."""
    path, other = tmp_path / "mine", tmp_path / "other"
    for place, value in ((path, 1.0), (other, 2.0)):
        if kind == "run":
            save_run(_a_run(value), place)
        else:
            write_pack(place, [CellRecord("k", DONE, run=_a_run(value))])
    module = run_file if kind == "run" else run_pack
    checked = module.check_contents

    def swap(*given: Any, **named: Any) -> None:
        checked(*given, **named)
        other.replace(path)

    monkeypatch.setattr(module, "check_contents", swap)
    found = load_run(path) if kind == "run" else load_row(path, 0, 0)
    assert found["a"].values.tolist() == [1.0, 1.0]
    assert not other.exists()


def test_a_checked_pack_that_is_replaced_is_checked_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Even if its size and modification time, which its writer can choose, are the same."""
    path, other = tmp_path / "mine", tmp_path / "other"
    for place, value in ((path, 1.0), (other, 2.0)):
        write_pack(place, [CellRecord("k", DONE, run=_a_run(value))])
    monkeypatch.setattr(run_pack, "RECENT_CHANGE_NS", -1)
    load_row(path, 0, 0)
    state = path.stat()
    spoilt = bytearray(other.read_bytes())
    assert len(spoilt) == state.st_size
    spoilt[-90] ^= 1
    path.write_bytes(spoilt)
    os.utime(path, ns=(state.st_atime_ns, state.st_mtime_ns))
    with pytest.raises(run_pack.DamagedPackError):
        load_row(path, 0, 0)


def test_a_recently_changed_pack_is_checked_again(tmp_path: Path) -> None:
    """Within a clock tick it may change again without a change of its times."""
    path = tmp_path / "mine"
    write_pack(path, [CellRecord("k", DONE, run=_a_run(1.0))])
    before = len(run_pack._remembered)
    load_row(path, 0, 0)
    assert len(run_pack._remembered) == before


def test_a_link_in_a_store_is_not_followed_to_another_folder(tmp_path: Path) -> None:
    """Catches: a store's file that was replaced by a link after it was checked."""
    save_run(_a_run(1.0), tmp_path / "mine.nc")
    (tmp_path / "key.nc").symlink_to(tmp_path / "mine.nc")
    assert load_run(tmp_path / "key.nc")["a"].values.tolist() == [1.0, 1.0]
    with pytest.raises(OSError, match=r"key\.nc"):
        load_run(tmp_path / "key.nc", follow=False)


def _two_faces(image: bytes, group: str, name: str, secret: Path) -> tuple[bytes, bytes]:
    """Return a file, and a copy that differs in 8 bytes: its array is one in another file.

    Both versions have that second array; the group's last name, which led to it, is removed.
    """
    stream = io.BytesIO(image)
    with h5py.File(stream, "r+") as file:
        array = file[group][name]
        places = [(str(secret), 0, array.size * 8)]
        twin = file[group].create_dataset("zzz", array.shape, "f8", external=places)
        twin.attrs.update(array.attrs)
        here, there = (h5py.h5o.get_info(one.id).addr for one in (array, twin))
    stored_values = bytearray(stream.getvalue())
    node = stored_values.rindex(
        b"SNOD", 0, stored_values.index(there.to_bytes(8, "little"), stored_values.index(b"SNOD"))
    )
    stored_values[node + 6] -= 1
    good = bytes(stored_values)
    place = stored_values.index(here.to_bytes(8, "little"), node)
    stored_values[place : place + 8] = there.to_bytes(8, "little")
    return good, bytes(stored_values)


def _write_into(path: Path, content: bytes) -> None:
    with path.open("r+b") as stream:
        stream.write(content)


@pytest.mark.slow
def test_a_run_modified_after_its_check_yields_no_foreign_byte(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: links that HDF5 drops from its cache, after 36 MB of attributes, and reads again."""
    path, secret, image = tmp_path / "run", tmp_path / "secret", io.BytesIO()
    secret.write_bytes(np.full(6, 666.0).tobytes())
    with h5py.File(image, "w") as file:
        file["first"] = np.ones(6)
        for number in range(600):
            name = f"heavy{number % 6}"
            heavy = file.require_dataset(name, (6,), "f8")
            heavy.attrs[f"a{number}"] = np.bytes_(60_000 * b"x")
    good, bad = _two_faces(image.getvalue(), "/", "first", secret)
    checked = run_file.check_contents

    def written_into(*given: Any) -> None:
        checked(*given)
        _write_into(path, bad)

    path.write_bytes(bad)
    with pytest.raises(ValueError, match="got another file"):
        load_run(path)
    path.write_bytes(good)
    monkeypatch.setattr(run_file, "check_contents", written_into)
    assert load_run(path)["first"].values.tolist() == 6 * [1.0]


def test_a_pack_modified_after_its_check_yields_no_foreign_byte(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Catches: a pack that was checked before and is modified while it is open."""
    path, secret = tmp_path / "pack", tmp_path / "secret"
    secret.write_bytes(np.full(2, 666.0).tobytes())
    image = pack_content([CellRecord("k", DONE, run=_a_run(1.0))])
    good, bad = _two_faces(image, "0/arrays", "a", secret)
    write_sealed(path, good)
    monkeypatch.setattr(run_pack, "RECENT_CHANGE_NS", -1)
    assert load_row(path, 0, 0)["a"].values.tolist() == [1.0, 1.0]
    opened = h5py.File

    def written_into(*given: Any, **named: Any) -> Any:
        _write_into(path, bad)
        return opened(*given, **named)

    monkeypatch.setattr(h5py, "File", written_into)
    with pytest.raises(ValueError, match="a must be stored in the file itself"):
        load_row(path, 0, 0)
