"""Whether the denominators of a proof differ from 0 on a dense part of the domain.

A polynomial in functions that are analytic on a connected domain does so if it is not 0 at one
point.  Roots and absolute values may change branch inside the domain (|x| at 0); then the product
over all their branches is analytic, and every branch must differ from 0 at the point.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from math import prod

from flint import acb, arb, ctx, fmpq, fmpq_mpoly

from .field import Field
from .generators import Generator
from .limits import BRANCHES, CertificateError, within
from .points import BITS, Balls, excludes_zero
from .smoothness import is_clean
from .statement import Statement

Point = Mapping[int, fmpq]


class Branches(Balls):
    """Balls with other branches of some roots and absolute values.

    Complex conjugates are continued with them, by the formulas that they have on the domain.
    """

    def __init__(self, field: Field, point: Point, turns: Mapping[int, fmpq]) -> None:
        super().__init__(field.nodes, point)
        self._field, self._turns = field, turns

    def _ball(self, node: int) -> acb:
        match self._nodes.all[node]:
            case ("Pow", base, exponent) if node in self._turns:
                root = _some_root(self.ball(base), int(exponent.q)) * self._unit(node)
                return root ** int(exponent.p)
            case ("Abs", inner) if node in self._turns:
                return (self.ball(inner) * self._conjugate(inner)).sqrt() * self._unit(node)
            case ("conjugate", inner):
                return self._conjugate(inner)
            case ("re", inner):
                return (self.ball(inner) + self._conjugate(inner)) / 2
            case ("im", inner):
                return (self.ball(inner) - self._conjugate(inner)) / acb(0, 2)
            case ("sign", inner) if node in self._turns:
                size = (self.ball(inner) * self._conjugate(inner)).sqrt()
                return self.ball(inner) / size * self._unit(node)
        return super()._ball(node)

    def _conjugate(self, inner: int) -> acb:
        return self.ball(self._field.conjugate(inner))

    def _unit(self, node: int) -> acb:
        return (acb(0, 2) * acb.pi() * acb(arb(self._turns[node]))).exp()


def _some_root(value: acb, degree: int) -> acb:
    """A root, off the cut; all branches are tried anyway."""
    if value.real < 0:
        return (-value).root(degree) * (acb(0, 1) * acb.pi() / degree).exp()
    return value.root(degree)


class Denominators:
    """The check of the factors of a field's ring at a point of a statement's domain."""

    def __init__(self, field: Field, statement: Statement, point: Point) -> None:
        self._field, self._point = field, point
        self._connected = is_connected(field, statement)
        self._values: dict[tuple[tuple[int, fmpq], ...], list[acb]] = {}

    def check(self, factor: fmpq_mpoly) -> None:
        """Raise CertificateError if ``factor`` is not shown to differ from 0."""
        generators = self._generators(factor)
        within_them = self._field.nodes.below([node for g in generators for node in g.nodes])
        nodes = [node for node in within_them if not self._is_constant(node)]
        turning = [node for node in nodes if self._turns(node)]
        if turning and any(self._jumps(node) for node in nodes):
            raise CertificateError("a denominator has both a root and a logarithm that may jump")
        degrees_of = [self._degree(node) for node in turning]
        within("the branches of a denominator", prod(degrees_of), BRANCHES)
        for shares in product(*([fmpq(k, n) for k in range(n)] for n in degrees_of)):
            values = self._at(tuple(zip(turning, shares, strict=True)))
            if not excludes_zero(factor, values):
                raise CertificateError("a denominator is not shown to be other than 0 at the point")

    def _generators(self, polynomial: fmpq_mpoly) -> list[Generator]:
        """The generators that occur, also in the scales of others."""
        degrees = polynomial.degrees()[::-1]
        found = [g for g, n in zip(self._field.generators, degrees, strict=False) if n]
        scales = [g.scale for g in found if g.scale is not None]
        return found + [g for scale in scales for g in self._generators(scale)]

    def _at(self, turns: tuple[tuple[int, fmpq], ...]) -> list[acb]:
        if turns not in self._values:
            point = self._point
            balls = Branches(self._field, point, dict(turns)) if turns else None
            with ctx.workprec(BITS):
                self._values[turns] = self._field.balls(balls or Balls(self._field.nodes, point))
        return self._values[turns]

    def _is_constant(self, node: int) -> bool:
        return all(self._field.nodes.all[n][0] != "symbol" for n in self._field.nodes.below([node]))

    def _turns(self, node: int) -> bool:
        """Whether a function may have another branch in another part of the domain."""
        match self._field.nodes.all[node]:
            case ("Pow", _, exponent) if exponent.q != 1:
                return not (self._connected and is_clean(self._field, node))
            case ("Abs" | "sign", _):
                return True
        return False

    def _jumps(self, node: int) -> bool:
        match self._field.nodes.all[node]:
            case ("log", inner):
                root = self._field.nodes.made("Pow", inner, fmpq(1, 2))
                return not is_clean(self._field, root)
            case ("atan", inner):
                return not self._field.signs.is_real(inner)
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
        if is_linear(field, left) and is_linear(field, right):
            continue
        rest = [ends for i, (_, *ends) in enumerate(statement.domain) if i != place]
        match nodes.all[left], nodes.all[right]:
            case ("symbol", *_), ("elliptic_k", m) if field.signs.below_one(m):
                others = [ends for ends in rest if left in nodes.below(ends)]
                lower = [nodes.value(low) for low, high in others if high == left]
                alone = len(lower) == len(others) and left not in nodes.below([m])
                if alone and all(value is not None and value <= 0 for value in lower):
                    continue
        return False
    return True


def is_linear(field: Field, node: int) -> bool:
    """Whether a node is evidently of degree 1 or less in real symbols."""
    match field.nodes.all[node]:
        case ("number" | "pi", *_):
            return True
        case ("symbol", _, kind):
            return bool(kind == "real")
        case ("Add", *terms):
            return all(is_linear(field, term) for term in terms)
        case ("Mul", *factors):
            moving = [f for f in factors if field.nodes.all[f][0] not in ("number", "pi")]
            return len(moving) <= 1 and all(is_linear(field, f) for f in moving)
    return False
