"""The exact half of the checker: the residual's numerator, multiplied out and divided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce
from operator import mul
from typing import Any

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

Powers = tuple[int, ...]


@dataclass(frozen=True)
class Element:
    """``numerator`` over the factors to ``powers``."""

    numerator: fmpq_mpoly
    powers: Powers


class Identity:
    """The certificate's generators as polynomials, with its slopes and relations."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        generators = data["generators"]
        self.names = [generator["name"] for generator in generators]
        if len(set(self.names)) != len(self.names):
            raise ValueError(f"generators must differ in name, got {self.names} (prove it anew)")
        self.context = fmpq_mpoly_ctx.get(tuple(self.names[::-1]), Ordering.lex)
        self.gens = self.context.gens()[::-1]
        self.factors = [self.polynomial(factor) for factor in data["factors"]]
        self.relations = [
            self._relation(place, *relation)
            for place, generator in reversed(list(enumerate(generators)))
            for relation in generator["relation"]
        ]
        self.image = self.element(data["image"])
        self.known = {place: self.element(value) for place, value in data["coefficients"]}
        count = len(data["variables"])
        self.slopes = [
            [self.element(generator["slopes"][v]) for generator in generators] for v in range(count)
        ]
        self._jets: dict[tuple[int, ...], Element] = {(0,) * count: self.image}

    def polynomial(self, terms: Sequence[Any]) -> fmpq_mpoly:
        """A polynomial from its terms."""
        found = {}
        for coefficient, exponents in terms:
            monomial = tuple(exponents[::-1])
            if len(monomial) != len(self.names) or monomial in found:
                raise ValueError(f"exponents must fit the generators, got {monomial} (prove anew)")
            found[monomial] = fraction(coefficient)
        return self.context.from_dict(found)

    def element(self, data: Mapping[str, Any]) -> Element:
        """A fraction from its data."""
        powers = [0] * len(self.factors)
        for place, power in data["denominator"]:
            powers[place] += power
        return Element(self.polynomial(data["numerator"]), tuple(powers))

    def residual(self, equation: Sequence[Any]) -> fmpq_mpoly:
        """The numerator of the residual modulo the relations."""
        terms = [self._term(*term) for term in equation]
        top = tuple(map(max, zip(*(term.powers for term in terms), strict=True)))
        return sum((self._over(term, top) for term in terms), self.context.constant(0))

    def reduced(self, polynomial: fmpq_mpoly) -> fmpq_mpoly:
        """The remainder of the division by the relations, the last generator first."""
        for relation in self.relations:
            polynomial = divmod(polynomial, relation)[1]
        return polynomial

    def _relation(self, place: int, degree: int, terms: Sequence[Any]) -> fmpq_mpoly:
        value = self.polynomial(terms)
        if any(value.degrees()[: len(self.names) - place]):
            raise ValueError(
                f"relations must be in earlier generators, got that of {self.names[place]} "
                "(prove it anew)"
            )
        return self.gens[place] ** degree - value

    def _term(self, number: str, known: Sequence[int], jets: Sequence[Sequence[int]]) -> Element:
        parts = [self.known[place] for place in known] + [self._jet(tuple(jet)) for jet in jets]
        unit = Element(self.context.constant(fraction(number)), (0,) * len(self.factors))
        return reduce(self._product, parts, unit)

    def _product(self, left: Element, right: Element) -> Element:
        powers = tuple(map(sum, zip(left.powers, right.powers, strict=True)))
        return Element(self.reduced(left.numerator * right.numerator), powers)

    def _over(self, element: Element, top: Powers) -> fmpq_mpoly:
        missing = [a - b for a, b in zip(top, element.powers, strict=True)]
        factors = [f for f, n in zip(self.factors, missing, strict=True) for _ in range(n)]
        return reduce(lambda a, b: self.reduced(a * b), factors, element.numerator)

    def _jet(self, orders: tuple[int, ...]) -> Element:
        if orders not in self._jets:
            place = next(i for i, order in enumerate(orders) if order)
            lower = tuple(order - (i == place) for i, order in enumerate(orders))
            self._jets[orders] = self._derivative(self._jet(lower), place)
        return self._jets[orders]

    def _derivative(self, element: Element, variable: int) -> Element:
        """(N'/d) / F - N F'/(d F**2) for N/F, with every slope over the denominator d."""
        slopes = self.slopes[variable]
        below = tuple(map(max, zip(*(slope.powers for slope in slopes), strict=True)))
        steps = [self._over(slope, below) for slope in slopes]
        present = [i for i, power in enumerate(element.powers) if power]
        moved = {i: self._along(self.factors[i], steps) for i in present}
        raised = [i for i in present if not moved[i].is_zero()]
        total = reduce(
            mul, (self.factors[i] for i in raised), self._along(element.numerator, steps)
        )
        for i in raised:
            others = (self.factors[j] for j in raised if j != i)
            start = element.powers[i] * moved[i] * element.numerator
            total -= reduce(lambda a, b: self.reduced(a * b), others, start)
        powers = [a + b for a, b in zip(element.powers, below, strict=True)]
        for i in raised:
            powers[i] += 1
        return self._cancelled(self.reduced(total), powers)

    def _along(self, polynomial: fmpq_mpoly, steps: Sequence[fmpq_mpoly]) -> fmpq_mpoly:
        parts = zip(self.names, steps, strict=True)
        total = sum(
            (polynomial.derivative(name) * step for name, step in parts), self.context.constant(0)
        )
        return self.reduced(total)

    def _cancelled(self, numerator: fmpq_mpoly, powers: list[int]) -> Element:
        for i, factor in enumerate(self.factors):
            while powers[i] and not numerator.is_zero():
                quotient, rest = divmod(numerator, factor)
                if not rest.is_zero():
                    break
                numerator, powers[i] = quotient, powers[i] - 1
        return Element(numerator, tuple(powers))


def fraction(text: str) -> fmpq:
    """A rational number written ``p`` or ``p/q``."""
    parts = [int(part) for part in text.split("/")]
    return fmpq(*parts)
