"""The numerical half of the checker: what a certificate's generators stand for, in balls."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import sympy as sp
from flint import acb, arb, fmpq_mpoly

from .balls import BallEvaluator, Point
from .identity import Element, Identity
from .jet import Jet, Shape

AGREEMENT = 100
"""Bits to which two balls must agree."""


class CertificateError(ValueError):
    """A certificate does not prove what it says; the message says where it fails."""


class Meanings:
    """Balls around a certificate's generators and their first derivatives at a point."""

    def __init__(
        self,
        data: Mapping[str, Any],
        identity: Identity,
        found: Sequence[sp.Expr],
        point: Point,
    ) -> None:
        self._data, self._identity, self._found = data, identity, found
        variables = [self._found[place] for place in data["variables"]]
        units = [tuple(int(i == j) for j in range(len(variables))) for i in range(len(variables))]
        self._shape = Shape(units)
        self._slots = [self._shape.indices.index(unit) for unit in units]
        self._balls = BallEvaluator(self._shape, variables, point)
        self._generators = [self._jet(generator["meaning"]) for generator in data["generators"]]
        self._factors = [self._value(factor) for factor in identity.factors]

    def check(self) -> None:
        """Compare everything the certificate states with the balls.

        Raises CertificateError where they do not agree.
        """
        if not all(ball.is_finite() and not ball.contains(0) for ball in self._factors):
            raise CertificateError("a denominator vanishes at the point")
        for place, (generator, jet) in enumerate(
            zip(self._data["generators"], self._generators, strict=True)
        ):
            for variable, slot in enumerate(self._slots):
                slope = self._element(self._identity.slopes[variable][place])
                _agree(slope, jet.coefficients[slot], f"the slope of {generator['name']}")
        for relation in self._identity.relations:
            _agree(1 + self._value(relation), acb(1), f"the relation {relation}")
        image = self._element(self._identity.image)
        _agree(image, self._jet(self._data["expression"]).value, "the image of the formula")
        for place, element in self._identity.known.items():
            _agree(self._element(element), self._jet(place).value, "the image of a coefficient")

    def _jet(self, place: int) -> Jet:
        return self._balls.jet(self._found[place])

    def _element(self, element: Element) -> acb:
        ball = self._value(element.numerator)
        for factor, power in zip(self._factors, element.powers, strict=True):
            ball /= factor**power
        return ball

    def _value(self, polynomial: fmpq_mpoly) -> acb:
        values: Sequence[acb] = [jet.value for jet in self._generators[::-1]]
        total = acb(0)
        for exponents, coefficient in polynomial.terms():
            term = acb(coefficient)
            for value, exponent in zip(values, exponents, strict=True):
                term *= value ** int(exponent)
            total += term
        return total


def _agree(left: acb, right: acb, what: str) -> None:
    """Raise CertificateError unless the balls overlap and are narrow."""
    difference = left - right
    width = abs(difference) / (1 + abs(left) + abs(right))
    if not difference.contains(0) or not width < arb(2) ** -AGREEMENT:
        raise CertificateError(f"{what} does not agree with the meaning of its generators")
