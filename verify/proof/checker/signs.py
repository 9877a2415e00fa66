"""Signs of real formulas, derived from a domain by their structure alone.

A sign is a set of the values -1, 0, 1 that a formula may have the sign of.  What a domain says is
used through `Signs.stated`; an expression such as 1 - k**2 is decided by a witness: a formula with
the same image, (1 - k)(1 + k), whose structure shows the sign.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

from .nodes import Nodes

Sign = frozenset[int]

ANY, POSITIVE = Sign((-1, 0, 1)), Sign((1,))
NOT_NEGATIVE = Sign((0, 1))

EVERYWHERE_POSITIVE = ("exp", "cosh", "sech", "jacobi_dn", "jacobi_theta")
"""For real arguments, and m < 1 where there is one."""

BELOW_ONE = ("elliptic_k", "elliptic_e", "jacobi_zeta", "jacobi_theta", "jacobi_eta")
"""Functions that are taken for m < 1 only."""

ODD = ("sinh", "tanh", "csch", "coth", "atan", "sign", "re", "conjugate")
"""Of the sign of their argument if that is real."""

REAL = (
    *EVERYWHERE_POSITIVE,
    *ODD,
    *("sin", "cos", "tan", "cot", "sec", "csc"),
    *("jacobi_sn", "jacobi_cn", "jacobi_epsilon", "jacobi_zeta"),
)
"""Real where their arguments are real."""


class Signs:
    """What a domain tells of the nodes of a table.

    ``stated(node)`` is the sign that a domain's inequality gives directly; ``witnesses`` maps a
    node to another with the same image.
    """

    def __init__(
        self, nodes: Nodes, stated: Callable[[int], Sign], witness: Callable[[int], int | None]
    ) -> None:
        self._nodes, self._stated, self._witness = nodes, stated, witness
        self._signs: dict[int, Sign] = {}
        self._real: dict[int, bool] = {}

    def is_real(self, node: int) -> bool:
        """Whether ``node`` is shown to be real."""
        if node not in self._real:
            self._real[node] = False
            self._real[node] = self._is_real(node)
        return self._real[node]

    def sign(self, node: int) -> Sign:
        """The signs that a node may have if it is real; any if it is not shown to be."""
        if not self.is_real(node):
            return ANY
        if node not in self._signs:
            self._signs[node] = ANY
            found = self._sign(node) & self._stated(node)
            other = None if len(found) == 1 else self._witness(node)
            self._signs[node] = found if other is None else found & self.sign(other)
        return self._signs[node]

    def positive(self, node: int) -> bool:
        """Whether ``node`` is shown to be real and greater than 0."""
        return self.is_real(node) and self.sign(node) <= POSITIVE

    def not_negative(self, node: int) -> bool:
        """Whether ``node`` is shown to be real and at least 0."""
        return self.is_real(node) and self.sign(node) <= NOT_NEGATIVE

    def below_one(self, m: int) -> bool:
        """Whether ``m`` is shown to be real and less than 1."""
        made = self._nodes.made
        negative = made("Mul", self._nodes.rational(-1), m)
        return self.positive(made("Add", self._nodes.rational(1), negative))

    def _is_real(self, node: int) -> bool:
        match self._nodes.all[node]:
            case ("number", _) | ("pi",):
                return True
            case ("symbol", _, kind):
                return bool(kind == "real")
            case ("Abs" | "re" | "im", _):
                return True
            case ("Pow", base, exponent):
                return self.not_negative(base) if exponent.q != 1 else self.is_real(base)
            case ("log", inner):
                return self.positive(inner)
            case (str(name), *inner) if name in BELOW_ONE and not self.below_one(inner[-1]):
                return False
            case ("elliptic_k" | "elliptic_e", _):
                return True
            case ("jacobi_eta", z, m):
                return self.is_real(z) and self.not_negative(m)
            case ("poly", _, *inner) | (("Add" | "Mul"), *inner):
                return all(map(self.is_real, inner))
            case (str(name), *inner) if name in REAL:
                return all(map(self.is_real, inner))
        return False

    def _sign(self, node: int) -> Sign:
        match self._nodes.all[node]:
            case ("number", value):
                return Sign((int(value > 0) - int(value < 0),))
            case ("pi",):
                return POSITIVE
            case (("elliptic_k" | "elliptic_e"), m) if self.below_one(m):
                return POSITIVE
            case ("Add", *terms):
                return _combined(lambda a, b: a + b, [self.sign(term) for term in terms])
            case ("Mul", *factors):
                return _combined(lambda a, b: a * b, [self.sign(factor) for factor in factors])
            case ("Pow", base, exponent):
                return self._of_power(self.sign(base), exponent.p, exponent.q)
            case ("Abs", inner):
                found = self.sign(inner) if self.is_real(inner) else ANY
                return Sign(abs(s) for s in found)
            case (str(name), *inner) if name in EVERYWHERE_POSITIVE and self.is_real(node):
                return POSITIVE if len(inner) == 1 or self.below_one(inner[1]) else ANY
            case (str(name), inner) if name in ODD and self.is_real(inner):
                return self.sign(inner)
        return ANY

    def _of_power(self, base: Sign, p: int, q: int) -> Sign:
        if q != 1:
            return base & NOT_NEGATIVE
        return Sign(s ** (2 - p % 2) if s else int(p == 0) for s in base)


def _combined(rule: Callable[[int, int], int], parts: list[Sign]) -> Sign:
    """The signs of a sum or product of two parts, one after the other.

    A sum of opposite signs may have any sign.
    """
    found = parts[0]
    for part in parts[1:]:
        pairs = list(product(found, part))
        if rule(1, 1) == 2 and any(a * b < 0 for a, b in pairs):
            return ANY
        found = Sign(max(-1, min(1, rule(a, b))) for a, b in pairs)
    return found


__all__ = ["ANY", "NOT_NEGATIVE", "POSITIVE", "Sign", "Signs"]
