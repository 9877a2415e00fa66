"""Derivatives of generators and of what is made of them, by the axioms and the chain rule."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from flint import fmpq_mpoly

from . import axioms
from .axioms import SLOPES
from .images import Generator, Images
from .limits import CertificateError
from .ring import Element, Ring, common


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
        ring, numerator = self.ring, element.numerator
        result = self.along(numerator)
        raised = []
        for place, power in element.powers.items():
            slope, divides = self._factor_slope(place)
            if divides:
                result -= ring.product(power * slope, numerator)
            else:
                raised.append((place, power, slope))
        for place, _, _ in raised:
            result = ring.product(result, ring.factors[place])
        for place, power, slope in raised:
            term = ring.product(power * slope, numerator)
            for other, _, _ in raised:
                term = ring.product(term, ring.factors[other]) if other != place else term
            result -= term
        powers = dict(element.powers)
        for place, _, _ in raised:
            powers[place] += 1
        for place, power in self.below.items():
            powers[place] = powers.get(place, 0) + power
        return Element(ring, result, powers).cancelled()

    def _factor_slope(self, place: int) -> tuple[fmpq_mpoly, bool]:
        """The derivative of a factor (times the common denominator), over it where that goes."""
        if place not in self._moved:
            factor = self.ring.factors[place]
            slope = self.along(factor)
            quotient = self.ring.quotient(slope, factor)
            self._moved[place] = (slope, False) if quotient is None else (quotient, True)
        return self._moved[place]


class Slopes:
    """The derivatives of the generators of ``images``."""

    def __init__(self, images: Images) -> None:
        self._images = images
        self._slopes: dict[tuple[int, int], Element] = {}
        self._rates: dict[tuple[int, int], Element] = {}

    def slope(self, place: int, variable: int) -> Element:
        """The derivative of a generator."""
        if (place, variable) not in self._slopes:
            self._slopes[place, variable] = self._slope(self._images.generators[place], variable)
        return self._slopes[place, variable]

    def derivative(self, element: Element, variable: int) -> Element:
        """The chain rule, for the arguments of generators."""
        slopes = {place: self.slope(place, variable) for place in sorted(element.places)}
        return Derivation(self._images.ring, slopes)(element)

    def _slope(self, generator: Generator, variable: int) -> Element:
        images = self._images
        if generator.form:
            parts = [
                images.image(factor) * self._atom_slope(node, variable)
                for factor, node in generator.form
            ]
            return images.sum([self._rate(generator.shift, variable), *parts])
        image = images.image(generator.node)
        slope = self._atom_slope(generator.node, variable)
        if generator.scale is not None:
            scale = Element(images.ring, generator.scale)
            return slope * scale + image * self.derivative(scale, variable)
        if generator.below is not None:
            below = images.image(generator.below)
            return (slope - image * self._rate(generator.below, variable) / below) / below
        return slope

    def _atom_slope(self, node: int, variable: int) -> Element:
        """The axioms of differentiation."""
        images = self._images
        image = images.image(node)
        match images.nodes.all[node]:
            case ("symbol", *_):
                return images.one if node == variable else images.zero
            case ("I",) | ("pi",) | (("elliptic_k" | "elliptic_e"), _):
                return images.zero
            case ("parity", _) if images.nodes.all[variable][2] != "integer":
                return images.zero
            case ("Pow", *_) if node in self._images.circles.values():
                return images.zero
            case ("Pow", base, exponent):
                rate = self._rate(base, variable)
                factor = images.ring.number(exponent)
                return images.zero if rate.is_zero else factor * image * rate / images.image(base)
            case ("Abs", f):
                rate = self.derivative(images.squared(f), variable)
                return images.zero if rate.is_zero else rate / (image + image)
            case ("jet", z, *nome, (name, order)):
                slope = self._times(self._rate(z, variable), "jet", z, *nome, (name, order + 1))
                for q in nome:  # the heat equation
                    turn = self._rate(q, variable) / (images.ring.number(-4) * images.image(q))
                    slope = slope + self._times(turn, "jet", z, q, (name, order + 2))
                return slope
            case (str(name), *_) if name in SLOPES:
                letters = axioms.letters(images.nodes.all[node])
                rate = self._rate(letters["z"], variable)
                if rate.is_zero:
                    return images.zero
                return rate * images.image(axioms.read(images.nodes, SLOPES[name], **letters))
        raise CertificateError("the derivative of a generator does not follow from the axioms")

    def _times(self, rate: Element, *node: Any) -> Element:
        """A rate times the image of a node, which is not asked for if the rate is 0."""
        return rate if rate.is_zero else rate * self._images.made(*node)

    def _rate(self, node: int, variable: int) -> Element:
        """The derivative of a formula, by its structure."""
        if (node, variable) not in self._rates:
            self._rates[node, variable] = self._made_rate(node, variable)
        return self._rates[node, variable]

    def _made_rate(self, node: int, variable: int) -> Element:
        images = self._images
        if not images.moves(node):
            return images.zero
        match images.nodes.all[node]:
            case ("Add", *terms):
                return images.sum([self._rate(term, variable) for term in terms])
            case ("Mul", *factors):
                parts = []
                for i, factor in enumerate(factors):
                    rate = self._rate(factor, variable)
                    if not rate.is_zero:
                        others = (images.image(f) for j, f in enumerate(factors) if j != i)
                        parts.append(images.product([rate, *others]))
                return images.sum([images.zero, *parts])
            case ("Pow", base, exponent) if exponent.q == 1:
                power = images.image(base) ** (int(exponent.p) - 1)
                outer = images.ring.number(exponent) * power
                return outer * self._rate(base, variable)
            case (name, *_) if name == "symbol" or name in SLOPES:
                return self._atom_slope(node, variable)
        return self.derivative(images.image(node), variable)
