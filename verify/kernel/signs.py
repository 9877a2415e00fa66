"""What a domain shows of formulas: signs, conjugates, smoothness.

Signs are those of intervals, which are derived from the structure of formulas and the inequalities
of the domain.  An expression such as 1 - k**2 is decided by a witness: a formula with the same
image, (1 - k)(1 + k), whose structure shows the sign.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from operator import add, mul

from flint import fmpq

from . import axioms
from .bounds import OF_REAL, POSITIVE, UNIT, Interval, of_constant, stated
from .limits import CertificateError
from .nodes import CYLINDER, Balls, Nodes
from .ring import Element

BELOW_ONE = ("elliptic_k", "elliptic_e", "jacobi_zeta", "jacobi_theta", "jacobi_eta")
"""Functions that are taken for m < 1 only."""

ODD = ("sinh", "tanh", "csch", "coth", "atan", "sign", "re", "conjugate")
"""Of the sign of their argument if that is real."""

REAL = (
    *ODD,
    *OF_REAL,
    *("tan", "cot", "sec", "csc", "jacobi_epsilon", "jacobi_zeta", "diff", "parity"),
    *(
        "airy_ai",
        "airy_ai_prime",
        "airy_bi",
        "airy_bi_prime",
        "weierstrass_p",
        "weierstrass_p_prime",
    ),
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
    *("lambert_w", "weierstrass_p", "weierstrass_p_prime", *CYLINDER, *BELOW_ONE),
)
"""Functions that may have poles or jumps at real arguments, or for m > 1."""

WITH_POLES = ("tanh", "sech", "atan", "jet")
"""Functions that have poles or jumps at complex arguments alone, besides those of Jacobi."""

CLEAN = ("number", "symbol", "I", "pi", "Add", "Mul", "exp", "elliptic_k", "elliptic_e")
"""Analytic functions, besides those of Jacobi."""

THROUGH = (
    *("exp", "erf", "airy_ai", "airy_ai_prime", "airy_bi", "airy_bi_prime"),
    *("weierstrass_p", "weierstrass_p_prime"),
    *(*axioms.HYPERBOLIC, *axioms.TRIGONOMETRIC),
)
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
        self._real: dict[int, bool] = {}
        self._intervals: dict[int, Interval] = {}
        pairs = (stated(nodes, node, weak) for node, weak in positive.items())
        self._known = [pair for pair in pairs if pair is not None]
        self._constants = Balls(nodes, {})

    def is_real(self, node: int) -> bool:
        """Whether ``node`` is shown to be real."""
        if node not in self._real:
            self._real[node] = False
            self._real[node] = self._is_real(node)
        return self._real[node]

    def sign(self, node: int) -> frozenset[int]:
        """The signs that a node may have if it is real; any if it is not shown to be."""
        found = self.interval(node)
        below = set[int]() if found.is_not_negative else {-1}
        above = set[int]() if (-found).is_not_negative else {1}
        zero = set[int]() if found.is_positive or (-found).is_positive else {0}
        return frozenset(below | zero | above)

    def positive(self, node: int) -> bool:
        """Whether ``node`` is shown to be real and greater than 0."""
        return self.interval(node).is_positive

    def not_negative(self, node: int) -> bool:
        """Whether ``node`` is shown to be real and at least 0."""
        return self.interval(node).is_not_negative

    def interval(self, node: int) -> Interval:
        """Where the values of a node are; anywhere if it is not shown to be real."""
        if not self.is_real(node):
            return Interval()
        if node not in self._intervals:
            self._intervals[node] = Interval()  # no rule asks for its own node
            found = self._interval(node) & self._stated(node)
            if node in self._witnesses and not (found.is_positive or (-found).is_positive):
                found = found & self.interval(self._witness(node))
            self._intervals[node] = found
        return self._intervals[node]

    def _interval(self, node: int) -> Interval:
        match self._nodes.all[node]:
            case ("number", value):
                return Interval(value, value)
            case _ if self._nodes.is_constant(node):
                return of_constant(self._constants.ball(node).real)
            case ("Add", *terms):
                return reduce(add, map(self.interval, terms))
            case ("Mul", *factors):
                return reduce(mul, map(self.interval, factors))
            case ("Pow", base, exponent):
                inner = self.interval(base)
                return (inner if exponent.q == 1 else inner.root()).power(int(exponent.p))
            case ("power", base, _):
                return Interval(fmpq(0), None, self.positive(base))
            case ("Abs", inner):
                return self.interval(inner).absolute()
            case (("elliptic_k" | "elliptic_e"), _):
                return POSITIVE
            case ("exp", z) if self.interval(z).is_below:
                return Interval(fmpq(0), fmpq(1), True, (-self.interval(z)).is_positive)
            case ("cos", z) if self.is_between(z, -HALF_PI, HALF_PI):
                return POSITIVE
            case ("sin", z) if self.is_between(z, fmpq(0), 2 * HALF_PI):
                return Interval(fmpq(0), None, self.positive(z))
            case ("jacobi_dn", z, m) if self.not_negative(m) and self.below_one(m):
                return POSITIVE & UNIT if self.is_real(z) else Interval()
            case (str(name), z, *m) if name in OF_REAL and all(map(self.is_real, (z, *m))):
                needs = name in ("jacobi_dn", "jacobi_theta") and not self.below_one(*m)
                return Interval() if needs else OF_REAL[name]
            case (("acos" | "acosh" | "lambert_w"), _):
                return Interval(fmpq(0))
            case (str(name), inner) if name in (*ODD, *INVERSE):
                return self.interval(inner).side()
        return Interval()

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
            case ("jet", *inner, tail):
                return made("jet", *map(inside, inner), tail)
            case (str(name), *inner) if name in THROUGH:
                return made(name, *map(inside, inner))
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
            case (("log" | "lambert_w"), inner):
                return self.not_negative(inner)
            case ("power", base, exponent):
                return self.not_negative(base) and self.is_real(exponent)
            case (str(name), inner) if name in INVERSE:
                return self.is_between(inner, *INVERSE[name])
            case ("jet", z, *nome, _):
                return self.is_real(z) and all(map(self.positive, nome))
            case (str(name), v, z) if name in CYLINDER:
                entire = name in ("bessel_j", "bessel_i") and self._nodes.is_integer(v)
                return self.is_real(v) and (self.positive(z) or (entire and self.is_real(z)))
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

    def _stated(self, node: int) -> Interval:
        """What the inequalities of the domain say of a node, or of a multiple plus a number."""
        found = Interval()
        for other, known in self._known:
            if other == node:
                found = found & known
        if node in self._positive:
            return found & Interval(fmpq(0), None, not self._positive[node])
        if self._nodes.all[node][0] not in ("Add", "Mul", "symbol") or self._nodes.is_constant(
            node
        ):
            return found
        for bound, weak in self._positive.items():
            try:
                multiple = _multiple(self._image(node), self._image(bound))
            except CertificateError:  # a formula of the domain that the proof has no generator for
                continue
            if multiple is not None:
                ratio, gap = multiple
                up, down = Interval(gap, None, not weak), Interval(None, gap, False, not weak)
                found = found & (up if ratio > 0 else down)
        return found

    def _witness(self, node: int) -> int:
        """The formula with the same image that a hint names, checked."""
        other = self._witnesses[node]
        if node != other and not (self._image(node) - self._image(other)).is_zero:
            raise CertificateError("the witness of a sign has another image")
        return other


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
