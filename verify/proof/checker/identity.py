"""The last step of a proof: a polynomial in an unknown's derivatives is 0."""

from __future__ import annotations

from collections.abc import Sequence

from .field import Field
from .quotients import Quotient, constant_rates
from .ring import Derivation, Element, total
from .statement import Jet, Statement, Term

LONG = 20
"""Terms of a numerator from which a quotient in two generators is evaluated, not multiplied out."""


class Residual:
    """The left-hand sides of a statement's equations in a field."""

    def __init__(self, field: Field, statement: Statement) -> None:
        self._field, self._statement = field, statement
        self._derivations: dict[int, Derivation] = {}
        self._jets: dict[Jet, Element] = {}

    def vanishes(self, terms: Sequence[Term]) -> bool:
        """Whether the numerator of an equation reduces to 0."""
        quick = self._at_enough_values(terms)
        if quick is not None:
            return quick
        parts = [self._term(term) for term in terms]
        return total(self._field.ring, parts).is_zero

    def _at_enough_values(self, terms: Sequence[Term]) -> bool | None:
        """The answer for a long quotient of polynomials in two generators; None for any other."""
        field = self._field
        if field.ring.relations or len(field.generators) != 2 or len(self._statement.formulas) > 1:
            return None
        image = field.image(self._statement.formulas[0])
        if len(image.numerator) < LONG or any(known for _, known, _ in terms):
            return None
        t, x = sorted(range(2), key=lambda place: image.numerator.degrees()[1 - place])
        slopes = [(field.slope(x, v), field.slope(t, v)) for v in self._statement.variables]
        rates = constant_rates(slopes)
        return None if rates is None else Quotient(image, x, t).vanishes(terms, rates)

    def _term(self, term: Term) -> Element:
        value, known, jets = term
        result = self._field.ring.number(value)
        for node in known:
            result = result * self._field.image(node)
        for jet in jets:
            result = result * self._jet(jet)
        return result

    def _jet(self, jet: Jet) -> Element:
        if jet not in self._jets:
            unknown, orders = jet
            place = next((i for i, n in enumerate(orders) if n), None)
            if place is None:
                self._jets[jet] = self._field.image(self._statement.formulas[unknown])
            else:
                lower = (*orders[:place], orders[place] - 1, *orders[place + 1 :])
                derivation = self._derivation(self._statement.variables[place])
                self._jets[jet] = derivation(self._jet((unknown, lower)))
        return self._jets[jet]

    def _derivation(self, variable: int) -> Derivation:
        if variable not in self._derivations:
            slopes: dict[int, Element] = {}
            images = [self._field.image(formula) for formula in self._statement.formulas]
            while new := {place for image in images for place in image.places} - slopes.keys():
                slopes |= {place: self._field.slope(place, variable) for place in new}
                images = [slopes[place] for place in new]
            self._derivations[variable] = Derivation(self._field.ring, slopes)
        return self._derivations[variable]
