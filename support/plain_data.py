"""Numbers, texts, arrays and what they are gathered in as bytes: to be read without believing them.

The bytes are a text in JSON, and the numbers of all arrays behind it. Reading calls nothing that
they name, takes no more memory than a few times their length, and gives what was written, type by
type and bit by bit. Of other types those come through that the caller names, each with its parts.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

if TYPE_CHECKING:
    import numpy as np

BARE = (type(None), bool, int, float, str)
"""What JSON has: other types are a dictionary of one entry there, their sign and what they hold."""

NUMBERS = re.compile(r"[<>|=][biufcSU][1-9]\d{0,8}")
"""NumPy's types of numbers and texts, none of which is an address."""

FAULTS = (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError)
"""What reading meets in bytes that were not made here."""

HEAD = 8
"""Bytes that say how long the text is."""


class PlainKind(NamedTuple):
    """A type that may stand in plain data: how it is taken apart, and made of those parts again."""

    type: type
    parts: Callable[[Any], object]
    made: Callable[[Any], object]


Kinds = Callable[[str], PlainKind | None]
"""The type of a name that may stand in the data, None if there is none."""


def no_kinds(_: str) -> None:
    """Of no name."""


def plain_bytes(value: object, kinds: Kinds = no_kinds) -> bytes:
    """The value as bytes. Raises TypeError for what it may not hold.

    >>> plain_value(plain_bytes({"a": (1, 2.5), 3: [None, 1j]}))
    {'a': (1, 2.5), 3: [None, 1j]}
    """
    writer = _Writer(kinds)
    text = json.dumps(writer.tree(value), separators=(",", ":")).encode()
    return b"".join([len(text).to_bytes(HEAD, "little"), text, *writer.arrays])


def plain_value(content: bytes, kinds: Kinds = no_kinds) -> Any:
    """What `plain_bytes` was given. Raises ValueError for what it has not made."""
    end = HEAD + int.from_bytes(content[:HEAD], "little")
    try:
        return _Reader(memoryview(content)[end:], kinds).value(json.loads(content[HEAD:end]))
    except FAULTS as error:
        raise ValueError(f"data must be as they were written, got others: {error}") from None


class _Writer:
    """Makes the tree that becomes JSON, and gathers the arrays."""

    def __init__(self, kinds: Kinds) -> None:
        self._kinds = kinds
        self.arrays: list[bytes] = []
        self._length = 0

    def tree(self, value: Any) -> Any:
        """The value in JSON's types."""
        import numpy as np

        kind = type(value)
        if kind in BARE:
            return value
        if kind is list:
            return [self.tree(item) for item in value]
        if kind is tuple:
            return {"tuple": [self.tree(item) for item in value]}
        if kind is dict:
            return {"dict": [[self.tree(key), self.tree(item)] for key, item in value.items()]}
        if kind is complex:
            return {"complex": [value.real, value.imag]}
        if kind is np.ndarray:
            return {"array": self._array(value)}
        if isinstance(value, np.generic):
            return {"scalar": self._array(np.asarray(value))}
        known = self._kinds(kind.__name__)
        if known is not None and known.type is kind:
            return {kind.__name__: self.tree(known.parts(value))}
        raise TypeError(f"data must be numbers, texts, arrays or lists of them, got {kind}")

    def _array(self, values: np.ndarray[Any, Any]) -> list[Any]:
        """Type, shape, order of the numbers in memory, and where they begin."""
        if not NUMBERS.fullmatch(values.dtype.str):
            raise TypeError(f"arrays must be of numbers or texts, got {values.dtype}")
        flags = values.flags
        order: Literal["F", "C"] = "F" if flags.f_contiguous and not flags.c_contiguous else "C"
        place = self._length
        self.arrays.append(values.tobytes(order))
        self._length += len(self.arrays[-1])
        return [values.dtype.str, list(values.shape), order, place]


class _Reader:
    """Makes values of a tree and the bytes of its arrays."""

    def __init__(self, held: memoryview, kinds: Kinds) -> None:
        self._held, self._kinds = held, kinds
        self._bare: dict[str, Callable[[Any], Any]] = {
            "tuple": lambda items: tuple(map(self.value, items)),
            "dict": lambda items: {self.value(key): self.value(item) for key, item in items},
            "complex": lambda parts: complex(*map(float, parts)),
            "array": self._array,
            "scalar": lambda parts: self._array(parts)[()],
        }

    def value(self, tree: Any) -> Any:
        """The value of a tree."""
        if isinstance(tree, list):
            return [self.value(item) for item in tree]
        if isinstance(tree, dict):
            ((name, parts),) = tree.items()
            if name in self._bare:
                return self._bare[name](parts)
            kind = self._kinds(name)
            if kind is None:
                raise ValueError(f"{name} has no place there")
            return kind.made(self.value(parts))
        return tree

    def _array(self, parts: list[Any]) -> Any:
        import numpy as np

        kind, shape, order, place = parts
        if not NUMBERS.fullmatch(kind) or order not in ("C", "F"):
            raise ValueError(f"an array of {kind}")
        if any(type(size) is not int or size < 0 for size in (place, *shape)):
            raise ValueError(f"an array of the shape {shape} at {place}")
        dtype, count = np.dtype(kind), math.prod(shape)
        part = self._held[place : place + count * dtype.itemsize]
        if not count:
            return np.empty(shape, dtype, order)
        return np.frombuffer(part, dtype, count).reshape(shape, order=order).copy(order)
