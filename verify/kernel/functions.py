"""Values of functions that are no generators, by the axioms, where their premises are shown.

Roots and absolute values (which value is the principal one), exp, log and atan of sums and
products, and Jacobi functions by the addition theorems.
"""

from __future__ import annotations

from collections.abc import Mapping

from flint import fmpq

from . import axioms, further
from .axioms import DEFINITIONS, UNITY, Station
from .images import Images, integer_of
from .limits import CertificateError
from .nodes import CYLINDER
from .ring import Element
from .signs import BELOW_ONE, HALF_PI


def root(images: Images, node: int, base: int, q: int) -> Element:
    """base**(1/q): a value whose power and whose branch are checked."""
    value = images.named(node)
    if not (images.image(value) ** q - images.image(base)).is_zero:
        raise CertificateError(f"the power {q} of what a root is said to be is another")
    shown = images.signs.not_negative(value) or _is_scaled_root(images, value, q)
    if not shown and not (q == 2 and _is_principal(images, value)):
        raise CertificateError("what a root is said to be is not shown to be >= 0 there")
    return images.image(value)


def _is_scaled_root(images: Images, node: int, q: int) -> bool:
    """Whether a value is r f**(1/q) with r >= 0, the root of r**q f whatever f is."""
    match images.nodes.all[node]:
        case ("Mul", *factors):
            rest = [f for f in factors if not images.signs.not_negative(f)]
            return len(rest) == 1 and images.nodes.all[rest[0]][::2] == ("Pow", fmpq(1, q))
    return False


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


def exponential(images: Images, z: int) -> Element:
    """exp(sum n u) = product of exp(u)**n; exp(q log f) = f**q, exp(W(f)) = f/W(f)."""
    nodes, result = images.nodes, images.one
    root = further.power_of_root_of_unity(images, z)
    if root is not None:
        return root
    for coefficient, u in images.sum_of(nodes.made("exp", z)):
        inner = nodes.all[u]
        angle = angle_of(images, u)
        if inner[0] == "log":
            result = result * images.made("Pow", inner[1], coefficient)
        elif inner[0] == "lambert_w":
            quotient = images.image(inner[1]) / images.image(u)
            result = result * quotient ** integer_of(coefficient)
        elif angle is not None and nodes.all[angle] == ("pi",) and int(coefficient.q) in UNITY:
            first = images.image(axioms.read(nodes, UNITY[int(coefficient.q)]))
            result = result * first ** (int(coefficient.p) % (2 * int(coefficient.q)))
        elif angle is not None and nodes.all[angle][0] == "atan":
            times, f = integer_of(coefficient), nodes.all[angle][1]
            result = result * images.image(axioms.read(nodes, axioms.PHASE, z=f)) ** (times // 2)
            if times % 2:
                result = result * images.image(axioms.read(nodes, axioms.HALF_PHASE, z=f))
        else:
            result = result * images.made("exp", u) ** integer_of(coefficient)
    return result


def logarithm(images: Images, node: int, inner: int) -> Element:
    """log of a product of powers of positive factors, and of one factor of any kind."""
    factors = images.hinted(images.hints.logs, node)
    if factors is None:
        raise CertificateError("there is no generator for a log")
    product, total = images.one, images.zero
    others = {f: _angle_value(images, f) for _, f in factors if not images.signs.not_negative(f)}
    powers = [q for q, f in factors if f in others]
    if powers not in ([], [1]) or (inner in others and others[inner] is None):
        raise CertificateError("a factor in a logarithm is not shown to be positive")
    for q, factor in factors:
        # It is not 0 where the logarithm is smooth.
        product = product * images.image(images.nodes.made("Pow", factor, q))
        part, value = images.nodes.all[factor], others.get(factor)
        if value is None:
            real = part[0] == "exp" and factor not in others
            value = images.image(part[1]) if real else images.made("log", factor)
        total = total + images.ring.number(q) * value
    if product.is_zero or not (product - images.image(inner)).is_zero:
        raise CertificateError("a logarithm is not of the product that it is said to be of")
    return total


def _angle_value(images: Images, phase: int) -> Element | None:
    """log exp(i r) = i r for abs r < pi, and log i = i pi/2; None for what is no such phase."""
    match images.nodes.all[phase]:
        case ("I",):
            quarter = images.made("pi") * images.ring.number(fmpq(1, 2))
            return images.image(phase) * quarter
        case ("exp", z):
            angle = angle_of(images, z)
            if angle is not None and images.signs.is_between(angle, -2 * HALF_PI, 2 * HALF_PI):
                return images.image(z)
    return None


PRINCIPAL: Mapping[str, tuple[fmpq | None, fmpq | None]] = {
    "asin": (-HALF_PI, HALF_PI),
    "acos": (fmpq(0), 2 * HALF_PI),
    "atan": (-HALF_PI, HALF_PI),
    "asinh": (None, None),
    "acosh": (fmpq(0), None),
    "atanh": (None, None),
}
"""Between which real numbers the values of inverse functions lie."""


def inverse_function(images: Images, node: int, name: str, inner: int) -> Element:
    """By definition, or the principal one of the numbers of which the function is ``inner``."""
    value = images.hinted(images.hints.values, node)
    if value is None and name != "atan":
        return images.image(axioms.defined(images.nodes, name, inner))
    value = images.named(node)
    shown = images.signs.is_between(value, *PRINCIPAL[name])
    if not (shown or images.is_kept(name, inner, value)):
        raise CertificateError(f"what an {name} is said to be is not shown to be a principal value")
    if not is_value(images, name, inner, value):
        raise CertificateError(f"what an {name} is said to be is that of another argument")
    return images.image(value)


def is_value(images: Images, name: str, f: int, value: int) -> bool:
    """Whether a function of ``value`` is ``f``: tan v if exp(2 i v) = (1 + i f)/(1 - i f)."""
    made = images.nodes.made
    turned = made("exp", made("Mul", images.nodes.rational(2), made("I"), value))
    if name == "atan" and images.hinted(images.hints.sums, turned) is not None:
        phase = images.image(axioms.read(images.nodes, axioms.PHASE, z=f))
        return (images.image(turned) - phase).is_zero
    return (images.made(axioms.INVERSE_OF[name], value) - images.image(f)).is_zero


def parity(images: Images, z: int) -> Element:
    """(-1)**z of a sum of integer symbols times integers, and of an integer."""
    nodes = images.nodes
    match nodes.all[z]:
        case ("number", value):
            return images.one if integer_of(value) % 2 == 0 else -images.one
        case ("Add", *terms):
            return images.product([images.made("parity", term) for term in terms])
        case ("Mul", *factors):
            numbers = [f for f in factors if nodes.value(f) is not None]
            rest = [f for f in factors if f not in numbers]
            if len(numbers) == len(rest) == 1:
                return images.made("parity", *rest) ** integer_of(nodes.all[numbers[0]][1])
    raise CertificateError("a power of -1 must be to a sum of integers")


ABOVE_ZERO = ("jacobi_theta", "jacobi_eta", "jet")
"""Functions whose parameter, or nome, must be greater than 0."""


class Functions:
    """Images of roots and functions, of generators or of what follows from them."""

    def __init__(self, images: Images) -> None:
        self._images = images
        self._stations: dict[tuple[int, int, str], Station] = {}

    def need_parameters(self, node: int) -> None:
        """All arguments but z are constant, or integers, or a nome; m and that are in range."""
        images, name = self._images, self._images.nodes.all[node][0]
        rest = [u for letter, u in axioms.letters(images.nodes.all[node]).items() if letter != "z"]
        real = {v for v in images.variables if images.nodes.all[v][2] == "real"}
        if name != "jet" and real & set(images.nodes.below(rest)):
            raise CertificateError(f"the parameters of {name} must be constant")
        if name in (*BELOW_ONE, "jet") and not all(map(images.signs.below_one, rest)):
            raise CertificateError(f"{name} needs m < 1, which is not shown on the domain")
        if name in ABOVE_ZERO and not all(map(images.signs.positive, rest)):
            raise CertificateError(f"{name} needs m > 0, which is not shown on the domain")

    def value(self, node: int) -> Element:
        """The image of a root or function; raises CertificateError where it does not follow."""
        images = self._images
        known = images.known(node)
        if known is not None:
            return known
        match images.nodes.all[node]:
            case ("Pow", base, exponent):
                return root(images, node, base, int(exponent.q))
            case ("exp", z):
                return exponential(images, z)
            case ("log", f):
                return logarithm(images, node, f)
            case (str(name), f) if name in PRINCIPAL:
                return inverse_function(images, node, name, f)
            case ("Abs", f):
                return absolute_value(images, node, f)
            case ("conjugate", f):
                return images.image(images.signs.conjugate(f))
            case ("diff", _, *variables):
                inner = images.nodes.made("diff", *images.nodes.all[node][1:-1])
                lower = images.image(inner if variables[1:] else images.nodes.all[node][1])
                return images.derivative(lower, variables[-1])
            case ("power", base, exponent) if further.is_turned(images, base, exponent):
                return further.power_of_negative(images, base, exponent)
            case ("parity", z):
                return parity(images, z)
            case (str(name), v, z) if name in CYLINDER:
                return further.cylinder(images, name, v, z)
            case _ if (turned := further.opposite(images, node)) is not None:
                return turned
            case (name, z, m) if name.startswith("jacobi_"):
                self.need_parameters(node)
                return self._jacobi(name.removeprefix("jacobi_"), z, m)
            case (name, *arguments) if name in DEFINITIONS:
                return images.image(axioms.defined(images.nodes, name, *arguments))
        raise CertificateError(f"there is no generator for a {images.nodes.all[node][0]}")

    def _jacobi(self, name: str, z: int, m: int) -> Element:
        """A Jacobi function, by the addition theorems."""
        images = self._images
        if name == "theta":
            return self._theta(z, m)
        if name == "eta" or (name == "zeta" and not images.atoms("jacobi_zeta")):
            return images.image(axioms.defined(images.nodes, f"jacobi_{name}", z, m))
        station = self._station(z, m, name if name in ("epsilon", "zeta") else "")
        if name in ("epsilon", "zeta"):
            if station.second is None:
                return images.zero
            return station.second
        found: Element = getattr(station, name)
        return found

    def _station(self, z: int, m: int, second: str) -> Station:
        images = self._images
        if (z, m, second) not in self._stations:
            found = images.sum_of(images.nodes.made("jacobi_sn", z, m))
            parts = [(integer_of(n), u) for n, u in found]
            total: Station | None = None
            for n, u in parts:
                if n:
                    step = self._base(u, m, second).times(n)
                    total = step if total is None else total + step
            if total is None:
                zero, one = images.zero, images.one
                total = Station(images.image(m), zero, one, one, zero)
            self._stations[z, m, second] = total
        return self._stations[z, m, second]

    def _base(self, u: int, m: int, second: str) -> Station:
        """A generator's argument, or K, or again a sum."""
        images = self._images
        made, parameter = images.nodes.made, images.image(m)
        if images.nodes.all[u] == ("elliptic_k", m):
            negative = made("Mul", images.nodes.rational(-1), m)
            rest = made("Add", images.nodes.rational(1), negative)
            dn = images.image(made("Pow", rest, fmpq(1, 2)))
            value = images.made("elliptic_e", m) if second == "epsilon" else images.zero
            return Station(parameter, images.one, images.zero, dn, value)
        names = [f"jacobi_{name}" for name in ("sn", "cn", "dn", second) if name]
        return Station(parameter, *(images.made(name, u, m) for name in names))

    def _theta(self, z: int, m: int) -> Element:
        """Theta is even; Theta(u-d) by the product theorem."""
        images = self._images
        for atom in images.atoms("jacobi_theta"):
            _, other, parameter = images.nodes.all[atom]
            if images.equal(m, parameter) and (images.image(z) + images.image(other)).is_zero:
                return images.image(atom)
        match images.sum_of(images.nodes.made("jacobi_theta", z, m)):
            case ((plus, u), (minus, d)) if plus == 1 and minus == -1:
                return images.image(axioms.read(images.nodes, axioms.BEHIND, u=u, d=d, m=m))
        raise CertificateError("theta's argument must be a difference of two")
