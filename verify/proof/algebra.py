"""The differential field of a translation: its images as exact fractions."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp
from flint import fmpq, fmpq_mpoly

from .derivation import Derivation
from .field import PolynomialRing
from .fraction import Fraction
from .generator import Generator
from .roots import RootTable
from .translation import Translation


class DifferentialField:
    """Fractions in the generators of ``translation``, with a derivation for each variable.

    All images must have been made before: a polynomial ring cannot grow.  ``identified`` says
    for a square root that is rational in others what it is equal to.
    """

    def __init__(self, translation: Translation) -> None:
        self.translation = translation
        self.identified: dict[sp.Expr, sp.Expr] = {}
        self.generators = tuple(translation.generators)
        self.ring = PolynomialRing([g.symbol.name for g in self.generators])
        self._symbols = {
            generator.symbol: Fraction(self.ring, polynomial)
            for generator, polynomial in zip(self.generators, self.ring.generators, strict=True)
        }
        self._values: dict[sp.Expr, Fraction] = {}
        self._scales: dict[sp.Symbol, Fraction] = {}
        self._relate()
        self.derivations = {v: self._derivation(v) for v in translation.variables}

    def element(self, expression: sp.Expr) -> Fraction:
        """The image of a formula in the variables and parameters."""
        return self.fraction(self.translation.image(self.translation.rewriting(expression)))

    def fraction(self, image: sp.Expr) -> Fraction:
        """An expression that is rational in the generators, as a fraction."""
        if image not in self._values:
            self._values[image] = self._fraction(image)
        return self._values[image]

    def slope(self, generator: Generator, variable: sp.Symbol) -> Fraction:
        """The derivative of a generator of the ring."""
        slope = self.fraction(generator.slopes.get(variable, sp.S.Zero))
        scale = self._scales.get(generator.symbol)
        if scale is None:
            return slope
        moved = self._slope_of_polynomial(scale.denominator(), variable)
        return slope * scale.inverse() + self._symbols[generator.symbol] * moved

    def number(self, value: sp.Rational) -> Fraction:
        """A rational number as an element of the field."""
        return Fraction(self.ring, self.ring.constant(fmpq(int(value.p), int(value.q))))

    def _slope_of_polynomial(self, polynomial: fmpq_mpoly, variable: sp.Symbol) -> Fraction:
        total = Fraction(self.ring, self.ring.constant(0))
        for generator in self.generators:
            partial = polynomial.derivative(generator.symbol.name)
            if not partial.is_zero():
                slope = self.slope(generator, variable)
                total = total + Fraction(self.ring, self.ring.reduce(partial)) * slope
        return total

    def _fraction(self, image: sp.Expr) -> Fraction:
        if image.is_Symbol:
            return self._symbols[image]
        if image.is_Rational:
            return self.number(image)
        if image.is_Pow:
            return self.fraction(image.base) ** int(image.exp)
        parts = [self.fraction(part) for part in image.args]
        total = parts[0]
        for part in parts[1:]:
            total = total + part if image.is_Add else total * part
        return total

    def _relate(self) -> None:
        """Set up the relations: of roots of polynomials first, then of those of quotients."""
        roots = RootTable()
        algebraic = [g for g in self.generators if g.degree]
        for generator in sorted(algebraic, key=self._is_quotient):
            value = self.fraction(generator.value)
            if generator.degree > 2 or not self._depends(generator, value, roots):
                self._add_relation(generator, value)
                self._values.clear()

    def _is_quotient(self, generator: Generator) -> int:
        """0 for a root of a polynomial, 1 with a constant denominator, 2 with any other."""
        powers = self.fraction(generator.value).powers
        if not powers:
            return 0
        return 1 if all(self._is_constant(self.ring.factors[i]) for i in powers) else 2

    def _is_constant(self, polynomial: fmpq_mpoly) -> bool:
        used = zip(reversed(self.generators), polynomial.degrees(), strict=True)
        return not any(degree and generator.slopes for generator, degree in used)

    def _add_relation(self, generator: Generator, value: Fraction) -> None:
        """The relation of an independent root; a denominator is moved into the root."""
        place = self.generators.index(generator)
        if not value.powers:
            self.ring.relate(place, generator.degree, value.numerator)
            return
        powers = {i: -(-power // generator.degree) for i, power in value.powers.items()}
        scale = Fraction(self.ring, self.ring.constant(1), powers)
        whole = value * scale.inverse() ** generator.degree
        meaning = generator.meaning * self.written(scale.denominator())
        self.ring.relate(place, generator.degree, whole.numerator)
        self._symbols[generator.symbol] = self._symbols[generator.symbol] * scale
        self._scales[generator.symbol] = scale
        moved = replace(generator, meaning=meaning)
        self.generators = (*self.generators[:place], moved, *self.generators[place + 1 :])

    def _depends(self, generator: Generator, square: Fraction, roots: RootTable) -> bool:
        """Whether a square root is rational in others; if so, its symbol then stands for that.

        Only where it and these are shown not to be negative and the sign of the rational part is
        known: then the equation of the squares is one of the roots on the whole of the domains.
        """
        signs = self.translation.rewriting.signs
        if not isinstance(generator.meaning, sp.Pow | sp.Abs):
            return False
        if not signs.is_nonnegative(generator.meaning):
            return False
        companions = roots.companions(generator.symbol, square)
        if companions is None:
            return False
        value = roots.rational_part(square, companions)
        written = self._meaning(value)
        if signs.is_nonpositive(written):
            value = -value
        elif not signs.is_nonnegative(written):
            return False
        for symbol in companions:
            value = value * self._symbols[symbol]
        self._symbols[generator.symbol] = value
        self.identified[generator.meaning] = self._meaning(value)
        self._values.clear()
        return True

    def _meaning(self, element: Fraction) -> sp.Expr:
        """An element in the variables and parameters of the formula."""
        return self.written(element.numerator) / self.written(element.denominator())

    def written(self, polynomial: fmpq_mpoly) -> sp.Expr:
        """A polynomial in the generators as a formula in the variables and parameters."""
        meanings = [generator.meaning for generator in self.generators[::-1]]
        terms = []
        for exponents, coefficient in polynomial.terms():
            powers = (m ** int(e) for m, e in zip(meanings, exponents, strict=True))
            terms.append(sp.Mul(sp.Rational(str(coefficient)), *powers))
        return sp.Add(*terms)

    def _derivation(self, variable: sp.Symbol) -> Derivation:
        return Derivation(self.ring, [self.slope(g, variable) for g in self.generators])
