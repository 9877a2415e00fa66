"""Derivatives of rational functions of generators."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from flint import fmpq_mpoly

from .field import PolynomialRing
from .fraction import Fraction, common_denominator


class Derivation:
    """The derivation that maps each generator to its slope.

    With the slopes over one common denominator ``d``, ``d`` times the derivative of a polynomial
    is a polynomial; the quotient rule is applied to the factors of a denominator one by one, so
    a factor never occurs with more than one power above what it had.
    """

    def __init__(self, ring: PolynomialRing, slopes: Sequence[Fraction]) -> None:
        self.ring = ring
        moving = {i: slope for i, slope in enumerate(slopes) if not slope.is_zero}
        self.denominator: Mapping[int, int] = common_denominator(list(moving.values()))
        self._slopes = {ring.names[i]: s.over(self.denominator) for i, s in moving.items()}
        self._cofactors: dict[int, tuple[fmpq_mpoly, bool]] = {}

    def of_polynomial(self, polynomial: fmpq_mpoly) -> fmpq_mpoly:
        """The derivative of ``polynomial`` times ``denominator``."""
        total = self.ring.constant(0)
        for name, slope in self._slopes.items():
            partial = polynomial.derivative(name)
            if not partial.is_zero():
                total += partial * slope
        return self.ring.reduce(total)

    def __call__(self, fraction: Fraction) -> Fraction:
        """The derivative of ``fraction``."""
        ring, raised = self.ring, []
        total = self.of_polynomial(fraction.numerator)
        logarithmic = ring.constant(0)
        for i, power in fraction.powers.items():
            slope, divides = self._cofactor(i)
            if divides:
                logarithmic += power * slope
            elif not slope.is_zero():
                raised.append((i, power, slope))
        total -= fraction.numerator * logarithmic
        for i, _, _ in raised:
            total = ring.reduce(total * ring.factors[i])
        for i, power, slope in raised:
            term = power * fraction.numerator * slope
            for j, _, _ in raised:
                term = ring.reduce(term * ring.factors[j]) if j != i else term
            total -= term
        powers = dict(fraction.powers)
        for i in [i for i, _, _ in raised]:
            powers[i] += 1
        for i, power in self.denominator.items():
            powers[i] = powers.get(i, 0) + power
        return Fraction(ring, ring.reduce(total), powers).cancelled()

    def _cofactor(self, place: int) -> tuple[fmpq_mpoly, bool]:
        """The derivative of a factor (times ``denominator``), divided by it where that goes."""
        if place not in self._cofactors:
            factor = self.ring.factors[place]
            slope = self.of_polynomial(factor)
            quotient = None if slope.is_zero() else self.ring.exact_quotient(slope, factor)
            self._cofactors[place] = (slope, False) if quotient is None else (quotient, True)
        return self._cofactors[place]
