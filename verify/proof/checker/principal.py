"""Roots and absolute values that are no generators: which value is the principal one."""

from __future__ import annotations

from flint import fmpq

from .images import Images
from .limits import CertificateError
from .ring import Element


def root(images: Images, node: int, base: int, q: int) -> Element:
    """base**(1/q): a generator, or a value whose power and whose branch are checked."""
    known = images.known(node)
    if known is not None:
        return known
    value = images.named(node)
    if not (images.image(value) ** q - images.image(base)).is_zero:
        raise CertificateError(f"the power {q} of what a root is said to be is another")
    if not (images.signs.not_negative(value) or (q == 2 and _is_principal(images, value))):
        raise CertificateError("what a root is said to be is not shown to be >= 0 there")
    return images.image(value)


def absolute_value(images: Images, node: int, inner: int) -> Element:
    """abs(inner): a value whose square is right, and that is not negative."""
    value = images.named(node)
    if not (images.image(value) ** 2 - images.squared(inner)).is_zero:
        raise CertificateError("what an absolute value is said to be has another square")
    if not images.signs.not_negative(value):
        raise CertificateError("what an absolute value is said to be is not shown to be >= 0 there")
    return images.image(value)


def _is_principal(images: Images, node: int) -> bool:
    """Whether a value w is shown to be the root of w**2: Re w > 0, or w = i s with s >= 0."""
    height, real = angle_of(images, node), _real_part(images, node)
    above = height is not None and images.signs.not_negative(height)
    return above or (real is not None and images.signs.positive(real))


def _real_part(images: Images, node: int) -> int | None:
    """A node for the real part of a sum of real terms, phases and multiples of them."""
    made = images.nodes.made
    if images.signs.is_real(node):
        return node
    match images.nodes.all[node]:
        case ("I",):
            return images.nodes.rational(0)
        case ("Add", *terms):
            parts = [_real_part(images, term) for term in terms]
            known = [part for part in parts if part is not None]
            return made("Add", *known) if len(known) == len(parts) else None
        case ("Mul", *factors):
            rest = [factor for factor in factors if not images.signs.is_real(factor)]
            part = _real_part(images, rest[0]) if len(rest) == 1 else None
            real = [factor for factor in factors if factor not in rest]
            return None if part is None else made("Mul", part, *real)
        case ("exp", z):
            angle = angle_of(images, z)
            return None if angle is None else made("cos", angle)
        case ("Pow", _, exponent) if exponent == fmpq(1, 2):
            return made("Abs", made("re", node))  # the principal root's is not negative
    return None


def angle_of(images: Images, z: int) -> int | None:
    """The real factor of I in a node ``I * angle``."""
    match images.nodes.all[z]:
        case ("Mul", *factors):
            rest = [f for f in factors if images.nodes.all[f] != ("I",)]
            if len(factors) == len(rest) + 1 and rest and all(map(images.signs.is_real, rest)):
                return rest[0] if len(rest) == 1 else images.nodes.made("Mul", *rest)
    return None
