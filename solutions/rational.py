"""The rational solutions of every order, from their generating function.

With ``x = xi - 6 tau``, ``t = tau`` the generating function (Ankiewicz and Akhmediev's family,
written as a Schur-type determinant) is::

    P(z) = exp[z x - 4 z**3 t + sum_{odd k} tau_k z**k - (i/2) arctan z] = sum_n p_n z**n

``f_j = det[p_{2m-1-r}]`` (rows m = 1..j, columns r = 0..j-1) is a real constant times
``A + i B`` with real polynomials A and B, and ``U_j = (-1)**j [1 - 2 (arg f_j)_x]``.
Everything here is exact, on python-flint's polynomials over the rationals.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from importlib import import_module
from typing import Any

import sympy as sp
from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from solutions.closed_form import ClosedForm, FarFields, Reference
from solutions.equation import FOCUSING_MKDV
from solutions.gaussian_polynomial import GaussianPolynomial
from solutions.parameter import Parameter
from solutions.precision import HardRange
from solutions.symbols import shift_symbol, tau, xi

__all__ = ["CO_MOVING", "RationalTau", "horner_form", "rational", "rational_tau"]

CO_MOVING: sp.Expr = xi - 6 * tau


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
        """The SymPy symbols of the generators, ``x`` and ``t`` first."""
        return (*_SPACE_TIME, *(shift_symbol(index) for index in self.free))


_SPACE_TIME = (sp.Symbol("x", real=True), sp.Symbol("t", real=True))


@lru_cache(maxsize=32, typed=True)
def rational_tau(order: int, free: tuple[int, ...] = ()) -> RationalTau:
    """``A`` and ``B`` of order ``order``; ``free`` lists the shifts tau_5, tau_7, ... kept.

    Raises ValueError if ``order`` is no positive integer or a shift does not occur at it.

    >>> first = rational_tau(1)
    >>> print(first.A, first.B)
    2*x -1
    """
    _check_order(order, free)
    names = ("x", "t", *(f"tau_{index}" for index in free))
    context = fmpq_mpoly_ctx.get(names, Ordering.lex)
    coefficients = _generating_coefficients(2 * order, _exponents(context, 2 * order, free))
    f = _determinant(coefficients, order)
    content = _content(f, order)
    return RationalTau(order, free, f.re / content, f.im / content)


def _check_order(order: int, free: tuple[int, ...]) -> None:
    if isinstance(order, bool) or not isinstance(order, int) or order < 1:
        raise ValueError(f"order must be a positive integer, got {order!r}")
    for index in free:
        if index % 2 == 0 or not 5 <= index <= 2 * order - 1:
            raise ValueError(
                f"free shifts must be odd with 5 <= index <= {2 * order - 1}, got {index} "
                f"(tau_1 and tau_3 are translations in xi and tau)"
            )


def _exponents(
    context: fmpq_mpoly_ctx, count: int, free: tuple[int, ...]
) -> dict[int, GaussianPolynomial]:
    """The odd coefficients ``e_k`` of the exponent of P."""
    generators = context.gens()
    real = {index: generators[2 + place] for place, index in enumerate(free)}
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
    """``p_0 .. p_{count-1}`` by ``n p_n = sum k e_k p_{n-k}``."""
    one = exponents[1].re.context().constant(1)
    p = [GaussianPolynomial(one, 0 * one)]
    for n in range(1, count):
        total = p[0].scaled(fmpq(0))
        for index in range(1, n + 1, 2):
            total = total + (exponents[index] * p[n - index]).scaled(fmpq(index, n))
        p.append(total)
    return p


def _determinant(p: list[GaussianPolynomial], order: int) -> GaussianPolynomial:
    """``det[p_{2m-1-r}]`` by minors: row after row, keyed by the set of columns used."""
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


def _content(f: GaussianPolynomial, order: int) -> fmpq:
    """The common rational content of both parts, with the sign of A's leading x power."""
    values = [Fraction(int(c.p), int(c.q)) for part in (f.re, f.im) for c in part.coeffs()]
    content = values[0]
    for value in values[1:]:
        content = _gcd(content, value)
    leading = max(f.re.terms(), key=lambda term: term[0])[1]
    sign = 1 if leading > 0 else -1
    return fmpq(sign * content.numerator, content.denominator)


def _gcd(left: Fraction, right: Fraction) -> Fraction:
    numerator = sp.igcd(left.numerator * right.denominator, right.numerator * left.denominator)
    return Fraction(int(numerator), left.denominator * right.denominator)


def horner_form(order: int, free: tuple[int, ...] = ()) -> sp.Expr:
    """``(-1)**j [1 - 2 (A B_x - A_x B)/(A**2 + B**2)]``, each polynomial in Horner form."""
    family = rational_tau(order, free)
    parts = [sp.horner(_to_sympy(part, *family.symbols), *family.symbols) for part in _parts(family)]
    wave = _wave(order, *parts)
    return wave.subs(dict(zip(_SPACE_TIME, (CO_MOVING, tau), strict=True)), simultaneous=True)


def rational(order: int, free: Iterable[int] = ()) -> ClosedForm:
    """The rational solution of any order; ``free`` lists the shifts tau_5, ... left as parameters.

    Peak ``2 order + 1`` at the origin on the background ``(-1)**order`` (with all shifts zero).
    Source: the paper's Ref. ankiewicz2018rogue. Raises ValueError as ``rational_tau`` does.

    >>> rational(3, free=[5]).parameters[0].name
    'tau_5'
    """
    shifts = tuple(sorted(free))
    family = rational_tau(order, shifts)
    symbols = (CO_MOVING, tau, *family.symbols[2:])
    level = sp.Integer((-1) ** order)
    return ClosedForm(
        name=f"rational_{order}",
        title=f"rational solution of order {order}",
        expression=_wave(order, *(_to_sympy(part, *symbols) for part in _parts(family))),
        equation=FOCUSING_MKDV,
        parameters=tuple(Parameter(shift_symbol(i), default=sp.S.Zero) for i in shifts),
        background=level,
        far_fields=FarFields(level, level),
        reference=Reference("ankiewicz2018rogue", "standard mKdV"),
        stabilise=lambda: horner_form(order, shifts),
        hard=HardRange(sp.true, "A and B cancel among their terms, more with every order"),
        evaluator=lambda parameters: _evaluator(family, parameters),
    )


def _evaluator(family: RationalTau, shifts: Mapping[sp.Symbol, sp.Expr]) -> Any:
    """Imported at first use, so that reading the formulas needs no compiler."""
    return import_module("solutions.rational_evaluator").RationalEvaluator(family, shifts)


def _parts(family: RationalTau) -> list[fmpq_mpoly]:
    """A, B, A_x and B_x."""
    return [family.A, family.B, family.A.derivative("x"), family.B.derivative("x")]


def _wave(order: int, A: sp.Expr, B: sp.Expr, A_x: sp.Expr, B_x: sp.Expr) -> sp.Expr:
    return (-1) ** order * (1 - 2 * (A * B_x - A_x * B) / (A**2 + B**2))


def _to_sympy(polynomial: fmpq_mpoly, *generators: sp.Expr) -> sp.Expr:
    """The expanded polynomial in these generators."""
    powers = [[sp.S.One] for _ in generators]
    for row, generator, degree in zip(powers, generators, polynomial.degrees(), strict=True):
        row.extend(generator**n for n in range(1, degree + 1))
    terms = (
        sp.Mul(sp.Rational(int(c.p), int(c.q)), *(row[n] for row, n in zip(powers, exponents, strict=True)))
        for exponents, c in polynomial.terms()
    )
    return sp.Add(*terms)
