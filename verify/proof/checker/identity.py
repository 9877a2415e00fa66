"""The last step of a proof: a polynomial in an unknown's derivatives is 0."""

from __future__ import annotations

from collections.abc import Sequence

from .field import Field
from .ring import Derivation, Element, total
from .statement import Jet, Statement, Term


class Residual:
    """The left-hand sides of a statement's equations in a field."""

    def __init__(self, field: Field, statement: Statement) -> None:
        self._field, self._statement = field, statement
        self._derivations: dict[int, Derivation] = {}
        self._jets: dict[Jet, Element] = {}

    def vanishes(self, terms: Sequence[Term]) -> bool:
        """Whether the numerator of an equation reduces to 0."""
        parts = [self._term(term) for term in terms]
        return total(self._field.ring, parts).is_zero

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
