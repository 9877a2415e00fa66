"""Functions that are known by their differential equations alone."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flint import fmpq

from ..axioms import FUNCTIONS, SQUARES, Function
from ..bounds import POSITIVE, Interval
from ..field import Field, rule
from ..function_rules import whole
from ..limits import CertificateError
from ..node_balls import BALLS
from ..ring import Element
from .weierstrass_values import weierstrass

CYLINDER: Mapping[str, tuple[int, int]] = {
    "bessel_j": (-1, 1),
    "bessel_y": (-1, 1),
    "bessel_i": (1, 1),
    "bessel_k": (-1, -1),
}
"""Bessel functions C of order v, with a and b in C' = v/z C + a C(v + 1) = b C(v - 1) - v/z C."""


def _row(kind: str, slope: str, **more: Any) -> Function:
    return Function(kind, slope, free=True, **more)


ABOVE: Mapping[str, Any] = {"between": (fmpq(0), None)}

FUNCTIONS |= {
    "erf": _row("entire", "2*exp(-z**2)/sqrt(pi)", symmetry="same",
                values=Interval(fmpq(-1), fmpq(1), True, True)),
    "airy_ai": _row("entire", "airy_ai_prime(z)"),
    "airy_ai_prime": _row("entire", "z*airy_ai(z)"),
    "airy_bi": _row("entire", "airy_bi_prime(z)"),
    "airy_bi_prime": _row("entire", "z*airy_bi(z)"),
    "lambert_w": _row("cut", "lambert_w(z)/(z*(1 + lambert_w(z)))",
                      values=Interval(fmpq(0)), **ABOVE),
    **{
        name: _row("cut", f"v/z*{name}(v, z) + ({up})*{name}(v + 1, z)", letters="vz",
                   values=POSITIVE if name == "bessel_k" else Interval(), **ABOVE)
        for name, (up, _) in CYLINDER.items()
    },
    "weierstrass_p": _row("poles", "weierstrass_p_prime(z, g, h)", letters="zgh", symmetry="even"),
    "weierstrass_p_prime": _row("poles", "6*weierstrass_p(z, g, h)**2 - g/2", letters="zgh",
                                symmetry="odd"),
}  # fmt: skip

SQUARES["weierstrass_p_prime", "weierstrass_p"] = (
    "4*weierstrass_p(z, g, h)**3 - g*weierstrass_p(z, g, h) - h"
)

BALLS |= {
    "airy_ai_prime": lambda z: z.airy_ai(derivative=1),
    "airy_bi_prime": lambda z: z.airy_bi(derivative=1),
    "lambert_w": lambda z: z.lambertw(),
    "bessel_j": lambda v, z: z.bessel_j(v),
    "bessel_y": lambda v, z: z.bessel_y(v),
    "bessel_i": lambda v, z: z.bessel_i(v),
    "bessel_k": lambda v, z: z.bessel_k(v),
    "weierstrass_p": lambda *z: weierstrass(*z)[0],
    "weierstrass_p_prime": lambda *z: weierstrass(*z)[1],
}


@rule("exp", first=True)
def exponential_of_lambert(field: Field, node: int) -> Element | None:
    """exp(n W(f)) = (f/W(f))**n."""
    times, u = field.nodes.multiple(field.nodes.all[node][1])
    match field.nodes.all[u]:
        case ("lambert_w", f):
            return (field.image(f) / field.image(u)) ** whole(times)
    return None


@rule("lambert_w")
def lambert(field: Field, node: int) -> Element | None:
    """W(f) = r if r exp(r) = f and r >= -1, where r exp(r) increases."""
    value = field.hinted(node)
    if value is None:
        return None
    if not field.signs.is_between(value, fmpq(-1), None):
        raise CertificateError("the value given for lambert_w is not shown to be >= -1")
    product = field.image(value) * field.made("exp", value)
    if not (product - field.image(field.nodes.all[node][1])).is_zero:
        raise CertificateError("the value given for lambert_w is that of another argument")
    return field.image(value)


HALF_ORDERS: Mapping[str, tuple[str, str]] = {
    "bessel_j": ("cos(z)", "sin(z)"),
    "bessel_y": ("sin(z)", "-cos(z)"),
    "bessel_i": ("cosh(z)", "sinh(z)"),
    "bessel_k": ("pi/2*exp(-z)", "pi/2*exp(-z)"),
}
"""sqrt(pi/2) sqrt(z) times the functions of the orders -1/2 and 1/2."""


@rule(*CYLINDER)
def cylinder(field: Field, node: int) -> Element:
    """A Bessel function, from those of the orders v and v + 1 that are generators, or +-1/2.

    That K is even in its order gives it from the orders -v too.
    """
    name, order, z = field.nodes.all[node]
    for other in field.primitives(name):
        _, v, w = field.nodes.all[other]
        if not field.equal(z, w):
            continue
        sides = (1, -1) if name == "bessel_k" else (1,)
        for side in sides:
            steps = _difference(field, field.nodes.times(side, order), v)
            if steps is not None and steps.q == 1:
                above = field.nodes.made("Add", v, field.nodes.rational(1))
                pair = field.image(other), field.made(name, above, z)
                return _of_order(field, node, pair, field.image(v), whole(steps))
    start = field.nodes.rational(-1, 2)
    steps = _difference(field, order, start)
    if steps is None or steps.q != 1:
        raise CertificateError(f"there is no generator for a {name}")
    scale = field.read("sqrt(2)/(sqrt(pi)*sqrt(z))", z=z)
    lower, higher = (scale * field.read(text, z=z) for text in HALF_ORDERS[name])
    return _of_order(field, node, (lower, higher), field.image(start), whole(steps))


def _difference(field: Field, left: int, right: int) -> fmpq | None:
    """The difference of two orders if it is a number."""
    gap = field.image(left) - field.image(right)
    if gap.powers or not gap.numerator.is_constant():
        return None
    return fmpq(0) if gap.is_zero else gap.numerator.leading_coefficient()


def _of_order(
    field: Field, node: int, pair: tuple[Element, Element], place: Element, steps: int
) -> Element:
    """The Bessel function some steps of 1 from the order ``place``, of this and the next one."""
    name, _, z = field.nodes.all[node]
    up, down = map(field.ring.number, CYLINDER[name])
    lower, higher = pair
    for _ in range(abs(steps)):
        share = field.ring.number(2) / field.image(z)
        if steps > 0:
            place = place + field.one
            lower, higher = higher, up * (down * lower - share * place * higher)
        else:
            lower, higher = down * (up * higher + share * place * lower), lower
            place = place - field.one
    return lower
