"""Polynomials in the generators over the rationals, modulo relations, and their fractions.

A relation ``g**n = value`` has only earlier generators in its value, so that dividing by the
relations, the last one first, gives a normal form.  A relation holds at every point, whether or
not it is irreducible: normal form 0 proves that a polynomial in the generators' meanings is 0.
The converse is never used.  Fractions are only added, multiplied, inverted and differentiated, so
their identities hold wherever no entry of `Ring.factors` vanishes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import reduce
from operator import or_

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx
from flint.utils.flint_exceptions import DomainError

from .limits import DEGREE, FACTOR_DEGREE, FACTOR_TERMS, HEIGHT, WORK, CertificateError, within

Powers = Mapping[int, int]


class Ring:
    """Ring of polynomials in ``count`` generators, with the ``factors`` of all denominators."""

    def __init__(self, count: int) -> None:
        self.names = tuple(f"g{place}" for place in range(count))
        self.context = fmpq_mpoly_ctx.get(self.names[::-1], Ordering.lex)
        self.generators: tuple[fmpq_mpoly, ...] = self.context.gens()[::-1]
        self.factors: list[fmpq_mpoly] = []
        self.relations: list[tuple[int, int, fmpq_mpoly]] = []
        self._work = 0

    def number(self, value: fmpq | int) -> Element:
        """Return a rational number as an element."""
        return Element(self, self.context.constant(value))

    def generator(self, place: int) -> Element:
        """Return generator number ``place`` as an element."""
        return Element(self, self.generators[place])

    def relate(self, place: int, degree: int, value: fmpq_mpoly) -> None:
        """Add the relation ``generators[place] ** degree = value``; ``value`` has lower powers."""
        *later, own = value.degrees()[: len(self.names) - place]
        if any(later) or own >= degree:
            raise CertificateError(f"the relation of generator {place} needs a later one")
        modulus = self.generators[place] ** degree - value
        self.relations.insert(0, (len(self.names) - 1 - place, degree, modulus))
        self.relations.sort(key=lambda relation: relation[0])

    def product(self, left: fmpq_mpoly, right: fmpq_mpoly) -> fmpq_mpoly:
        """Return the normal form of a product; raises CertificateError beyond the budget."""
        self.spend(len(left) * len(right))
        within("degrees", int(left.total_degree() + right.total_degree()), DEGREE)
        return self.reduced(left * right)

    def reduced(self, polynomial: fmpq_mpoly) -> fmpq_mpoly:
        """Return the normal form of a polynomial modulo the relations."""
        for index, degree, modulus in self.relations:
            top = int(polynomial.degrees()[index])
            if top >= degree:
                self.spend(len(polynomial) * len(modulus) * (top // degree))
                polynomial = divmod(polynomial, modulus)[1]
        return polynomial

    def roots(self) -> list[tuple[int, int, fmpq_mpoly]]:
        """Return (index in ``factors``, degree, value) of each factor that has a relation."""
        known = ((self.context.gens()[index], n, modulus) for index, n, modulus in self.relations)
        return [(self.factors.index(g), n, g**n - m) for g, n, m in known if g in self.factors]

    def spend(self, work: int) -> None:
        """Add ``work`` to the total; raises CertificateError if that exceeds the limit."""
        self._work = within("the work of polynomial products", self._work + work, WORK)

    def quotient(self, polynomial: fmpq_mpoly, factor: fmpq_mpoly) -> fmpq_mpoly | None:
        """Return ``polynomial / factor`` if it is a polynomial; else None."""
        try:
            return polynomial / factor
        except DomainError:
            return None

    def split(self, polynomial: fmpq_mpoly) -> tuple[fmpq, dict[int, int]]:
        """Return a number and powers of ``factors``, by index, whose product is ``polynomial``."""
        if len(polynomial) > FACTOR_TERMS or polynomial.total_degree() > FACTOR_DEGREE:
            unit, parts = fmpq(1), [(polynomial, 1)]
        else:
            unit, parts = polynomial.factor()
        powers: dict[int, int] = {}
        for part, power in parts:
            if part not in self.factors:
                self.factors.append(part)
            powers[self.factors.index(part)] = int(power)
        return unit, powers

    def multiplied_out(self, powers: Powers) -> fmpq_mpoly:
        """Return the product of ``factors[i] ** powers[i]`` as a polynomial."""
        product = self.context.constant(1)
        for place, power in powers.items():
            for _ in range(power):
                product = self.product(product, self.factors[place])
        return product


@dataclass(frozen=True)
class Element:
    """``numerator`` over the product of ``ring.factors[i] ** powers[i]``."""

    ring: Ring
    numerator: fmpq_mpoly
    powers: Powers = field(default_factory=dict)

    @property
    def is_zero(self) -> bool:
        """Whether the numerator's normal form is 0."""
        return bool(self.numerator.is_zero())

    @property
    def value(self) -> fmpq | None:
        """Rational value of the element; None if it is not a number."""
        if self.powers or not self.numerator.is_constant():
            return None
        return fmpq(0) if self.is_zero else self.numerator.leading_coefficient()

    @property
    def places(self) -> set[int]:
        """Indices of the generators that occur."""
        polynomials = (self.numerator, *(self.ring.factors[i] for i in self.powers))
        degrees = (reversed(polynomial.degrees()) for polynomial in polynomials)
        return {place for row in degrees for place, degree in enumerate(row) if degree > 0}

    def over(self, powers: Powers) -> fmpq_mpoly:
        """Return the numerator over the denominator ``powers``, a multiple of the element's own."""
        rest = self.ring.multiplied_out(Counter(powers) - Counter(self.powers))
        return self.ring.product(self.numerator, rest)

    def denominator(self) -> fmpq_mpoly:
        """Return the denominator as a polynomial."""
        return self.ring.multiplied_out(self.powers)

    def __add__(self, other: Element) -> Element:
        return total(self.ring, [self, other]).cancelled()

    def __neg__(self) -> Element:
        return Element(self.ring, -self.numerator, self.powers)

    def __sub__(self, other: Element) -> Element:
        return self + -other

    def __mul__(self, other: Element) -> Element:
        powers = Counter(self.powers) + Counter(other.powers)
        numerator = self.ring.product(self.numerator, other.numerator)
        return Element(self.ring, numerator, powers).cancelled()

    def __truediv__(self, other: Element) -> Element:
        return self * other.inverse()

    def __pow__(self, exponent: int) -> Element:
        base = self if exponent >= 0 else self.inverse()
        longest = max((c.height_bits() for c in base.numerator.coeffs()), default=0)
        within("the bits of a coefficient", longest * abs(exponent), HEIGHT)
        if len(base.numerator) == 1 and not base.powers and not self.ring.relations:
            within("degrees", int(base.numerator.total_degree()) * abs(exponent), DEGREE)
            return Element(self.ring, base.numerator ** abs(exponent))
        result = self.ring.number(1)
        size = len(base.numerator) * (longest + len(base.numerator).bit_length())
        for power in range(abs(exponent)):
            self.ring.spend(len(result.numerator) * size * power // 64)  # words of 64 bits
            result = result * base
        return result

    def inverse(self) -> Element:
        """Return ``1 / self``; raises CertificateError if the normal form is 0."""
        if self.is_zero:
            raise CertificateError("a denominator vanishes identically")
        unit, powers = self.ring.split(self.numerator)
        inverse = Element(self.ring, self.denominator() / unit, powers).cancelled()
        for place, degree, value in self.ring.roots():
            power = inverse.powers.get(place, 0)
            if power:  # 1/g = g**(degree - 1)/value
                factor = self.ring.factors[place]
                rest = {i: n for i, n in inverse.powers.items() if i != place}
                whole, above = Element(self.ring, inverse.numerator, rest), factor ** (degree - 1)
                other = Element(self.ring, above) * Element(self.ring, value).inverse()
                inverse = whole * other**power
        return inverse

    def cancelled(self) -> Element:
        """Return the element without common factors of numerator and denominator."""
        if self.is_zero or not self.powers:
            return Element(self.ring, self.numerator)
        numerator, powers = self.numerator, dict(self.powers)
        for place in self.powers:
            factor = self.ring.factors[place]
            while powers[place] and (quotient := self.ring.quotient(numerator, factor)) is not None:
                numerator, powers[place] = quotient, powers[place] - 1
        return Element(self.ring, numerator, {i: n for i, n in powers.items() if n})


def common(elements: Iterable[Element]) -> Counter[int]:
    """Return the least common denominator of elements, as powers of the ring's factors."""
    return reduce(or_, (Counter(element.powers) for element in elements), Counter())


def total(ring: Ring, elements: Sequence[Element]) -> Element:
    """Return the sum of elements over their least common denominator, not cancelled."""
    below = common(elements)
    numerator = ring.context.constant(0)
    for element in elements:
        numerator += element.over(below)
    return Element(ring, numerator, below)


class Derivation:
    """Derivation of the ring that maps each generator to its slope, 0 unless given."""

    def __init__(self, ring: Ring, slopes: Mapping[int, Element]) -> None:
        self.ring = ring
        self.slopes = {i: slope for i, slope in slopes.items() if not slope.is_zero}
        self.below = common(self.slopes.values())
        self._steps = {i: slope.over(self.below) for i, slope in self.slopes.items()}
        self._moved: dict[int, tuple[fmpq_mpoly, bool]] = {}

    def along(self, polynomial: fmpq_mpoly) -> fmpq_mpoly:
        """Return a polynomial's derivative, multiplied by the common denominator of the slopes."""
        total = self.ring.context.constant(0)
        for place, step in self._steps.items():
            partial = polynomial.derivative(self.ring.names[place])
            if not partial.is_zero():
                total += self.ring.product(partial, step)
        return total

    def __call__(self, element: Element) -> Element:
        """Return (N/F)' = N'/F - sum of n N f'/(f F), where F is the product of factors f**n."""
        powers = Counter(element.powers) + self.below
        parts = [Element(self.ring, self.along(element.numerator), powers)]
        for place, power in element.powers.items():
            slope, divides = self._factor_slope(place)
            above = self.ring.product(-power * slope, element.numerator)
            raised = powers if divides else powers + Counter([place])
            parts.append(Element(self.ring, above, raised))
        return total(self.ring, parts).cancelled()

    def _factor_slope(self, place: int) -> tuple[fmpq_mpoly, bool]:
        """Return a factor's derivative by `along`, and whether it was divided by the factor."""
        if place not in self._moved:
            factor = self.ring.factors[place]
            slope = self.along(factor)
            quotient = self.ring.quotient(slope, factor)
            self._moved[place] = (slope, False) if quotient is None else (quotient, True)
        return self._moved[place]
