"""Rational functions of a few symbols over Q, kept in lowest terms by FLINT.

They are the coefficients of all expansions.  Denominators are kept as irreducible factors: there
are few, from determinants, and all sums share them.  A sum is reduced by dividing by the factors
that both denominators have in the same power, a product by those of the other operand; neither
needs a greatest common divisor of polynomials, which is a hundred times slower.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from flint import fmpq_mpoly_ctx, fmpz_mpoly, fmpz_mpoly_ctx
from flint.utils.flint_exceptions import DomainError
from sympy import Expr, Integer, Rational, S, Symbol

Exponents = tuple[int, ...]
Terms = list[tuple[Exponents, int]]
"""Terms of a polynomial: pairs (exponents of the symbols, coefficient)."""


def _factored(polynomial: fmpz_mpoly) -> tuple[int, list[tuple[fmpz_mpoly, int]]]:
    """Return the content and the irreducible factors with their powers.

    python-flint sorts integer factors by coefficients that must fit a machine word; on overflow
    the polynomial is factored over the rationals instead.
    """
    try:
        content, parts = polynomial.factor()
        return int(content), parts
    except OverflowError:
        context = polynomial.context()
        rational = fmpq_mpoly_ctx.get(context.names(), context.ordering())
        _, over_q = rational.from_dict(polynomial.to_dict()).factor()
        factors = [(_primitive(part, context), int(times)) for part, times in over_q]
        number = int(polynomial.leading_coefficient())
        for factor, times in factors:
            number //= int(factor.leading_coefficient()) ** times
        return number, factors


def _primitive(part: Any, context: fmpz_mpoly_ctx) -> fmpz_mpoly:
    """Return the multiple of a rational polynomial with coprime integer coefficients."""
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
        """Pickle the symbols only, because FLINT's rings do not pickle."""
        return RationalFunctions, (self.symbols,)

    @cached_property
    def context(self) -> Any:
        """FLINT's ring of polynomials, generators in the order of the symbols."""
        return fmpz_mpoly_ctx.get([f"x{i}" for i in range(len(self.symbols))], "lex")

    @cached_property
    def zero(self) -> RationalFunction:
        """The number 0."""
        return self(0)

    @cached_property
    def one(self) -> RationalFunction:
        """The number 1."""
        return self(1)

    def __call__(self, value: int | Symbol) -> RationalFunction:
        """Return an integer or one of the symbols as an element."""
        ring = self.context
        if isinstance(value, Symbol):
            return self.polynomial(ring.gens()[self.symbols.index(value)])
        return self.polynomial(ring.constant(int(value)))

    def polynomial(self, value: fmpz_mpoly) -> RationalFunction:
        """Return a FLINT polynomial as an element."""
        return RationalFunction(self, value, 1, {})

    def from_terms(self, terms: Iterable[tuple[Exponents, int]]) -> RationalFunction:
        """Return the polynomial with the given ``terms``; no two may have the same exponents."""
        return self.polynomial(self.context.from_dict(dict(terms)))

    def from_expr(
        self, value: Expr, images: Mapping[Symbol, RationalFunction] | None = None
    ) -> RationalFunction:
        """Convert a SymPy expression; symbols that are keys of ``images`` are replaced."""
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


class Factor:
    """An irreducible polynomial with positive first coefficient; equal ones have equal hashes."""

    __slots__ = ("_hash", "polynomial", "terms")

    def __init__(self, polynomial: fmpz_mpoly) -> None:
        self.polynomial = polynomial
        self.terms = _terms(polynomial)
        self._hash = hash(tuple(self.terms))

    def __hash__(self) -> int:
        return self._hash

    def __eq__(self, other: object) -> bool:
        return self is other or (
            isinstance(other, Factor)
            and self._hash == other._hash
            and bool(self.polynomial == other.polynomial)
        )

    def __reduce__(self) -> tuple[Callable[..., Factor], tuple[Any, ...]]:
        return _factor, (self.polynomial.context().names(), dict(self.terms))

    def taken_from(self, numer: fmpz_mpoly, most: int) -> tuple[fmpz_mpoly, int]:
        """Divide ``numer`` by this factor, ``most`` times at most; return quotient, times left."""
        while most:
            try:
                numer = numer / self.polynomial
            except DomainError:  # not a factor
                break
            most -= 1
        return numer, most


Factors = Mapping[Factor, int]
"""Irreducible factor -> its power."""


class RationalFunction:
    """A quotient of polynomials with integer coefficients, without a common factor.

    ``numer`` is the numerator; the denominator is the positive integer ``content`` times the
    irreducible factors ``below``.
    """

    __slots__ = ("_parts", "below", "content", "field", "numer")

    def __init__(
        self, field: RationalFunctions, numer: fmpz_mpoly, content: int, below: Factors
    ) -> None:
        self.field, self.numer, self.content, self.below = field, numer, content, below
        self._parts: tuple[int, dict[Factor, int]] | None = None

    def __reduce__(self) -> tuple[Callable[..., RationalFunction], tuple[Any, ...]]:
        return _quotient, (self.field, dict(self.terms()), self.content, dict(self.below))

    @property
    def denom(self) -> fmpz_mpoly:
        """The denominator as one polynomial."""
        denominator = self.field.context.constant(self.content)
        for factor, times in self.below.items():
            denominator *= factor.polynomial**times
        return denominator

    def _lowest(
        self, numer: fmpz_mpoly, content: int, below: Factors, among: Iterable[Factor]
    ) -> RationalFunction:
        """Return ``numer/(content below)`` reduced by the factors ``among``; no other is tried."""
        if not numer:
            return self.field.zero
        numer, content = _without_content(numer, content)
        remaining = dict(below)
        for factor in among:
            numer, remaining[factor] = factor.taken_from(numer, remaining[factor])
        return RationalFunction(self.field, numer, content, _nonzero_powers(remaining))

    @property
    def _numerator_factors(self) -> tuple[int, dict[Factor, int]]:
        """Content and irreducible factors of the numerator."""
        if self._parts is None:
            content, parts = _factored(self.numer)
            factors = {Factor(part): int(times) for part, times in parts}
            self._parts = int(content), factors
        return self._parts

    def _other(self, value: int | RationalFunction) -> RationalFunction:
        return self.field(value) if isinstance(value, int) else value

    def __bool__(self) -> bool:
        return bool(self.numer)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, int | RationalFunction):
            return NotImplemented
        value = self._other(other)
        same_denominator = self.content == value.content and self.below == value.below
        return same_denominator and bool(self.numer == value.numer)

    def __hash__(self) -> int:
        return hash((str(self.numer), self.content, frozenset(self.below.items())))

    def __neg__(self) -> RationalFunction:
        return RationalFunction(self.field, -self.numer, self.content, self.below)

    def __add__(self, other: int | RationalFunction) -> RationalFunction:
        addend = self._other(other)
        content = math.lcm(self.content, addend.content)
        below = dict(self.below)
        for factor, times in addend.below.items():
            below[factor] = max(times, below.get(factor, 0))
        # a factor in different powers is in one expanded numerator only, so it divides no sum
        shared = [f for f in below if self.below.get(f) == addend.below.get(f)]
        numer = self._over(content, below) + addend._over(content, below)
        return self._lowest(numer, content, below, shared)

    def _over(self, content: int, below: Factors) -> fmpz_mpoly:
        """Return the numerator over ``content`` times ``below``, a multiple of the denominator."""
        numer = self.numer
        if content != self.content:
            numer = numer * (content // self.content)
        for factor, times in below.items():
            missing_power = times - self.below.get(factor, 0)
            if missing_power:
                numer = numer * factor.polynomial**missing_power
        return numer

    def __sub__(self, other: int | RationalFunction) -> RationalFunction:
        return self + -other

    def __mul__(self, other: int | RationalFunction) -> RationalFunction:
        if not isinstance(other, int | RationalFunction):  # polynomials and series handle it
            return NotImplemented
        factor_ = self._other(other)
        if not (self.numer and factor_.numer):
            return self.field.zero
        left, over = _without_content(self.numer, factor_.content)
        right, content = _without_content(factor_.numer, self.content)
        below: dict[Factor, int] = {}
        for factor, times in self.below.items():
            right, below[factor] = factor.taken_from(right, times)
        for factor, times in factor_.below.items():
            left, remaining = factor.taken_from(left, times)
            below[factor] = below.get(factor, 0) + remaining
        return RationalFunction(self.field, left * right, over * content, _nonzero_powers(below))

    def __truediv__(self, other: int | RationalFunction) -> RationalFunction:
        divisor = self._other(other)
        if not divisor:
            raise ZeroDivisionError("the divisor must not be 0, got 0")
        if not self:
            return self
        leading_content, parts = divisor._numerator_factors
        numer, content = _without_content(self.numer, abs(leading_content))
        common = math.gcd(self.content, divisor.content)
        below = dict(self.below)
        for factor, times in parts.items():
            numer, remaining = factor.taken_from(numer, times)
            below[factor] = below.get(factor, 0) + remaining
        numer = numer * (divisor.content // common * (1 if leading_content > 0 else -1))
        for factor, times in divisor.below.items():
            cancelled = min(times, below.get(factor, 0))
            numer = numer * factor.polynomial ** (times - cancelled)
            below[factor] = below.get(factor, 0) - cancelled
        content *= self.content // common
        return RationalFunction(self.field, numer, content, _nonzero_powers(below))

    __radd__, __rmul__ = __add__, __mul__

    def __rtruediv__(self, other: int) -> RationalFunction:
        return self.field(other) / self

    def __pow__(self, exponent: int) -> RationalFunction:
        if exponent < 0:
            return 1 / self ** (-exponent)
        below = {factor: times * exponent for factor, times in self.below.items() if exponent}
        return RationalFunction(self.field, self.numer**exponent, self.content**exponent, below)

    def __repr__(self) -> str:
        return str(self.as_expr())

    @property
    def is_number(self) -> bool:
        """Whether the element contains no symbol."""
        return bool(self.numer.is_constant() and not self.below)

    @property
    def is_negative(self) -> bool:
        """Whether the numerator's first coefficient is negative: a minus sign is then printed."""
        return bool(self.numer.leading_coefficient() < 0)

    @property
    def size(self) -> int:
        """Number of terms of the numerator and of the denominator's factors."""
        return len(self.numer) + sum(len(factor.polynomial) for factor in self.below)

    @property
    def is_polynomial(self) -> bool:
        """Whether the denominator is a number or one term."""
        return all(len(factor.polynomial) == 1 for factor in self.below)

    def factors(self, *, below: bool = False) -> list[RationalFunction]:
        """Return the irreducible factors of the numerator, or of the denominator if ``below``."""
        parts = self.below if below else self._numerator_factors[1]
        return [self.field.polynomial(factor.polynomial) for factor, _ in _sorted(parts)]

    def factored_terms(self, *, below: bool = False) -> list[tuple[Terms, int]]:
        """Return (terms, power) of the content, then of each factor; ``below`` as in `factors`."""
        content, parts = (self.content, self.below) if below else self._numerator_factors
        nothing = (0,) * len(self.field.symbols)
        factors = [(factor.terms, times) for factor, times in _sorted(parts)]
        return [([(nothing, content)], 1), *factors]

    def numerator(self) -> RationalFunction:
        """Return the numerator as an element."""
        return self.field.polynomial(self.numer)

    def common(self, other: RationalFunction) -> RationalFunction:
        """Return the greatest common divisor of both numerators."""
        return self.field.polynomial(self.numer.gcd(other.numer))

    def diff(self, symbol: Symbol) -> RationalFunction:
        """Return the derivative in one of the symbols."""
        index = self.field.symbols.index(symbol)
        slope = self.numer.derivative(index)
        total = self._lowest(slope, self.content, self.below, self.below)
        for factor, times in self.below.items():
            slope = self.numer * factor.polynomial.derivative(index) * -times
            below = {**self.below, factor: times + 1}
            total = total + self._lowest(slope, self.content, below, below)
        return total

    def terms(self, *, below: bool = False) -> Terms:
        """Return the terms of the numerator, or of the denominator if ``below``."""
        return _terms(self.denom if below else self.numer)

    def mapped(
        self, image: Callable[[Terms], RationalFunction], known: dict[Factor, RationalFunction]
    ) -> RationalFunction:
        """Return the image under a map of polynomials that preserves sums and products.

        ``known`` caches the images of denominator factors, and is extended by new ones.
        """
        result = image(self.terms()) / self.content
        for factor, times in self.below.items():
            if factor not in known:
                known[factor] = image(factor.terms)
            for _ in range(times):
                result = result / known[factor]
        return result

    def as_expr(self) -> Expr:
        """Return the quotient as a SymPy expression."""
        numerator, denominator = (
            sum((_product(self.field.symbols, *term) for term in self.terms(below=below)), S.Zero)
            for below in (False, True)
        )
        return numerator / denominator

    def factored(self) -> Expr:
        """Return the quotient as a SymPy expression, both sides factored.

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
        """Return the numerator as a polynomial in ``symbol``: power -> coefficient."""
        index = self.field.symbols.index(symbol)
        parts: dict[int, Terms] = {}
        for exponents, value in self.terms():
            others = (*exponents[:index], 0, *exponents[index + 1 :])
            parts.setdefault(exponents[index], []).append((others, value))
        return {power: self.field.from_terms(terms) for power, terms in parts.items()}

    def solved_for(self, symbol: Symbol, power: int = 1) -> RationalFunction | None:
        """Solve ``self = 0`` for ``symbol**power``.

        None if another power of ``symbol`` occurs, or no term without it.
        """
        parts = self.powers_of(symbol)
        return -parts[0] / parts[power] if parts.keys() == {0, power} else None


def _quotient(
    field: RationalFunctions, above: Mapping[Exponents, int], content: int, below: Factors
) -> RationalFunction:
    """Rebuild a pickled rational function."""
    return RationalFunction(field, field.context.from_dict(above), content, below)


def _factor(names: Sequence[str], terms: Mapping[Exponents, int]) -> Factor:
    """Rebuild a pickled factor."""
    return Factor(fmpz_mpoly_ctx.get(names, "lex").from_dict(terms))


def _terms(polynomial: fmpz_mpoly) -> Terms:
    return [(tuple(map(int, e)), int(value)) for e, value in polynomial.terms()]


def _sorted(powers: Factors) -> list[tuple[Factor, int]]:
    """Return the factors in FLINT's order: by powers, exponents and coefficients."""

    def sort_key(item: tuple[Factor, int]) -> tuple[Any, ...]:
        exponents, values = zip(*item[0].terms, strict=True)
        return item[1], exponents, values

    return sorted(powers.items(), key=sort_key)


def _nonzero_powers(powers: Factors) -> Factors:
    """Return the factors with nonzero power."""
    return {factor: times for factor, times in powers.items() if times}


def _without_content(numer: fmpz_mpoly, content: int) -> tuple[fmpz_mpoly, int]:
    """Divide numerator and content by their greatest common integer."""
    if content == 1:
        return numer, 1
    common = numer.gcd(numer.context().constant(content))
    return numer / common, content // int(common.leading_coefficient())


def _product(symbols: Sequence[Symbol], exponents: Exponents, value: int) -> Expr:
    result = Integer(value)
    for symbol, exponent in zip(symbols, exponents, strict=True):
        result *= symbol**exponent
    return result
