"""The images of formulas in the generators of a proof, and the signs of real formulas.

Sums, products and integer powers are computed here; what the image of a root or of another
function is, a subclass says.

Signs are derived from a domain by the structure of formulas alone.  A sign is a set of the values
-1, 0, 1 that a formula may have the sign of.  What a domain says is used through `Signs.stated`; an
expression such as 1 - k**2 is decided by a witness: a formula with the same image, (1 - k)(1 + k),
whose structure shows the sign.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from flint import fmpq

from . import axioms
from .limits import EXPONENT, CertificateError, within
from .nodes import Nodes, children
from .ring import Element, Ring

Sum = tuple[tuple[fmpq, int], ...]
"""Coefficients and nodes."""


@dataclass(frozen=True)
class Hints:
    """Which axiom instances to use: nothing of this is believed, all of it is checked.

    ``sums[f(z)]`` writes the argument of exp, sn or theta as a combination of others,
    ``values[f]`` names what a root or an absolute value is, ``logs[log f]`` the factors of f,
    ``signs[f]`` a formula with the same image whose structure shows its sign.
    """

    sums: Mapping[int, Sum]
    values: Mapping[int, int]
    logs: Mapping[int, Sum]
    signs: Mapping[int, int]


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


def conjugate(nodes: Nodes, signs: Signs, node: int) -> int:
    """The complex conjugate of a node as a node."""
    made = nodes.made

    def inside(part: int) -> int:
        return conjugate(nodes, signs, part)

    if signs.is_real(node):
        return node
    match nodes.all[node]:
        case ("I",):
            return made("Mul", nodes.rational(-1), node)
        case (("Add" | "Mul") as name, *parts):
            return made(name, *map(inside, parts))
        case ("Pow", base, exponent) if exponent.q == 1:
            return made("Pow", inside(base), exponent)
        case ("poly", terms, *parts):
            return made("poly", terms, *map(inside, parts))
        case ("conjugate", inner):
            return int(inner)
        case (str(name), inner) if name in ("exp", *axioms.HYPERBOLIC, *axioms.TRIGONOMETRIC):
            return made(name, inside(inner))
        case (("jacobi_sn" | "jacobi_cn" | "jacobi_dn") as name, z, m) if signs.is_real(m):
            return made(name, inside(z), m)
        case (name, *_):
            raise CertificateError(f"the conjugate of {name} does not follow from the domain")
    raise CertificateError("a node has no conjugate")


class Images(ABC):
    """The nodes of a certificate as elements of a ring."""

    signs: Signs

    def __init__(self, nodes: Nodes, count: int, variables: Sequence[int], hints: Hints) -> None:
        self.nodes, self.ring, self.hints = nodes, Ring(count), hints
        self.variables = variables
        self.one = self.ring.number(1)
        self.zero = self.ring.number(0)
        self._images: dict[int, Element] = {}
        self._atoms: dict[str, list[int]] = {}

    def walk(self, nodes: Sequence[int]) -> None:
        """Make the images of ``nodes`` from the inside out."""
        wanted = set(nodes)
        for node in range(max(nodes, default=-1), -1, -1):
            if node in wanted and node not in self._images:
                wanted.update(children(self.nodes.all[node]))
        for node in sorted(wanted):
            self.image(node)

    def image(self, node: int) -> Element:
        """The image of a node; raises CertificateError where it does not follow from generators."""
        if node not in self._images:
            self._images[node] = self._image(node)
        return self._images[node]

    def equal(self, left: int, right: int) -> bool:
        """Whether two nodes have the same image."""
        return left == right or (self.image(left) - self.image(right)).is_zero

    def made(self, name: str, *arguments: int) -> Element:
        """The image of the node ``(name, *arguments)``."""
        return self.image(self.nodes.made(name, *arguments))

    def sum(self, parts: list[Element]) -> Element:
        """The sum; polynomials are added first."""
        whole = self.zero.numerator
        for part in parts:
            if not part.powers:
                whole += part.numerator
        result = Element(self.ring, whole)
        for part in parts:
            if part.powers:
                result = result + part
        return result

    def product(self, parts: list[Element]) -> Element:
        """The product of one or more."""
        total = parts[0]
        for part in parts[1:]:
            total = total * part
        return total

    def atoms(self, name: str) -> list[int]:
        """The nodes of the function ``name`` that are generators."""
        return self._atoms.get(name, [])

    def known(self, node: int) -> Element | None:
        """The image of the same function of equal arguments, if that is a generator."""
        name, *arguments = self.nodes.all[node]
        if not arguments or name == "symbol":
            return None
        for atom in self._atoms.get(name, []):
            others = self.nodes.all[atom][1:]
            if name == "Pow" and arguments[1] != others[1]:
                continue
            inner = zip(children(self.nodes.all[node]), children(self.nodes.all[atom]), strict=True)
            if all(self.equal(a, b) for a, b in inner):
                return self._images[atom]
        return None

    def moves(self, node: int) -> bool:
        """Whether a formula contains a variable of the equation."""
        return any(inner in self.variables for inner in self.nodes.below([node]))

    def sum_of(self, function: int) -> Sum:
        """The combination that a hint gives for a function's argument, checked."""
        found, z = self.hints.sums.get(function), self.nodes.all[function][1]
        if found is None:
            raise CertificateError("there is no generator for a function of a sum")
        parts = [self.ring.number(n) * self.image(u) for n, u in found]
        if not (self.sum([self.zero, *parts]) - self.image(z)).is_zero:
            raise CertificateError("an argument is not the sum that it is said to be")
        return found

    def named(self, node: int) -> int:
        """The node that a hint says is the value of ``node``."""
        if node not in self.hints.values:
            raise CertificateError(f"there is no generator for a {self.nodes.all[node][0]}")
        return self.hints.values[node]

    def conjugate(self, node: int) -> int:
        """The complex conjugate of a node as a node."""
        return conjugate(self.nodes, self.signs, node)

    def squared(self, inner: int) -> Element:
        """abs(f)**2 = f conj(f)."""
        return self.image(inner) * self.image(self.conjugate(inner))

    def _image(self, node: int) -> Element:
        match self.nodes.all[node]:
            case ("number", value):
                return self.ring.number(value)
            case ("Add", *terms):
                return self.sum([self.image(term) for term in terms])
            case ("Mul", *factors):
                return self.product([self.image(factor) for factor in factors])
            case ("poly", terms, *places):
                return self._polynomial(terms, [self.image(place) for place in places])
            case ("Pow", base, exponent):
                return self._power(node, base, int(exponent.p), int(exponent.q))
            case ("symbol", name, _):
                raise CertificateError(f"there is no generator for the symbol {name}")
            case (name, *arguments) if arguments:
                return self._function(node, name, arguments)
            case (name,):
                raise CertificateError(f"there is no generator for {name}")
        raise CertificateError("a node has no image")

    def _polynomial(
        self, terms: Sequence[tuple[fmpq, tuple[int, ...]]], values: list[Element]
    ) -> Element:
        parts = []
        for coefficient, exponents in terms:
            powers = (v**n for v, n in zip(values, exponents, strict=True) if n)
            parts.append(self.product([self.ring.number(coefficient), *powers]))
        return self.sum(parts)

    def _power(self, node: int, base: int, p: int, q: int) -> Element:
        if q != 1:
            if p != 1:
                return self.image(self.nodes.made("Pow", base, fmpq(1, q))) ** p
            return self._root(node, base, q)
        inner = self.nodes.all[base]
        if inner[0] == "Abs" and p % 2 == 0:
            return self.squared(inner[1]) ** (p // 2)
        return self.image(base) ** p

    @abstractmethod
    def _root(self, node: int, base: int, q: int) -> Element:
        """The image of base**(1/q)."""

    @abstractmethod
    def _function(self, node: int, name: str, arguments: Sequence[int]) -> Element:
        """The image of a function of ``arguments`` that is neither a sum, product nor power."""


def integer_of(value: fmpq) -> int:
    """The integer that a coefficient in a sum of arguments must be."""
    if value.q != 1:
        raise CertificateError("coefficients in a sum of arguments must be integers")
    within("coefficients", abs(int(value.p)), EXPONENT)
    return int(value.p)
