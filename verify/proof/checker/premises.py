"""What the use of an axiom rests on: signs that a domain states, formulas without poles."""

from __future__ import annotations

from collections.abc import Mapping

from flint import fmpq

from .images import ANY, BELOW_ONE, NOT_NEGATIVE, POSITIVE, Images, Sign
from .limits import CertificateError
from .nodes import Balls
from .ring import Element

HALF_PI = fmpq(15707963, 10**7)
"""A little less than pi/2."""


class StatedSigns:
    """What the inequalities of a domain say.

    ``positive`` are the nodes that the domain states to be positive (True: or 0).
    """

    def __init__(self, images: Images, positive: Mapping[int, bool]) -> None:
        self._images, self._positive = images, positive

    def sign(self, node: int) -> Sign:
        """The sign that an inequality of the domain gives a node with the same image."""
        images = self._images
        if node in self._positive:
            return Sign((0, 1)) if self._positive[node] else Sign((1,))
        match images.nodes.all[node]:
            case ("cos", z) if self.is_between(z, -HALF_PI, HALF_PI):
                return POSITIVE
            case ("sin", z) if self.is_between(z, fmpq(0), 2 * HALF_PI):
                return POSITIVE if images.signs.positive(z) else NOT_NEGATIVE
        if images.nodes.all[node][0] not in ("Add", "Mul", "symbol"):
            return ANY
        if all(images.nodes.all[inner][0] != "symbol" for inner in images.nodes.below([node])):
            value = Balls(images.nodes, {}).ball(node).real
            return Sign((1 if value > 0 else -1,)) if value > 0 or value < 0 else ANY
        for bound, weak in self._positive.items():
            try:
                found = _multiple(images.image(node), images.image(bound))
            except CertificateError:  # a formula of the domain that the proof has no generator for
                continue
            if found is not None:
                ratio, gap = found
                side = 1 if ratio > 0 else -1
                if gap * side >= 0:
                    return Sign((0, side)) if weak and gap == 0 else Sign((side,))
        return ANY

    def witness(self, node: int) -> int | None:
        """The formula with the same image that a hint names, checked."""
        images = self._images
        other = images.hints.signs.get(node)
        if other is None:
            return None
        if not images.equal(node, other):
            raise CertificateError("the witness of a sign has another image")
        return other

    def is_between(self, node: int, low: fmpq, high: fmpq) -> bool:
        """Whether ``node`` is shown to be real and not outside two rational numbers."""
        images = self._images
        made, number = images.nodes.made, images.nodes.rational
        negative = made("Mul", number(-1), node)
        above = made("Add", node, number(-int(low.p), int(low.q)))
        below = made("Add", negative, number(int(high.p), int(high.q)))
        return images.signs.not_negative(above) and images.signs.not_negative(below)


def _multiple(element: Element, other: Element) -> tuple[fmpq, fmpq] | None:
    """Rational r, not 0, and c with ``element = r * other + c``."""
    above, below = element.numerator, other.numerator
    if element.powers or other.powers or above.is_constant() or below.is_constant():
        return None
    ratio = above.leading_coefficient() / below.leading_coefficient()
    gap = above - ratio * below
    if not gap.is_constant():
        return None
    return ratio, fmpq(0) if gap.is_zero() else gap.leading_coefficient()


UNBOUNDED = ("coth", "csch", "tan", "cot", "sec", "csc", "log", "sign")
"""Functions with poles or jumps at real arguments."""

CLEAN = ("number", "symbol", "I", "pi", "Add", "Mul", "poly", "exp", "elliptic_k", "elliptic_e")
"""Analytic functions, besides those of Jacobi."""


def is_clean(images: Images, node: int) -> bool:
    """Whether a formula is analytic on the whole domain but for isolated poles."""
    for inner in images.nodes.below([node]):
        name = images.nodes.all[inner][0]
        if name == "Pow":
            base, exponent = images.nodes.all[inner][1:]
            if exponent.q != 1 and not (images.signs.positive(base) and is_bounded(images, base)):
                return False
        elif name in BELOW_ONE:
            if not is_bounded(images, images.nodes.all[inner][-1]):
                return False
        elif name not in CLEAN and not name.startswith("jacobi_"):
            return False
    return True


def is_bounded(images: Images, node: int) -> bool:
    """Whether a formula, with the witnesses of its sign, has evidently no poles or jumps.

    Then it is positive at every point if it is shown to be; 1/(1 + 1/x**2) is 0 at 0.
    """
    todo, seen = [node], set()
    while todo:
        for inner in images.nodes.below([todo.pop()]):
            if inner in seen:
                continue
            seen.add(inner)
            name, *arguments = images.nodes.all[inner]
            if name == "Pow" and arguments[1] < 0 and 0 in images.signs.sign(arguments[0]):
                return False
            complex_jacobi = name.startswith("jacobi_") and not images.signs.is_real(inner)
            if complex_jacobi or name in (*UNBOUNDED, *BELOW_ONE):
                return False
            if inner in images.hints.signs:
                todo.append(images.hints.signs[inner])
    return True
