"""That the denominators of a proof are not 0 on a dense part of the domain.

A polynomial in functions that are analytic on a connected domain differs from 0 there if it is not
0 at one point.  Roots and absolute values may change branch inside the domain (|x| at 0); then the
product over all their branches is analytic, and every branch must differ from 0 at the point.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from math import prod

from flint import acb, ctx, fmpq, fmpq_mpoly

from .axioms import FUNCTIONS
from .field import Field
from .limits import BRANCHES, CertificateError, within
from .node_balls import BITS, Balls, value_at
from .nodes import Nodes
from .statement import Statement

Point = Mapping[int, fmpq]


class Denominators:
    """The check of the factors of a field's ring at a point of a statement's domain."""

    def __init__(self, field: Field, statement: Statement, point: Point) -> None:
        self._field, self._point = field, point
        self._connected = is_connected(field, statement)
        self._values: dict[tuple[tuple[int, fmpq], ...], list[acb]] = {}

    def check(self, factor: fmpq_mpoly) -> None:
        """Raise CertificateError if ``factor`` is not shown to differ from 0."""
        within_it = self._field.nodes.below(list(self._formulas(factor)))
        nodes = [node for node in within_it if not self._field.nodes.is_constant(node)]
        turning = [node for node in nodes if self._turns(node)]
        if turning and any(self._jumps(node) for node in nodes):
            raise CertificateError("a denominator has both a root and a logarithm that may jump")
        degrees = [self._degree(node) for node in turning]
        within("the branches of a denominator", prod(degrees), BRANCHES)
        for shares in product(*([fmpq(k, n) for k in range(n)] for n in degrees)):
            values = self._at(tuple(zip(turning, shares, strict=True)))
            with ctx.workprec(BITS):
                ball = value_at(factor, values)
            if not ball.is_finite() or ball.contains(0):
                raise CertificateError("a denominator is not shown to be other than 0 at the point")

    def _formulas(self, polynomial: fmpq_mpoly) -> set[int]:
        """What the generators stand for that occur, also in the scales of others."""
        degrees = polynomial.degrees()[::-1]
        found = [g for g, n in zip(self._field.generators, degrees, strict=False) if n]
        return {g.formula for g in found}.union(*(self._formulas(g.scale) for g in found))

    def _at(self, turns: tuple[tuple[int, fmpq], ...]) -> list[acb]:
        if turns not in self._values:
            conjugate = self._field.signs.conjugate if turns else None
            balls = Balls(self._field.nodes, self._point, dict(turns), conjugate)
            with ctx.workprec(BITS):
                self._values[turns] = self._field.balls(balls)
        return self._values[turns]

    def _turns(self, node: int) -> bool:
        """Whether a function may have another branch in another part of the domain."""
        match self._field.nodes.all[node]:
            case ("Pow", _, exponent) if exponent.q != 1:
                return not (self._connected and self._field.signs.is_analytic(node))
            case ("Abs" | "sign" | "parity", _):
                return True
        return False

    def _jumps(self, node: int) -> bool:
        match self._field.nodes.all[node]:
            case ("log", inner):
                root = self._field.nodes.made("Pow", inner, fmpq(1, 2))
                return not self._field.signs.is_analytic(root)
            case (str(name), *_) if name in FUNCTIONS and FUNCTIONS[name].kind in ("arc", "cut"):
                return not self._field.signs.is_real(node)
        return False

    def _degree(self, node: int) -> int:
        name, *_, last = self._field.nodes.all[node]
        return int(last.q) if name == "Pow" else 2


def is_connected(field: Field, statement: Statement) -> bool:
    """Whether the domain is evidently connected.

    Linear inequalities give a convex one; s < K(m), m < 1, may bound one symbol s more that has
    nothing but numbers <= 0 below it.
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
    """Whether an end of the domain is evidently real and continuous: no point of it is alone."""
    signs, nodes = field.signs, field.nodes
    name, *arguments = nodes.all[node]
    if name == "elliptic_k":
        return signs.below_one(arguments[0]) and is_continuous_end(field, arguments[0])
    return signs.is_bounded(node) and all(map(signs.is_real, nodes.below([node])))


def is_linear(nodes: Nodes, node: int) -> bool:
    """Whether a node is evidently of degree 1 or less in real symbols."""
    match nodes.all[node]:
        case ("number" | "pi", *_):
            return True
        case ("symbol", _, kind):
            return bool(kind != "complex")
        case ("Add", *terms):
            return all(is_linear(nodes, term) for term in terms)
        case ("Mul", *factors):
            moving = [f for f in factors if nodes.all[f][0] not in ("number", "pi")]
            return len(moving) <= 1 and all(is_linear(nodes, f) for f in moving)
    return False
