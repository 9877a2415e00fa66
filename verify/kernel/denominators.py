"""Check that the denominators of a proof are not 0 on a dense part of the domain.

A polynomial in functions that are analytic on a connected domain differs from 0 there if it is not
0 at one point.  Roots and absolute values may change branch inside the domain (|x| at 0); then the
product over all their branches is analytic, and every branch must differ from 0 at the point.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain, product
from math import prod

from flint import acb, ctx, fmpq, fmpq_mpoly

from .axioms import FUNCTIONS, Function
from .field import Field
from .limits import BRANCHES, CertificateError, within
from .node_balls import BITS, Balls, constant, value_at
from .nodes import Nodes, children
from .reading import axiom
from .statement import Statement, Substitution


class Denominators:
    """Check that no denominator's factor vanishes identically, by values at one point."""

    def __init__(self, field: Field, statement: Statement, point: Mapping[int, fmpq]) -> None:
        self._field, self._statement, self._point = field, statement, point
        self._connected = is_connected(field, statement)
        self._values: dict[tuple[tuple[int, fmpq], ...], list[acb]] = {}

    def check(self, factor: fmpq_mpoly) -> None:
        """Raise CertificateError unless ``factor`` is shown to be nonzero on every branch."""
        within_it = self._field.nodes.below(list(self._formulas(factor)))
        nodes = [node for node in within_it if not self._field.nodes.is_constant(node)]
        turning = [node for node in nodes if self._turns(node)]
        if any(self._jumps(node) for node in nodes):
            if turning:
                raise CertificateError("a denominator has both a root and a function that may jump")
            if factor not in self._own:
                raise CertificateError("a denominator that may jump is none of the statement's")
        turns = [self._field.nodes.all[node] for node in turning]
        degrees = [int(turn[2].q) if turn[0] == "Pow" else 2 for turn in turns]
        within("the branches of a denominator", prod(degrees), BRANCHES)
        for fractions in product(*([fmpq(k, n) for k in range(n)] for n in degrees)):
            values = self._at(tuple(zip(turning, fractions, strict=True)))
            with ctx.workprec(BITS):
                ball = value_at(factor, values)
            if not ball.is_finite() or ball.contains(0):
                raise CertificateError("a denominator is not shown to be other than 0 at the point")

    @cached_property
    def _own(self) -> list[fmpq_mpoly]:
        """Factors that are accepted although functions in them may jump.

        They are 0 only where the statement is not smooth, or almost nowhere: divisors and arguments
        of logarithms in the statement (a part, without unknowns, has none) and in the definitions
        of its functions; exponentials, which are nowhere 0; and, if f does not jump, W(f), 0 where
        f is 0, and 1 + W(f), 0 at the branch point of W.
        """
        field, nodes, own = self._field, self._field.nodes, self._statement
        put = Substitution(nodes, own.variables, own.formulas)
        stated = [*own.formulas, *map(put, own.equations)] if own.unknowns else []
        singular = [*_divisors(nodes, stated), *field.primitives("exp")]
        for node in field.primitives("lambert_w"):
            if not any(map(self._jumps, nodes.below(nodes.all[node][1:]))):
                singular += [node, nodes.add("Add", node, nodes.rational(1))]
        images = (field.image(node) for node in singular)
        powers = [field.ring.split(i.numerator)[1] for i in images if not i.is_zero]
        return [field.ring.factors[place] for place in chain.from_iterable(powers)]

    def _formulas(self, polynomial: fmpq_mpoly) -> set[int]:
        """Return the formulas of the generators in a polynomial, also of those in their scales."""
        degrees = polynomial.degrees()[::-1]
        occurring = [g for g, n in zip(self._field.generators, degrees, strict=False) if n]
        return {g.formula for g in occurring}.union(*(self._formulas(g.scale) for g in occurring))

    def _at(self, turns: tuple[tuple[int, fmpq], ...]) -> list[acb]:
        if turns not in self._values:
            conjugate = self._field.signs.conjugate if turns else None
            balls = Balls(self._field.nodes, self._point, dict(turns), conjugate)
            with ctx.workprec(BITS):
                self._values[turns] = self._field.balls(balls)
        return self._values[turns]

    def _turns(self, node: int) -> bool:
        """Return whether a root, absolute value or sign may change its branch within the domain."""
        match self._field.nodes.all[node]:
            case ("Pow", _, exponent) if exponent.q != 1:
                return not (self._connected and self._field.signs.is_analytic(node))
            case ("Abs" | "sign" | "parity", _):
                return True
        return False

    def _jumps(self, node: int) -> bool:
        """Return whether a function may differ from its continuation in some part of the domain."""
        nodes, signs = self._field.nodes, self._field.signs
        name, inner = nodes.all[node][0], children(nodes.all[node])
        own = FUNCTIONS.get(name)
        if own is None or not (own.below_one or own.kind in ("arc", "cut")):
            return False
        if own.below_one:
            return not (self._connected and all(map(signs.is_bounded, own.parameters(*inner))))
        z = inner[own.letters.index("z")]
        off_cut = signs.is_real(node) if own.kind == "arc" else own.free and signs.positive(z)
        return not (self._connected and off_cut and signs.is_bounded(z))


def _divisors(nodes: Nodes, stated: Sequence[int]) -> Iterator[int]:
    """Yield divisors and arguments of logarithms in the ``stated`` nodes and their definitions."""
    waiting, visited = list(stated), set[int]()
    while waiting:
        new = set(nodes.below(waiting)) - visited
        visited, waiting = visited | new, []
        for node in new:
            name, *inner = nodes.all[node]
            if name == "log" or (name == "Pow" and inner[1] < 0):
                yield inner[0]
            own = FUNCTIONS.get(name, Function("jump"))
            text = own.slope if name == "atan" else own.definition
            if text:
                waiting.append(axiom(nodes, text, **own.arguments(*inner)))


def is_connected(field: Field, statement: Statement) -> bool:
    """Return whether the domain is evidently connected.

    Linear inequalities define a convex domain.  A symbol s may also be bounded by s < K(m), m < 1,
    if its only other bounds are lower ones by numbers <= 0.
    """
    nodes = field.nodes
    for place, (_, left, right) in enumerate(statement.domain):
        if is_linear(nodes, left) and is_linear(nodes, right):
            continue
        rest = [ends for i, (_, *ends) in enumerate(statement.domain) if i != place]
        match nodes.all[left], nodes.all[right]:
            case ("symbol", *_), ("elliptic_k", m) if is_continuous_end(field, right):
                others = [ends for ends in rest if left in nodes.below(ends)]
                lower = [nodes.value(low) for low, high in others if high == left]
                alone = len(lower) == len(others) and left not in nodes.below([m])
                if alone and all(value is not None and value <= 0 for value in lower):
                    continue
        return False
    return True


def is_continuous_end(field: Field, node: int) -> bool:
    """Return whether a node that bounds the domain is evidently real and continuous."""
    signs, nodes = field.signs, field.nodes
    name, *arguments = nodes.all[node]
    if name == "elliptic_k":
        return signs.below_one(arguments[0]) and is_continuous_end(field, arguments[0])
    return signs.is_bounded(node) and all(map(signs.is_real, nodes.below([node])))


def is_linear(nodes: Nodes, node: int) -> bool:
    """Return whether a node is evidently of degree 1 or less in real symbols."""
    match nodes.all[node]:
        case ("number", _):
            return True
        case ("symbol", _, kind):
            return bool(kind != "complex")
        case ("Add", *terms):
            return all(is_linear(nodes, term) for term in terms)
        case ("Mul", *factors):
            moving = [f for f in factors if not nodes.is_constant(f)]
            return len(moving) <= 1 and all(is_linear(nodes, f) for f in factors)
    value = constant(nodes, node)  # a real number without a symbol, such as log(2)
    return value is not None and bool(value.imag == 0)
