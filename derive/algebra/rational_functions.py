"""Rational functions of a few symbols over Q, kept in lowest terms by FLINT.

The coefficients of all expansions.  Greatest common divisors are nearly all of their time, and are
found some hundred times as fast as in SymPy's ``FracField``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import fmpq_mpoly_ctx, fmpz_mpoly, fmpz_mpoly_ctx
from sympy import Expr, Integer, Rational, Symbol

Exponents = tuple[int, ...]
Terms = list[tuple[Exponents, int]]
"""Of a polynomial: exponents of the symbols, and the coefficient."""


def _factored(polynomial: fmpz_mpoly) -> tuple[int, list[tuple[fmpz_mpoly, int]]]:
    """The content and the irreducible factors with their powers.

    python-flint puts integer factors in the order of their coefficients, which must fit a machine's
    word for that; rational ones have no such limit.
    """
    try:
        content, parts = polynomial.factor()
        return int(content), parts
    except OverflowError:
        context = polynomial.context()
        rational = fmpq_mpoly_ctx.get(context.names(), context.ordering())
        _, over_q = rational.from_dict(polynomial.to_dict()).factor()
        found = [(_primitive(part, context), int(times)) for part, times in over_q]
        rest = int(polynomial.leading_coefficient())
        for part, times in found:
            rest //= int(part.leading_coefficient()) ** times
        return rest, found


def _primitive(part: Any, context: fmpz_mpoly_ctx) -> fmpz_mpoly:
    """The multiple of a rational polynomial with integers that have no divisor in common."""
    terms = part.to_dict()
    scale = math.lcm(*(int(value.denominator) for value in terms.values()))
    whole = {powers: int(value * scale) for powers, value in terms.items()}
    common = math.gcd(*whole.values())
    return context.from_dict({powers: value // common for powers, value in whole.items()})


@dataclass(frozen=True)
class RationalFunctions:
    """The field Q(symbols).

    >>> x, y = Symbol("x"), Symbol("y")
    >>> field = RationalFunctions((x, y))
    >>> field.from_expr((x**2 - y**2) / (x - y))
    x + y
    """

    symbols: tuple[Symbol, ...]

    def __reduce__(self) -> tuple[type, tuple[tuple[Symbol, ...]]]:
        """FLINT's rings do not pickle; the field of these symbols has but one."""
        return RationalFunctions, (self.symbols,)

    @cached_property
    def context(self) -> Any:
        """FLINT's ring of polynomials, generators in the order of the symbols."""
        return fmpz_mpoly_ctx.get([f"x{i}" for i in range(len(self.symbols))], "lex")

    @cached_property
    def zero(self) -> RationalFunction:
        """0."""
        return self(0)

    @cached_property
    def one(self) -> RationalFunction:
        """1."""
        return self(1)

    def __call__(self, value: int | Symbol) -> RationalFunction:
        """An integer or one of the symbols."""
        ring = self.context
        one = ring.constant(1)
        if isinstance(value, Symbol):
            return RationalFunction(self, ring.gens()[self.symbols.index(value)], one)
        return RationalFunction(self, ring.constant(int(value)), one)

    def from_terms(self, terms: Iterable[tuple[Exponents, int]]) -> RationalFunction:
        """The polynomial with these terms; no two have the same exponents."""
        return RationalFunction(self, self.context.from_dict(dict(terms)), self.context.constant(1))

    def from_expr(
        self, value: Expr, images: Mapping[Symbol, RationalFunction] | None = None
    ) -> RationalFunction:
        """A SymPy expression, with ``images`` in the places of some symbols."""
        known = images or {}
        if value.is_Symbol:
            return known[value] if value in known else self(value)
        if value.is_Rational:
            return self(int(value.p)) / self(int(value.q))
        parts = [self.from_expr(part, known) for part in value.args[: 1 if value.is_Pow else None]]
        if value.is_Pow and value.exp.is_Integer:
            return parts[0] ** int(value.exp)
        if not (value.is_Add or value.is_Mul):
            raise ValueError(
                f"value must be a rational function, got {value} (put a symbol for it)"
            )
        total = parts[0]
        for part in parts[1:]:
            total = total + part if value.is_Add else total * part
        return total


class RationalFunction:
    """A quotient of polynomials with integer coefficients, without a common factor."""

    __slots__ = ("denom", "field", "numer")

    def __init__(self, field: RationalFunctions, numer: fmpz_mpoly, denom: fmpz_mpoly) -> None:
        self.field = field
        self.numer = numer
        self.denom = denom

    def __reduce__(self) -> tuple[Callable[..., RationalFunction], tuple[Any, ...]]:
        return _quotient, (self.field, dict(self.terms()), dict(self.terms(below=True)))

    def _lowest(self, numer: fmpz_mpoly, denom: fmpz_mpoly) -> RationalFunction:
        common = numer.gcd(denom)
        if denom.leading_coefficient() < 0:
            common = -common
        if not common.is_one():
            numer, denom = numer / common, denom / common
        return RationalFunction(self.field, numer, denom)

    def _other(self, value: int | RationalFunction) -> RationalFunction:
        return self.field(value) if isinstance(value, int) else value

    def __bool__(self) -> bool:
        return bool(self.numer)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, int | RationalFunction):
            return NotImplemented
        found = self._other(other)
        return bool(self.numer == found.numer and self.denom == found.denom)

    def __hash__(self) -> int:
        return hash((str(self.numer), str(self.denom)))

    def __neg__(self) -> RationalFunction:
        return RationalFunction(self.field, -self.numer, self.denom)

    def __add__(self, other: int | RationalFunction) -> RationalFunction:
        found = self._other(other)
        if self.denom == found.denom:
            return self._lowest(self.numer + found.numer, self.denom)
        return self._lowest(
            self.numer * found.denom + found.numer * self.denom, self.denom * found.denom
        )

    def __sub__(self, other: int | RationalFunction) -> RationalFunction:
        return self + -other

    def __mul__(self, other: int | RationalFunction) -> RationalFunction:
        if not isinstance(other, int | RationalFunction):  # a polynomial or series takes it
            return NotImplemented
        found = self._other(other)
        return self._lowest(self.numer * found.numer, self.denom * found.denom)

    def __truediv__(self, other: int | RationalFunction) -> RationalFunction:
        found = self._other(other)
        if not found:
            raise ZeroDivisionError("the divisor must not be 0, got 0")
        return self._lowest(self.numer * found.denom, self.denom * found.numer)

    __radd__, __rmul__ = __add__, __mul__

    def __rtruediv__(self, other: int) -> RationalFunction:
        return self.field(other) / self

    def __pow__(self, exponent: int) -> RationalFunction:
        if exponent < 0:
            return 1 / self ** (-exponent)
        return RationalFunction(self.field, self.numer**exponent, self.denom**exponent)

    def __repr__(self) -> str:
        return str(self.as_expr())

    @property
    def is_number(self) -> bool:
        """Whether no symbol is in it."""
        return bool(self.numer.is_constant() and self.denom.is_constant())

    @property
    def is_negative(self) -> bool:
        """Whether it is printed behind a minus sign: by its first coefficient."""
        return bool(self.numer.leading_coefficient() < 0)

    @property
    def is_polynomial(self) -> bool:
        """Whether what is below the line is a number or one term."""
        return len(self.denom) == 1

    def factors(self, *, below: bool = False) -> list[RationalFunction]:
        """The irreducible polynomials in the numerator or ``below`` the line, each once."""
        polynomial = self.denom if below else self.numer
        one = self.field.one.numer
        return [RationalFunction(self.field, part, one) for part, _ in _factored(polynomial)[1]]

    def factored_terms(self, *, below: bool = False) -> list[tuple[Terms, int]]:
        """The terms of each irreducible factor with its power, a number first."""
        polynomial = self.denom if below else self.numer
        content, parts = _factored(polynomial)
        nothing = (0,) * len(self.field.symbols)
        found = [([(nothing, int(content))], 1)]
        for part, times in parts:
            terms = [(tuple(map(int, e)), int(value)) for e, value in part.terms()]
            found.append((terms, int(times)))
        return found

    def numerator(self) -> RationalFunction:
        """The numerator."""
        return RationalFunction(self.field, self.numer, self.field.one.numer)

    def common(self, other: RationalFunction) -> RationalFunction:
        """The greatest common divisor of both numerators."""
        return RationalFunction(self.field, self.numer.gcd(other.numer), self.field.one.numer)

    def diff(self, symbol: Symbol) -> RationalFunction:
        """The derivative in one of the symbols."""
        place = self.field.symbols.index(symbol)
        above, below = (part.derivative(place) for part in (self.numer, self.denom))
        return self._lowest(above * self.denom - self.numer * below, self.denom**2)

    def terms(self, *, below: bool = False) -> Terms:
        """Exponents and coefficients of the numerator or of what is ``below`` the line."""
        polynomial = self.denom if below else self.numer
        return [(tuple(map(int, e)), int(value)) for e, value in polynomial.terms()]

    def as_expr(self) -> Expr:
        """The quotient in SymPy."""
        above, below = Integer(0), Integer(0)
        for exponents, value in self.terms():
            above += _product(self.field.symbols, exponents, value)
        for exponents, value in self.terms(below=True):
            below += _product(self.field.symbols, exponents, value)
        return above / below

    def factored(self) -> Expr:
        """The quotient in SymPy, both sides in factors.

        >>> x, y = Symbol("x"), Symbol("y")
        >>> RationalFunctions((x, y)).from_expr((2 * x**2 - 2 * y**2) / y).factored()
        2*(x - y)*(x + y)/y
        """
        product: Expr = Integer(1)
        number = Rational(1)
        for below, power in ((False, 1), (True, -1)):
            (content, _), *parts = self.factored_terms(below=below)
            number *= Rational(content[0][1]) ** power
            for terms, times in parts:
                product *= self.field.from_terms(terms).as_expr() ** (power * times)
        return number * product

    def powers_of(self, symbol: Symbol) -> dict[int, RationalFunction]:
        """The coefficients of a symbol's powers in the numerator."""
        place = self.field.symbols.index(symbol)
        parts: dict[int, Terms] = {}
        for exponents, value in self.terms():
            others = (*exponents[:place], 0, *exponents[place + 1 :])
            parts.setdefault(exponents[place], []).append((others, value))
        return {power: self.field.from_terms(terms) for power, terms in parts.items()}

    def solved_for(self, symbol: Symbol, power: int = 1) -> RationalFunction | None:
        """The symbol's power where the quotient vanishes, if no other is in it; else None."""
        parts = self.powers_of(symbol)
        return -parts[0] / parts[power] if parts.keys() == {0, power} else None


def _quotient(
    field: RationalFunctions, above: Mapping[Exponents, int], below: Mapping[Exponents, int]
) -> RationalFunction:
    """A pickled element: numerator and denominator as they were."""
    numer, denom = (field.context.from_dict(terms) for terms in (above, below))
    return RationalFunction(field, numer, denom)


def _product(symbols: Sequence[Symbol], exponents: Exponents, value: int) -> Expr:
    found = Integer(value)
    for symbol, exponent in zip(symbols, exponents, strict=True):
        found *= symbol**exponent
    return found
