"""Formulas as a table of nodes: plain tuples, equal ones shared, none evaluated but by balls.

A node is ``(name, *arguments)``.  Leaves are ``("number", fmpq)``, ``("symbol", name, kind)`` with
the kind ``real``, ``integer`` or ``complex``, ``("I",)`` and ``("pi",)``, and in equations
``("unknown", place, shifts)``, a statement's unknown at shifted variables; ``("diff", node,
*variables)`` is a derivative; ``("jet", z, ..., (name, order))`` is a derivative in z of a function
of which all derivatives are free; all others are functions of nodes that stand earlier.  `Balls`
encloses their values at a rational point (FLINT's arb and acb).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import reduce
from operator import add, mul
from typing import Any

from flint import acb, acb_series, arb, ctx, fmpq, fmpq_mpoly

from .jacobi_values import Jacobi
from .limits import DEPTH, DIGITS, NODES, CertificateError, within
from .weierstrass_values import weierstrass

NUMBER = re.compile(r"(-?[0-9]+)(?:/([0-9]+))?")
KINDS = ("real", "integer", "complex", "function")

ELLIPTIC = ("sn", "cn", "dn", "epsilon", "zeta", "theta", "eta")
ANALYTIC = (
    *("sinh", "cosh", "tanh", "coth", "sech", "csch", "sin", "cos", "tan", "cot", "sec", "csc"),
    *("exp", "log", "atan", "asin", "acos", "asinh", "acosh", "atanh", "elliptic_k", "elliptic_e"),
)
"""Functions of FLINT's balls by the same name."""

CYLINDER: Mapping[str, tuple[int, int]] = {
    "bessel_j": (-1, 1),
    "bessel_y": (-1, 1),
    "bessel_i": (1, 1),
    "bessel_k": (-1, -1),
}
"""Bessel functions C of order v, with a and b in C' = v/z C + a C(v + 1) = b C(v - 1) - v/z C."""

THETA = tuple(f"jacobi_theta_{place}" for place in (1, 2, 3, 4))
"""Theta functions of z and the nome q, 0 < q < 1."""

SPECIAL: Mapping[str, Callable[..., acb]] = {
    "erf": acb.erf,
    "airy_ai": acb.airy_ai,
    "airy_ai_prime": lambda z: z.airy_ai(derivative=1),
    "airy_bi": acb.airy_bi,
    "airy_bi_prime": lambda z: z.airy_bi(derivative=1),
    "lambert_w": acb.lambertw,
    "bessel_j": lambda v, z: z.bessel_j(v),
    "bessel_y": lambda v, z: z.bessel_y(v),
    "bessel_i": lambda v, z: z.bessel_i(v),
    "bessel_k": lambda v, z: z.bessel_k(v),
    "weierstrass_p": lambda *z: weierstrass(*z)[0],
    "weierstrass_p_prime": lambda *z: weierstrass(*z)[1],
}
"""Functions that are known by their differential equations alone, as balls."""

ARITY = {
    **dict.fromkeys((*ANALYTIC, *SPECIAL, "conjugate", "re", "im", "Abs", "sign", "parity"), 1),
    **dict.fromkeys(CYLINDER, 2),
    **dict.fromkeys(("weierstrass_p", "weierstrass_p_prime"), 3),
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

    ``places`` are those that a proof refers to by number.

    >>> nodes = Nodes()
    >>> x, two = nodes.made("symbol", "x", "real"), nodes.rational(2)
    >>> nodes.made("Mul", x, two) == nodes.made("Mul", two, x)
    True
    """

    def __init__(self) -> None:
        self.all: list[Node] = []
        self.depth: list[int] = []
        self._known: dict[Node, int] = {}
        self.places: list[int] = []

    def place(self, value: object) -> int:
        """The node that a place in the proof's list of formulas means."""
        return self.places[integer(value, 0, len(self.places) - 1, "a place in formulas")]

    def made(self, name: str, *arguments: Any) -> int:
        """The node ``(name, *arguments)``; sums and products know no order."""
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
        """The node of a rational number."""
        return self.made("number", fmpq(p, q))

    def value(self, node: int) -> fmpq | None:
        """The value of a number's node; None for any other."""
        found = self.all[node]
        return found[1] if found[0] == "number" else None

    def is_constant(self, node: int) -> bool:
        """Whether a node has no symbols and no functions of free derivatives."""
        return all(self.all[inner][0] not in ("symbol", "jet") for inner in self.below([node]))

    def is_integer(self, node: int) -> bool:
        """Whether a node is evidently an integer at every point."""
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
        """The node with the images of its children in their places."""
        name, *rest = self.all[node]
        inner = children(self.all[node])
        if not inner:
            return node
        moved = map(images, inner)
        return self.made(name, *moved, *rest[len(inner) :])

    def below(self, roots: Sequence[int]) -> Iterator[int]:
        """The nodes in ``roots``, each once, arguments first."""
        wanted = set(roots)
        for node in range(max(roots, default=-1), -1, -1):
            if node in wanted:
                wanted.update(children(self.all[node]))
        yield from sorted(wanted)


def children(node: Node) -> tuple[int, ...]:
    """The nodes that a node is made of."""
    match node[0]:
        case "number" | "symbol" | "I" | "pi" | "unknown":
            return ()
        case "diff":
            return (node[1],)
        case "Pow" | "jet":
            return node[1:-1]
    return node[1:]


BITS = 320
"""Precision of balls: they only show that something is not 0."""

BALL_FUNCTIONS: Mapping[str, Callable[..., acb]] = {
    **{name: getattr(acb, name) for name in ANALYTIC},
    **SPECIAL,
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
        self._elliptic: dict[int, Jacobi] = {}

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
            case ("power", base, exponent):
                return (known[exponent] * known[base].log()).exp()
            case ("parity", inner):
                whole = known[inner].real.unique_fmpz()
                if whole is None or known[inner].imag != 0:
                    raise CertificateError("a power of -1 must be to an integer at the point")
                return acb(-1 if int(whole) % 2 else 1)
            case (str(name), z, m) if name.startswith("jacobi_"):
                return getattr(self._parameter(m), name.removeprefix("jacobi_"))(known[z])
            case ("sign", inner):
                return known[inner] / acb(abs(known[inner]))
            case ("jet", *inner, (name, order)):
                return jet(name, order, *(known[place] for place in inner))
            case (str(name), *inner) if name in BALL_FUNCTIONS:
                return BALL_FUNCTIONS[name](*(known[place] for place in inner))
        raise CertificateError("a node has no value")

    def _parameter(self, m: int) -> Jacobi:
        if m not in self._elliptic:
            self._elliptic[m] = Jacobi(self._found[m])
        return self._elliptic[m]


def jet(name: str, order: int, z: acb, *nome: acb) -> acb:
    """A derivative of a theta function, or, for any function of the name, of one that is generic.

    That is 1/gamma at a shift, which satisfies no algebraic differential equation.
    """
    if nome:
        tau = nome[0].log() / (acb(0, 1) * acb.pi())
        return (z / acb.pi()).modular_theta(tau, order)[THETA.index(name)] / acb.pi() ** order
    place = z + acb(arb(generic_shift(name)))
    return acb_series([place, 1], order + 1).rgamma()[order] * acb(order + 1).gamma()


def generic_shift(name: str) -> fmpq:
    """The number s of a name: what stands for any function f is f(z) = 1/gamma(z + s)."""
    return fmpq(sum(map(ord, name)) % 89, 97)


def excludes_zero(factor: fmpq_mpoly, generators: list[acb]) -> bool:
    """Whether a polynomial in the generators, given by their balls, does not vanish."""
    with ctx.workprec(BITS):
        ball = value_at(factor, generators)
    return bool(ball.is_finite() and not ball.contains(0))


def value_at(element: fmpq_mpoly, generators: list[acb]) -> acb:
    """A polynomial of the ring at the values of its generators, the first one first."""
    total = acb(0)
    for exponents, coefficient in element.terms():
        powers = zip(generators[::-1], exponents, strict=True)
        total += reduce(mul, (v ** int(n) for v, n in powers if n), acb(arb(coefficient)))
    return total
