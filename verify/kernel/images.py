"""The images of formulas in the generators of a proof.

Sums, products and integer powers are computed here; what the image of a root or of another
function is, a subclass says.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, TypeVar

from flint import fmpq, fmpq_mpoly

from .limits import EXPONENT, CertificateError, within
from .nodes import Nodes, children
from .ring import Element, Ring
from .signs import Signs

Sum = tuple[tuple[fmpq, int], ...]
"""Coefficients and nodes."""

Hint = TypeVar("Hint")

Form = tuple[tuple[int, ...], int]
"""The factors of some primitives, and what is added."""


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


@dataclass(frozen=True)
class Generator:
    """What a generator stands for: ``scale * node / below``, or a sum of products and a shift."""

    node: int
    scale: fmpq_mpoly | None = None
    below: int | None = None
    form: tuple[tuple[int, int], ...] = ()
    shift: int = 0

    @property
    def nodes(self) -> list[int]:
        """The nodes whose values make the generator's."""
        if self.form:
            return [self.shift, *(node for pair in self.form for node in pair)]
        return [self.node] if self.below is None else [self.node, self.below]


class Images(ABC):
    """The nodes of a certificate as elements of a ring.

    ``positive`` are the nodes that the domain states to be positive (True: or 0).  ``circles`` maps
    each symbol s to the node of sqrt(1 - s**2) that is a generator in its place.
    """

    ring_type: ClassVar[type[Ring]] = Ring

    def __init__(
        self,
        nodes: Nodes,
        count: int,
        variables: Sequence[int],
        positive: Mapping[int, bool],
        hints: Hints,
    ) -> None:
        self.nodes, self.ring, self.hints = nodes, self.ring_type(count), hints
        self.variables, self.generators = variables, list[Generator]()
        self.circles: dict[int, int] = {}
        self.positive, self.point = positive, dict[int, fmpq]()
        self.signs = Signs(nodes, self.image, positive, hints.signs)
        self.one = self.ring.number(1)
        self.zero = self.ring.number(0)
        self._images: dict[int, Element] = {}
        self._underway: set[int] = set()
        self._atoms: dict[str, list[int]] = {}

    def walk(self, nodes: Sequence[int]) -> None:
        """Make the images of ``nodes`` from the inside out."""
        wanted = set(nodes)
        for node in range(max(nodes, default=-1), -1, -1):
            if node in wanted and node not in self._images:
                wanted.update(self._used(node))
        for node in sorted(wanted):
            self.image(node)

    def _used(self, node: int) -> tuple[int, ...]:
        """The nodes whose images make that of a node: abs(f)**2 is f conj(f)."""
        match self.nodes.all[node]:
            case ("Pow", base, exponent) if exponent.q == 1 and exponent.p % 2 == 0:
                inner = self.nodes.all[base]
                return (inner[1],) if inner[0] == "Abs" else (base,)
        return children(self.nodes.all[node])

    def image(self, node: int) -> Element:
        """The image of a node; raises CertificateError where it does not follow from generators."""
        if node not in self._images:
            if node in self._underway:
                raise CertificateError("an image must not be made of itself")
            self._underway.add(node)
            try:
                self._images[node] = self._image(node)
            finally:
                self._underway.remove(node)
        return self._images[node]

    def equal(self, left: int, right: int) -> bool:
        """Whether two nodes have the same image."""
        return left == right or (self.image(left) - self.image(right)).is_zero

    def made(self, name: str, *arguments: int | fmpq) -> Element:
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
        alike = (atom for atom in self.atoms(self.nodes.all[node][0]) if self._alike(node, atom))
        return next((self._images[atom] for atom in alike), None)

    def moves(self, node: int) -> bool:
        """Whether a formula contains a variable of the equation."""
        return any(inner in self.variables for inner in self.nodes.below([node]))

    def sum_of(self, function: int) -> Sum:
        """The combination that a hint gives for a function's argument, checked."""
        found, z = self.hinted(self.hints.sums, function), self.nodes.all[function][1]
        found = self._turned_sum(function) if found is None else found
        if found is None:
            raise CertificateError("there is no generator for a function of a sum")
        parts = [self.ring.number(n) * self.image(u) for n, u in found]
        if not (self.sum([self.zero, *parts]) - self.image(z)).is_zero:
            raise CertificateError("an argument is not the sum that it is said to be")
        return found

    def _turned_sum(self, function: int) -> Sum | None:
        """The combination that a hint gives for the opposite argument, turned round."""
        name, z, *rest = self.nodes.all[function]
        opposite = self.nodes.made(name, self.nodes.made("Mul", self.nodes.rational(-1), z), *rest)
        found = self.hinted(self.hints.sums, opposite)
        return None if found is None else tuple((-n, u) for n, u in found)

    def named(self, node: int) -> int:
        """The node that a hint says is the value of ``node``."""
        found = self.hinted(self.hints.values, node)
        if found is None:
            raise CertificateError(f"there is no generator for a {self.nodes.all[node][0]}")
        return found

    def hinted(self, table: Mapping[int, Hint], node: int) -> Hint | None:
        """What a table of hints has of a node, or of the same function of equal arguments."""
        if node in table:
            return table[node]
        return next((table[other] for other in table if self._alike(node, other)), None)

    def _alike(self, node: int, other: int) -> bool:
        """Whether two nodes are the same function of arguments of equal images."""
        left, right = self.nodes.all[node], self.nodes.all[other]
        inner, outer = children(left), children(right)
        if left[0] != right[0] or left[len(inner) + 1 :] != right[len(outer) + 1 :]:
            return False
        try:
            return all(self.equal(a, b) for a, b in zip(inner, outer, strict=True))
        except CertificateError:  # a hint for a node that the proof has no generator for
            return False

    def squared(self, inner: int) -> Element:
        """abs(f)**2 = f conj(f)."""
        return self.image(inner) * self.image(self.signs.conjugate(inner))

    def _image(self, node: int) -> Element:
        match self.nodes.all[node]:
            case ("number", value):
                return self.ring.number(value)
            case ("Add", *terms):
                return self.sum([self.image(term) for term in terms])
            case ("Mul", *factors):
                return self.product([self.image(factor) for factor in factors])
            case ("Pow", base, exponent):
                return self._power(node, base, int(exponent.p), int(exponent.q))
            case ("symbol", name, _):
                raise CertificateError(f"there is no generator for the symbol {name}")
            case (name,):
                raise CertificateError(f"there is no generator for {name}")
        return self._function(node)

    def _power(self, node: int, base: int, p: int, q: int) -> Element:
        if q != 1:
            if p != 1:
                return self.image(self.nodes.made("Pow", base, fmpq(1, q))) ** p
            return self._function(node)
        inner = self.nodes.all[base]
        if inner[0] == "Abs" and p % 2 == 0:
            return self.squared(inner[1]) ** (p // 2)
        return self.image(base) ** p

    @abstractmethod
    def slope(self, place: int, variable: int) -> Element:
        """The derivative of a generator."""

    @abstractmethod
    def derivative(self, element: Element, variable: int) -> Element:
        """The derivative of an element, of which all generators' slopes follow from the axioms."""

    @abstractmethod
    def is_kept(self, name: str, f: int, value: int) -> bool:
        """Whether ``value``, of which the function is ``f``, is principal by continuity."""

    @abstractmethod
    def _function(self, node: int) -> Element:
        """The image of a root or function, which is no sum, product or integer power."""


def integer_of(value: fmpq) -> int:
    """The integer that a coefficient in a sum of arguments must be."""
    if value.q != 1:
        raise CertificateError("coefficients in a sum of arguments must be integers")
    within("coefficients", abs(int(value.p)), EXPONENT)
    return int(value.p)
