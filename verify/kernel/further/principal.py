"""Real parts and angles, and the principal square roots that they show."""

from __future__ import annotations

from flint import fmpq

from ..field import Field
from ..function_rules import BRANCHES

HALF = fmpq(1, 2)


def is_principal(field: Field, node: int, exponent: fmpq) -> bool:
    """Whether a value w is shown to be the root of w**2: Re w > 0, or w = i s with s >= 0."""
    if exponent != HALF:
        return False
    height, real = angle_of(field, node), real_part(field, node)
    if height is not None and field.signs.not_negative(height):
        return True
    return real is not None and field.signs.positive(real) and field.signs.is_bounded(real)


BRANCHES.append(is_principal)


def real_part(field: Field, node: int) -> int | None:
    """A node for the real part of a sum of real terms, phases and multiples of them."""
    nodes, made = field.nodes, field.nodes.made
    if field.signs.is_real(node):
        return node
    match nodes.all[node]:
        case ("I",):
            return nodes.rational(0)
        case ("Add", *terms):
            parts = [real_part(field, term) for term in terms]
            known = [part for part in parts if part is not None]
            return made("Add", *known) if len(known) == len(parts) else None
        case ("Mul", *factors):
            rest = [factor for factor in factors if not field.signs.is_real(factor)]
            part = real_part(field, rest[0]) if len(rest) == 1 else None
            real = [factor for factor in factors if factor not in rest]
            return None if part is None else made("Mul", part, *real)
        case ("exp", z):
            angle = angle_of(field, z)
            return None if angle is None else made("cos", angle)
        case ("Pow", _, exponent) if exponent == HALF:
            return made("Abs", made("re", node))  # the principal root's is not negative
    return None


def angle_of(field: Field, z: int) -> int | None:
    """The real factor of I in a node ``I * angle``."""
    match field.nodes.all[z]:
        case ("Mul", *factors):
            rest = [f for f in factors if field.nodes.all[f] != ("I",)]
            if len(factors) == len(rest) + 1 and rest and all(map(field.signs.is_real, rest)):
                return field.nodes.product(*rest)
    return None
