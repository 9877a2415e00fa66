"""Formulas as a table of nodes: plain tuples, equal ones shared, none evaluated but by balls.

A node is ``(name, *arguments)``.  Leaves are ``("number", fmpq)``, ``("symbol", name, kind)`` with
the kind ``real``, ``integer`` or ``complex``, ``("I",)`` and ``("pi",)``, and in equations
``("unknown", place, shifts)``, a statement's unknown at shifted variables; ``("poly", terms,
*arguments)`` is a polynomial in its arguments, ``("diff", node, *variables)`` a derivative; all
others are functions of nodes that stand earlier.  `Balls` encloses their values at a rational point
(FLINT's arb and acb).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import reduce
from operator import add, mul
from typing import Any

from flint import acb, arb, ctx, fmpq, fmpq_mpoly

from verify.proof.taylor import Elliptic

from .limits import (
    ARGUMENTS,
    DEPTH,
    DIGITS,
    EXPONENT,
    NAME,
    NODES,
    ORDER,
    SHIFT,
    CertificateError,
    within,
)

NUMBER = re.compile(r"(-?[0-9]+)(?:/([0-9]+))?")
SYMBOL = re.compile(r"[^\W\d]\w*")
KINDS = ("real", "integer", "complex")

ELLIPTIC = ("sn", "cn", "dn", "epsilon", "zeta", "theta", "eta")
ARITY = {
    **dict.fromkeys(("sinh", "cosh", "tanh", "coth", "sech", "csch"), 1),
    **dict.fromkeys(("sin", "cos", "tan", "cot", "sec", "csc"), 1),
    **dict.fromkeys(("exp", "log", "atan", "conjugate", "re", "im", "Abs", "sign"), 1),
    **dict.fromkeys(("asin", "acos", "asinh", "acosh", "atanh"), 1),
    **dict.fromkeys(("elliptic_k", "elliptic_e", "parity"), 1),
    "power": 2,
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

    def rebuilt(self, node: int, images: Callable[[int], int]) -> int:
        """The node with the images of its children in their places."""
        name, *rest = self.all[node]
        inner = children(self.all[node])
        if not inner:
            return node
        moved = map(images, inner)
        if name == "poly":
            return self.made(name, rest[0], *moved)
        return self.made(name, *moved, *(rest[1:] if name in ("Pow", "diff") else ()))

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
            case ["unknown", place, shifts]:
                steps = listed(shifts, 8, "the shifts of an unknown")
                moved = (integer(n, -SHIFT, SHIFT, "a shift") for n in steps)
                return self.made("unknown", integer(place, 0, 7, "an unknown"), tuple(moved))
            case ["diff", place, *places] if 0 < len(places) <= ORDER:
                variables = sorted(map(self.place, places))
                if any(self.all[variable][0] != "symbol" for variable in variables):
                    raise CertificateError("derivatives must be in symbols")
                return self.made("diff", self.place(place), *variables)
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
        case "number" | "symbol" | "I" | "pi" | "unknown":
            return ()
        case "Pow" | "diff":
            return (node[1],)
        case "poly":
            return node[2:]
    return node[1:]


BITS = 320
"""Precision of balls: they only show that something is not 0."""

BALL_FUNCTIONS: Mapping[str, Callable[[acb], acb]] = {
    **{name: getattr(acb, name) for name in ("exp", "log", "atan", "sinh", "cosh", "tanh")},
    **{name: getattr(acb, name) for name in ("coth", "sech", "csch", "sin", "cos", "tan", "cot")},
    **{name: getattr(acb, name) for name in ("sec", "csc", "elliptic_k", "elliptic_e")},
    **{name: getattr(acb, name) for name in ("asin", "acos", "asinh", "acosh", "atanh")},
    "conjugate": lambda z: acb(z.real, -z.imag),
    "re": lambda z: acb(z.real),
    "im": lambda z: acb(z.imag),
    "Abs": lambda z: acb(abs(z)),
}


class Balls:
    """Balls around the nodes of a table, with its symbols at ``point``."""

    def __init__(self, nodes: Nodes, point: Mapping[int, fmpq]) -> None:
        self._nodes = nodes
        self._found = {symbol: acb(arb(value)) for symbol, value in point.items()}
        self._elliptic: dict[int, Elliptic] = {}

    def ball(self, node: int) -> acb:
        """The ball of a node; raises CertificateError where there is none."""
        with ctx.workprec(BITS):
            for inner in self._nodes.below([node]):
                if inner not in self._found:
                    self._found[inner] = self._ball(inner)
        return self._found[node]

    def _ball(self, node: int) -> acb:
        known = self._found
        match self._nodes.all[node]:
            case ("number", value):
                return acb(arb(value))
            case ("I",):
                return acb(0, 1)
            case ("pi",):
                return acb.pi()
            case ("symbol", name, _):
                raise CertificateError(f"the point must have a value of {name}")
            case (("Add" | "Mul") as name, *inner):
                return reduce(add if name == "Add" else mul, (known[place] for place in inner))
            case ("Pow", base, exponent):
                root = known[base] if exponent.q == 1 else known[base].root(int(exponent.q))
                return root ** int(exponent.p)
            case ("poly", terms, *inner):
                return polynomial([known[place] for place in inner], terms)
            case ("power", base, exponent):
                return (known[exponent] * known[base].log()).exp()
            case ("parity", _):
                return acb(1)  # the other value is tried as another branch
            case (str(name), z, m) if name.startswith("jacobi_"):
                return getattr(self._parameter(m), name.removeprefix("jacobi_"))(known[z], 0)[0]
            case ("sign", inner):
                return known[inner] / acb(abs(known[inner]))
            case (str(name), inner) if name in BALL_FUNCTIONS:
                return BALL_FUNCTIONS[name](known[inner])
        raise CertificateError("a node has no value")

    def _parameter(self, m: int) -> Elliptic:
        if m not in self._elliptic:
            self._elliptic[m] = Elliptic(self._found[m])
        return self._elliptic[m]


def polynomial(values: list[acb], terms: Iterable[tuple[fmpq, tuple[int, ...]]]) -> acb:
    """The value of a polynomial given by its terms."""
    total = acb(0)
    for coefficient, exponents in terms:
        term = acb(arb(coefficient))
        for value, exponent in zip(values, exponents, strict=True):
            if exponent:
                term *= value ** int(exponent)
        total += term
    return total


def excludes_zero(factor: fmpq_mpoly, generators: list[acb]) -> bool:
    """Whether a polynomial in the generators, given by their balls, does not vanish."""
    with ctx.workprec(BITS):
        ball = value_at(factor, generators)
    return bool(ball.is_finite() and not ball.contains(0))


def value_at(element: fmpq_mpoly, generators: list[acb]) -> acb:
    """A polynomial of the ring at the values of its generators, the first one first."""
    return polynomial(generators[::-1], ((c, exponents) for exponents, c in element.terms()))
