"""Balls around the nodes of a formula at a rational point (FLINT's arb and acb)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import reduce
from operator import add, mul

from flint import acb, arb, ctx, fmpq, fmpq_mpoly

from verify.proof.ballfunctions import Elliptic

from .limits import CertificateError
from .nodes import Nodes

BITS = 320

FUNCTIONS: Mapping[str, Callable[[acb], acb]] = {
    **{name: getattr(acb, name) for name in ("exp", "log", "atan", "sinh", "cosh", "tanh")},
    **{name: getattr(acb, name) for name in ("coth", "sech", "csch", "sin", "cos", "tan", "cot")},
    **{name: getattr(acb, name) for name in ("sec", "csc", "elliptic_k", "elliptic_e")},
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
            case (str(name), z, m) if name.startswith("jacobi_"):
                return getattr(self._parameter(m), name.removeprefix("jacobi_"))(known[z], 0)[0]
            case ("sign", inner):
                return known[inner] / acb(abs(known[inner]))
            case (str(name), inner):
                return FUNCTIONS[name](known[inner])
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
