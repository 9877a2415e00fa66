"""Files in HDF5 are looked through before anything in them is read: what they may hold and claim.

A file of some bytes may claim arrays of any size, for what was never written reads as its fill
value; a text may stand at a million places and be kept once. It may name other files, whose bytes
then come as its own. So every object of a run's file or a pack is looked at first: links of the
file into itself alone, numbers and texts, in chunks as they are written here, and in all no more
bytes than a file of its size can hold.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import prod
from typing import Any

import numpy as np

MOST_SHRUNK = 1100
"""Bytes that one byte of a file can hold at most, compressed."""

SMALL = 10**6
"""Bytes that any file may hold."""

UNREAD = b"This is a netCDF dimension but not a netCDF variable."
"""In the name of an array that is there for its length, as h5netcdf asks for it."""

DEFLATE, SHUFFLE, CHECKSUM = 1, 2, 3
"""Filters of the library's own; each once, as two that shrink would shrink by their product."""

SINGLE = 4
"""Bytes of the shortest floating-point number that NetCDF has; pandas warns of shorter ones."""

OBJECT, COPIES = 64, 8
"""Bytes that a text in memory takes beside its letters, and those that a letter takes while the
libraries make texts (5.8 were measured); in a file that was written here each letter is there."""


def check_contents(file: Any, size: int, deepest: int = 0) -> None:
    """Look through an open file of ``size`` bytes with groups nested ``deepest`` deep.

    Raises ValueError for what no run's file or pack has, and one that would take more bytes than
    such a file can hold. Without groups it is read by h5netcdf, which leaves arrays alone that are
    there for their length. What was looked at stays in memory while the file is open, and is not
    read again: somebody may write into the file meanwhile.
    """
    _keep_structure(file)
    look = _Look(size, leaves_lengths=deepest == 0)
    for thing in _things(file["/"], deepest, set()):
        look.attributes(thing)
        look.array(thing)


def _keep_structure(file: Any) -> None:
    """Have the library keep what it reads of objects and links, and read none of it again."""
    plan = file.id.get_mdc_config()
    plan.evictions_enabled = False
    plan.incr_mode = plan.flash_incr_mode = plan.decr_mode = 0  # as it must be then
    file.id.set_mdc_config(plan)


def own(parent: Any, name: str) -> Any:
    """What has that name in an open file that was looked through when it was opened before.

    Raises ValueError if it stands in another file: that is asked of the open object, which is what
    is read, as the file may have been written into since.
    """
    import h5py

    thing = parent[name]
    files = [h5py.h5o.get_info(one.id).fileno for one in (parent, thing)]
    if files[0] != files[1] or (isinstance(thing, h5py.Dataset) and _is_elsewhere(thing)):
        raise ValueError(f"{name} is in other files")
    return thing


def _is_elsewhere(array: Any) -> bool:
    """Whether an array is made of others, or its bytes stand in another file."""
    return bool(array.id.get_create_plist().get_external_count() or array.is_virtual)


def _things(group: Any, deepest: int, seen: set[Any]) -> Iterator[Any]:
    """The group and all that is in it, by links that lead into the file itself, each once.

    ``seen`` are the addresses of the objects met before.
    """
    import h5py

    _check_new(group, seen)
    yield group
    for name in group:
        link = group.get(name, getclass=True, getlink=True)
        if link is not h5py.HardLink:
            raise ValueError(f"{name} is a link ({link.__name__})")
        thing = group[name]
        if isinstance(thing, h5py.Group):
            if deepest == 0:
                raise ValueError(f"{name} is a group in which nothing may be")
            yield from _things(thing, deepest - 1, seen)
        elif isinstance(thing, h5py.Dataset):
            _check_new(thing, seen)
            yield thing
        else:
            raise ValueError(f"{name} is no array")


def _check_new(thing: Any, seen: set[Any]) -> None:
    """Note an object's address; ValueError for one that was seen, by another hard link."""
    from h5py import h5o

    address = h5o.get_info(thing.id).addr
    if address in seen:
        raise ValueError(f"{thing.name} has another name")
    seen.add(address)


class _Look:
    """Counts the bytes that a file's arrays and attributes take in memory."""

    def __init__(self, size: int, leaves_lengths: bool) -> None:
        self.size, self.total, self._leaves_lengths = size, 0, leaves_lengths
        self.most = SMALL + MOST_SHRUNK * size

    def count(self, more: int) -> None:
        """Count them; ValueError if there are more than the file can hold."""
        self.total += more
        if self.total > self.most:
            raise ValueError(f"{self.total:.3g} bytes are claimed to be in {self.size}")

    def attributes(self, thing: Any) -> None:
        """Those of an array or group, texts as long as they are."""
        from h5py import h5a, h5s, h5t

        plain = (h5t.INTEGER, h5t.FLOAT, h5t.STRING, h5t.ENUM, h5t.REFERENCE)
        for name in thing.attrs:
            held = h5a.open(thing.id, name.encode())
            if held.get_space().get_simple_extent_type() == h5s.NULL:
                continue
            kind, places = held.get_type(), prod(held.shape)
            of = kind.get_class()
            if not _is_of_scales(name, kind, held.shape, getattr(thing, "shape", None)):
                raise ValueError(f"{name} of {thing.name} is not what says which dimensions it has")
            if of == h5t.STRING and kind.is_variable_str():
                self._may_read(name, places)
                self._letters(np.asarray(thing.attrs[name], object).ravel())
            elif of in plain or (of == h5t.COMPOUND and not _has_lists(kind)):
                self.count(places * kind.get_size())
            elif of == h5t.VLEN and kind.get_super().get_class() == h5t.REFERENCE and places <= 32:
                self.count(self.size)  # which dimensions an array has
            else:
                raise ValueError(f"{name} is of lists")

    def array(self, thing: Any) -> None:
        """An array; a group has none."""
        import h5py

        if not isinstance(thing, h5py.Dataset):
            return
        layout, kind = thing.id.get_create_plist(), thing.id.get_type()
        if _is_elsewhere(thing):
            raise ValueError(f"{thing.name} is in other files")
        filters = sorted(layout.get_filter(place)[0] for place in range(layout.get_nfilters()))
        if not {*filters} <= {DEFLATE, SHUFFLE, CHECKSUM} or len({*filters}) < len(filters):
            raise ValueError(f"{thing.name} is packed by filters {filters}")
        of, h5t = kind.get_class(), h5py.h5t
        if of not in (h5t.INTEGER, h5t.FLOAT, h5t.STRING, h5t.ENUM):
            raise ValueError(f"{thing.name} is of no numbers and no texts")
        if of == h5t.FLOAT and kind.get_size() < SINGLE:
            raise ValueError(f"{thing.name} is of numbers of {kind.get_size()} bytes")
        if self._leaves_lengths and of != h5t.STRING and _is_unread(thing):
            return
        places = prod(thing.shape or ())
        self.count(max(places, prod(thing.chunks or (0,))) * kind.get_size())
        if of == h5t.STRING and kind.is_variable_str():
            self._texts(thing, places)

    def _texts(self, thing: Any, places: int) -> None:
        """Texts, read so many at a time as the file could hold if each were all of it."""
        if thing.ndim != 1:
            self._may_read(thing.name, places)
            self._letters(np.asarray(thing[()], object).ravel())
            return
        step = max(1, self.most // self.size)
        for begin in range(0, places, step):
            self._letters(thing[begin : begin + step])

    def _may_read(self, name: str, places: int) -> None:
        """ValueError for more texts than the file could hold if each were all of it."""
        if places * self.size > self.most:
            raise ValueError(f"{name} has {places} texts")

    def _letters(self, texts: Iterable[Any]) -> None:
        self.count(sum(OBJECT + COPIES * len(text) for text in texts))


def _is_of_scales(
    name: str, kind: Any, shape: tuple[int, ...], extent: tuple[int, ...] | None
) -> bool:
    """Whether an attribute that the library takes for an array's dimensions is what it expects.

    It reads these without a look at their kind, into as much memory as they should take.
    """
    from h5py import h5t

    if extent is None or name not in ("DIMENSION_LIST", "REFERENCE_LIST", "CLASS", "NAME"):
        return True
    if name == "DIMENSION_LIST":
        is_list = kind.get_class() == h5t.VLEN and kind.get_super().get_class() == h5t.REFERENCE
        return is_list and shape == (len(extent),)
    if name == "REFERENCE_LIST":
        if kind.get_class() != h5t.COMPOUND or len(shape) != 1 or kind.get_nmembers() != 2:
            return False
        parts = [kind.get_member_class(place) for place in range(2)]
        return parts == [h5t.REFERENCE, h5t.INTEGER] and kind.get_size() <= 16
    return kind.get_class() == h5t.STRING and not kind.is_variable_str() and shape == ()


def _is_unread(thing: Any) -> bool:
    """Whether h5netcdf takes an array for the length of a dimension, and nothing more."""
    name = thing.attrs.get("NAME")
    return thing.is_scale and isinstance(name, bytes | np.bytes_) and UNREAD in bytes(name)


def _has_lists(kind: Any) -> bool:
    """Whether parts of a record have no size of their own."""
    from h5py import h5t

    return kind.detect_class(h5t.VLEN) or kind.detect_class(h5t.STRING)
