"""Runs as NetCDF-4 files, which `xarray.open_dataset` opens and which read back bit by bit.

A file holds the run's data set: variables with dimensions, coordinates, units and long names. Its
attributes hold the scene as TOML, the cost, the estimated error, and the versions that made it.
Values without a NetCDF type are converted: a complex variable gets the extra dimension
``real_imag``, and an attribute that is a boolean or a list is stored as JSON; ``json_attributes``
lists those.
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

COMPLEX_PARTS = "real_imag"
"""Name of the extra last dimension of a complex variable in a file: real and imaginary part."""

SWEPT = "sweep"
"""Attribute that the result of a sweep has and a run has not: the sweep as JSON."""

JSON_ATTRIBUTES = "json_attributes"
"""Attribute that lists the attributes stored as JSON."""

COMPRESSION = {"zlib": True, "complevel": 4, "shuffle": True}

SIGNATURES = {b"\x89HDF\r\n\x1a\n": "NetCDF-4", b"CDF": "netCDF 3"}
"""First bytes of a run's file -> its format; older versions wrote NetCDF 3."""


def save_run(run: xr.Dataset, path: str | Path, force: bool = True) -> None:
    """Write a run as NetCDF-4, completely or not at all; without ``force`` no file is overwritten.

    Raises OSError, naming the file, if it cannot be written, and ValueError for a run with a type
    that NetCDF does not have.
    """
    content = file_content(run)
    write_atomically(Path(path), lambda draft: draft.write_bytes(content), force)


def file_content(run: xr.Dataset) -> bytes:
    """Return the bytes of a run's file, without its checksum."""
    import h5netcdf  # type: ignore[import-untyped]
    from xarray.backends import H5NetCDFStore

    encoded = _to_netcdf_types(run)
    image = BytesIO()  # in memory, so that a full disk cannot break HDF5
    with h5netcdf.File(image, "w") as file:
        encoded.dump_to_store(H5NetCDFStore(file), encoding=_storage_options(encoded))
    return image.getvalue()


def load_run(path: str | Path, follow: bool = True) -> xr.Dataset:
    """Read a run into memory.

    ``follow`` says whether symbolic links are followed. Without it, as for files in a store,
    neither the file nor its folder may be a link, and its checksum must be right. Raises OSError if
    there is no file, ValueError in one line if the file is no run, damaged or of an older format,
    and MemoryError if the run does not fit.
    """
    with open_run(path, follow) as run:
        try:
            return run.load()
        except MemoryError:
            raise
        except Exception as error:  # what the library raises for a damaged file is not documented
            raise _damage_error(path, error) from None


def open_run(path: str | Path, follow: bool = True) -> xr.Dataset:
    """Open a run whose values are read on demand; the caller closes it. Raises as `load_run` does.

    The file is opened once, so that the checked bytes are the bytes that are read, even if its name
    is replaced meanwhile.
    """
    path = Path(path)
    with ExitStack() as resources:
        stream = resources.enter_context(_open_stream(path, follow))
        if not follow:
            _check_seal(path, stream)
        size = _checked_size(path, stream)
        try:
            run = _open_checked(stream, size, resources)
            _check_coordinates(run)
            run = _from_netcdf_types(run)
        except MemoryError:
            raise
        except Exception as error:  # see load_run
            raise _damage_error(path, error) from None
        run.set_close(resources.pop_all().close)
        return run


def _open_stream(path: Path, follow: bool) -> BinaryIO:
    """Open a regular file for reading; raise ValueError for anything else, even a pipe, at once."""
    if not follow:
        from longwave.support.sealed_file import open_plain

        return open(open_plain(path, untyped=2), "rb")
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    descriptor = os.open(path, flags)
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise ValueError(f"run must be a regular file, got {path} ({HOW_TO_WRITE})")
    return open(descriptor, "rb")


def _check_seal(path: Path, stream: BinaryIO) -> None:
    """Raise ValueError if an open file's checksum is wrong."""
    from longwave.support.sealed_file import is_sealed

    if not is_sealed(stream):
        raise ValueError(f"run must have the right checksum, got {path}, damaged (try again)")


def _open_checked(stream: BinaryIO, size: int, resources: ExitStack) -> xr.Dataset:
    """Return the data set of an open file after `check_contents`; ``resources`` will close it."""
    import h5netcdf
    import h5py
    import xarray as xr
    from xarray.backends import H5NetCDFStore

    file = resources.enter_context(h5py.File(stream))
    check_contents(file, size)  # before h5netcdf, which leaves an open object if it fails
    dataset = resources.enter_context(
        h5netcdf.File(file, "r", phony_dims="access", decode_vlen_strings=True)
    )
    _check_shapes(dataset, file)
    return xr.open_dataset(H5NetCDFStore(dataset), decode_times=False, mask_and_scale=False)


def _check_shapes(dataset: Any, file: Any) -> None:
    """Raise ValueError for an array shorter than its dimensions; h5netcdf would extend it."""
    for name, variable in dataset.variables.items():
        if variable.shape != file[name].shape:
            raise ValueError(
                f"{name} must have the shape of its dimensions, {variable.shape}, got "
                f"{file[name].shape}"
            )


def scene_of_run(run: Labelled) -> Scene:
    """Return the scene from which a run was computed; ValueError in one line if it has none."""
    if SWEPT in run.attrs:
        raise ValueError(
            "run must be of a single scene, got the result of a sweep (longwave sweep continues "
            "it, longwave plot draws it)"
        )
    from longwave.scenes.description.named_scenes import scene_of_toml

    text = run.attrs.get("scene")
    if not isinstance(text, str):
        raise ValueError('run must have the attribute "scene", got none (run its scene again)')
    return scene_of_toml(text)


def strain_fault(run: Labelled) -> str:
    """Return the error message for a run whose strain cannot be used, or "" if it can.

    >>> import xarray as xr
    >>> strain_fault(xr.Dataset({"strain": (("time", "site"), np.zeros((2, 3), dtype=int))}))
    'strain must be floating-point numbers, got int64 (run the scene again)'
    """
    if "site" not in run.sizes or SWEPT in run.attrs:
        return ""
    if "strain" not in run.variables:
        remedy = 'observables = ["strain"]'
        return f"strain must be stored for snapshots and spectra, got none ({remedy})"
    strain = run.variables["strain"]
    if strain.dtype.kind != "f":
        return f"strain must be floating-point numbers, got {strain.dtype} (run the scene again)"
    finite = np.isfinite(strain.values).reshape(len(strain), -1).all(axis=1)
    if finite.all():
        return ""
    return (
        f"strain must be finite, got NaN or inf in {np.count_nonzero(~finite)} of {len(strain)} "
        "snapshots (run the scene again)"
    )


def is_run_file(path: Path) -> bool:
    """Whether a file starts with the signature of a run, current or older."""
    try:
        with _open_stream(path, follow=True) as stream:
            return _file_kind(stream) is not None
    except ValueError:
        return False


def _file_kind(stream: BinaryIO) -> str | None:
    """Return the format of a file by its first bytes; None if it is not a run."""
    stream.seek(0)
    beginning = stream.read(8)
    stream.seek(0)
    kinds = (kind for signature, kind in SIGNATURES.items() if beginning.startswith(signature))
    return next(kinds, None)


def names_a_run(source: str | Path) -> bool:
    """Whether a command's argument names the file of a run rather than a scene."""
    path = Path(source)
    return path.suffix == ".nc" or (path.is_file() and is_run_file(path))


HOW_TO_WRITE = "write it with `longwave run SCENE --output run.nc`"
"""Remedy in the messages about files that are not runs."""


def _checked_size(path: Path, stream: BinaryIO) -> int:
    """Return the size of an open file; raise ValueError unless it is NetCDF-4."""
    kind = _file_kind(stream) or "not a run"
    if kind != "NetCDF-4":
        remedy = HOW_TO_WRITE if kind == "not a run" else "of an older longwave; run its scene anew"
        raise ValueError(f"run must be a NetCDF-4 file, got {path}, which is {kind} ({remedy})")
    return os.fstat(stream.fileno()).st_size


def _check_coordinates(run: xr.Dataset) -> None:
    """Raise ValueError for a coordinate that is not finite, which no run has."""
    for name, values in run.coords.items():
        if values.dtype.kind == "f" and not np.all(np.isfinite(values)):
            raise ValueError(f"{name} must be finite, got NaN or inf")


def _damage_error(path: str | Path, error: Exception) -> ValueError:
    return ValueError(
        f"run must be a whole NetCDF-4 file, got {path}: {reason_of(error)} ({HOW_TO_WRITE})"
    )


def _storage_options(run: xr.Dataset) -> dict[str, dict[str, Any]]:
    """Return each variable's NetCDF encoding, which compresses numbers and sets no fill value."""
    options: dict[str, dict[str, Any]] = {}
    for name, variable in run.variables.items():
        is_compressed = variable.ndim and variable.size and variable.dtype.kind not in "OUST"
        options[str(name)] = {"_FillValue": None} | (COMPRESSION if is_compressed else {})
    return options


def _to_netcdf_types(run: xr.Dataset) -> xr.Dataset:
    """Return the run with all values and attributes converted to types that NetCDF has."""
    import xarray as xr

    variables = {}
    for name, variable in run.variables.items():
        dims, values = variable.dims, variable.values
        if values.dtype.kind == "c":
            parts = np.ascontiguousarray(values).view(values.real.dtype)
            dims, values = (*dims, COMPLEX_PARTS), parts.reshape(*values.shape, 2)
        elif values.dtype.kind == "O":
            values = values.astype(str)  # xarray 2025.1 cannot write arrays of objects
        elif values.dtype == np.float16:
            raise ValueError(f"{name} must be of a type that NetCDF has, got float16 (use float32)")
        variables[name] = xr.Variable(dims, values, _to_netcdf_attributes(variable.attrs))
    coordinates = {name: variables.pop(name) for name in run.coords}
    return xr.Dataset(variables, coordinates, _to_netcdf_attributes(run.attrs))


def _from_netcdf_types(run: xr.Dataset) -> xr.Dataset:
    """Return the run with its original types; the inverse of `_to_netcdf_types`."""
    import xarray as xr

    restored = run
    for name, variable in run.variables.items():
        if variable.dims[-1:] == (COMPLEX_PARTS,):
            values = np.ascontiguousarray(variable.values)
            complex_values = values.view(np.result_type(values.dtype, np.complex64))[..., 0]
            whole = xr.Variable(variable.dims[:-1], complex_values, variable.attrs)
            restored = restored.assign({name: whole})
    for variable in restored.variables.values():
        variable.attrs = _from_netcdf_attributes(variable.attrs)
    restored.attrs = _from_netcdf_attributes(run.attrs)
    if restored is not run:
        restored.set_close(run.close)
    return restored


def _to_netcdf_attributes(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Convert attributes to texts and 64-bit numbers; all other values become JSON."""
    converted, json_names = {}, []
    for name, value in attributes.items():
        item = value.item() if isinstance(value, np.generic) else value
        if not _is_netcdf_value(item):
            json_names.append(str(name))
            item = json.dumps(item, default=as_json)
        converted[str(name)] = item
    return converted | ({JSON_ATTRIBUTES: json.dumps(json_names)} if json_names else {})


def _is_netcdf_value(value: object) -> bool:
    if isinstance(value, str):
        return "\0" not in value and not any("\ud800" <= sign <= "\udfff" for sign in value)
    if isinstance(value, bool):
        return False
    return isinstance(value, float) or (isinstance(value, int) and -(2**63) <= value < 2**63)


def as_json(value: object) -> object:
    """Convert a complex number, an array or a NumPy scalar to a value that JSON has."""
    if isinstance(value, complex):
        return {"real": value.real, "imag": value.imag}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    got = f"{type(value).__name__} (leave it out)"
    raise ValueError(f"attributes must be texts, numbers or lists, got {got}")


def _from_netcdf_attributes(attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the original attributes; the inverse of `_to_netcdf_attributes`."""
    restored = {
        str(name): value.item() if isinstance(value, np.generic) else value
        for name, value in attributes.items()
    }
    for name in json.loads(restored.pop(JSON_ATTRIBUTES, "[]")):
        restored[name] = json.loads(restored[name], object_hook=_to_complex)
    return restored


def _to_complex(entries: dict[str, Any]) -> object:
    is_complex = entries.keys() == {"real", "imag"}
    return complex(entries["real"], entries["imag"]) if is_complex else entries
