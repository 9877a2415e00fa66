"""Catches: a file that loses a bit, a type, a unit or the scene; a file that is no run."""

import gc
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5netcdf
import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from longwave.runs import load_run, open_run, save_run, scene_of_run
from longwave.scenes.description.named_scenes import load_scene
from longwave.scenes.description.scene import Scene
from longwave.scenes.engines import scene_run
from longwave.scenes.observed.observables import OBSERVABLES

EVERYTHING = tuple(OBSERVABLES)
RING = Scene.of(
    name="a name",
    title='"Title" \\ ä\n\x7f',
    wave="rogue_cn",
    parameters={"k": 0.1 + 0.2},
    eps=0.1,
    t0=-2,
    snapshots=[-2, 0.1, 2],
    K2=1,
    K4=1,
    step=0.5,
    domain="ring",
    sites=400,
    compared=50,
    curve_points=5,
    observables=EVERYTHING,
)
CHOSEN = RING.changed(
    step=None,
    domain=None,
    sites=None,
    scheme=None,
    tolerance=1e-2,
    engine="stencil",
    observables=["strain", "crest_track", "space_time", "spectrum"],
)
DIMER = load_scene("dimer_peregrine").changed(eps=0.15, half_width=2.0, slow_times=[-0.1, 0])


@pytest.fixture(scope="module", params=[RING, CHOSEN, DIMER], ids=["stated", "chosen", "lattice"])
def run(request: pytest.FixtureRequest) -> xr.Dataset:
    return scene_run.run(request.param)


def same_bits(one: xr.Dataset, other: xr.Dataset) -> None:
    assert list(one.variables) == list(other.variables)
    assert set(one.coords) == set(other.coords)
    for name in one.variables:
        a, b = one.variables[name], other.variables[name]
        assert (a.dims, a.dtype, repr(a.attrs)) == (b.dims, b.dtype, repr(b.attrs)), name
        assert a.values.tobytes() == b.values.tobytes(), name
    assert repr(one.attrs) == repr(other.attrs)


def test_a_run_is_read_back_to_the_bit_with_its_scene(run: xr.Dataset, tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    save_run(run, path)
    same_bits(load_run(path), run)
    with open_run(path) as lazy:
        assert scene_of_run(lazy) in (RING, CHOSEN, DIMER)
        assert scene_of_run(lazy).title == run.attrs["title"]


def test_plain_xarray_opens_it_with_units_and_names_on_everything(
    run: xr.Dataset, tmp_path: Path
) -> None:
    save_run(run, tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as found:
        assert {*found.variables} == {*run.variables}
        for name, variable in found.variables.items():
            assert variable.attrs["units"].strip(), name
            assert len(variable.attrs["long_name"]) > 2, name
            floats = variable.dtype.kind == "f"
            assert np.array_equal(variable.values, run[name].values, equal_nan=floats), name
        output = found.attrs
        for package in ("longwave ", "numba ", "llvmlite ", "h5netcdf ", "Python "):
            assert package in output["versions"]
        assert "solutions/forms " in output["code"]
        assert output["platform"]
        assert output["seconds"] > 0
        assert {"steps", "sites", "force_evaluations"} <= output.keys()


def test_the_file_has_the_choices_made_for_a_tolerance() -> None:
    found = scene_run.run(CHOSEN)
    assert scene_of_run(found) == CHOSEN
    assert "step = " in found.attrs["plan"]
    assert found.attrs["error_estimate"] <= 1e-2


def test_numbers_beyond_32_bits_are_kept(tmp_path: Path) -> None:
    """Such as the steps of a long run, and the sites that a wave has travelled."""
    many = 2**31 + 1
    created = xr.Dataset(
        {"n": ("site", np.array([many, -many]))}, attrs={"force_evaluations": many}
    )
    save_run(created, tmp_path / "run.nc")
    same_bits(load_run(tmp_path / "run.nc"), created)


NUMBERS = st.sampled_from(["f8", "f4", "c16", "c8", "i8", "i4", "i2", "u8", "u1", "?"])
VALUES = (
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.complex_numbers()
    | st.text(max_size=9)
    | st.lists(st.integers() | st.text(max_size=3) | st.floats(), max_size=3)
)
NAMES = st.text("abcdefg_", min_size=1, max_size=5).filter(lambda name: name.strip("_"))


@settings(max_examples=25, deadline=None)
@given(data=st.data())
def test_any_data_are_read_back_to_the_bit(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    shape = data.draw(hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3))
    attributes = st.dictionaries(NAMES, VALUES, max_size=3)
    dims = tuple(f"x{axis}" for axis in range(len(shape)))
    variables = {
        f"v_{kind.strip('?')}": (
            dims,
            data.draw(hnp.arrays(kind, shape)),
            data.draw(attributes),
        )
        for kind in data.draw(st.lists(NUMBERS, unique=True, max_size=3))
    }
    created = xr.Dataset(variables, attrs=data.draw(attributes))
    path = tmp_path_factory.getbasetemp() / "any.nc"
    save_run(created, path)
    same_bits(load_run(path), created)


@pytest.mark.parametrize(
    ("created", "message"),
    [
        (xr.Dataset(attrs={"what": object()}), "attributes must be texts, numbers or lists"),
        (xr.Dataset({"a": ("x", np.zeros(2, "f2"))}), "a must be of a type that NetCDF has"),
    ],
)
def test_data_without_a_netcdf_type_is_a_one_line_error(
    created: xr.Dataset, message: str, tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match=rf"^{message}[^\n]*$"):
        save_run(created, tmp_path / "run.nc")
    assert list(tmp_path.iterdir()) == []


FULL = """
import resource, signal, sys
import numpy as np, xarray as xr
from longwave.runs import save_run
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
run = xr.Dataset({"x": ("site", np.random.default_rng(0).random(10**5))})
resource.setrlimit(resource.RLIMIT_FSIZE, (10**5, 10**5))
try:
    save_run(run, sys.argv[1])
except OSError as error:
    print(error.filename, error.strerror)
"""


@pytest.mark.slow
def test_a_full_disk_names_the_file_and_leaves_the_older_one(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    path.write_bytes(b"older")
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(path)], capture_output=True, text=True, check=True
    )
    assert (done.stdout, done.stderr) == (f"{path} File too large\n", "")
    assert path.read_bytes() == b"older"
    assert [each.name for each in tmp_path.iterdir()] == ["run.nc"]


def test_nothing_is_overwritten_without_force(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    path.write_bytes(b"older")
    with pytest.raises(FileExistsError):
        save_run(xr.Dataset(), path, force=False)
    assert path.read_bytes() == b"older"


def foreign(path: Path) -> None:
    """Write a NetCDF-4 file of another program, with a shape that is only claimed."""
    with h5netcdf.File(path, "w") as file:
        file.dimensions = {"x": 10**6, "y": 10**6}
        file.create_variable("a", ("x", "y"), "f8", chunks=(1000, 1000))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda path: xr.Dataset().to_netcdf(path, engine="scipy"),
            "which is netCDF 3 [(]of",
        ),
        (lambda path: path.write_bytes(b""), "which is not a run"),
        (lambda path: path.write_text("wave = 3"), "which is not a run"),
        (lambda path: path.mkdir(), "regular file"),
        (
            lambda path: path.write_bytes(b"\x89HDF\r\n\x1a\n" + b"x" * 99),
            "whole NetCDF-4",
        ),
        (foreign, "bytes in memory, got"),
        (
            lambda path: xr.Dataset(attrs={"json_attributes": "[1]"}).to_netcdf(
                path, engine="h5netcdf"
            ),
            "whole NetCDF-4",
        ),
        (
            lambda path: xr.Dataset(coords={"time": [0.0, np.inf]}).to_netcdf(
                path, engine="h5netcdf"
            ),
            "whole NetCDF-4 file, got [^\n]*: time must be finite",
        ),
    ],
    ids=["netCDF 3", "empty", "text", "folder", "broken", "huge", "attributes", "times"],
)
def test_a_file_that_is_no_run_is_a_one_line_error(
    make: Callable[[Path], Any], message: str, tmp_path: Path
) -> None:
    make(tmp_path / "run.nc")
    with pytest.raises(ValueError, match=rf"^run must be [^\n]*{message}[^\n]*$"):
        load_run(tmp_path / "run.nc")


def test_a_run_without_a_scene_is_a_one_line_error() -> None:
    with pytest.raises(ValueError, match=r"^run must have the attribute"):
        scene_of_run(xr.Dataset())
    with pytest.raises(ValueError, match=r"^run must be of a single scene, got the result of a sw"):
        scene_of_run(xr.Dataset(attrs={"sweep": "{}"}))
    with pytest.raises(ValueError, match=r"^scene must be a TOML file"):
        scene_of_run(xr.Dataset(attrs={"scene": "{}"}))
    assert scene_of_run(xr.Dataset(attrs={"scene": RING.toml()})) == RING
    assert load_scene("rogue_cn_k_0.5").name in load_scene("rogue_cn_k_0.5").toml()


def test_a_damaged_root_group_leaves_no_open_object(tmp_path: Path) -> None:
    path = tmp_path / "run.nc"
    save_run(xr.Dataset({"a": 1.0}), path)
    content = bytearray(path.read_bytes())
    content[content.index(b"OHDR") + 8] ^= 0xFF
    path.write_bytes(content)
    with pytest.raises(ValueError, match="must be a whole NetCDF-4 file"):
        open_run(path)
    gc.collect()  # what is left behind tells of itself as a warning


@pytest.mark.slow
def test_file_content_keeps_no_view_of_the_image() -> None:
    """With one, Python 3.13 prints a warning when the garbage collector closes the image."""
    script = (
        "import gc, xarray as xr\n"
        "from longwave.runs.run_file import file_content\n"
        "class Held: pass\n"
        "held = Held()\n"
        "held.itself = held\n"
        "held.content = file_content(xr.Dataset({'a': ('x', [1.0, 2.0])}))\n"
        "del held\n"
        "gc.collect()\n"
    )
    words = [sys.executable, "-X", "dev", "-W", "ignore", "-c", script]
    done = subprocess.run(words, capture_output=True, text=True, timeout=600)
    assert (done.returncode, done.stderr) == (0, "")
