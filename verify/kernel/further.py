"""Inverse functions by continuity, powers of what is negative, roots of unity.

Let v be real and continuous on a connected domain.  If tan v is f there, which is finite, v is at
no odd multiple of pi/2 anywhere; if it lies between -pi/2 and pi/2 at one point, it does so at all
of them, and is atan f.  So is v = asin f if sin v = f is between -1 and 1, and v = acos f, between
0 and pi, if cos v is.

For an integer n and f < 0, f**n = (-1)**n (-f)**n.  exp(i pi k/n), k and n coprime, is a primitive
root of unity, of order n for even k and 2 n for odd k, and a root of the cyclotomic polynomial.
"""

from __future__ import annotations

from collections.abc import Mapping

from flint import fmpq, fmpz_poly

from . import axioms
from .images import Images, integer_of
from .limits import CertificateError
from .nodes import CYLINDER, Balls, Nodes
from .ring import Element
from .signs import HALF_PI

PERIODIC: Mapping[str, tuple[fmpq, fmpq]] = {
    "atan": (-HALF_PI, HALF_PI),
    "asin": (-HALF_PI, HALF_PI),
    "acos": (fmpq(0), 2 * HALF_PI),
}
"""Inverses of periodic functions, and between which numbers their values lie."""

LARGEST_ORDER = 60
"""Denominator of a share of i pi whose exponential has a relation."""

CONTINUOUS = (
    *("number", "symbol", "pi", "Add", "Mul", "Pow", "Abs", "exp", "sinh", "cosh", "tanh", "sech"),
    *("sin", "cos", "log", "atan", "asinh", "asin", "acos", "acosh"),
)
"""Continuous where all that they are made of is real, but for 1/f and log f at f = 0."""


def is_kept(images: Images, name: str, f: int, value: int) -> bool:
    """Whether ``value``, of which the function is ``f``, is the principal one on all the domain."""
    signs = images.signs
    if name not in PERIODIC or not is_convex(images):
        return False
    if not (is_continuous(images, f) and is_continuous(images, value)):
        return False
    if name != "atan" and not signs.positive(_rest(images, f)):
        return False
    low, high = PERIODIC[name]
    ball = Balls(images.nodes, images.point).ball(value)
    return bool(ball.imag == 0 and ball.real > low and ball.real < high)


def _rest(images: Images, f: int) -> int:
    """1 - f**2."""
    made, number = images.nodes.made, images.nodes.rational
    return made("Add", number(1), made("Mul", number(-1), made("Pow", f, fmpq(2))))


def is_convex(images: Images) -> bool:
    """Whether all inequalities of the domain are linear in real symbols."""
    nodes = images.nodes
    inside = (nodes.all[node] for node in nodes.below([*images.positive]))
    whole = any(node[2:] == ("integer",) for node in inside)
    return not whole and all(is_linear(nodes, node) for node in images.positive)


def is_continuous(images: Images, node: int) -> bool:
    """Whether a formula is evidently real and continuous on the whole domain."""
    signs = images.signs
    for inner in images.nodes.below([node]):
        name, *arguments = images.nodes.all[inner]
        if name not in CONTINUOUS or not signs.is_real(inner) or arguments[1:] == ["integer"]:
            return False
        if name == "log" and not signs.positive(arguments[0]):
            return False
        if name == "Pow" and arguments[1] < 0 and 0 in signs.sign(arguments[0]):
            return False
    return True


def is_linear(nodes: Nodes, node: int) -> bool:
    """Whether a node is evidently of degree 1 or less in real symbols."""
    match nodes.all[node]:
        case ("number" | "pi", *_):
            return True
        case ("symbol", _, kind):
            return bool(kind != "complex")
        case ("Add", *terms):
            return all(is_linear(nodes, term) for term in terms)
        case ("Mul", *factors):
            moving = [f for f in factors if nodes.all[f][0] not in ("number", "pi")]
            return len(moving) <= 1 and all(is_linear(nodes, f) for f in moving)
    return False


def is_turned(images: Images, base: int, exponent: int) -> bool:
    """Whether a power is one of a negative base to an integer, and not by the base's logarithm."""
    if not images.nodes.is_integer(exponent):
        return False
    logarithm = images.nodes.made("log", base)
    return images.known(logarithm) is None and images.signs.positive(_negative(images, base))


def power_of_negative(images: Images, base: int, exponent: int) -> Element:
    """f**n for f < 0."""
    turn = images.made("parity", exponent)
    return turn * images.made("power", _negative(images, base), exponent)


def _negative(images: Images, node: int) -> int:
    return images.nodes.made("Mul", images.nodes.rational(-1), node)


def opposite(images: Images, node: int) -> Element | None:
    """The image of an even or odd function, if the same one of -z is a generator."""
    name, z, *rest = images.nodes.all[node]
    own, order = rest[-1] if name == "jet" else (name, 0)
    if own not in (*axioms.EVEN, *axioms.ODD):
        return None
    found = images.known(images.nodes.made(name, _negative(images, z), *rest))
    return found if found is None or (own in axioms.EVEN) == (order % 2 == 0) else -found


def cylinder(images: Images, name: str, order: int, z: int) -> Element:
    """A Bessel function, from those of the orders v and v + 1 that are generators."""
    up, down = map(images.ring.number, CYLINDER[name])
    two, w = images.ring.number(2), images.image(z)
    for atom in images.atoms(name):
        _, v, other = images.nodes.all[atom]
        gap = images.image(order) - images.image(v)
        if gap.powers or not gap.numerator.is_constant() or not images.equal(z, other):
            continue
        steps = integer_of(gap.numerator.leading_coefficient())
        higher = images.made(name, images.nodes.made("Add", v, images.nodes.rational(1)), z)
        lower, v = images.image(atom), images.image(v)
        for _ in range(abs(steps)):
            if steps > 0:
                v = v + images.one
                lower, higher = higher, up * (down * lower - two * v / w * higher)
            else:
                lower, higher = down * (up * higher + two * v / w * lower), lower
                v = v - images.one
        return lower
    raise CertificateError(f"there is no generator for a {name}")


def share_of_turn(nodes: Nodes, z: int) -> fmpq | None:
    """q if a node is a product i pi q, with a number q of small denominator; else None."""
    share, names, waiting = fmpq(1), list[str](), [z]
    while waiting:
        match nodes.all[waiting.pop()]:
            case ("Mul", *factors):
                waiting += factors
            case ("number", value):
                share *= value
            case ("Pow", base, exponent) if exponent == -1 and (below := nodes.value(base)):
                share /= below
            case (str(name),):
                names.append(name)
            case _:
                return None
    return share if sorted(names) == ["I", "pi"] and share.q <= LARGEST_ORDER else None


def power_of_root_of_unity(images: Images, z: int) -> Element | None:
    """exp(z) = exp(s)**m for a generator exp(s), if z = m s up to a multiple of 2 i pi."""
    share = share_of_turn(images.nodes, z)
    if share is None:
        return None
    for atom in images.atoms("exp"):
        own = share_of_turn(images.nodes, images.nodes.all[atom][1])
        if own is None:
            continue
        for times in range(2 * int(own.q)):
            if ((times * own - share) / 2).q == 1:
                return images.image(atom) ** times
    return None


def cyclotomic_relation(root: Element, share: fmpq) -> tuple[int, Element]:
    """The degree of exp(i pi share), a root of unity, and that power of it in lower ones."""
    order = int(share.q) * (1 if share.p % 2 == 0 else 2)
    *lower, _ = [int(c) for c in fmpz_poly.cyclotomic(order).coeffs()]
    terms = [root.ring.number(-c) * root**n for n, c in enumerate(lower) if c]
    return len(lower), sum(terms[1:], terms[0])
