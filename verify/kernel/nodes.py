"""Formulas as a table of nodes: plain tuples, equal ones shared, none evaluated.

A node is ``(name, *arguments)``.  Leaves are ``("number", fmpq)``, ``("symbol", name, kind)`` with
the kind ``real``, ``integer`` or ``complex``, ``("I",)`` and ``("pi",)``, and in equations
``("unknown", place, shifts)``, a statement's unknown at shifted variables; ``("diff", node,
*variables)`` is a derivative; ``("jet", z, (name, order))`` one of an arbitrary function, and
``("theta", z, q, (name, order))`` one in z of a theta function of the nome q; all others are
functions of nodes that stand earlier.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from math import prod
from typing import Any

from flint import fmpq

from .limits import DEPTH, DIGITS, NODES, CertificateError, within

NUMBER = re.compile(r"(-?[0-9]+)(?:/([0-9]+))?")
KINDS = ("real", "integer", "complex", "function")

DOMAIN_WORDS = (*KINDS, "nonzero", "positive", "negative")
"""Words that state the kind or sign of a name; none of them may be used as a name."""

Node = tuple[Any, ...]


def number(text: object) -> fmpq:
    """Return a rational number written ``p`` or ``p/q``.

    >>> number("-3/4")
    -3/4
    """
    if not isinstance(text, str):
        raise CertificateError(f"numbers must be text, got {type(text).__name__} (write p/q)")
    within("digits of a number", len(text), DIGITS)
    match = NUMBER.fullmatch(text)
    if match is None or not text.isascii():
        raise CertificateError(f"numbers must be written p or p/q, got {text[:40]!r}")
    below = int(match[2] or 1)
    if below == 0:
        raise CertificateError(f"numbers must have a denominator, got {text[:40]!r}")
    return fmpq(int(match[1]), below)


def integer(value: object, least: int, limit: int, what: str) -> int:
    """Return an integer from ``least`` to ``limit``; raises CertificateError otherwise."""
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= limit:
        got = value if isinstance(value, int) and abs(value) < 10**9 else type(value).__name__
        raise CertificateError(f"{what} must be an integer from {least} to {limit}, got {got}")
    return value


def listed(value: object, limit: int, what: str, exactly: bool = False) -> list[Any]:
    """Return ``value``, checked to be a list of at most, or ``exactly``, ``limit`` entries."""
    if not isinstance(value, list) or (exactly and len(value) != limit):
        raise CertificateError(f"{what} must be a list{f' of {limit}' if exactly else ''}")
    within(f"the length of {what}", len(value), limit)
    return value


class Nodes:
    """Table of the nodes of a certificate; ``places`` are the nodes of the proof's formulas.

    >>> nodes = Nodes()
    >>> x, two = nodes.add("symbol", "x", "real"), nodes.rational(2)
    >>> nodes.add("Mul", x, two) == nodes.add("Mul", two, x)
    True
    """

    def __init__(self) -> None:
        self.all: list[Node] = []
        self.depth: list[int] = []
        self._known: dict[Node, int] = {}
        self.places: list[int] = []

    def place(self, value: object) -> int:
        """Return the node of formula number ``value`` in the proof's list."""
        return self.places[integer(value, 0, len(self.places) - 1, "a place in formulas")]

    def add(self, name: str, *arguments: Any) -> int:
        """Return the node ``(name, *arguments)``, added if new; Add and Mul sort the arguments."""
        if name in ("Add", "Mul"):
            arguments = tuple(sorted(arguments))
        node = (name, *arguments)
        if node not in self._known:
            depth = 1 + max((self.depth[argument] for argument in children(node)), default=0)
            self.depth.append(within("the depth of a formula", depth, DEPTH))
            within("the number of nodes", len(self.all) + 1, 2 * NODES)
            self._known[node] = len(self.all)
            self.all.append(node)
        return self._known[node]

    def rational(self, p: int, q: int = 1) -> int:
        """Return the node of a rational number."""
        return self.add("number", fmpq(p, q))

    def negative(self, node: int) -> int:
        """Return the node times -1."""
        return self.times(-1, node)

    def gap(self, left: int, right: int) -> int:
        """Return the node of ``right - left``."""
        if self.value(left) == 0:
            return right
        negative = self.negative(left)
        return negative if self.value(right) == 0 else self.add("Add", right, negative)

    def value(self, node: int) -> fmpq | None:
        """Return the rational number of a number node; None for any other node."""
        parts = self.all[node]
        return parts[1] if parts[0] == "number" else None

    def terms(self, node: int) -> tuple[int, ...]:
        """Return the terms of a sum; any other node is its own only term."""
        return self.all[node][1:] if self.all[node][0] == "Add" else (node,)

    def multiple(self, node: int) -> tuple[fmpq, int]:
        """Split a product into its rational coefficient and the node of the rest, maybe 1."""
        factors = self.all[node][1:] if self.all[node][0] == "Mul" else (node,)
        values = [value for value in map(self.value, factors) if value is not None]
        rest = [factor for factor in factors if self.value(factor) is None]
        return prod(values, start=fmpq(1)), self.product(*rest)

    def times(self, number: int, node: int) -> int:
        """Return the node of ``number`` times ``node``."""
        return node if number == 1 else self.add("Mul", self.rational(number), node)

    def product(self, *factors: int) -> int:
        """Return the node of a product, which is 1 without factors."""
        if len(factors) < 2:
            return factors[0] if factors else self.rational(1)
        return self.add("Mul", *factors)

    def is_constant(self, node: int) -> bool:
        """Return whether a node has no symbols and no arbitrary functions."""
        return all(self.all[inner][0] not in ("symbol", "jet") for inner in self.below([node]))

    def is_integer(self, node: int) -> bool:
        """Return whether a node is evidently an integer at every point."""
        match self.all[node]:
            case ("number", value):
                return bool(value.q == 1)
            case ("symbol", _, kind):
                return bool(kind == "integer")
            case ("Add" | "Mul", *parts):
                return all(map(self.is_integer, parts))
            case ("Pow", base, exponent):
                return bool(exponent.q == 1 and exponent > 0 and self.is_integer(base))
        return False

    def rebuilt(self, node: int, images: Callable[[int], int]) -> int:
        """Return the node with each child replaced by its image."""
        name, *rest = self.all[node]
        inner = children(self.all[node])
        if not inner:
            return node
        moved = map(images, inner)
        return self.add(name, *moved, *rest[len(inner) :])

    def below(self, roots: Sequence[int]) -> Iterator[int]:
        """Yield ``roots`` and all nodes below them, each once, arguments first."""
        reached = set(roots)
        for node in range(max(roots, default=-1), -1, -1):
            if node in reached:
                reached.update(children(self.all[node]))
        yield from sorted(reached)


def children(node: Node) -> tuple[int, ...]:
    """Return the arguments of a node that are nodes."""
    match node[0]:
        case "number" | "symbol" | "I" | "pi" | "unknown":
            return ()
        case "diff":
            return (node[1],)
        case "Pow" | "jet" | "theta":
            return node[1:-1]
    return node[1:]
