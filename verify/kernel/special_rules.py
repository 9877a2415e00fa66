"""Rules for elliptic, theta and Bessel functions that are not generators.

Addition theorems split sums of arguments; for the parameters 0 and 1 elliptic functions are
elementary.  Bessel functions of all orders follow from those of two orders.
"""

from __future__ import annotations

from collections.abc import Mapping

from .axioms import BEHIND, CYLINDER, FUNCTIONS, SPECIAL_VALUES, SUMS, ZETA
from .field import Field
from .function_values import THETA
from .limits import CertificateError
from .ring import Element
from .root_rules import whole

ENDS: Mapping[str, tuple[str, str]] = {
    "jacobi_sn": ("sin(z)", "tanh(z)"),
    "jacobi_cn": ("cos(z)", "sech(z)"),
    "jacobi_dn": ("1", "sech(z)"),
    "jacobi_epsilon": ("z", "tanh(z)"),
    "elliptic_k": ("pi/2", ""),
    "elliptic_e": ("pi/2", "1"),
}
"""Elementary formulas of the elliptic functions at m = 0 and at m = 1."""


def at_end(field: Field, node: int) -> Element | None:
    """Return the elementary form of an elliptic function of parameter 0 or 1; else None."""
    name, *arguments = field.nodes.all[node]
    m = field.image(arguments[-1])
    if not (m.is_zero or (m - field.one).is_zero):
        return None
    text = ENDS[name][0 if m.is_zero else 1]
    return field.read(text, **FUNCTIONS[name].arguments(*arguments)) if text else None


def elliptic(field: Field, node: int) -> Element | None:
    """Return sn, cn, dn, epsilon or zeta by addition theorems and values at 0 and K."""
    nodes = field.nodes
    name, z, m = nodes.all[node]
    field.need_parameters(node)
    if name == "jacobi_zeta" and not field.primitives(name):
        return field.read(ZETA, z=z, m=m)
    terms, (times, u) = nodes.terms(z), nodes.multiple(z)
    if len(terms) > 1:
        rest = terms[1] if len(terms) == 2 else nodes.add("Add", *terms[1:])
        return field.read(SUMS[name], u=terms[0], v=rest, m=m, z=z)
    if times == 0 or (times == 1 and u == nodes.add("elliptic_k", m)):
        field.image(u)  # a divisor in it counts, though it is multiplied by 0
        return field.read(SPECIAL_VALUES[name][int(times.p)], m=m)
    if times == 1:
        raise CertificateError("there is no generator for a function of a sum")
    if times < 0:
        value = field.image_of(name, nodes.times(whole(-times), u), m)
        return value if name in ("jacobi_cn", "jacobi_dn") else -value
    half = whole(times) // 2
    rest = nodes.times(whole(times) - half, u)
    return field.read(SUMS[name], u=nodes.times(half, u), v=rest, m=m, z=z)


def theta(field: Field, node: int) -> Element:
    """Return Theta(u - d) by the product theorem, from Theta at u + d, u, d and 0."""
    _, z, m = field.nodes.all[node]
    field.need_parameters(node)
    terms = field.nodes.terms(z)
    for place, term in enumerate(terms):
        times, d = field.nodes.multiple(term)
        if len(terms) == 2 and times == -1:
            return field.read(BEHIND, u=terms[1 - place], d=d, m=m)
    raise CertificateError("theta's argument must be a difference of two")


HALF_ORDERS: Mapping[str, tuple[str, str]] = {
    "bessel_j": ("cos(z)", "sin(z)"),
    "bessel_y": ("sin(z)", "-cos(z)"),
    "bessel_i": ("cosh(z)", "sinh(z)"),
    "bessel_k": ("pi/2*exp(-z)", "pi/2*exp(-z)"),
}
"""sqrt(pi/2) sqrt(z) times the Bessel functions of the orders -1/2 and 1/2."""


def cylinder(field: Field, node: int) -> Element:
    """Return a Bessel function by recurrence from two orders: of generators, or -1/2 and 1/2."""
    name, order, z = field.nodes.all[node]
    for other in field.primitives(name):
        _, v, w = field.nodes.all[other]
        if not field.equal(z, w):
            continue
        for side in (1, -1) if name == "bessel_k" else (1,):  # K is even in its order
            steps = (field.image(field.nodes.times(side, order)) - field.image(v)).value
            if steps is not None and steps.q == 1:
                above = field.nodes.add("Add", v, field.nodes.rational(1))
                pair = field.image(other), field.image_of(name, above, z)
                return _of_order(field, node, pair, field.image(v), whole(steps))
    start = field.nodes.rational(-1, 2)
    steps = (field.image(order) - field.image(start)).value
    if steps is None or steps.q != 1:
        raise CertificateError(f"there is no generator for a {name}")
    scale = field.read("sqrt(2)/(sqrt(pi)*sqrt(z))", z=z)
    lower, higher = (scale * field.read(text, z=z) for text in HALF_ORDERS[name])
    return _of_order(field, node, (lower, higher), field.image(start), whole(steps))


def _of_order(
    field: Field, node: int, pair: tuple[Element, Element], place: Element, steps: int
) -> Element:
    """Return the Bessel function of order ``place + steps``.

    ``pair`` has those of the orders ``place`` and ``place + 1``."""
    name, _, z = field.nodes.all[node]
    up, down = map(field.ring.number, CYLINDER[name])
    lower, higher = pair
    for _ in range(abs(steps)):
        factor = field.ring.number(2) / field.image(z)
        if steps > 0:
            place = place + field.one
            lower, higher = higher, up * (down * lower - factor * place * higher)
        else:
            lower, higher = down * (up * higher + factor * place * lower), lower
            place = place - field.one
    return lower


def odd_or_even(field: Field, node: int) -> Element | None:
    """Return a theta function from a generator at -z; theta_1 is odd in z, the others are even."""
    _, z, q, (label, order) = field.nodes.all[node]
    turned = field.known(field.nodes.add("theta", field.nodes.negative(z), q, (label, order)))
    return turned if turned is None or (label == THETA[0]) == (order % 2 == 1) else -turned
