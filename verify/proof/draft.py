"""A proof that is being written: generators and hints, as places in a table of nodes."""

from __future__ import annotations

from typing import Any

from .balls import Point
from .tree import NodeTable

Data = dict[str, Any]


class Unsupported(ValueError):
    """A formula contains something that no axiom speaks of."""


class Draft:
    """The generators so far, the hints by kind, and the witnesses of signs."""

    def __init__(self, table: NodeTable) -> None:
        self.table = table
        self.generators: list[list[Any]] = []
        self.registered: set[int] = set()
        self.hints: dict[str, dict[int, Any]] = {n: {} for n in ("sums", "values", "logs")}
        self.signs: dict[int, int] = {}
        self.parts: list[list[Any]] = []

    def atom(self, place: int, *rest: Any) -> None:
        """A generator for the node at ``place``, unless it has one; ``rest`` if it is no atom."""
        if place not in self.registered:
            self.registered.add(place)
            self.generators.append([*(rest or ("atom", place))])

    def data(self, point: Point) -> Data:
        """The proof's part of a certificate; ``point`` is where no denominator vanishes."""
        return {
            "generators": self.generators,
            **{name: [[z, v] for z, v in hints.items()] for name, hints in self.hints.items()},
            "signs": [[node, other] for node, other in self.signs.items()],
            "point": [[self.table.place(s), str(value)] for s, value in point.items()],
            "parts": self.parts,
        }
