"""Check a certificate: from its plain data to the statement that it proves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from .denominators import Denominators, is_continuous_end, is_linear
from .field import Field, Hints
from .limits import FORMAT, FORMS, GENERATORS, NAME, NODES, PARTS, CertificateError, digest, within
from .node_balls import Balls
from .nodes import Nodes, listed, number
from .reading import formula
from .statement import Statement, Substitution, read_statement, statement_text
from .table import RULES


def check_certificate(data: object) -> str:
    """Repeat the proof in ``data``; return its statement in words or raise CertificateError."""
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
    prove(statement, data["proof"])
    return statement_text(statement, data["statement"])


def opened(data: Mapping[str, Any]) -> Statement:
    """Return the statement of a certificate, with the proof's formulas in its ``nodes.places``."""
    nodes = Nodes()
    statement, scope = read_statement(nodes, data["statement"])
    symbols = len(scope.known)
    for text in listed(data["proof"]["formulas"], NODES, "formulas"):
        nodes.places.append(formula(scope, text, nodes.places))
    if len(scope.known) > symbols:
        raise CertificateError("the formulas of a proof must be in the statement's symbols")
    return statement


def prove(statement: Statement, proof: Mapping[str, Any], part: bool = False) -> None:
    """Raise CertificateError unless ``proof`` proves it; a ``part`` may not use equal parts."""
    field = registered(statement, proof, part)
    field.walk(statement.formulas)
    for equation in statement.equations:
        if not vanishes(field, statement, equation):
            raise CertificateError("the numerator of the residual is not 0")
    _check_point(field, statement)


def vanishes(field: Field, statement: Statement, equation: int) -> bool:
    """Return whether an equation holds with the statement's formulas in place of its unknowns."""
    for answer in field.rules.tried("equation", "="):
        result = answer(field, statement, equation)
        if result is not None:
            return result
    residual = Substitution(field.nodes, statement.variables, statement.formulas)(equation)
    field.walk([residual])
    return field.image(residual).is_zero


def registered(
    statement: Statement,
    proof: Mapping[str, Any],
    part: bool = False,
    field_type: type[Field] = Field,
) -> Field:
    """Return the field in which a proof is checked, with the proof's generators and hints."""
    nodes = statement.nodes
    hints = Hints(*(_places(nodes, proof[kind]) for kind in ("values", "signs")))
    generators = listed(proof["generators"], GENERATORS, "generators")
    count = sum(len(entry[2]) if entry[0] == "forms" else 1 for entry in generators)
    within("generators", count, GENERATORS)
    positive = {nodes.gap(left, right): weak for weak, left, right in statement.domain}
    field = field_type(nodes, count, statement.variables, positive, hints, RULES)
    field.point = {nodes.place(s): number(value) for s, value in _pairs(proof["point"])}
    parts = listed(proof["parts"], 0 if part else PARTS, "parts")
    for entry in generators:
        _register(field, entry, parts, statement)
    return field


def _pairs(data: object) -> list[list[Any]]:
    return [listed(entry, 2, "an entry", exactly=True) for entry in listed(data, NODES, "hints")]


def _places(nodes: Nodes, data: object) -> dict[int, int]:
    return {nodes.place(node): nodes.place(other) for node, other in _pairs(data)}


def _register(field: Field, entry: object, parts: Sequence[Any], statement: Statement) -> None:
    place = field.nodes.place
    match listed(entry, 3, "a generator"):
        case ["atom", node]:
            field.register(place(node))
        case ["forms", list(primitives), list(rows)] if len(rows) == len(primitives) <= FORMS:
            forms = [([place(f) for f in factors], place(shift)) for factors, shift in _pairs(rows)]
            field.register_forms([place(p) for p in primitives], forms)
        case ["part", int(number_of)] if 0 <= number_of < len(parts):
            left, right, proof = listed(parts[number_of], 3, "a part", exactly=True)
            sides = place(left), place(right)
            difference = field.nodes.gap(sides[1], sides[0])
            equality = replace(statement, unknowns=(), formulas=sides, equations=(difference,))
            prove(equality, proof, part=True)
            field.register_part(*sides)
        case _:
            raise CertificateError(f"no generator is written {ascii(entry)[:60]}")


def _check_point(field: Field, statement: Statement) -> None:
    """Check that the domain is not empty and no denominator vanishes identically."""
    nodes, point = field.nodes, field.point
    if any(nodes.all[symbol][0] != "symbol" for symbol in point):
        raise CertificateError("the point must give symbols their values")
    if any(nodes.all[s][2] == "integer" and value.q != 1 for s, value in point.items()):
        raise CertificateError("the point must give integers to integer symbols")
    balls = Balls(nodes, point)
    for weak, left, right in statement.domain:
        gap = balls.ball(right) - balls.ball(left)
        if not (gap.real > 0 and gap.imag == 0):
            raise CertificateError("the point is not in the domain, or not inside it")
        if not (is_continuous_end(field, left) and is_continuous_end(field, right)):
            raise CertificateError("a domain's ends must be shown to be real and without jumps")
        if weak and not (is_linear(nodes, left) and is_linear(nodes, right)):
            raise CertificateError("<= must be between formulas of degree 1 (write < instead)")
    if all(nodes.all[generator.formula][0] == "symbol" for generator in field.generators):
        return  # polynomials in symbols
    if not all(value.is_finite() for value in field.balls(balls)):
        raise CertificateError("a function is not shown to be finite at the point")
    denominators = Denominators(field, statement, point)
    for factor in field.ring.factors:
        if not factor.is_constant():
            denominators.check(factor)
