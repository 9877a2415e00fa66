"""Formulas as a table of nodes: plain tuples, equal ones shared, none of them evaluated.

A node is ``(name, *arguments)``.  Leaves are ``("number", fmpq)``, ``("symbol", name, kind)`` with
the kind ``real`` or ``complex``, ``("I",)`` and ``("pi",)``; ``("poly", terms, *arguments)`` is a
polynomial in its arguments; all others are functions of nodes that stand earlier.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any

from flint import fmpq

from .limits import ARGUMENTS, DEPTH, DIGITS, EXPONENT, NAME, NODES, CertificateError, within

NUMBER = re.compile(r"(-?[0-9]+)(?:/([0-9]+))?")
SYMBOL = re.compile(r"[^\W\d]\w*")
KINDS = ("real", "complex")

ELLIPTIC = ("sn", "cn", "dn", "epsilon", "zeta", "theta", "eta")
ARITY = {
    **dict.fromkeys(("sinh", "cosh", "tanh", "coth", "sech", "csch"), 1),
    **dict.fromkeys(("sin", "cos", "tan", "cot", "sec", "csc"), 1),
    **dict.fromkeys(("exp", "log", "atan", "conjugate", "re", "im", "Abs", "sign"), 1),
    **dict.fromkeys(("elliptic_k", "elliptic_e"), 1),
    **{f"jacobi_{name}": 2 for name in ELLIPTIC},
}

Node = tuple[Any, ...]


def number(text: object) -> fmpq:
    """A rational number written ``p`` or ``p/q``.

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
    """An integer between ``least`` and ``limit``; raises CertificateError for anything else."""
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= limit:
        shown = value if isinstance(value, int) and abs(value) < 10**9 else type(value).__name__
        raise CertificateError(f"{what} must be an integer from {least} to {limit}, got {shown}")
    return value


def listed(value: object, limit: int, what: str, length: int | None = None) -> list[Any]:
    """A list of at most ``limit`` entries (exactly ``length`` if given)."""
    if not isinstance(value, list) or (length is not None and len(value) != length):
        raise CertificateError(f"{what} must be a list{'' if length is None else f' of {length}'}")
    within(f"the length of {what}", len(value), limit)
    return value


class Nodes:
    """The nodes of a certificate, and those that the axioms make from them.

    >>> nodes = Nodes([["symbol", "x", "real"], ["number", "2"], ["Mul", 0, 1]])
    >>> nodes.made("Mul", 1, 0) == nodes.places[2]
    True
    """

    def __init__(self, table: object) -> None:
        self.all: list[Node] = []
        self.depth: list[int] = []
        self._known: dict[Node, int] = {}
        self.places: list[int] = []
        self.read(table)

    def read(self, table: object) -> None:
        """Make ``table`` the one that `place` reads from; equal nodes of both are one."""
        self.places = []
        for entry in listed(table, NODES, "nodes"):
            self.places.append(self._read(entry))
        symbols = [node[1] for node in self.all if node[0] == "symbol"]
        if len(set(symbols)) != len(symbols):
            raise CertificateError("symbols must differ in name")

    def place(self, value: object) -> int:
        """The node that a place in the certificate's table means."""
        return self.places[integer(value, 0, len(self.places) - 1, "a place in nodes")]

    def made(self, name: str, *arguments: Any) -> int:
        """The node ``(name, *arguments)``; sums and products know no order."""
        if name in ("Add", "Mul"):
            arguments = tuple(sorted(arguments))
        node = (name, *arguments)
        if node not in self._known:
            inner = arguments[1:] if name == "poly" else children(node)
            depth = 1 + max((self.depth[argument] for argument in inner), default=0)
            self.depth.append(within("the depth of a formula", depth, DEPTH))
            within("the number of nodes", len(self.all) + 1, 2 * NODES)
            self._known[node] = len(self.all)
            self.all.append(node)
        return self._known[node]

    def rational(self, p: int, q: int = 1) -> int:
        """The node of a rational number."""
        return self.made("number", fmpq(p, q))

    def value(self, node: int) -> fmpq | None:
        """The value of a number's node; None for any other."""
        found = self.all[node]
        return found[1] if found[0] == "number" else None

    def below(self, roots: Sequence[int]) -> Iterator[int]:
        """The nodes in ``roots``, each once, arguments first."""
        wanted = set(roots)
        for node in range(max(roots, default=-1), -1, -1):
            if node in wanted:
                wanted.update(children(self.all[node]))
        yield from sorted(wanted)

    def _read(self, entry: object) -> int:
        match listed(entry, ARGUMENTS, "a node"):
            case ["number", text]:
                return self.made("number", number(text))
            case ["symbol", str(name), str(kind)] if kind in KINDS:
                within("the length of a name", len(name), NAME)
                if not SYMBOL.fullmatch(name):
                    raise CertificateError(f"names must be letters and digits, got {name!a}")
                return self.made("symbol", name, kind)
            case ["constant", ("I" | "pi") as name]:
                return self.made(name)
            case [("Add" | "Mul") as name, *places] if places:
                return self.made(name, *map(self.place, places))
            case ["Pow", base, exponent]:
                return self._power(self.place(base), number(exponent))
            case ["poly", terms, *places] if places:
                return self._polynomial(terms, [self.place(place) for place in places])
            case [str(name), *places] if ARITY.get(name) == len(places):
                return self.made(name, *map(self.place, places))
        raise CertificateError(f"nodes must be such as the prover writes, got {ascii(entry)[:60]}")

    def _power(self, base: int, exponent: fmpq) -> int:
        for part, what in ((exponent.p, "exponents"), (exponent.q, "the degree of a root")):
            within(what, abs(int(part)), EXPONENT)
        return self.made("Pow", base, exponent)

    def _polynomial(self, terms: object, places: list[int]) -> int:
        found = []
        for term in listed(terms, NODES, "the terms of a polynomial"):
            text, exponents = listed(term, 2, "a term", 2)
            powers = listed(exponents, ARGUMENTS, "exponents", len(places))
            found.append(
                (number(text), tuple(integer(n, 0, EXPONENT, "an exponent") for n in powers))
            )
        return self.made("poly", tuple(found), *places)


def children(node: Node) -> tuple[int, ...]:
    """The nodes that a node is made of."""
    match node[0]:
        case "number" | "symbol" | "I" | "pi":
            return ()
        case "Pow":
            return (node[1],)
        case "poly":
            return node[2:]
    return node[1:]
