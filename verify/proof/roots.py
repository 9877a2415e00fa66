"""Square roots that depend on each other: sqrt(6) = sqrt(2) sqrt(3), up to a sign.

A square root whose square, times those of some others, is a square is plus or minus a known
element; where the domains tell which, it is no generator of its own.
"""

from __future__ import annotations

from collections import Counter

import sympy as sp
from flint import fmpq

from .fraction import Fraction
from .generator import Unsupported

Key = tuple[str, int]
"""An irreducible factor: a prime or -1, or the place of a polynomial in the ring's list."""


def factor_exponents(element: Fraction) -> Counter[Key]:
    """The irreducible factors of a fraction with their exponents."""
    unit, powers = element.ring.split(element.numerator)
    found: Counter[Key] = Counter({("polynomial", i): power for i, power in powers.items()})
    found.subtract({("polynomial", i): power for i, power in element.powers.items()})
    for number, sign in ((unit.p, 1), (unit.q, -1)):
        for prime, power in sp.factorint(int(number)).items():
            found["number", int(prime)] += sign * power
    return found


class RootTable:
    """The independent square roots, as rows of a matrix of exponents modulo 2."""

    def __init__(self) -> None:
        self._squares: dict[sp.Symbol, Fraction] = {}
        self._rows: list[tuple[frozenset[Key], frozenset[sp.Symbol]]] = []

    def companions(self, symbol: sp.Symbol, square: Fraction) -> frozenset[sp.Symbol] | None:
        """The roots whose product with this one is rational; None if there are none.

        In that case the root joins the table.
        """
        exponents = factor_exponents(square)
        odd = frozenset(key for key, power in exponents.items() if power % 2)
        members = frozenset[sp.Symbol]()
        for row, row_members in self._rows:
            if max(row) in odd:
                odd, members = odd ^ row, members ^ row_members
        if not odd:
            return members
        self._squares[symbol] = square
        self._rows.append((odd, members | {symbol}))
        return None

    def rational_part(self, square: Fraction, companions: frozenset[sp.Symbol]) -> Fraction:
        """The square root of ``square`` over the squares of ``companions``, up to its sign."""
        quotient = square
        for symbol in companions:
            quotient = quotient * self._squares[symbol].inverse()
        ring, halves = square.ring, Fraction(square.ring, square.ring.constant(1))
        for (kind, name), power in factor_exponents(quotient).items():
            base = ring.factors[name] if kind == "polynomial" else ring.constant(fmpq(name))
            halves = halves * Fraction(ring, base) ** (power // 2)
        if not (halves * halves - quotient).is_zero:
            raise Unsupported("a product of square roots is no rational element")
        return halves
