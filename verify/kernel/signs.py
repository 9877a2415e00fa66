"""Signs, conjugates and smoothness of formulas, derived from the inequalities of a domain.

Signs are those of intervals, which are derived from the structure of formulas and the inequalities
of the domain.  An expression such as 1 - k**2 is decided by a witness: a formula with the same
image, (1 - k)(1 + k), whose structure shows the sign.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import reduce
from operator import add, mul

from flint import fmpq

from .axioms import FUNCTIONS, HALF_PI, Function
from .bounds import POSITIVE, UNIT, Interval, of_constant
from .limits import CertificateError
from .node_balls import Balls, constant
from .nodes import Nodes, children
from .ring import Element

ANALYTIC = ("number", "symbol", "I", "pi", "Add", "Mul", "Pow")
"""Nodes that are analytic if their arguments are, except for poles and for roots."""


class Signs:
    """Signs, conjugates and smoothness of a table's nodes on the domain of a statement.

    ``positive`` has the nodes that the domain states to be > 0 (True: >= 0).  ``witnesses`` maps a
    node to one with the same ``image``, whose structure shows the sign.
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
        self._constants = Balls(nodes, {})

    def is_real(self, node: int) -> bool:
        """Return whether ``node`` is shown to be real."""
        if node not in self._real:
            self._real[node] = False
            self._real[node] = self._is_real(node)
        return self._real[node]

    def _is_real(self, node: int) -> bool:
        match self._nodes.all[node]:
            case ("number", _) | ("pi",) | (("Abs" | "re" | "im"), _):
                return True
            case ("symbol", _, kind):
                return bool(kind != "complex")
            case ("Pow", base, exponent):
                return self.not_negative(base) if exponent.q != 1 else self.is_real(base)
            case ("power", base, exponent):
                return self.not_negative(base) and self.is_real(exponent)
            case (("bessel_j" | "bessel_i"), v, z) if self._nodes.is_integer(v):
                return self.is_real(z)
            case (("Add" | "Mul"), *inner):
                return all(map(self.is_real, inner))
            case (str(name), *_) if name in FUNCTIONS and FUNCTIONS[name].values is not None:
                arguments = children(self._nodes.all[node])
                own, z = FUNCTIONS[name], arguments[FUNCTIONS[name].letters.find("z")]
                inside = own.between == (None, None) or self.is_between(z, *own.between)
                real = all(map(self.is_real, arguments))
                return inside and real and not self.needed(name, *arguments)
        return False

    def needed(self, name: str, *arguments: int) -> str:
        """Return a condition on a function's parameter that is not shown, as "m < 1"; else ""."""
        own = FUNCTIONS[name]
        if own.below_one and not all(map(self.below_one, own.parameters(*arguments))):
            return "m < 1"
        if own.above_zero and not all(map(self.positive, own.parameters(*arguments))):
            return "m > 0"
        return ""

    def positive(self, node: int) -> bool:
        """Return whether ``node`` is shown to be real and greater than 0."""
        return self.interval(node).is_positive

    def not_negative(self, node: int) -> bool:
        """Return whether ``node`` is shown to be real and at least 0."""
        return self.interval(node).is_not_negative

    def below_one(self, m: int) -> bool:
        """Return whether ``m`` is shown to be real and less than 1."""
        return self.positive(self._nodes.gap(m, self._nodes.rational(1)))

    def is_between(self, node: int, low: fmpq | None, high: fmpq | None) -> bool:
        """Return whether ``node`` is shown to be real with low <= node <= high (None: no bound)."""
        add, gap = self._nodes.add, self._nodes.gap
        gaps = [] if low is None else [gap(add("number", low), node)]
        gaps += [] if high is None else [gap(node, add("number", high))]
        return self.is_real(node) and all(map(self.not_negative, gaps))

    def interval(self, node: int) -> Interval:
        """Return an interval of a node's values; unbounded if the node is not shown to be real."""
        if not self.is_real(node):
            return Interval()
        if node not in self._intervals:
            self._intervals[node] = Interval()  # no rule asks for its own node
            bounds = self._interval(node) & self._stated(node)
            if node in self._witnesses and not bounds.is_not_zero:
                other = self._witnesses[node]
                if node != other and not (self._image(node) - self._image(other)).is_zero:
                    raise CertificateError("the witness of a sign has another image")
                witnessed = self.interval(other)  # an open end is where the witness is defined
                ends = Interval(witnessed.low, witnessed.high)
                bounds = bounds & (witnessed if self.is_bounded(other) else ends)
            self._intervals[node] = bounds
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
            case ("exp", z):
                return self.interval(z).exponential()
            case ("cos", z) if self.is_between(z, -HALF_PI, HALF_PI):
                return POSITIVE & UNIT
            case ("sin", z) if self.is_between(z, fmpq(0), 2 * HALF_PI):
                return UNIT & Interval(fmpq(0), None, self.positive(z))
            case ("jacobi_dn", _, m) if self.below_one(m):
                return POSITIVE & UNIT if self.not_negative(m) else POSITIVE
            case (str(name), z, *_) if name in FUNCTIONS:
                own = FUNCTIONS[name]
                whole = own.values or Interval()
                return whole & self.interval(z).side() if own.symmetry == "same" else whole
        return Interval()

    def _stated(self, node: int) -> Interval:
        """Return the bounds of a node by inequalities of the domain for it, or for r * node + c."""
        result = Interval()
        if node in self._positive:
            result = Interval(fmpq(0), None, not self._positive[node])
        linear = self._nodes.all[node][0] in ("Add", "Mul", "symbol")
        for bound, weak in self._positive.items() if linear else ():
            result = result & self._beside_constant(node, bound, weak)
            try:
                multiple = _multiple(self._image(node), self._image(bound))
            except CertificateError:  # what the proof has no generator for
                continue
            if multiple is not None:
                ratio, gap = multiple
                up, down = Interval(gap, None, not weak), -Interval(-gap, None, not weak)
                result = result & (up if ratio > 0 else down)
        return result

    def _beside_constant(self, node: int, bound: int, weak: bool) -> Interval:
        """Return bounds of a node if ``bound``, node + c or c - node, is > 0 (>= 0 if ``weak``)."""
        terms = self._nodes.terms(bound)
        rest = [term for term in terms if self._nodes.is_constant(term)]
        moving = [term for term in terms if term not in rest]
        if rest and moving in ([node], [self._nodes.negative(node)]):
            gap = self.interval(rest[0] if len(rest) == 1 else self._nodes.add("Add", *rest))
            if gap.high is not None:
                above = Interval(-gap.high, None, not weak)
                below = Interval(None, gap.high, False, not weak)
                return above if moving == [node] else below
        return Interval()

    def conjugate(self, node: int) -> int:
        """Return the node of the complex conjugate; raises CertificateError if no rule gives it."""
        add, inside = self._nodes.add, self.conjugate
        if self.is_real(node):
            return node
        match self._nodes.all[node]:
            case ("I",):
                return self._nodes.negative(node)
            case ("symbol", _, "complex"):
                return add("conjugate", node)
            case (("Add" | "Mul") as name, *parts):
                return add(name, *map(inside, parts))
            case ("Pow", base, exponent) if exponent.q == 1:
                return add("Pow", inside(base), exponent)
            case ("conjugate", inner):
                return int(inner)
            case ("sign", _):  # of modulus 1 wherever it is defined
                return add("Pow", node, fmpq(-1))
            case ("diff", inner, *variables):
                return add("diff", inside(inner), *variables)
            case (str(name), z, *rest) if name in FUNCTIONS:
                through = FUNCTIONS[name].kind in ("entire", "regular", "poles")
                if through and all(map(self.is_real, children(self._nodes.all[node])[1:])):
                    return add(name, inside(z), *rest)
        name = self._nodes.all[node][0]
        raise CertificateError(f"the conjugate of {name} does not follow from the domain")

    def is_analytic(self, node: int) -> bool:
        """Return whether a formula is analytic on the whole domain except for isolated poles."""
        return all(map(self._is_analytic, self._nodes.below([node])))

    def _is_analytic(self, node: int) -> bool:
        name, *arguments = self._nodes.all[node]
        if name in ANALYTIC:
            root = name == "Pow" and arguments[1].q != 1
            return not root or (self.positive(arguments[0]) and self.is_bounded(arguments[0]))
        own = FUNCTIONS.get(name, Function("jump"))
        if name.startswith(("jacobi_", "elliptic_")):
            return not own.below_one or self.is_bounded(arguments[-1])
        return own.kind == "entire"

    def is_bounded(self, node: int) -> bool:
        """Return whether a formula and its witnesses evidently have no poles or jumps.

        Only then is a sign sure at every point of the domain: 1/(1 + 1/x**2) is 0 at x = 0.
        """
        todo, visited = [node], set[int]()
        while todo:
            new = set(self._nodes.below([todo.pop()])) - visited
            if not all(map(self._is_tame, new)):
                return False
            visited |= new
            todo += [self._witnesses[inner] for inner in new if inner in self._witnesses]
        return True

    def _is_tame(self, node: int) -> bool:
        name, *arguments = self._nodes.all[node]
        if name in ANALYTIC:
            return name != "Pow" or arguments[1] > 0 or self.interval(arguments[0]).is_not_zero
        if constant(self._nodes, node) is not None:
            return True
        own = FUNCTIONS.get(name, Function("jump"))
        parameters = own.parameters(*children(self._nodes.all[node])) if own.below_one else []
        tame = own.kind in ("regular", "arc") and self.is_real(node)
        tame = tame and all(map(self._nodes.is_constant, parameters))  # it may be 1 somewhere
        return tame or own.kind in ("entire", "tame")


def _multiple(element: Element, other: Element) -> tuple[fmpq, fmpq] | None:
    """Return rational r != 0 and c with ``element = r * other + c``; None if there are none."""
    above, below = element.numerator, other.numerator
    if element.powers or other.powers or above.is_constant() or below.is_constant():
        return None
    ratio = above.leading_coefficient() / below.leading_coefficient()
    gap = Element(element.ring, above - ratio * below).value
    return None if gap is None else (ratio, gap)
