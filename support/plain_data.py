"""Safe serialisation of numbers, texts, arrays and their containers as bytes.

The bytes are a JSON text followed by the data of all arrays. Reading calls nothing that the bytes
name, takes no more memory than a few times their length, and returns what was written, type by type
and bit by bit. Other types are allowed if the caller names them, each by its parts.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

if TYPE_CHECKING:
    import numpy as np

JSON_TYPES = (type(None), bool, int, float, str)
"""Scalar types of JSON. Values of types other than these and lists become a dictionary {tag:
content}."""

NUMBER_DTYPE = re.compile(r"[<>|=][biufcSU][1-9]\d{0,8}")
"""Pattern of NumPy's dtypes for numbers and texts; it excludes the dtype of objects, which holds
addresses."""

READING_ERRORS = (ValueError, TypeError, LookupError, AttributeError, OverflowError, RecursionError)
"""Errors that may occur when bytes written elsewhere are read."""

HEAD = 8
"""Number of bytes that hold the length of the JSON text."""


class PlainKind(NamedTuple):
    """Additional type for plain data: how to take its values apart and how to rebuild them."""

    type: type
    parts: Callable[[Any], object]
    build: Callable[[Any], object]


Kinds = Callable[[str], PlainKind | None]
"""Function from a tag in the data to the additional type with that tag, or None if it is
unknown."""


def plain_bytes(value: object, kinds: Kinds = lambda _: None) -> bytes:
    """Return the value as bytes. Raises TypeError for unsupported types.

    >>> plain_value(plain_bytes({"a": (1, 2.5), 3: [None, 1j]}))
    {'a': (1, 2.5), 3: [None, 1j]}
    """
    writer = _Writer(kinds)
    text = json.dumps(writer.tree(value), separators=(",", ":")).encode()
    return b"".join([len(text).to_bytes(HEAD, "little"), text, *writer.arrays])


def plain_value(content: bytes, kinds: Kinds = lambda _: None) -> Any:
    """Return the value from the bytes of `plain_bytes`. Raises ValueError for other bytes."""
    end = HEAD + int.from_bytes(content[:HEAD], "little")
    try:
        return _Reader(memoryview(content)[end:], kinds).value(json.loads(content[HEAD:end]))
    except READING_ERRORS as error:
        raise ValueError(f"data must be those of plain_bytes, got other bytes: {error}") from None


class _Writer:
    """Builds the JSON tree of a value and collects its arrays."""

    def __init__(self, kinds: Kinds) -> None:
        self._kinds = kinds
        self.arrays: list[bytes] = []
        self._length = 0

    def tree(self, value: Any) -> Any:
        """Return the value as a tree of JSON's types."""
        import numpy as np

        kind = type(value)
        if kind in JSON_TYPES:
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
        raise TypeError(f"data must be numbers, texts, arrays or lists, got {kind} (convert it)")

    def _array(self, values: np.ndarray[Any, Any]) -> list[Any]:
        """Store an array's data; return its dtype, shape, memory order and byte offset."""
        if not NUMBER_DTYPE.fullmatch(values.dtype.str):
            raise TypeError(f"array entries must be numbers or texts, got {values.dtype} (convert)")
        flags = values.flags
        order: Literal["F", "C"] = "F" if flags.f_contiguous and not flags.c_contiguous else "C"
        offset = self._length
        self.arrays.append(values.tobytes(order))
        self._length += len(self.arrays[-1])
        return [values.dtype.str, list(values.shape), order, offset]


class _Reader:
    """Rebuilds values from a tree and the arrays' bytes."""

    def __init__(self, data: memoryview, kinds: Kinds) -> None:
        self._data, self._kinds = data, kinds
        self._bare: dict[str, Callable[[Any], Any]] = {
            "tuple": lambda items: tuple(map(self.value, items)),
            "dict": lambda items: {self.value(key): self.value(item) for key, item in items},
            "complex": lambda parts: complex(*map(float, parts)),
            "array": self._array,
            "scalar": lambda parts: self._array(parts)[()],
        }

    def value(self, tree: Any) -> Any:
        """Return the value that `_Writer.tree` turned into this tree."""
        if isinstance(tree, list):
            return [self.value(item) for item in tree]
        if isinstance(tree, dict):
            ((name, parts),) = tree.items()
            if name in self._bare:
                return self._bare[name](parts)
            kind = self._kinds(name)
            if kind is None:
                raise ValueError(
                    f"types in the data must be known, got {name} (of a newer version?)"
                )
            return kind.build(self.value(parts))
        return tree

    def _array(self, parts: list[Any]) -> Any:
        import numpy as np

        kind, shape, order, offset = parts
        if not NUMBER_DTYPE.fullmatch(kind) or order not in ("C", "F"):
            raise ValueError(f"an array of {kind}")
        if any(type(size) is not int or size < 0 for size in (offset, *shape)):
            raise ValueError(f"an array of the shape {shape} at {offset}")
        dtype, count = np.dtype(kind), math.prod(shape)
        part = self._data[offset : offset + count * dtype.itemsize]
        if not count:
            return np.empty(shape, dtype, order)
        return np.frombuffer(part, dtype, count).reshape(shape, order=order).copy(order)
