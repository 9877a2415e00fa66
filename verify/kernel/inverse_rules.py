"""Rules for logarithms and inverse functions, whose branch is shown by signs, bounds or continuity.

Let v be real and continuous on a connected domain.  If tan v is f there, which is finite, v is at
no odd multiple of pi/2 anywhere; if it lies between -pi/2 and pi/2 at one point, it does so at all
of them, and is atan f.  Likewise v = asin f if sin v = f is between -1 and 1, and v = acos f, with
v between 0 and pi, if cos v = f is between -1 and 1.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import reduce
from operator import mul

from flint import fmpq

from .axioms import FUNCTIONS, HALF_PI, Ends
from .denominators import is_linear
from .exponential_rules import PHASE
from .field import Field
from .limits import CertificateError
from .node_balls import Balls
from .ring import Element
from .root_rules import angle_of

PRINCIPAL: Mapping[str, Ends] = {
    "asin": (-HALF_PI, HALF_PI),
    "acos": (fmpq(0), 2 * HALF_PI),
    "atan": (-HALF_PI, HALF_PI),
    "asinh": (None, None),
    "acosh": (fmpq(0), None),
    "atanh": (None, None),
}
"""Ends of the real principal values of inverse functions, rounded inwards (None: unbounded)."""


def logarithm(field: Field, node: int) -> Element | None:
    """Return log f as a hinted sum of logs, by log 1 = 0, log exp z = z or log(-f); else None."""
    nodes, inner = field.nodes, field.nodes.all[node][1]
    if nodes.value(inner) == 1:
        return field.zero
    value = field.hinted(node)
    if value in (None, node):
        return _logarithm_of_exponential(field, inner) or _logarithm_of_negative(field, inner)
    terms = [nodes.multiple(term) for term in nodes.terms(value)]
    if any(nodes.all[u][0] != "log" for _, u in terms):
        raise CertificateError("the value given for a logarithm must be a sum of logarithms")
    factors = [(q, nodes.all[u][1]) for q, u in terms]
    powers = [q for q, f in factors if not field.signs.not_negative(f)]
    if powers not in ([], [1]):
        raise CertificateError("a factor in a logarithm is not shown to be positive")
    # It is not 0 where the logarithm is smooth.
    product = reduce(mul, (field.image_of("Pow", f, q) for q, f in factors))
    if product.is_zero or not (product - field.image(inner)).is_zero:
        raise CertificateError("the value given for a logarithm is that of another argument")
    return field.image(value)


def _logarithm_of_exponential(field: Field, f: int) -> Element | None:
    """Apply log exp(z) = z for real z, and z = i r with abs r < pi; log i = i pi/2."""
    match field.nodes.all[f]:
        case ("I",):
            return field.image(f) * field.image_of("pi") * field.ring.number(fmpq(1, 2))
        case ("exp", z):
            angle = angle_of(field, z)
            turn = angle is not None and field.signs.is_between(angle, -2 * HALF_PI, 2 * HALF_PI)
            return field.image(z) if turn or field.signs.positive(f) else None
    return None


def _logarithm_of_negative(field: Field, f: int) -> Element | None:
    """Apply log f = log(-f) + i pi for f < 0."""
    number = field.nodes.value(f)
    other = field.nodes.negative(f) if number is None else field.nodes.add("number", -number)
    if not field.signs.positive(other):
        return None
    return field.image_of("log", other) + field.image_of("I") * field.image_of("pi")


def inverse_function(field: Field, node: int) -> Element | None:
    """Return the hinted value of an inverse function, checked to be principal; else None."""
    name, f = field.nodes.all[node]
    value = field.hinted(node)
    if value is None:
        return None
    if not (field.signs.is_between(value, *PRINCIPAL[name]) or field.is_kept(name, f, value)):
        raise CertificateError(f"the value given for {name} is not shown to be a principal value")
    if not is_value(field, name, f, value):
        raise CertificateError(f"the value given for {name} is that of another argument")
    return field.image(value)


def is_value(field: Field, name: str, f: int, value: int) -> bool:
    """Return whether f is sin v, cos v or tan v for ``name`` asin, acos or atan; v is ``value``."""
    nodes = field.nodes
    if name == "atan":
        turned = field.image_of("exp", nodes.product(nodes.rational(2), nodes.add("I"), value))
        return (turned - field.read(PHASE, z=f)).is_zero
    return (field.image_of(name.removeprefix("a"), value) - field.image(f)).is_zero


def is_kept(field: Field, name: str, f: int, value: int) -> bool:
    """Return whether ``value``, known to solve e.g. sin value = f, is principal by continuity."""
    if name not in ("atan", "asin", "acos") or not is_convex(field):
        return False
    if not (is_continuous(field, f) and is_continuous(field, value)):
        return False
    one, square = field.nodes.rational(1), field.nodes.add("Pow", f, fmpq(2))
    if name != "atan" and not field.signs.positive(field.nodes.gap(square, one)):
        return False
    ball = Balls(field.nodes, field.point).ball(value)
    turn = ball.real / HALF_PI - (1 if name == "acos" else 0)
    return bool(ball.imag == 0 and turn > -1 and turn < 1)


def is_convex(field: Field) -> bool:
    """Return whether the domain is convex: linear inequalities without integer symbols."""
    nodes = field.nodes
    inside = (nodes.all[node] for node in nodes.below([*field.positive]))
    whole = any(node[2:] == ("integer",) for node in inside)
    return not whole and all(is_linear(nodes, node) for node in field.positive)


def is_continuous(field: Field, node: int) -> bool:
    """Return whether a formula is evidently real and continuous on the whole domain."""
    return all(_is_continuous(field, inner) for inner in field.nodes.below([node]))


def _is_continuous(field: Field, node: int) -> bool:
    name, *arguments = field.nodes.all[node]
    if not field.signs.is_real(node) or arguments[1:] == ["integer"]:
        return False
    match name:
        case "number" | "symbol" | "pi" | "Add" | "Mul" | "Abs" | "asin" | "acos" | "acosh":
            return True
        case "log":
            return field.signs.positive(arguments[0])
        case "Pow":
            return arguments[1] > 0 or field.signs.interval(arguments[0]).is_not_zero
    return name in FUNCTIONS and FUNCTIONS[name].kind in ("entire", "regular", "arc")


def lambert(field: Field, node: int) -> Element | None:
    """Return the hinted r = W(f), checked by r exp(r) = f and r >= -1; None without a hint."""
    value = field.hinted(node)
    if value is None:
        return None
    if not field.signs.is_between(value, fmpq(-1), None):
        raise CertificateError("the value given for lambert_w is not shown to be >= -1")
    product = field.image(value) * field.image_of("exp", value)
    if not (product - field.image(field.nodes.all[node][1])).is_zero:
        raise CertificateError("the value given for lambert_w is that of another argument")
    return field.image(value)
