"""Balls around the values of formulas at a rational point (FLINT's arb and acb), on any branch."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from operator import add, mul

from flint import acb, arb, ctx, fmpq, fmpq_mpoly

from .axioms import FUNCTIONS
from .function_values import Jacobi
from .limits import CertificateError
from .nodes import Nodes, children

BITS = 320
"""Precision of balls in bits; they only have to show that a value is not 0."""


class Balls:
    """Balls around the nodes of a table, with its symbols at ``point``.

    ``turns`` puts roots, absolute values and signs on another branch: it maps their nodes to a
    fraction r, for a factor exp(2 i pi r).  ``conjugate`` maps a node to its conjugate's node.
    """

    def __init__(
        self,
        nodes: Nodes,
        point: Mapping[int, fmpq],
        turns: Mapping[int, fmpq] | None = None,
        conjugate: Callable[[int], int] | None = None,
    ) -> None:
        self._nodes, self._turns, self._formula = nodes, turns or {}, conjugate
        with ctx.workprec(BITS):
            self._found = {symbol: acb(arb(value)) for symbol, value in point.items()}
        self._elliptic: dict[int, Jacobi] = {}

    def ball(self, node: int) -> acb:
        """Return the ball of a node; raises CertificateError if it has no value."""
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
                return self._root(node, known[base], int(exponent.q)) ** int(exponent.p)
            case ("power", base, exponent):
                return (known[exponent] * known[base].log()).exp()
            case (("Abs" | "sign") as name, inner):
                size = self._size(node, inner)
                return size if name == "Abs" else known[inner] / size
            case (("re" | "im" | "conjugate") as name, inner):
                return self._part(name, inner)
            case ("parity", inner):
                return _turn(self._turns[node]) if node in self._turns else _parity(known[inner])
            case (str(name), z, m) if name.startswith("jacobi_"):
                return getattr(self._parameter(m), name.removeprefix("jacobi_"))(known[z])
            case (str(name), *rest) if name in FUNCTIONS:
                inner = children(self._nodes.all[node])
                function = FUNCTIONS[name].ball or getattr(acb, name, None)
                if function is not None:
                    return function(*(known[place] for place in inner), *rest[len(inner) :])
        raise CertificateError("a node has no value")

    def _root(self, node: int, value: acb, degree: int) -> acb:
        """Return a root; it is principal unless ``turns`` gives the node another branch."""
        if degree == 1:
            return value
        if node not in self._turns:
            return value.root(degree)
        if value.real < 0:
            return (-value).root(degree) * _turn(fmpq(1, 2 * degree)) * _turn(self._turns[node])
        return value.root(degree) * _turn(self._turns[node])

    def _size(self, node: int, inner: int) -> acb:
        if node not in self._turns:
            return acb(abs(self._found[inner]))
        return (self._found[inner] * self._conjugate(inner)).sqrt() * _turn(self._turns[node])

    def _part(self, name: str, inner: int) -> acb:
        value = self._found[inner]
        if name == "conjugate":
            return self._conjugate(inner)
        if self._formula is None:
            return acb(value.real if name == "re" else value.imag)
        other = self._conjugate(inner)
        return (value + other) / 2 if name == "re" else (value - other) / acb(0, 2)

    def _conjugate(self, inner: int) -> acb:
        if self._formula is not None and self._nodes.all[inner][0] != "symbol":
            return self.ball(self._formula(inner))
        return acb(self._found[inner].real, -self._found[inner].imag)

    def _parameter(self, m: int) -> Jacobi:
        if m not in self._elliptic:
            self._elliptic[m] = Jacobi(self._found[m])
        return self._elliptic[m]


def constant(nodes: Nodes, node: int) -> acb | None:
    """Return the value of a node without symbols; None if it has symbols or is not finite."""
    if not nodes.is_constant(node):
        return None
    try:
        value = Balls(nodes, {}).ball(node)
    except CertificateError:
        return None
    return value if value.is_finite() else None


def _turn(fraction: fmpq) -> acb:
    """Return exp(2 i pi fraction)."""
    return (acb(0, 2) * acb.pi() * acb(arb(fraction))).exp()


def _parity(value: acb) -> acb:
    whole = value.real.unique_fmpz()
    if whole is None or value.imag != 0:
        raise CertificateError("exponents of -1 must be integers at the point")
    return acb(-1 if int(whole) % 2 else 1)


def value_at(element: fmpq_mpoly, generators: list[acb]) -> acb:
    """Return the value of a polynomial of the ring from the values of its generators, in order."""
    total = acb(0)
    for exponents, coefficient in element.terms():
        powers = zip(generators[::-1], exponents, strict=True)
        total += reduce(mul, (v ** int(n) for v, n in powers if n), acb(arb(coefficient)))
    return total
