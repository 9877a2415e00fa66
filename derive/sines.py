"""Rational functions of ``z = exp(i k)`` and ``w = i omega`` in sin(k/2), cos(k/2) and omega.

A factor that is invariant under conjugation, z -> 1/z and w -> -w, is real or imaginary after
multiplication by a phase that centres its powers of z. So a polynomial is factored first, and
each factor is multiplied by its phase.
"""

from functools import cache
from math import comb

from sympy import Expr, Integer, Symbol

from longwave.derive.algebra.rational_functions import RationalFunction, RationalFunctions

frequency = Symbol("omega~", positive=True)
sine, cosine = Symbol("sin(k/2)", real=True), Symbol("cos(k/2)", real=True)
"""Symbols of sin(k/2) and cos(k/2), with names that no constant of a lattice can have."""

omega = Symbol("omega", positive=True)
"""Printed symbol of the frequency, unless a constant has this name."""

Complex = tuple[RationalFunction, RationalFunction]
"""Real and imaginary part."""


def in_sines(element: RationalFunction) -> tuple[Expr, Expr]:
    """Return an element's real and imaginary part, factored; its first symbols must be z, w.

    >>> z, w, K = map(Symbol, "zwK")
    >>> field = RationalFunctions((z, w, K))
    >>> in_sines(field.from_expr(K * (z - 2 + 1 / z) * w))
    (0, -4*K*omega~*sin(k/2)**2)
    """
    field = RationalFunctions((sine, cosine, frequency, *element.field.symbols[2:]))
    numerator, denominator = (_Product(field, element, below=below) for below in (False, True))
    value = _times(numerator.mixed, _power(field, numerator.turns - denominator.turns))
    if denominator.mixed[1]:
        real, imaginary = denominator.mixed
        value = _times(value, (real, -imaginary))
        divisor = _reduce_cosines(real * real + imaginary * imaginary)
    else:
        divisor = denominator.mixed[0]
    for _ in range((numerator.quarters - denominator.quarters) % 4):
        value = -value[1], value[0]
    pure = numerator.pure / denominator.pure
    real, imaginary = ((part / divisor).factored() * pure if part else Integer(0) for part in value)
    return real, imaginary


class _Product:
    """Factors of a numerator or denominator: ``pure i^quarters mixed exp(i k turns/2)``.

    ``pure`` is the product of the real or imaginary factors, ``mixed`` the product of the others.
    """

    def __init__(self, field: RationalFunctions, element: RationalFunction, *, below: bool) -> None:
        self.field = field
        self.pure: Expr = Integer(1)
        self.quarters = self.turns = 0
        self.mixed: Complex = (field.one, field.zero)
        for terms, times in element.factored_terms(below=below):
            turns = [exponents[0] for exponents, _ in terms]
            middle = max(turns) + min(turns)
            self.turns += middle * times
            part = real, imaginary = _times_phase(field, terms, middle)
            if real and imaginary:
                for _ in range(times):
                    self.mixed = _times(self.mixed, part)
                continue
            self.quarters += times if imaginary else 0
            self.pure *= (imaginary or real).factored() ** times


def _times_phase(
    field: RationalFunctions, terms: list[tuple[tuple[int, ...], int]], middle: int
) -> Complex:
    """Return the polynomial in z and w given by ``terms``, times ``exp(-i k middle/2)``."""
    real, imaginary = field.zero, field.zero
    for (turn, power, *others), value in terms:
        factor = field.from_terms([((0, 0, power, *others), value)])
        cos_part, sin_part = (factor * part for part in _power(field, 2 * turn - middle))
        for _ in range(power % 4):
            cos_part, sin_part = -sin_part, cos_part
        real, imaginary = real + cos_part, imaginary + sin_part
    return real, imaginary


@cache
def _power(field: RationalFunctions, count: int) -> Complex:
    """Return ``exp(i k count/2)`` as the power ``(cos(k/2) + i sin(k/2))**count``."""
    real, imaginary = field.zero, field.zero
    for i in range(abs(count) + 1):
        sign = 1 if i % 4 < 2 else -1
        exponents = (i, abs(count) - i, *(0,) * (len(field.symbols) - 2))
        term = field.from_terms([(exponents, sign * comb(abs(count), i))])
        real, imaginary = (real, imaginary + term) if i % 2 else (real + term, imaginary)
    return _reduce_cosines(real), _reduce_cosines(imaginary if count > 0 else -imaginary)


def _times(left: Complex, right: Complex) -> Complex:
    (a, b), (c, d) = left, right
    return _reduce_cosines(a * c - b * d), _reduce_cosines(a * d + b * c)


def _reduce_cosines(polynomial: RationalFunction) -> RationalFunction:
    """Return a polynomial with powers of the cosine reduced to 0 and 1."""
    field = polynomial.field
    square = field.one - field(sine) ** 2
    total = field.zero
    for (first, second, *others), value in polynomial.terms():
        term = field.from_terms([((first, second % 2, *others), value)])
        total = total + term * square ** (second // 2)
    return total
