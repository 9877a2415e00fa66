"""Runs as files: NetCDF-4 that `xarray.open_dataset` opens, and that reads back bit by bit.

A file holds what a run's data set holds: variables with dimensions, coordinates, units and long
names, and as attributes the scene as TOML, the cost, the estimated error, and what made it. What
NetCDF has no type for is written as what it has: a complex variable gets the dimension
``real_imag``, an attribute that is a truth value or a list is JSON, and ``json_attributes`` names
those.
"""

from __future__ import annotations

import json
import os
import stat
from collections.abc import Mapping
from contextlib import ExitStack
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from longwave.runs.hdf_contents import check_contents
from longwave.support.atomic_file import write_atomically
from longwave.support.user_files import reason_of

if TYPE_CHECKING:
    import xarray as xr

    from longwave.scenes.description.scene import Scene
    from longwave.support.labelled_arrays import Labelled

PARTS = "real_imag"
"""The last dimension of what is complex."""

SWEPT = "sweep"
"""The attribute of the result of a sweep that runs have not."""

TEXTS = "json_attributes"
"""The attribute that lists those that are JSON."""

COMPRESSION = {"zlib": True, "complevel": 4, "shuffle": True}

SIGNATURES = {b"\x89HDF\r\n\x1a\n": "NetCDF-4", b"CDF": "netCDF 3"}


def save_run(run: xr.Dataset, path: str | Path, force: bool = True) -> None:
    """Write a run as NetCDF-4, whole or not at all; without ``force`` no file is overwritten.

    Raises OSError that names the file if it cannot be written, and ValueError for what no file can
    hold.
    """
    content = file_content(run)
    write_atomically(Path(path), lambda draft: draft.write_bytes(content), force)


def file_content(run: xr.Dataset) -> bytes:
    """The bytes of a run's file. They are made in memory: a full disk then breaks no library."""
    import h5netcdf  # type: ignore[import-untyped]
    from xarray.backends import H5NetCDFStore

    kept = _encoded(run)
    image = BytesIO()
    with h5netcdf.File(image, "w") as file:
        kept.dump_to_store(H5NetCDFStore(file), encoding=_encoding(kept))
    return image.getvalue()


def load_run(path: str | Path, follow: bool = True) -> xr.Dataset:
    """Read a run back into memory.

    A name that nobody has typed, as in a store, is not one to ``follow``: neither it nor its folder
    may be a link, and the file must be sealed.
    Raises OSError if there is none, ValueError in one line if the file is no run, damaged or of an
    older kind, and MemoryError for what does not fit.
    """
    with open_run(path, follow) as run:
        try:
            return run.load()
        except MemoryError:
            raise
        except Exception as error:  # what the library raises for a damaged file is not documented
            raise _damaged(path, error) from None


def open_run(path: str | Path, follow: bool = True) -> xr.Dataset:
    """A run whose values are read when they are asked for; to be closed. Raises as `load_run`.

    The file is opened once: what is checked is what is read, also where its name leads to another
    file since.
    """
    path = Path(path)
    with ExitStack() as opened:
        stream = opened.enter_context(_opened(path, follow))
        if not follow:
            _check_seal(path, stream)
        size = _checked_size(path, stream)
        try:
            run = _looked_through(stream, size, opened)
            _check_coordinates(run)
            run = _decoded(run)
        except MemoryError:
            raise
        except Exception as error:  # see load_run
            raise _damaged(path, error) from None
        run.set_close(opened.pop_all().close)
        return run


def _opened(path: Path, follow: bool) -> BinaryIO:
    """Open a file to be read; ValueError for what is none, without waiting for a pipe."""
    if not follow:
        from longwave.support.sealed_file import open_plain

        return open(open_plain(path, untyped=2), "rb")
    number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    if not stat.S_ISREG(os.fstat(number).st_mode):
        os.close(number)
        raise ValueError(f"run must be a file, got {path}, which is none ({REMEDY})")
    return open(number, "rb")


def _check_seal(path: Path, stream: BinaryIO) -> None:
    """Raise ValueError for an open file that is not as it was written."""
    from longwave.support.sealed_file import is_sealed

    if not is_sealed(stream):
        raise ValueError(f"run must be as it was written, got {path}, damaged (try again)")


def _looked_through(stream: BinaryIO, size: int, opened: ExitStack) -> xr.Dataset:
    """The dataset of an open file whose contents were looked at; ``opened`` closes its parts."""
    import h5netcdf
    import h5py
    import xarray as xr
    from xarray.backends import H5NetCDFStore

    file = opened.enter_context(h5py.File(stream))
    check_contents(file, size)  # fails cleanly where h5netcdf leaves half an object
    held = opened.enter_context(
        h5netcdf.File(file, "r", phony_dims="access", decode_vlen_strings=True)
    )
    _check_shapes(held, file)
    return xr.open_dataset(H5NetCDFStore(held), decode_times=False, mask_and_scale=False)


def _check_shapes(held: Any, file: Any) -> None:
    """Refuse an array that is shorter than its dimensions: h5netcdf fills it up to any length."""
    for name, variable in held.variables.items():
        if variable.shape != file[name].shape:
            raise ValueError(
                f"{name} has the shape {file[name].shape}, its dimensions {variable.shape}"
            )


def scene_of_run(run: Labelled) -> Scene:
    """The scene that a run was asked for; ValueError in one line if it carries none."""
    if SWEPT in run.attrs:
        raise ValueError(
            "run must be one of one scene, got the result of a sweep (longwave sweep goes on with "
            "it, longwave plot draws it)"
        )
    from longwave.scenes.description.named_scenes import scene_of_toml

    text = run.attrs.get("scene")
    if not isinstance(text, str):
        raise ValueError("run must carry the scene that it was made from, got none (run it anew)")
    return scene_of_toml(text)


def strain_fault(run: Labelled) -> str:
    """What is wrong with the strain of a run's file, in words; empty if nothing is.

    >>> import xarray as xr
    >>> strain_fault(xr.Dataset({"strain": (("time", "site"), np.zeros((2, 3), dtype=int))}))
    'strain must be floating-point numbers, got int64 (no run writes that; run the scene again)'
    """
    if "site" not in run.sizes or SWEPT in run.attrs:
        return ""
    if "strain" not in run.variables:
        return 'strain must be there for snapshots and spectra, got none (observables = ["strain"])'
    strain = run.variables["strain"]
    if strain.dtype.kind != "f":
        return (
            f"strain must be floating-point numbers, got {strain.dtype} (no run writes that; run "
            "the scene again)"
        )
    finite = np.isfinite(strain.values).reshape(len(strain), -1).all(axis=1)
    if finite.all():
        return ""
    return (
        f"strain must be finite, got {np.count_nonzero(~finite)} of {len(strain)} snapshots "
        "that are not (run the scene again)"
    )


def is_run_file(path: Path) -> bool:
    """Whether a file begins as runs do, older ones as well; what is no file does not."""
    try:
        with _opened(path, follow=True) as stream:
            return _kind(stream) is not None
    except ValueError:
        return False


def _kind(stream: BinaryIO) -> str | None:
    """What a file is by its beginning; None for what is no run."""
    stream.seek(0)
    begun = stream.read(8)
    stream.seek(0)
    return next((kind for sign, kind in SIGNATURES.items() if begun.startswith(sign)), None)


def names_a_run(source: str | Path) -> bool:
    """Whether what is to be run is the file of a run, and no scene."""
    path = Path(source)
    return path.suffix == ".nc" or (path.is_file() and is_run_file(path))


REMEDY = "write it with `longwave run SCENE --output run.nc`"


def _checked_size(path: Path, stream: BinaryIO) -> int:
    """The size of an open file that begins as NetCDF-4 does."""
    kind = _kind(stream) or "no run"
    if kind != "NetCDF-4":
        remedy = REMEDY if kind == "no run" else "of an earlier longwave; run its scene again"
        raise ValueError(f"run must be a NetCDF-4 file, got {path}, which is {kind} ({remedy})")
    return os.fstat(stream.fileno()).st_size


def _check_coordinates(run: xr.Dataset) -> None:
    """Refuse times and places that are no numbers: a run has none."""
    for name, values in run.coords.items():
        if values.dtype.kind == "f" and not np.all(np.isfinite(values)):
            raise ValueError(f"{name} is not finite")


def _damaged(path: str | Path, error: Exception) -> ValueError:
    return ValueError(
        f"run must be a whole NetCDF-4 file, got {path}: {reason_of(error)} ({REMEDY})"
    )


def _encoding(run: xr.Dataset) -> dict[str, dict[str, Any]]:
    """How each variable is stored: numbers compressed, no value standing for a missing one."""
    found: dict[str, dict[str, Any]] = {}
    for name, variable in run.variables.items():
        packed = variable.ndim > 0 and variable.size > 0 and variable.dtype.kind not in "OUST"
        found[str(name)] = {"_FillValue": None} | (COMPRESSION if packed else {})
    return found


def _encoded(run: xr.Dataset) -> xr.Dataset:
    """The run in the types that NetCDF has."""
    import xarray as xr

    variables = {}
    for name, variable in run.variables.items():
        dims, values, attributes = variable.dims, variable.values, _plain(variable.attrs)
        if values.dtype.kind == "c":
            parts = np.ascontiguousarray(values).view(values.real.dtype)
            dims, values = (*dims, PARTS), parts.reshape(*values.shape, 2)
        elif values.dtype.kind == "O":
            values = values.astype(str)  # as objects, xarray 2025.1 writes none
        elif values.dtype == np.float16:
            raise ValueError(f"{name} must be of a type that NetCDF has, got float16 (use float32)")
        variables[name] = xr.Variable(dims, values, attributes)
    coordinates = {name: variables.pop(name) for name in run.coords}
    return xr.Dataset(variables, coordinates, _plain(run.attrs))


def _decoded(run: xr.Dataset) -> xr.Dataset:
    """What `_encoded` was given."""
    import xarray as xr

    found = run
    for name, variable in run.variables.items():
        if variable.dims[-1:] == (PARTS,):
            values = np.ascontiguousarray(variable.values)
            whole = values.view(np.result_type(values.dtype, np.complex64))[..., 0]
            found = found.assign({name: xr.Variable(variable.dims[:-1], whole, variable.attrs)})
    for variable in found.variables.values():
        variable.attrs = _restored(variable.attrs)
    found.attrs = _restored(run.attrs)
    if found is not run:
        found.set_close(run.close)
    return found


def _plain(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes as texts and numbers of 64 bits, what is neither as JSON."""
    found, texts = {}, []
    for name, value in attributes.items():
        item = value.item() if isinstance(value, np.generic) else value
        if not _is_plain(item):
            texts.append(str(name))
            item = json.dumps(item, default=as_json)
        found[str(name)] = item
    return found | ({TEXTS: json.dumps(texts)} if texts else {})


def _is_plain(value: object) -> bool:
    if isinstance(value, str):
        return "\0" not in value and not any("\ud800" <= sign <= "\udfff" for sign in value)
    if isinstance(value, bool):
        return False
    return isinstance(value, float) or (isinstance(value, int) and -(2**63) <= value < 2**63)


def as_json(value: object) -> object:
    """What JSON has of a complex number, an array or one of NumPy's numbers: the same value."""
    if isinstance(value, complex):
        return {"real": value.real, "imag": value.imag}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise ValueError(
        f"an attribute must be a text, a number or a list, got {type(value).__name__} (leave it)"
    )


def _restored(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """What `_plain` was given."""
    found = {
        str(name): value.item() if isinstance(value, np.generic) else value
        for name, value in attributes.items()
    }
    for name in json.loads(found.pop(TEXTS, "[]")):
        found[name] = json.loads(found[name], object_hook=_complex)
    return found


def _complex(found: dict[str, Any]) -> object:
    return complex(found["real"], found["imag"]) if found.keys() == {"real", "imag"} else found
