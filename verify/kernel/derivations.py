"""Derivatives of generators and of what is made of them, by the axioms and the chain rule."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from flint import fmpq_mpoly

from .axioms import FUNCTIONS
from .limits import CertificateError
from .ring import Element, Ring, common, total

if TYPE_CHECKING:
    from .field import Field

RATES: dict[str, Callable[[Slopes, Field, int, int], Element]] = {}
"""Derivatives of functions that are told by no formula, along a variable."""


class Derivation:
    """The derivation of the ring that takes each generator to its slope."""

    def __init__(self, ring: Ring, slopes: Mapping[int, Element]) -> None:
        self.ring = ring
        self.slopes = {i: slope for i, slope in slopes.items() if not slope.is_zero}
        self.below = common(self.slopes.values())
        self._steps = {i: slope.over(self.below) for i, slope in self.slopes.items()}
        self._moved: dict[int, tuple[fmpq_mpoly, bool]] = {}

    def along(self, polynomial: fmpq_mpoly) -> fmpq_mpoly:
        """The derivative of a polynomial times the common denominator of the slopes."""
        total = self.ring.context.constant(0)
        for place, step in self._steps.items():
            partial = polynomial.derivative(self.ring.names[place])
            if not partial.is_zero():
                total += self.ring.product(partial, step)
        return total

    def __call__(self, element: Element) -> Element:
        """(N / F)' for F a product of powers of factors f: N'/F - sum of n N f'/(f F)."""
        powers = Counter(element.powers) + self.below
        parts = [Element(self.ring, self.along(element.numerator), powers)]
        for place, power in element.powers.items():
            slope, divides = self._factor_slope(place)
            above = self.ring.product(-power * slope, element.numerator)
            raised = powers if divides else powers + Counter([place])
            parts.append(Element(self.ring, above, raised))
        return total(self.ring, parts).cancelled()

    def _factor_slope(self, place: int) -> tuple[fmpq_mpoly, bool]:
        """The derivative of a factor (times the common denominator), over it where that goes."""
        if place not in self._moved:
            factor = self.ring.factors[place]
            slope = self.along(factor)
            quotient = self.ring.quotient(slope, factor)
            self._moved[place] = (slope, False) if quotient is None else (quotient, True)
        return self._moved[place]


class Slopes:
    """The derivatives of the generators of a field, and of all that is made of them."""

    def __init__(self, field: Field) -> None:
        self._of = field
        self._slopes: dict[tuple[int, int], Element] = {}
        self._rates: dict[tuple[int, int], Element] = {}
        self._derivations: dict[int, tuple[frozenset[int], Derivation]] = {}

    def derivative(self, element: Element, variable: int) -> Element:
        """The derivative of an element, by the slopes of its generators."""
        known, derivation = self._derivations.get(variable, (frozenset[int](), None))
        if derivation is None or not element.places <= known:
            slopes = {p: self.slope(p, variable) for p in sorted(known | element.places)}
            derivation = Derivation(self._of.ring, slopes)
            self._derivations[variable] = frozenset(slopes), derivation
        return derivation(element)

    def slope(self, place: int, variable: int) -> Element:
        """The derivative of a generator."""
        if (place, variable) not in self._slopes:
            self._slopes[place, variable] = self._slope(place, variable)
        return self._slopes[place, variable]

    def _slope(self, place: int, variable: int) -> Element:
        generator = self._of.generators[place]
        rate, scale = self.rate(generator.formula, variable), generator.scale
        if scale.is_one():
            return rate
        factor = Element(self._of.ring, scale)
        image = self._of.ring.generator(place) / factor
        return rate * factor + image * self.derivative(factor, variable)

    def rate(self, node: int, variable: int) -> Element:
        """The derivative of a formula, by its structure and the axioms."""
        if (node, variable) not in self._rates:
            moves = variable in self._of.nodes.below([node])
            self._rates[node, variable] = (
                self._made_rate(node, variable) if moves else self._of.zero
            )
        return self._rates[node, variable]

    def _made_rate(self, node: int, variable: int) -> Element:
        field = self._of
        match field.nodes.all[node]:
            case ("symbol", *_):
                return field.one
            case ("Add", *terms):
                return field.sum([self.rate(term, variable) for term in terms])
            case ("Mul", *factors):
                parts = [field.zero]
                for i, factor in enumerate(factors):
                    rate = self.rate(factor, variable)
                    if not rate.is_zero:
                        others = [f for j, f in enumerate(factors) if j != i]
                        parts.append(rate * field.product(others) if others else rate)
                return field.sum(parts)
            case ("Pow", base, exponent) if node in field.primitives("Pow"):
                rate = field.ring.number(exponent) * self.rate(base, variable)
                return rate if rate.is_zero else rate * field.image(node) / field.image(base)
            case ("Pow", base, exponent) if exponent.q == 1:
                outer = field.image(base) ** (int(exponent.p) - 1)
                return field.ring.number(exponent) * outer * self.rate(base, variable)
            case ("Abs", f) if node in field.primitives("Abs"):
                rate = self.derivative(field.squared(f), variable)
                return rate if rate.is_zero else rate / (field.image(node) + field.image(node))
            case (str(name), *_) if name in RATES:
                return RATES[name](self, field, node, variable)
            case (str(name), *arguments) if name in FUNCTIONS and FUNCTIONS[name].slope:
                letters = FUNCTIONS[name].arguments(*arguments)
                rate = self.rate(letters["z"], variable)
                return rate if rate.is_zero else rate * field.read(FUNCTIONS[name].slope, **letters)
            case (name, *_) if node in field.primitives(name):
                raise CertificateError("a generator's derivative does not follow from the axioms")
        return self.derivative(field.image(node), variable)
