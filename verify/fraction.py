"""Rational functions as numerator over a power of one fixed denominator, on FLINT polynomials.

Derivatives keep the denominator, ``(N/Q^n)' = (N' Q - n N Q')/Q^(n+1)``, so no greatest common
divisor is ever taken while a residual is put together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp
from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx


class NotRationalError(ValueError):
    """An expression is no rational function with rational coefficients of the generators."""


@dataclass(frozen=True)
class Jet:
    """``numerator / Q**power`` for a denominator Q that the owner of the jet keeps."""

    numerator: fmpq_mpoly
    power: int


class Ring:
    """Polynomials over Q in named generators, and SymPy expressions read as fractions of them.

    >>> x, y = sp.symbols("x y")
    >>> numerator, denominator = Ring([x, y]).fraction(1 / x + y)
    >>> print(numerator, "over", denominator)
    x*y + 1 over x
    """

    def __init__(self, generators: Sequence[sp.Symbol]) -> None:
        names = tuple(str(symbol) for symbol in generators)
        self.generators = tuple(generators)
        self.context = fmpq_mpoly_ctx.get(names, Ordering.degrevlex)
        self._images = dict(zip(generators, self.context.gens(), strict=True))

    def constant(self, value: sp.Rational | int) -> fmpq_mpoly:
        """A rational number as a polynomial."""
        number = sp.Rational(value)
        return self.context.constant(fmpq(int(number.p), int(number.q)))

    def fraction(self, expression: sp.Expr) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        """Numerator and denominator of ``expression``.

        Raises NotRationalError for anything but +, *, integer powers, rationals and generators,
        and for a denominator that is identically zero.
        """
        if expression in self._images:
            return self._images[expression], self.constant(1)
        if expression.is_Rational:
            return self.constant(expression), self.constant(1)
        if expression.is_Add:
            return self._sum([self.fraction(term) for term in expression.args])
        if expression.is_Mul:
            return self._product([self.fraction(factor) for factor in expression.args])
        if expression.is_Pow and expression.exp.is_Integer:
            return self._power(self.fraction(expression.base), int(expression.exp))
        names = ", ".join(map(str, self.generators))
        raise NotRationalError(
            f"expression must be rational in {names}, got {expression} (see verify.residual)"
        )

    def polynomial(self, expression: sp.Expr) -> fmpq_mpoly:
        """``expression`` as a polynomial; NotRationalError if it has a denominator."""
        numerator, denominator = self.fraction(expression)
        if not denominator.is_constant():
            raise NotRationalError(f"expression must be a polynomial, got {expression}")
        return numerator / denominator

    def _sum(self, terms: list[tuple[fmpq_mpoly, fmpq_mpoly]]) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        numerator, denominator = terms[0]
        for top, bottom in terms[1:]:
            if bottom == denominator:
                numerator = numerator + top
            else:
                common = denominator.gcd(bottom)
                left, right = denominator / common, bottom / common
                numerator, denominator = numerator * right + top * left, denominator * right
        return numerator, denominator

    def _product(
        self, factors: list[tuple[fmpq_mpoly, fmpq_mpoly]]
    ) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        numerator = denominator = self.constant(1)
        for top, bottom in factors:
            numerator, denominator = numerator * top, denominator * bottom
        return numerator, denominator

    def _power(
        self, fraction: tuple[fmpq_mpoly, fmpq_mpoly], exponent: int
    ) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        numerator, denominator = fraction if exponent >= 0 else fraction[::-1]
        if denominator.is_zero():
            raise NotRationalError("denominator must not vanish identically, got 0")
        return numerator ** abs(exponent), denominator ** abs(exponent)


def differentiate(jet: Jet, denominator: fmpq_mpoly, variable: str) -> Jet:
    """The derivative of ``jet`` over ``denominator`` with respect to the generator ``variable``."""
    N, n = jet.numerator, jet.power
    slope = N.derivative(variable) * denominator
    return Jet(slope - n * N * denominator.derivative(variable), n + 1)
