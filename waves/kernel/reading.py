"""Strict reading of certificates: every key is known, every number is exact text."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from flint import arb, fmpq

from .limits import CertificateError, decimal, preview


def without_doubles(pairs: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """Build a JSON object from its pairs. Raises CertificateError for a repeated key."""
    data = dict(pairs)
    if len(data) < len(pairs):
        raise CertificateError("an object has a key twice")
    return data


class Record:
    """A JSON object whose keys are read once each; `close` refuses those that were not read."""

    def __init__(self, data: object, name: str) -> None:
        if not isinstance(data, dict):
            raise CertificateError(f"{name} must be an object, got {type(data).__name__}")
        self._data: dict[str, Any] = dict(data)
        self._name = name

    def __contains__(self, key: str) -> bool:
        return key in self._data

    def take(self, key: str) -> Any:
        """Return the value of ``key`` and remove it, so that it counts as read."""
        if key not in self._data:
            raise CertificateError(f"{self._name} must have {key!r}")
        return self._data.pop(key)

    def text(self, key: str) -> str:
        """Read the text under ``key``."""
        value = self.take(key)
        if not isinstance(value, str):
            raise CertificateError(f"{self._name}.{key} must be a text, got {type(value).__name__}")
        return value

    def number(self, key: str) -> fmpq:
        """Read the exact number under ``key``."""
        return decimal(self.take(key))

    def integer(self, key: str, least: int, most: int) -> int:
        """Read the integer under ``key``, which must be from ``least`` to ``most``."""
        value = self.take(key)
        if type(value) is not int or not least <= value <= most:
            raise CertificateError(
                f"{self._name}.{key} must be {least} to {most}, got {preview(value)}"
            )
        return value

    def items(self, key: str, most: int) -> Sequence[Any]:
        """Read the list under ``key``, which must have at most ``most`` entries."""
        value = self.take(key)
        if not isinstance(value, list) or len(value) > most:
            raise CertificateError(f"{self._name}.{key} must be a list of at most {most} entries")
        return value

    def record(self, key: str) -> Record:
        """Read the inner object under ``key`` as a record."""
        return Record(self.take(key), key)

    def close(self) -> None:
        """Raise CertificateError if a key was not read."""
        if self._data:
            raise CertificateError(
                f"{self._name} has unknown keys: {', '.join(map(str, self._data))[:80]}"
            )


def pieces_to(end: fmpq, items: Sequence[Any]) -> Iterator[tuple[Record, fmpq, fmpq]]:
    """Yield the pieces of the range 0 ... ``end``, each with its ends; the last is its "square".

    Raises CertificateError unless they rise from 0 to ``end``.
    """
    reached = fmpq(0)
    for item in items:
        piece = Record(item, "piece")
        last = piece.number("square")
        if not reached < last:
            raise CertificateError("the pieces of eps^2 must rise from 0")
        yield piece, reached, last
        reached = last
    if reached != end:
        raise CertificateError("the pieces of eps^2 must end at the square of eps")


Ends = tuple[arb, arb]
"""Proved lower and upper end of a number, as exact balls."""


def ends_of(value: arb) -> Ends:
    """Return the lower and the upper end of a ball, as exact balls."""
    return value.lower(), value.upper()


def check_claims(claims: Record, proved: Mapping[str, Ends]) -> list[str]:
    """Return a line for each claimed interval; each must contain what was proved.

    Raises CertificateError for a claim that is unknown, malformed or not proved.
    """
    lines = []
    for name, (least, most) in proved.items():
        if name in claims:
            ends = claims.items(name, 2)
            if len(ends) != 2:
                raise CertificateError(f"claim {name} must have a lower and an upper end")
            low, high = map(decimal, ends)
            if not (arb(low) <= least and most <= arb(high)):
                raise CertificateError(
                    f"claim {name} is not proved: [{ends[0]}, {ends[1]}] must contain "
                    f"[{least.str(20, radius=False)}, {most.str(20, radius=False)}]"
                )
            lines.append(f"{ends[0]} <= {name} <= {ends[1]}")
    claims.close()
    return lines
