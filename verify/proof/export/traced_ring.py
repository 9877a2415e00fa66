"""The checker's ring with elements that record their provenance, and the recorded steps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flint import fmpq

from longwave.verify.kernel.ring import Element, Ring

from . import terms
from .terms import Step, Term, Vanishing


@dataclass(frozen=True)
class TracedElement(Element):
    """Element of the checker's ring with the term that describes its provenance."""

    term: Term = ("number", fmpq(0))

    @property
    def plain(self) -> Element:
        """The element without its term."""
        return Element(self.ring, self.numerator, self.powers)

    @property
    def is_zero(self) -> bool:
        """Whether the normal form is 0; if so it is recorded, since a step may depend on it."""
        vanishes = self.plain.is_zero
        if vanishes and isinstance(self.ring, TracedRing):
            self.ring.trace.vanishing(self.term, "a premise")
        return vanishes

    def __add__(self, other: Element) -> TracedElement:
        other = followed(other)
        return traced(self.plain + other.plain, terms.added([self.term, other.term]))

    def __radd__(self, other: Element) -> TracedElement:
        return followed(other) + self

    def __neg__(self) -> TracedElement:
        return traced(-self.plain, terms.negated(self.term))

    def __sub__(self, other: Element) -> TracedElement:
        return self + -followed(other)

    def __rsub__(self, other: Element) -> TracedElement:
        return followed(other) - self

    def __mul__(self, other: Element) -> TracedElement:
        other = followed(other)
        return traced(self.plain * other.plain, terms.multiplied([self.term, other.term]))

    def __rmul__(self, other: Element) -> TracedElement:
        return followed(other) * self

    def __truediv__(self, other: Element) -> TracedElement:
        return self * _inverse(other)

    def __rtruediv__(self, other: Element) -> TracedElement:
        return followed(other) * _inverse(self)

    def __pow__(self, exponent: int) -> TracedElement:
        base = _inverse(self) if exponent < 0 else self
        value = base.plain ** abs(exponent)
        return traced(value, terms.raised(base.term, abs(exponent)))

    def inverse(self) -> TracedElement:
        """Return one over the element, as a traced element."""
        return _inverse(self)


def traced(element: Element, term: Term) -> TracedElement:
    """Return an element with its term."""
    return TracedElement(element.ring, element.numerator, element.powers, term)


def plain(element: Element) -> Element:
    """Return an element without its term."""
    return element.plain if isinstance(element, TracedElement) else element


def followed(element: Element) -> TracedElement:
    """Return an element with its term; an untraced one gets a quotient of polynomials."""
    if isinstance(element, TracedElement):
        return element
    factors = ((element.ring.factors[place], n) for place, n in element.powers.items())
    below = [terms.raised(terms.inverted(terms.polynomial_term(f)), n) for f, n in factors]
    _note_factors(element.ring, element.powers)
    term = terms.multiplied([terms.polynomial_term(element.numerator), *below])
    return traced(element, term)


def term_of(element: Element) -> Term:
    """Return the term that describes the provenance of an element."""
    return followed(element).term


def _inverse(element: Element) -> TracedElement:
    inverse = plain(element).inverse()
    _note_factors(element.ring, element.ring.split(element.numerator)[1])
    _note_factors(element.ring, inverse.powers)
    return traced(inverse, terms.inverted(term_of(element)))


def _note_factors(ring: Ring, powers: Mapping[int, int]) -> None:
    if isinstance(ring, TracedRing):
        ring.divisors.update(dict.fromkeys(powers))


class Trace:
    """Recorded steps with the checker's values; ``open`` has the slopes being computed."""

    def __init__(self) -> None:
        self.steps: list[tuple[Step, Element | None]] = []
        self.open: set[tuple[int, int]] = set()
        self._vanishing: set[Term] = set()
        self._waiting: list[Vanishing] = []

    def vanishing(self, term: Term, comment: str) -> None:
        """Record that a term is 0."""
        if not terms.is_number(term, 0) and term not in self._vanishing:
            self._vanishing.add(term)
            self._waiting.append(Vanishing(term, comment))
            self.settle()

    def settle(self) -> None:
        """Record the waiting claims that terms vanish, if no slope is being computed."""
        if not self.open:
            self.steps += [(step, None) for step in self._waiting]
            self._waiting.clear()


class TracedRing(Ring):
    """The checker's ring with traced elements; ``divisors`` are the indices of used factors."""

    def __init__(self, count: int) -> None:
        super().__init__(count)
        self.trace = Trace()
        self.divisors: dict[int, None] = {}

    def number(self, value: fmpq | int) -> TracedElement:
        """Return a rational number as a traced element."""
        return traced(super().number(value), terms.number(value))

    def generator(self, place: int) -> TracedElement:
        """Return generator number ``place`` as a traced element."""
        return traced(super().generator(place), ("generator", place))
