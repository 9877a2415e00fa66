"""What a domain shows of formulas: signs, conjugates, smoothness.

Signs are derived from the structure of formulas and the inequalities of the domain.  A sign is a
set of the values -1, 0, 1 that a formula may have the sign of.  An expression such as 1 - k**2 is
decided by a witness: a formula with the same image, (1 - k)(1 + k), whose structure shows the sign.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from itertools import product
from operator import add, mul

from flint import fmpq

from . import axioms
from .bounds import OF_REAL, Interval, of_constant, stated
from .limits import CertificateError
from .nodes import Balls, Nodes
from .ring import Element

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
    *("diff", "parity"),
)
"""Real where their arguments are real."""

INVERSE: Mapping[str, tuple[fmpq | None, fmpq | None]] = {
    "asin": (fmpq(-1), fmpq(1)),
    "acos": (fmpq(-1), fmpq(1)),
    "atanh": (fmpq(-1), fmpq(1)),
    "acosh": (fmpq(1), None),
    "asinh": (None, None),
}
"""Between which real arguments an inverse function is real."""

UNBOUNDED = (
    *INVERSE,
    *("coth", "csch", "tan", "cot", "sec", "csc", "log", "sign", "power", "parity", "diff"),
    *BELOW_ONE,
)
"""Functions that may have poles or jumps at real arguments, or for m > 1."""

WITH_POLES = ("tanh", "sech", "atan")
"""Functions that have poles or jumps at complex arguments alone, besides those of Jacobi."""

CLEAN = ("number", "symbol", "I", "pi", "Add", "Mul", "exp", "elliptic_k", "elliptic_e")
"""Analytic functions, besides those of Jacobi."""

THROUGH = ("exp", *axioms.HYPERBOLIC, *axioms.TRIGONOMETRIC)
"""Functions that take conjugates to conjugates."""

HALF_PI = fmpq(15707963, 10**7)
"""A little less than pi/2."""


class Signs:
    """What a domain tells of the nodes of a table.

    ``positive`` are the nodes that it states to be positive (True: or 0).  ``witnesses`` maps a
    node to another with the same ``image``.
    """

    def __init__(
        self,
        nodes: Nodes,
        image: Callable[[int], Element],
        positive: Mapping[int, bool],
        witnesses: Mapping[int, int],
    ) -> None:
        self._nodes, self._image = nodes, image
        self._positive, self._witnesses = positive, witnesses
        self._signs: dict[int, Sign] = {}
        self._real: dict[int, bool] = {}
        self._intervals: dict[int, Interval] = {}
        pairs = (stated(nodes, node, weak) for node, weak in positive.items())
        self._known = [pair for pair in pairs if pair is not None]

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
            if len(found) != 1 and node in self._witnesses:
                found &= self.sign(self._witness(node))
            self._signs[node] = found
        return self._signs[node]

    def positive(self, node: int) -> bool:
        """Whether ``node`` is shown to be real and greater than 0."""
        return self.is_real(node) and self.sign(node) <= POSITIVE

    def not_negative(self, node: int) -> bool:
        """Whether ``node`` is shown to be real and at least 0."""
        return self.is_real(node) and self.sign(node) <= NOT_NEGATIVE

    def interval(self, node: int) -> Interval:
        """Where the values of a node are that is shown to be real."""
        if node not in self._intervals:
            self._intervals[node] = Interval()  # no rule asks for its own node
            found = self._interval(node)
            for other, known in self._known:
                if other == node:
                    found = found & known
            if self.sign(node) <= NOT_NEGATIVE:
                found = found & Interval(fmpq(0), None, self.sign(node) <= POSITIVE)
            self._intervals[node] = found
        return self._intervals[node]

    def _interval(self, node: int) -> Interval:
        if not self.is_real(node):
            return Interval()
        match self._nodes.all[node]:
            case ("number", value):
                return Interval(value, value)
            case ("Add", *terms):
                return reduce(add, map(self.interval, terms))
            case ("Mul", *factors):
                return reduce(mul, map(self.interval, factors))
            case ("Pow", base, exponent):
                if exponent.q == 1:
                    return self.interval(base).power(int(exponent.p))
                root = self.interval(base).root()
                return root.power(int(exponent.p))
            case ("Abs", inner):
                return self.interval(inner).absolute()
            case ("jacobi_dn", _, m) if self.below_one(m) and self.not_negative(m):
                return Interval(fmpq(0), fmpq(1), True)
            case ("symbol", *_):
                return Interval()
            case (str(name), *inner) if name in OF_REAL and all(map(self.is_real, inner)):
                return OF_REAL[name]
        if self._is_constant(node):
            return of_constant(Balls(self._nodes, {}).ball(node).real)
        return Interval()

    def _is_constant(self, node: int) -> bool:
        return all(self._nodes.all[inner][0] != "symbol" for inner in self._nodes.below([node]))

    def below_one(self, m: int) -> bool:
        """Whether ``m`` is shown to be real and less than 1."""
        made = self._nodes.made
        negative = made("Mul", self._nodes.rational(-1), m)
        return self.positive(made("Add", self._nodes.rational(1), negative))

    def is_between(self, node: int, low: fmpq | None, high: fmpq | None) -> bool:
        """Whether ``node`` is shown to be real and not outside two rational numbers (None: any)."""
        made, number = self._nodes.made, self._nodes.rational
        gaps = []
        if low is not None:
            gaps.append(made("Add", node, number(-int(low.p), int(low.q))))
        if high is not None:
            negative = made("Mul", number(-1), node)
            gaps.append(made("Add", negative, number(int(high.p), int(high.q))))
        return self.is_real(node) and all(map(self.not_negative, gaps))

    def conjugate(self, node: int) -> int:
        """The complex conjugate of a node as a node."""
        made, inside = self._nodes.made, self.conjugate
        if self.is_real(node):
            return node
        match self._nodes.all[node]:
            case ("I",):
                return made("Mul", self._nodes.rational(-1), node)
            case (("Add" | "Mul") as name, *parts):
                return made(name, *map(inside, parts))
            case ("Pow", base, exponent) if exponent.q == 1:
                return made("Pow", inside(base), exponent)
            case ("conjugate", inner):
                return int(inner)
            case ("diff", inner, *variables):
                return made("diff", inside(inner), *variables)
            case (str(name), inner) if name in THROUGH:
                return made(name, inside(inner))
            case (("jacobi_sn" | "jacobi_cn" | "jacobi_dn") as name, z, m) if self.is_real(m):
                return made(name, inside(z), m)
        name = self._nodes.all[node][0]
        raise CertificateError(f"the conjugate of {name} does not follow from the domain")

    def is_clean(self, node: int) -> bool:
        """Whether a formula is analytic on the whole domain but for isolated poles."""
        for inner in self._nodes.below([node]):
            name = self._nodes.all[inner][0]
            if name == "Pow":
                base, exponent = self._nodes.all[inner][1:]
                if exponent.q != 1 and not (self.positive(base) and self.is_bounded(base)):
                    return False
            elif name in BELOW_ONE:
                if not self.is_bounded(self._nodes.all[inner][-1]):
                    return False
            elif name not in CLEAN and not name.startswith("jacobi_"):
                return False
        return True

    def is_bounded(self, node: int) -> bool:
        """Whether a formula, with the witnesses of its sign, has evidently no poles or jumps.

        Then it is positive at every point if it is shown to be; 1/(1 + 1/x**2) is 0 at 0.
        """
        todo, seen = [node], set()
        while todo:
            for inner in self._nodes.below([todo.pop()]):
                if inner in seen:
                    continue
                seen.add(inner)
                name, *arguments = self._nodes.all[inner]
                if name == "Pow" and arguments[1] < 0 and 0 in self.sign(arguments[0]):
                    return False
                tame = name not in WITH_POLES and not name.startswith("jacobi_")
                if name in UNBOUNDED or not (tame or self.is_real(inner)):
                    return False
                if inner in self._witnesses:
                    todo.append(self._witnesses[inner])
        return True

    def _is_real(self, node: int) -> bool:
        match self._nodes.all[node]:
            case ("number", _) | ("pi",):
                return True
            case ("symbol", _, kind):
                return bool(kind != "complex")
            case ("Abs" | "re" | "im", _):
                return True
            case ("Pow", base, exponent):
                return self.not_negative(base) if exponent.q != 1 else self.is_real(base)
            case ("log", inner):
                return self.not_negative(inner)
            case ("power", base, exponent):
                return self.not_negative(base) and self.is_real(exponent)
            case (str(name), inner) if name in INVERSE:
                return self.is_between(inner, *INVERSE[name])
            case (str(name), *inner) if name in BELOW_ONE and not self.below_one(inner[-1]):
                return False
            case ("elliptic_k" | "elliptic_e", _):
                return True
            case ("jacobi_eta", z, m):
                return self.is_real(z) and self.not_negative(m)
            case (("Add" | "Mul"), *inner):
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
                found = _combined(lambda a, b: a + b, [self.sign(term) for term in terms])
                return found if found != ANY else self._of_interval(self._interval(node))
            case ("Mul", *factors):
                return _combined(lambda a, b: a * b, [self.sign(factor) for factor in factors])
            case ("Pow", base, exponent):
                return self._of_power(self.sign(base), exponent.p, exponent.q)
            case ("power", base, _):
                return self.sign(base) & NOT_NEGATIVE
            case ("Abs", inner):
                found = self.sign(inner) if self.is_real(inner) else ANY
                return Sign(abs(s) for s in found)
            case (str(name), *inner) if name in EVERYWHERE_POSITIVE and self.is_real(node):
                return POSITIVE if len(inner) == 1 or self.below_one(inner[1]) else ANY
            case (("acos" | "acosh"), _):
                return NOT_NEGATIVE
            case (str(name), inner) if name in (*ODD, *INVERSE) and self.is_real(inner):
                return self.sign(inner)
        return ANY

    def _of_interval(self, found: Interval) -> Sign:
        for side, values in ((1, found), (-1, -found)):
            if values.is_not_negative:
                return Sign((side,)) if values.is_positive else Sign((0, side))
        return ANY

    def _of_power(self, base: Sign, p: int, q: int) -> Sign:
        if q != 1:
            return base & NOT_NEGATIVE
        return Sign(s ** (2 - p % 2) if s else int(p == 0) for s in base)

    def _stated(self, node: int) -> Sign:
        """The sign that an inequality of the domain gives a node with the same image."""
        if node in self._positive:
            return Sign((0, 1)) if self._positive[node] else Sign((1,))
        match self._nodes.all[node]:
            case ("cos", z) if self.is_between(z, -HALF_PI, HALF_PI):
                return POSITIVE
            case ("sin", z) if self.is_between(z, fmpq(0), 2 * HALF_PI):
                return POSITIVE if self.positive(z) else NOT_NEGATIVE
        if self._nodes.all[node][0] not in ("Add", "Mul", "symbol"):
            return ANY
        if self._is_constant(node):
            value = Balls(self._nodes, {}).ball(node).real
            return Sign((1 if value > 0 else -1,)) if value > 0 or value < 0 else ANY
        for bound, weak in self._positive.items():
            try:
                found = _multiple(self._image(node), self._image(bound))
            except CertificateError:  # a formula of the domain that the proof has no generator for
                continue
            if found is not None:
                ratio, gap = found
                side = 1 if ratio > 0 else -1
                if gap * side >= 0:
                    return Sign((0, side)) if weak and gap == 0 else Sign((side,))
        return ANY

    def _witness(self, node: int) -> int:
        """The formula with the same image that a hint names, checked."""
        other = self._witnesses[node]
        if node != other and not (self._image(node) - self._image(other)).is_zero:
            raise CertificateError("the witness of a sign has another image")
        return other


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
