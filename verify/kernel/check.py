"""From a certificate's plain data to the statement that it proves.

The denominators of a proof must differ from 0 on a dense part of the domain.  A polynomial in
functions that are analytic on a connected domain does so if it is not 0 at one point.  Roots and
absolute values may change branch inside the domain (|x| at 0); then the product over all their
branches is analytic, and every branch must differ from 0 at the point.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from math import prod
from typing import Any

from flint import acb, arb, ctx, fmpq, fmpq_mpoly

from .field import Field
from .further import is_linear
from .identity import Residual
from .images import Generator, Hints, Sum
from .limits import (
    BRANCHES,
    FORMAT,
    FORMS,
    GENERATORS,
    NAME,
    NODES,
    PARTS,
    CertificateError,
    digest,
    within,
)
from .nodes import BITS, CYLINDER, Balls, Nodes, excludes_zero, listed, number
from .reading import formula
from .signs import INVERSE
from .statement import Statement, read_statement, statement_text

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
            case ("parity", _) if node in self._turns:
                return self._unit(node)
            case ("sign", inner) if node in self._turns:
                size = (self.ball(inner) * self._conjugate(inner)).sqrt()
                return self.ball(inner) / size * self._unit(node)
        return super()._ball(node)

    def _conjugate(self, inner: int) -> acb:
        return self.ball(self._field.signs.conjugate(inner))

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
        nodes = [node for node in within_them if not self._field.nodes.is_constant(node)]
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

    def _turns(self, node: int) -> bool:
        """Whether a function may have another branch in another part of the domain."""
        match self._field.nodes.all[node]:
            case ("Pow", _, exponent) if exponent.q != 1:
                return not (self._connected and self._field.signs.is_clean(node))
            case ("Abs" | "sign" | "parity", _):
                return True
        return False

    def _jumps(self, node: int) -> bool:
        match self._field.nodes.all[node]:
            case (str(name), *_) if name == "power" or name in INVERSE:
                return not self._field.signs.is_real(node)
            case ("log", inner):
                root = self._field.nodes.made("Pow", inner, fmpq(1, 2))
                return not self._field.signs.is_clean(root)
            case (str(name), *_) if name in CYLINDER:
                return not self._field.signs.is_real(node)
            case (("atan" | "lambert_w"), inner):
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
        if is_linear(nodes, left) and is_linear(nodes, right):
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


def check_certificate(data: object) -> str:
    """Repeat the proof in ``data`` and return what it proves, in words.

    Raises CertificateError, with the reason on one line, if any part of it fails.
    """
    try:
        return _check(data)
    except CertificateError:
        raise
    except KeyError as error:
        raise CertificateError(f"the certificate lacks {ascii(error.args[0])[:60]}") from error
    except RecursionError as error:
        raise CertificateError("the certificate is nested too deeply") from error
    except (LookupError, TypeError, ValueError, ArithmeticError, MemoryError) as error:
        reason = ascii(str(error))[1:121]
        raise CertificateError(f"the certificate cannot be read: {reason}") from error


def _check(data: object) -> str:
    if not isinstance(data, Mapping):
        got = type(data).__name__
        raise CertificateError(f"certificate must be an object, got {got} (prove writes one)")
    if data["format"] != FORMAT:
        got = ascii(data["format"])[:60]
        raise CertificateError(f"format must be {FORMAT!r}, got {got} (prove the statement again)")
    name = data["name"]
    if not isinstance(name, str) or len(name) > NAME or not name.isprintable():
        raise CertificateError("the name must be a short printable text")
    if digest(data) != data["digest"]:
        raise CertificateError("the digest does not match the content")
    statement = opened(data)
    prove(statement.nodes, statement, data["proof"])
    return statement_text(statement, data["statement"])


def opened(data: Mapping[str, Any]) -> Statement:
    """The statement of a certificate; its nodes have the proof's formulas as places."""
    nodes = Nodes()
    statement, scope = read_statement(nodes, data["statement"])
    symbols = len(scope.known)
    for text in listed(data["proof"]["formulas"], NODES, "formulas"):
        nodes.places.append(formula(scope, text, nodes.places))
    if len(scope.known) > symbols:
        raise CertificateError("the formulas of a proof must be in the statement's symbols")
    return statement


def prove(nodes: Nodes, statement: Statement, proof: Mapping[str, Any], part: bool = False) -> None:
    """Decide whether the equations of ``statement`` vanish in the field of ``proof``.

    Raises CertificateError if they do not, if the point of the proof is outside the domain or a
    denominator is not shown to be other than 0 there.  A part is an equality used in a proof.
    """
    field = registered(nodes, statement, proof, part)
    field.walk(statement.roots)
    residual = Residual(field, statement)
    for equation in statement.equations:
        if not residual.vanishes(equation):
            raise CertificateError("the numerator of the residual is not 0")
    point = field.point
    if any(nodes.all[s][0] != "symbol" for s in point):
        raise CertificateError("the point must give symbols their values")
    if any(nodes.all[s][2] == "integer" and value.q != 1 for s, value in point.items()):
        raise CertificateError("the point must give integers to integer symbols")
    _check_point(field, statement, point)


def registered(
    nodes: Nodes,
    statement: Statement,
    proof: Mapping[str, Any],
    part: bool = False,
    field_type: type[Field] = Field,
) -> Field:
    """The field of a proof with its generators."""
    hints = Hints(
        sums={nodes.place(z): _sum(nodes, terms) for z, terms in _pairs(proof["sums"])},
        values={nodes.place(f): nodes.place(value) for f, value in _pairs(proof["values"])},
        logs={nodes.place(f): _sum(nodes, terms) for f, terms in _pairs(proof["logs"])},
        signs={nodes.place(f): nodes.place(other) for f, other in _pairs(proof["signs"])},
    )
    generators = listed(proof["generators"], GENERATORS, "generators")
    count = sum(len(entry[2]) if entry[0] == "forms" else 1 for entry in generators)
    within("generators", count, GENERATORS)
    positive = {_difference(nodes, left, right): weak for weak, left, right in statement.domain}
    field = field_type(nodes, count, statement.variables, positive, hints)
    field.point = _point(nodes, proof)
    parts = listed(proof["parts"], 0 if part else PARTS, "parts")
    for entry in generators:
        _register(field, nodes, entry, parts, statement)
    return field


def _point(nodes: Nodes, proof: Mapping[str, Any]) -> dict[int, fmpq]:
    return {nodes.place(symbol): number(value) for symbol, value in _pairs(proof["point"])}


def _pairs(data: object) -> list[list[Any]]:
    return [listed(entry, 2, "an entry", 2) for entry in listed(data, NODES, "hints")]


def _sum(nodes: Nodes, data: object) -> Sum:
    return tuple((number(n), nodes.place(u)) for n, u in _pairs(data))


def _difference(nodes: Nodes, left: int, right: int) -> int:
    """The node of ``right - left``."""
    if nodes.value(left) == 0:
        return right
    negative = nodes.made("Mul", nodes.rational(-1), left)
    return negative if nodes.value(right) == 0 else nodes.made("Add", right, negative)


def _register(
    field: Field, nodes: Nodes, entry: object, parts: list[Any], statement: Statement
) -> None:
    match listed(entry, 3, "a generator"):
        case ["atom", node]:
            field.register(nodes.place(node))
        case ["scaled", node, scale]:
            field.register_scaled(nodes.place(node), nodes.place(scale))
        case ["circle", root, symbol]:
            field.register_circle(nodes.place(root), nodes.place(symbol))
        case ["quotient", node, below]:
            field.register_quotient(nodes.place(node), nodes.place(below))
        case ["forms", list(primitives), list(rows)] if 0 < len(rows) == len(primitives) <= FORMS:
            forms = [(tuple(map(nodes.place, f)), nodes.place(s)) for f, s in _pairs(rows)]
            field.register_forms([nodes.place(p) for p in primitives], forms)
        case ["part", int(place), _] if 0 <= place < len(parts):
            left, right, proof = listed(parts[place], 3, "a part", 3)
            sides = nodes.place(left), nodes.place(right)
            prove(nodes, _equality(statement, *sides), proof, part=True)
            field.register_part(*sides)
        case _:
            raise CertificateError(f"no generator is written {ascii(entry)[:60]}")


def _equality(statement: Statement, left: int, right: int) -> Statement:
    """The statement that two formulas are equal on the domain of ``statement``."""
    zero = (0,) * len(statement.variables)
    terms = ((fmpq(1), (), ((0, zero),)), (fmpq(-1), (right,), ()))
    return Statement(
        statement.nodes, statement.variables, ("u",), (left,), (terms,), statement.domain
    )


def _check_point(field: Field, statement: Statement, point: Mapping[int, fmpq]) -> None:
    """The domain is not empty, and no denominator vanishes identically."""
    balls = Balls(field.nodes, point)
    for weak, left, right in statement.domain:
        gap = balls.ball(right) - balls.ball(left)
        if not (gap.real > 0 and gap.imag == 0):
            raise CertificateError("the point is not in the domain, or not inside it")
        if weak and not (is_linear(field.nodes, left) and is_linear(field.nodes, right)):
            raise CertificateError("<= must be between formulas of degree 1 (write < instead)")
    if (
        all(not g.form and field.nodes.all[g.node][0] == "symbol" for g in field.generators)
        and not field.ring.relations
    ):
        return  # polynomials in symbols
    if not all(value.is_finite() for value in field.balls(balls)):
        raise CertificateError("a function is not shown to be finite at the point")
    denominators = Denominators(field, statement, point)
    for factor in field.ring.factors:
        if not factor.is_constant():
            denominators.check(factor)
