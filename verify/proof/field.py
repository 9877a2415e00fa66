"""A differential field: rational functions of generators, with relations and derivations.

Elements are `Fraction`s over python-flint's polynomials with rational coefficients.  A relation
``g**n = rhs`` is monic in ``g`` and contains, apart from ``g``, only earlier generators; so one
pass from the last generator to the first brings a polynomial to its normal form.  Two equal
elements have the same normal form; the normal form 0 proves that an element vanishes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx
from flint.utils.flint_exceptions import DomainError

FACTORABLE_TERMS = 400
"""A denominator with more terms than this is not split into irreducible factors."""


@dataclass(frozen=True)
class Relation:
    """``generator ** degree`` equals ``value``, a polynomial in earlier generators."""

    generator: int
    degree: int
    value: fmpq_mpoly


class PolynomialRing:
    """Polynomials in named generators (first registered, last in the lex order), with relations.

    ``factors`` lists the irreducible denominators met so far; a `Fraction` refers to them by
    their place in the list.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.context = fmpq_mpoly_ctx.get(self.names[::-1], Ordering.lex)
        self.generators: tuple[fmpq_mpoly, ...] = self.context.gens()[::-1]
        self.relations: list[Relation] = []
        self.factors: list[fmpq_mpoly] = []
        self._moduli: list[tuple[str, int, fmpq_mpoly]] = []

    def constant(self, value: fmpq | int) -> fmpq_mpoly:
        """The rational number ``value`` as a polynomial."""
        return self.context.constant(value)

    def relate(self, place: int, degree: int, value: fmpq_mpoly) -> None:
        """Add the relation ``generators[place] ** degree = value``."""
        self.relations.append(Relation(place, degree, value))
        self.relations.sort(key=lambda relation: -relation.generator)
        self._moduli = [
            (self.names[r.generator], r.degree, self.generators[r.generator] ** r.degree - r.value)
            for r in self.relations
        ]

    def reduce(self, polynomial: fmpq_mpoly) -> fmpq_mpoly:
        """The normal form of ``polynomial`` modulo the relations."""
        for name, degree, modulus in self._moduli:
            if polynomial.degrees()[self.context.variable_to_index(name)] >= degree:
                polynomial = divmod(polynomial, modulus)[1]
        return polynomial

    def exact_quotient(self, polynomial: fmpq_mpoly, divisor: fmpq_mpoly) -> fmpq_mpoly | None:
        """``polynomial / divisor`` if the division leaves nothing, else None."""
        try:
            return polynomial / divisor
        except DomainError:
            return None

    def split(self, polynomial: fmpq_mpoly) -> tuple[fmpq, dict[int, int]]:
        """A rational number and the powers of entries of ``factors`` whose product it is."""
        if len(polynomial) > FACTORABLE_TERMS:
            unit, parts = fmpq(1), [(polynomial, 1)]
        else:
            unit, parts = polynomial.factor()
        powers: dict[int, int] = {}
        for part, power in parts:
            powers[self._place(part)] = int(power)
        return unit, powers

    def _place(self, factor: fmpq_mpoly) -> int:
        for place, known in enumerate(self.factors):
            if known == factor:
                return place
        self.factors.append(factor)
        return len(self.factors) - 1
