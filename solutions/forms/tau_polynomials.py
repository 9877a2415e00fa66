"""The polynomials A and B of the rational solutions, from their generating function.

With ``x = xi - 6 tau``, ``t = tau`` the generating function (Ankiewicz and Akhmediev's family,
written as a Schur-type determinant) is::

    P(z) = exp[z x - 4 z**3 t + sum_{odd k} tau_k z**k - (i/2) arctan z] = sum_n p_n z**n

``f_j = det[p_{2m-1-r}]`` (rows m = 1..j, columns r = 0..j-1) is a real constant times
``A + i B`` with real polynomials A and B. The arithmetic is exact, in python-flint's polynomials
over the rationals.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import sympy as sp
from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from longwave.solutions.symbols import shift_symbol


@dataclass(frozen=True)
class GaussianPolynomial:
    """``re + i im`` with real polynomial parts."""

    re: fmpq_mpoly
    im: fmpq_mpoly

    def __add__(self, other: "GaussianPolynomial") -> "GaussianPolynomial":
        return GaussianPolynomial(self.re + other.re, self.im + other.im)

    def __mul__(self, other: "GaussianPolynomial") -> "GaussianPolynomial":
        return GaussianPolynomial(
            self.re * other.re - self.im * other.im, self.re * other.im + self.im * other.re
        )

    def scaled(self, factor: fmpq) -> "GaussianPolynomial":
        """Return the product with a rational number."""
        return GaussianPolynomial(self.re * factor, self.im * factor)


SPACE_TIME: tuple[sp.Symbol, sp.Symbol] = sp.symbols("x t", real=True)
"""First generators of the polynomials: ``xi - 6 tau`` and ``tau``."""


@dataclass(frozen=True)
class RationalTau:
    """Real and imaginary part of ``f_j`` as integer polynomials without common content.

    ``A`` and ``B`` are python-flint polynomials in the generators ``("x", "t", "tau_5", ...)``;
    the leading coefficient of ``A`` in x is positive.
    """

    order: int
    free: tuple[int, ...]
    A: fmpq_mpoly
    B: fmpq_mpoly

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """SymPy symbols of the generators, ``x`` and ``t`` first."""
        return (*SPACE_TIME, *(shift_symbol(index) for index in self.free))


@lru_cache(maxsize=32, typed=True)
def rational_tau(order: int, free: tuple[int, ...] = ()) -> RationalTau:
    """Return the polynomials A and B of the rational solution of an order.

    ``free`` lists the indices 5, 7, ... of the shifts tau_5, tau_7, ... that are symbols.

    Raises ValueError if ``order`` is not a positive integer or a shift does not occur at that
    order.

    >>> first = rational_tau(1)
    >>> print(first.A, first.B)
    2*x -1
    """
    _check_order(order, free)
    names = ("x", "t", *(f"tau_{index}" for index in free))
    context = fmpq_mpoly_ctx.get(names, Ordering.lex)
    coefficients = _generating_coefficients(2 * order, _exponents(context, 2 * order, free))
    f = _determinant(coefficients, order)
    content = _content(f)
    return RationalTau(order, free, f.re / content, f.im / content)


def _check_order(order: int, free: tuple[int, ...]) -> None:
    if isinstance(order, bool) or not isinstance(order, int) or order < 1:
        raise ValueError(f"order must be a positive integer, got {order!r} (1 is rational_1)")
    for index in free:
        if index % 2 == 0 or not 5 <= index <= 2 * order - 1:
            raise ValueError(
                f"free shifts must be odd with 5 <= index <= {2 * order - 1}, got {index} "
                f"(tau_1 and tau_3 are translations in xi and tau)"
            )


def _exponents(
    context: fmpq_mpoly_ctx, count: int, free: tuple[int, ...]
) -> dict[int, GaussianPolynomial]:
    """Return the coefficients ``e_k`` of ``z**k``, odd k < ``count``, in the exponent of P(z)."""
    generators = context.gens()
    real = {index: generators[2 + position] for position, index in enumerate(free)}
    real |= {1: generators[0], 3: -4 * generators[1]}
    zero = context.constant(0)
    exponents = {}
    for index in range(1, count, 2):
        sign = (-1) ** ((index - 1) // 2)
        im = context.constant(fmpq(-sign, 2 * index))
        exponents[index] = GaussianPolynomial(real.get(index, zero), im)
    return exponents


def _generating_coefficients(
    count: int, exponents: dict[int, GaussianPolynomial]
) -> list[GaussianPolynomial]:
    """Return ``p_0 .. p_{count-1}`` by ``n p_n = sum k e_k p_{n-k}``."""
    one = exponents[1].re.context().constant(1)
    p = [GaussianPolynomial(one, 0 * one)]
    for n in range(1, count):
        total = p[0].scaled(fmpq(0))
        for index in range(1, n + 1, 2):
            total = total + (exponents[index] * p[n - index]).scaled(fmpq(index, n))
        p.append(total)
    return p


def _determinant(p: list[GaussianPolynomial], order: int) -> GaussianPolynomial:
    """Return ``det[p_{2m-1-r}]`` by minors: row after row, keyed by the set of columns used."""
    zero = p[0].scaled(fmpq(0))
    minors = {0: p[0]}
    for row in range(1, order + 1):
        extended: dict[int, GaussianPolynomial] = {}
        for used, minor in minors.items():
            for column in range(min(order, 2 * row)):
                if used >> column & 1:
                    continue
                swaps = (used >> column).bit_count()
                term = (minor * p[2 * row - 1 - column]).scaled(fmpq((-1) ** swaps))
                target = used | 1 << column
                extended[target] = extended.get(target, zero) + term
        minors = extended
    return minors[(1 << order) - 1]


def _content(f: GaussianPolynomial) -> fmpq:
    """Return the common rational content of both parts, with the sign of A's leading x power."""
    values = [c for part in (f.re, f.im) for c in part.coeffs()]
    leading = max(f.re.terms(), key=lambda term: term[0])[1]
    numerator = math.gcd(*(int(value.p) for value in values))
    denominator = math.lcm(*(int(value.q) for value in values))
    return fmpq(numerator if leading > 0 else -numerator, denominator)
