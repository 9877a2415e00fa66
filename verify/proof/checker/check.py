"""From a certificate's plain data to the statement that it proves."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from typing import Any

from flint import fmpq

from .denominators import Denominators, is_linear
from .field import Field
from .generators import Form, Hints, Sum
from .identity import Residual
from .limits import GENERATORS, NAME, NODES, CertificateError, within
from .nodes import Nodes, listed, number
from .points import Balls
from .statement import Statement, read_statement, statement_text

FORMAT = "longwave proof 2"
FORMS, PARTS = 4, 8
"""Most linear forms that belong together, and most equal parts that a proof may rest on."""


def digest(body: Mapping[str, Any]) -> str:
    """A checksum of everything but itself, against slips of the pen."""
    plain = {key: value for key, value in body.items() if key != "digest"}
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


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


def same_statement(data: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    """Whether two certificates that can be read state the same, node for node."""
    nodes = Nodes(data["nodes"])
    own = read_statement(nodes, data["statement"]).content()
    try:
        nodes.read(other["nodes"])
        return own == read_statement(nodes, other["statement"]).content()
    except CertificateError:
        return False


def _check(data: object) -> str:
    if not isinstance(data, Mapping):
        raise CertificateError(f"a certificate is an object, got {type(data).__name__}")
    if data["format"] != FORMAT:
        raise CertificateError(f"format must be {FORMAT!r}, got {ascii(data['format'])[:60]}")
    name = data["name"]
    if not isinstance(name, str) or len(name) > NAME or not name.isprintable():
        raise CertificateError("the name must be a short printable text")
    if digest(data) != data["digest"]:
        raise CertificateError("the digest does not match the content")
    nodes = Nodes(data["nodes"])
    statement = read_statement(nodes, data["statement"])
    prove(nodes, statement, data["proof"])
    return statement_text(statement)


def prove(nodes: Nodes, statement: Statement, proof: Mapping[str, Any], part: bool = False) -> None:
    """Decide whether the equations of ``statement`` vanish in the field of ``proof``.

    Raises CertificateError if they do not, if the point of the proof is outside the domain or a
    denominator is not shown to be other than 0 there.  A part is an equality used in a proof.
    """
    field = registered(nodes, statement, proof, part)
    field.walk(statement.roots)
    residual = Residual(field, statement)
    for terms in statement.equations:
        if not residual.vanishes(terms):
            raise CertificateError("the numerator of the residual is not 0")
    point = {nodes.place(symbol): number(value) for symbol, value in _pairs(proof["point"])}
    _check_point(field, statement, point)


def registered(
    nodes: Nodes, statement: Statement, proof: Mapping[str, Any], part: bool = False
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
    field = Field(nodes, count, statement.variables, positive, hints)
    parts = listed(proof["parts"], 0 if part else PARTS, "parts")
    for entry in generators:
        _register(field, nodes, entry, parts, statement)
    return field


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
            forms = [Form(tuple(map(nodes.place, f)), nodes.place(s)) for f, s in _pairs(rows)]
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
        if weak and not (is_linear(field, left) and is_linear(field, right)):
            raise CertificateError("<= must be between formulas of degree 1 (write < instead)")
    for symbol in point:
        if field.nodes.all[symbol][0] != "symbol":
            raise CertificateError("the point must give symbols their values")
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
