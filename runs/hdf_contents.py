"""Checks of an HDF5 file before it is read: which objects it has, and how many bytes it claims.

A file of a few bytes can claim arrays of any size, because values that were never written read as
the fill value. A text can be stored once and referenced a million times. A file can also refer to
other files, whose bytes would then be read as its own. So every object of a run's file or a pack is
checked first: only hard links within the file, only numbers and texts, only the filters that are
written here, and in total no more bytes than a file of this size can hold.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import prod
from typing import Any

import numpy as np

MAX_COMPRESSION = 1100
"""Largest number of bytes in memory that one compressed byte of a file can yield."""

BASE_BYTES = 10**6
"""Bytes in memory that a file of any size may claim."""

LENGTH_ONLY = b"This is a netCDF dimension but not a netCDF variable."
"""Text that h5netcdf puts into the name of an array that only stores the length of a dimension."""

DEFLATE, SHUFFLE, CHECKSUM = 1, 2, 3
"""HDF5's built-in filters. Each may be applied once: compressing twice multiplies the ratios."""

MIN_FLOAT_BYTES = 4
"""Bytes of NetCDF's shortest floating-point type. Pandas warns about shorter ones."""

TEXT_BYTES, LETTER_BYTES = 64, 8
"""Bytes in memory for each text, and for each of its letters while the libraries build it (5.8 were
measured)."""

MAX_REFERENCES = 32
"""Largest number of lists of references in an attribute: HDF5 arrays have at most 32 dimensions."""


def check_contents(file: Any, size: int, deepest: int = 0) -> None:
    """Check every object of an open HDF5 file; groups may be nested ``deepest`` levels deep.

    ``size`` is the size of the file in bytes. Raises ValueError for anything that no run's file or
    pack contains, and for a file that claims more bytes than its size allows. With ``deepest`` 0
    the file will be read by h5netcdf, which never reads arrays that only store the length of a
    dimension; these are not counted. The checked structure is cached until the file is closed, so
    that a concurrent write cannot change it.
    """
    _cache_structure(file)
    counter = _ByteCount(size, skips_lengths=deepest == 0)
    for member in _members(file["/"], deepest, set()):
        counter.count_attributes(member)
        counter.count_array(member)


def _cache_structure(file: Any) -> None:
    """Make HDF5 cache object headers and links while the file is open: none is read twice."""
    plan = file.id.get_mdc_config()
    plan.evictions_enabled = False  # HDF5 then requires fixed sizes:
    plan.incr_mode = plan.flash_incr_mode = plan.decr_mode = 0
    file.id.set_mdc_config(plan)


def local_member(parent: Any, name: str) -> Any:
    """Return the named member of a group in a file that `check_contents` has accepted.

    Raises ValueError if the member is stored in another file. The opened object itself is checked,
    because the file may have been modified since.
    """
    import h5py

    member = parent[name]
    parent_file, member_file = (h5py.h5o.get_info(item.id).fileno for item in (parent, member))
    is_external = isinstance(member, h5py.Dataset) and _is_external(member)
    if parent_file != member_file or is_external:
        raise ValueError(f"{name} must be stored in the file itself, got another file")
    return member


def _is_external(array: Any) -> bool:
    """Whether an array is a virtual dataset, or its bytes are stored in another file."""
    return bool(array.id.get_create_plist().get_external_count() or array.is_virtual)


def _members(item: Any, deepest: int, addresses: set[Any]) -> Iterator[Any]:
    """Yield an array or group and all members below it.

    ``addresses`` collects the objects met so far. Raises ValueError for a link that is not hard,
    an object with two names, and a group nested too deep.
    """
    import h5py

    _check_new(item, addresses)
    yield item
    for name in () if isinstance(item, h5py.Dataset) else item:
        link = item.get(name, getclass=True, getlink=True)
        if link is not h5py.HardLink:
            raise ValueError(f"{name} must be a hard link, got {link.__name__}")
        member = item[name]
        if not isinstance(member, h5py.Dataset | h5py.Group):
            raise ValueError(f"{name} must be an array or a group, got {type(member).__name__}")
        if isinstance(member, h5py.Group) and deepest == 0:
            raise ValueError(f"{name} must be an array, got a group nested too deep")
        yield from _members(member, deepest - 1, addresses)


def _check_new(item: Any, addresses: set[Any]) -> None:
    """Record an object's address; raise ValueError if another hard link led to it before."""
    from h5py import h5o

    address = h5o.get_info(item.id).addr
    if address in addresses:
        raise ValueError(f"{item.name} must have one name in the file, got two")
    addresses.add(address)


class _ByteCount:
    """Running total of the bytes that a file's arrays and attributes take in memory."""

    def __init__(self, size: int, skips_lengths: bool) -> None:
        self.size, self.total, self._skips_lengths = size, 0, skips_lengths
        self.allowed = BASE_BYTES + MAX_COMPRESSION * size

    def count(self, more: int) -> None:
        """Add bytes to the total; raise ValueError if it exceeds what the file can hold."""
        self.total += more
        if self.total > self.allowed:
            raise ValueError(
                f"contents of a file of {self.size} bytes must take at most {self.allowed:.3g} "
                f"bytes in memory, got {self.total:.3g}"
            )

    def count_attributes(self, item: Any) -> None:
        """Count the attributes of an array or group; texts count by their length."""
        from h5py import h5a, h5s, h5t

        plain = (h5t.INTEGER, h5t.FLOAT, h5t.STRING, h5t.ENUM, h5t.REFERENCE)
        for name in item.attrs:
            attribute = h5a.open(item.id, name.encode())
            if attribute.get_space().get_simple_extent_type() == h5s.NULL:
                continue
            type_, count = attribute.get_type(), prod(attribute.shape)
            type_class = type_.get_class()
            shape = getattr(item, "shape", None)
            if not _is_valid_scale_attribute(name, type_, attribute.shape, shape):
                raise ValueError(
                    f"{name} must describe the dimensions of {item.name}, got another type"
                )
            has_fixed_size = type_class in plain or (
                type_class == h5t.COMPOUND
                and not (type_.detect_class(h5t.VLEN) or type_.detect_class(h5t.STRING))
            )
            if type_class == h5t.STRING and type_.is_variable_str():
                self._check_text_count(name, count)
                self._count_letters(np.asarray(item.attrs[name], object).ravel())
            elif has_fixed_size:
                self.count(count * type_.get_size())
            elif _is_reference_list(type_) and count <= MAX_REFERENCES:
                self.count(self.size)  # references to an array's dimensions
            else:
                raise ValueError(f"attribute {name} must be of fixed size, got variable length")

    def count_array(self, item: Any) -> None:
        """Check an array's type, storage and filters, and count its bytes; ignore groups."""
        import h5py

        if not isinstance(item, h5py.Dataset):
            return
        layout, type_ = item.id.get_create_plist(), item.id.get_type()
        if _is_external(item):
            raise ValueError(f"{item.name} must be stored in the file itself, got another file")
        filters = sorted(layout.get_filter(i)[0] for i in range(layout.get_nfilters()))
        if not {*filters} <= {DEFLATE, SHUFFLE, CHECKSUM} or len({*filters}) < len(filters):
            raise ValueError(
                f"filters of {item.name} must be deflate, shuffle and checksum, got {filters}"
            )
        type_class, h5t = type_.get_class(), h5py.h5t
        if type_class not in (h5t.INTEGER, h5t.FLOAT, h5t.STRING, h5t.ENUM):
            raise ValueError(f"{item.name} must be numbers or texts, got {item.dtype}")
        if type_class == h5t.FLOAT and type_.get_size() < MIN_FLOAT_BYTES:
            raise ValueError(
                f"{item.name} must have floats of at least {MIN_FLOAT_BYTES} bytes, got "
                f"{type_.get_size()}"
            )
        if self._skips_lengths and type_class != h5t.STRING and _is_length_only(item):
            return
        count = prod(item.shape or ())
        self.count(max(count, prod(item.chunks or (0,))) * type_.get_size())
        if type_class == h5t.STRING and type_.is_variable_str():
            self._count_texts(item, count)

    def _count_texts(self, array: Any, count: int) -> None:
        """Count the bytes of an array of texts, in blocks that fit even for the longest texts."""
        if array.ndim != 1:
            self._check_text_count(array.name, count)
            self._count_letters(np.asarray(array[()], object).ravel())
            return
        step = max(1, self.allowed // self.size)
        for begin in range(0, count, step):
            self._count_letters(array[begin : begin + step])

    def _check_text_count(self, name: str, count: int) -> None:
        """Raise ValueError if ``count`` texts as long as the file exceed the allowed bytes."""
        if count * self.size > self.allowed:
            most = self.allowed // self.size
            raise ValueError(f"{name} must have at most {most} texts for its file, got {count}")

    def _count_letters(self, texts: Iterable[Any]) -> None:
        self.count(sum(TEXT_BYTES + LETTER_BYTES * len(text) for text in texts))


def _is_valid_scale_attribute(
    name: str, type_: Any, shape: tuple[int, ...], array_shape: tuple[int, ...] | None
) -> bool:
    """Whether an attribute that describes an array's dimensions has the type that HDF5 expects.
    HDF5 reads these without checking their type, into a buffer of the expected size."""
    from h5py import h5t

    if array_shape is None or name not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"):
        return True
    if name == "DIMENSION_LIST":
        return _is_reference_list(type_) and shape == (len(array_shape),)
    if name == "REFERENCE_LIST":
        if type_.get_class() != h5t.COMPOUND or len(shape) != 1 or type_.get_nmembers() != 2:
            return False
        classes = [type_.get_member_class(position) for position in range(2)]
        return classes == [h5t.REFERENCE, h5t.INTEGER] and type_.get_size() <= 16
    return type_.get_class() == h5t.STRING and not type_.is_variable_str() and shape == ()


def _is_length_only(array: Any) -> bool:
    """Whether h5netcdf treats an array as the length of a dimension, without values."""
    name = array.attrs.get("NAME")
    return array.is_scale and isinstance(name, bytes | np.bytes_) and LENGTH_ONLY in bytes(name)


def _is_reference_list(type_: Any) -> bool:
    """Whether an HDF5 type is a list of object references with variable length."""
    from h5py import h5t

    return type_.get_class() == h5t.VLEN and type_.get_super().get_class() == h5t.REFERENCE
