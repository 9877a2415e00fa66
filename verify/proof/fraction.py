"""Rational functions of generators with factored denominators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from flint import fmpq, fmpq_mpoly

from .field import PolynomialRing


@dataclass(frozen=True)
class Fraction:
    """``numerator`` over the product of ``ring.factors[i] ** powers[i]``, numerator reduced."""

    ring: PolynomialRing
    numerator: fmpq_mpoly
    powers: Mapping[int, int] = field(default_factory=dict)

    @property
    def is_zero(self) -> bool:
        """Whether the normal form is 0 (a sufficient condition for vanishing)."""
        return bool(self.numerator.is_zero())

    def denominator(self) -> fmpq_mpoly:
        """The denominator multiplied out."""
        return _product(self.ring, self.powers)

    def over(self, powers: Mapping[int, int]) -> fmpq_mpoly:
        """The numerator over the common denominator ``powers``, which this one divides."""
        rest = {i: power - self.powers.get(i, 0) for i, power in powers.items()}
        return self.ring.reduce(self.numerator * _product(self.ring, rest))

    def __add__(self, other: Fraction) -> Fraction:
        if self.powers == other.powers:
            return Fraction(self.ring, self.numerator + other.numerator, self.powers).cancelled()
        common = common_denominator([self, other])
        return Fraction(self.ring, self.over(common) + other.over(common), common).cancelled()

    def __neg__(self) -> Fraction:
        return Fraction(self.ring, -self.numerator, self.powers)

    def __sub__(self, other: Fraction) -> Fraction:
        return self + (-other)

    def __mul__(self, other: Fraction) -> Fraction:
        numerator = self.ring.reduce(self.numerator * other.numerator)
        powers = dict(self.powers)
        for i, power in other.powers.items():
            powers[i] = powers.get(i, 0) + power
        return Fraction(self.ring, numerator, powers).cancelled()

    def __pow__(self, exponent: int) -> Fraction:
        if exponent < 0:
            return self.inverse() ** (-exponent)
        result = Fraction(self.ring, self.ring.constant(1))
        for _ in range(exponent):
            result = result * self
        return result

    def inverse(self) -> Fraction:
        """``1 / self``; raises ZeroDivisionError if the normal form is 0."""
        if self.is_zero:
            raise ZeroDivisionError("a denominator vanishes identically")
        unit, powers = self.ring.split(self.numerator)
        numerator = self.ring.reduce(self.denominator() / unit)
        return Fraction(self.ring, numerator, powers).cancelled()

    def scaled(self, factor: fmpq) -> Fraction:
        """The product with a rational number."""
        return Fraction(self.ring, self.numerator * factor, self.powers)

    def cancelled(self) -> Fraction:
        """The same fraction with common polynomial factors divided out."""
        if self.is_zero:
            return Fraction(self.ring, self.numerator)
        numerator, powers = self.numerator, dict(self.powers)
        for i in list(powers):
            while powers[i] > 0:
                quotient = self.ring.exact_quotient(numerator, self.ring.factors[i])
                if quotient is None:
                    break
                numerator = quotient
                powers[i] -= 1
            if powers[i] == 0:
                del powers[i]
        return Fraction(self.ring, numerator, powers)


def common_denominator(fractions: list[Fraction]) -> dict[int, int]:
    """The least common denominator, as powers of the ring's factors."""
    common: dict[int, int] = {}
    for fraction in fractions:
        for i, power in fraction.powers.items():
            common[i] = max(common.get(i, 0), power)
    return common


def _product(ring: PolynomialRing, powers: Mapping[int, int]) -> fmpq_mpoly:
    product = ring.constant(1)
    for i, power in powers.items():
        for _ in range(power):
            product = ring.reduce(product * ring.factors[i])
    return product
