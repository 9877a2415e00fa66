"""Rules for exponentials, roots of unity and powers of negative numbers without generators.

A sum in the exponent is split term by term.  exp(i pi k/n), k and n coprime, is a primitive root
of unity, of order n for even k and 2 n for odd k, and a root of the cyclotomic polynomial.  For an
integer n and f < 0, f**n = (-1)**n (-f)**n.
"""

from __future__ import annotations

from functools import reduce
from operator import mul

from flint import fmpq, fmpz_poly

from .field import Field
from .limits import CertificateError
from .nodes import Nodes
from .ring import Element
from .root_rules import angle_of, whole

UNITY = {1: "-1", 2: "I", 3: "(1 + I*sqrt(3))/2", 4: "(1 + I)*sqrt(2)/2", 6: "(sqrt(3) + I)/2"}
"""exp(i pi/n) as text, by n."""

PHASE, HALF_PHASE = "(1 + I*z)/(1 - I*z)", "(1 + I*z)/sqrt(1 + z**2)"
"""Formulas of exp(2 i atan z) and of exp(i atan z)."""

LARGEST_ORDER = 60
"""Largest denominator of q for which exp(i pi q) gets a relation."""


def exponential_of_lambert(field: Field, node: int) -> Element | None:
    """Apply exp(n W(f)) = (f/W(f))**n."""
    times, u = field.nodes.multiple(field.nodes.all[node][1])
    name, *arguments = field.nodes.all[u]
    if name != "lambert_w":
        return None
    return (field.image(arguments[0]) / field.image(u)) ** whole(times)


def turn_of(nodes: Nodes, z: int) -> tuple[fmpq, list[int]] | None:
    """Return the rational q and the factors f, g, ... of a node i pi q f g ...; else None."""
    fraction, letters, others, waiting = fmpq(1), list[str](), list[int](), [z]
    while waiting:
        factor = waiting.pop()
        match nodes.all[factor]:
            case ("Mul", *factors):
                waiting += factors
            case ("number", value):
                fraction *= value
            case ("Pow", base, exponent) if exponent == -1 and (below := nodes.value(base)):
                fraction /= below
            case ("I" | "pi" as letter,):
                letters.append(letter)
            case _:
                others.append(factor)
    return (fraction, others) if sorted(letters) == ["I", "pi"] else None


def fraction_of_turn(nodes: Nodes, z: int) -> fmpq | None:
    """Return q of a node i pi q if q is rational with denominator <= `LARGEST_ORDER`; else None."""
    fraction, others = turn_of(nodes, z) or (None, [])
    return fraction if fraction is not None and not others and fraction.q <= LARGEST_ORDER else None


def cyclotomic_relation(field: Field, node: int) -> tuple[int, Element] | None:
    """Return the degree n of w = exp(i pi q), and w**n in lower powers; else None."""
    fraction = fraction_of_turn(field.nodes, field.nodes.all[node][1])
    if fraction is None:
        return None
    order = int(fraction.q) * (1 if fraction.p % 2 == 0 else 2)
    *lower, _ = [int(c) for c in fmpz_poly.cyclotomic(order).coeffs()]
    root = field.ring.generator(len(field.generators))
    return len(lower), field.sum([field.ring.number(-c) * root**n for n, c in enumerate(lower)])


def root_of_unity(field: Field, node: int) -> Element | None:
    """Return exp(i pi q) as a power of a generator or of an entry of `UNITY`; else None."""
    fraction = fraction_of_turn(field.nodes, field.nodes.all[node][1])
    if fraction is None:
        return None
    for other in field.primitives("exp"):
        own = fraction_of_turn(field.nodes, field.nodes.all[other][1]) or fmpq(0)
        for times in range(2 * int(own.q)):
            if ((times * own - fraction) / 2).q == 1:
                return field.image(other) ** times
    first = UNITY.get(int(fraction.q))
    return None if first is None else field.read(first) ** (int(fraction.p) % (2 * int(fraction.q)))


def turns_of_integer(field: Field, node: int) -> Element | None:
    """Return exp(i pi j n): 1 for even j; for odd j (-1)**n, if such a power is a generator."""
    fraction, others = turn_of(field.nodes, field.nodes.all[node][1]) or (fmpq(1, 2), [])
    if fraction.q != 1 or not others or not all(map(field.nodes.is_integer, others)):
        return None
    if fraction.p % 2 == 0:
        return field.one
    power = field.nodes.add("parity", field.nodes.product(*others))
    return field.image(power) if field.primitives("parity") else None


def phase_of_arctangent(field: Field, node: int) -> Element | None:
    """Return exp(n i atan f): `PHASE` to the power n // 2, times `HALF_PHASE` for odd n."""
    times, u = field.nodes.multiple(field.nodes.all[node][1])
    angle = angle_of(field, u)
    if angle is None or field.nodes.all[angle][0] != "atan":
        return None
    f, n = field.nodes.all[angle][1], whole(times)
    even = field.read(PHASE, z=f) ** (n // 2)
    return even * field.read(HALF_PHASE, z=f) if n % 2 else even


def parity_relation(field: Field, node: int) -> tuple[int, Element]:
    """Return the relation of g = (-1)**n for an integer symbol n: degree 2, and g**2 = 1."""
    if field.nodes.all[field.nodes.all[node][1]][::2] != ("symbol", "integer"):
        raise CertificateError("parity is no generator")
    return 2, field.one


def parity(field: Field, node: int) -> Element:
    """Return (-1)**z for a sum z of integers and of integer multiples of integer symbols."""
    z = field.nodes.all[node][1]
    terms, (times, rest) = field.nodes.terms(z), field.nodes.multiple(z)
    if len(terms) > 1:
        return field.product([field.nodes.add("parity", term) for term in terms])
    if field.nodes.value(z) is not None:
        return field.one if whole(times) % 2 == 0 else -field.one
    if rest == z:
        raise CertificateError("exponents of -1 must be sums of integers")
    return field.image_of("parity", rest) ** whole(times)


def power_of_negative(field: Field, node: int) -> Element | None:
    """Return f**n = (-1)**n (-f)**n for f < 0 and an integer n, unless log f is a generator."""
    _, base, exponent = field.nodes.all[node]
    negative = field.nodes.negative(base)
    turns = field.nodes.is_integer(exponent) and field.signs.positive(negative)
    if not turns or field.known(field.nodes.add("log", base)) is not None:
        return None
    return field.image_of("parity", exponent) * field.image_of("power", negative, exponent)


def exponential(field: Field, node: int) -> Element:
    """Apply exp(u + v) = exp(u) exp(v), exp(n u) = exp(u)**n, exp(q log f) = f**q."""
    z = field.nodes.all[node][1]
    terms = field.nodes.terms(z)
    if len(terms) > 1:
        return reduce(mul, (field.image_of("exp", term) for term in terms))
    times, u = field.nodes.multiple(z)
    if field.nodes.all[u][0] == "log":
        f = field.nodes.all[u][1]
        return field.image(f) if times == 1 else field.image_of("Pow", f, times)
    if times == 0:
        field.image(u)  # a divisor in it counts, though it is multiplied by 0
        return field.one
    if u == z:
        raise CertificateError("there is no generator for a function of a sum")
    return field.image_of("exp", u) ** whole(times)
