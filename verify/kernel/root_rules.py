"""Rules for roots, absolute values, conjugates and derivatives that are not generators.

Signs show which value is the principal one; real parts and angles show principal square roots.
"""

from __future__ import annotations

from itertools import combinations

from flint import fmpq

from .field import Field
from .limits import EXPONENT, CertificateError, within
from .ring import Element

HALF = fmpq(1, 2)


def root(field: Field, node: int) -> Element:
    """Return the hinted value of base**(1/q), whose q-th power and branch are checked."""
    _, base, exponent = field.nodes.all[node]
    value = field.hinted(node)
    if value is None:
        raise CertificateError("there is no generator for a Pow")
    if not (field.image(value) ** int(exponent.q) - field.image(base)).is_zero:
        raise CertificateError("the power of the value given for a root is not the radicand")
    if not is_branch(field, value, exponent):
        raise CertificateError("the value given for a root is not shown to be >= 0 on the domain")
    return field.image(value)


def is_branch(field: Field, value: int, exponent: fmpq) -> bool:
    """Return whether a rule shows that ``value`` is a principal root, with ``exponent`` = 1/q."""
    return any(answer(field, value, exponent) for answer in field.rules.tried("branch", "Pow"))


def is_not_negative(field: Field, node: int, _exponent: fmpq) -> bool:
    """Return whether ``node`` is shown to be real and at least 0."""
    return field.signs.not_negative(node)


def is_multiple(field: Field, node: int, exponent: fmpq) -> bool:
    """Return whether ``node`` is r f**s with r >= 0 and 0 < s <= ``exponent``, a principal root.

    r f**s g**t is principal too if f and g are real and f + g > 0: one of them is positive.
    """
    nodes = field.nodes
    factors = nodes.all[node][1:] if nodes.all[node][0] == "Mul" else (node,)
    powers = [_power(field, f) for f in factors if not field.signs.not_negative(f)]
    if not powers or not all(0 < fraction <= exponent for _, fraction in powers):
        return False
    bases = [base for base, _ in powers]
    if len(bases) > 1 and not all(map(field.signs.is_real, bases)):
        return False
    return all(_is_sum_positive(field, f, g) for f, g in combinations(bases, 2))


def _power(field: Field, node: int) -> tuple[int, fmpq]:
    """Return f and s of a node f**s, or (f**t)**n with an integer n and s = t n."""
    match field.nodes.all[node]:
        case ("Pow", base, exponent):
            inner, fraction = _power(field, base) if exponent.q == 1 else (base, fmpq(1))
            return inner, fraction * exponent
    return node, fmpq(1)


def _is_sum_positive(field: Field, left: int, right: int) -> bool:
    """Return whether the sum of two nodes is a positive number, or shown to be positive."""
    total = (field.image(left) + field.image(right)).value
    if total is not None:
        return bool(total > 0)
    return field.signs.positive(field.nodes.add("Add", left, right))


def is_principal(field: Field, node: int, exponent: fmpq) -> bool:
    """Return whether ``node`` w is the principal root of w**2: Re w > 0, or w = i s with s >= 0."""
    if exponent != HALF:
        return False
    height, real = angle_of(field, node), real_part(field, node)
    if height is not None and field.signs.not_negative(height):
        return True
    return real is not None and field.signs.positive(real) and field.signs.is_bounded(real)


def real_part(field: Field, node: int) -> int | None:
    """Return the real part of a sum of real multiples of 1, I, phases and roots; else None."""
    nodes, add = field.nodes, field.nodes.add
    if field.signs.is_real(node):
        return node
    match nodes.all[node]:
        case ("I",):
            return nodes.rational(0)
        case ("Add", *terms):
            parts = [real_part(field, term) for term in terms]
            known = [part for part in parts if part is not None]
            return add("Add", *known) if len(known) == len(parts) else None
        case ("Mul", *factors):
            rest = [factor for factor in factors if not field.signs.is_real(factor)]
            part = real_part(field, rest[0]) if len(rest) == 1 else None
            real = [factor for factor in factors if factor not in rest]
            return None if part is None else add("Mul", part, *real)
        case ("exp", z):
            angle = angle_of(field, z)
            return None if angle is None else add("cos", angle)
        case ("Pow", _, exponent) if exponent == HALF:
            return add("Abs", add("re", node))  # the principal root's is not negative
    return None


def angle_of(field: Field, z: int) -> int | None:
    """Return the node of a real ``angle`` if ``z`` is ``I * angle``; else None."""
    match field.nodes.all[z]:
        case ("Mul", *factors):
            rest = [f for f in factors if field.nodes.all[f] != ("I",)]
            if len(factors) == len(rest) + 1 and rest and all(map(field.signs.is_real, rest)):
                return field.nodes.product(*rest)
    return None


def absolute_value(field: Field, node: int) -> Element:
    """Return the hinted value of abs(f), checked to be at least 0 and to have the right square."""
    value = field.hinted(node)
    if value is None:
        raise CertificateError("there is no generator for a Abs")
    if not (field.image(value) ** 2 - field.squared(field.nodes.all[node][1])).is_zero:
        got = "is not the square of its argument"
        raise CertificateError(f"the square of the value given for an abs {got}")
    if not field.signs.not_negative(value):
        raise CertificateError("the value given for an abs is not shown to be >= 0 on the domain")
    return field.image(value)


def conjugate(field: Field, node: int) -> Element:
    """Return the conjugate, by its formula; that of a complex parameter must be a generator."""
    formula = field.signs.conjugate(field.nodes.all[node][1])
    if formula == node:
        raise CertificateError("there is no generator for the conjugate of a parameter")
    return field.image(formula)


def derivative(field: Field, node: int) -> Element:
    """Return the image of a ``diff`` node, differentiated in one variable at a time."""
    _, inner, *before, variable = field.nodes.all[node]
    lower = field.image_of("diff", inner, *before) if before else field.image(inner)
    return field.derivative(lower, variable)


def whole(value: fmpq) -> int:
    """Return an integer coefficient as an int; raises CertificateError for a fraction."""
    if value.q != 1:
        raise CertificateError("coefficients in a sum of arguments must be integers")
    within("coefficients", abs(int(value.p)), EXPONENT)
    return int(value.p)
