"""Factor formulas that are rational in symbols, roots and functions, with FLINT.

The factors are hints; nothing here decides a statement.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from math import lcm, prod

import sympy as sp
from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from longwave.verify.subexpressions import outer_nodes

MOST_TERMS, MOST_DEGREE = 200, 40
"""Most terms and highest degree of a polynomial that is factored."""

Powers = list[tuple[sp.Expr, int]]


class TooLong(ValueError):
    """Raised for a formula with too many terms when expanded."""


def factored(expression: sp.Expr) -> tuple[sp.Rational, Powers]:
    """Return a number and the powers of irreducible factors; raises TooLong.

    >>> x = sp.Symbol("x", positive=True)
    >>> factored(2 * sp.sqrt(x) + x + 1)
    (1, [(sqrt(x) + 1, 2)])
    """
    return Quotients(expression).factors()


def factors_of(expression: sp.Expr) -> tuple[sp.Expr, Powers]:
    """Return a number and powers of factors; they are irreducible unless the formula is too long.

    SymPy is tried first: it knows that exp(2*k) is a square, but fails on a product of roots.

    >>> x, k = sp.symbols("x k", positive=True)
    >>> factors_of(-2 * sp.sqrt(x))
    (-2, [(sqrt(x), 1)])
    >>> factors_of((sp.exp(2 * k) - 1) / x)
    (1, [(exp(k) - 1, 1), (exp(k) + 1, 1), (x, -1)])
    """
    with suppress(sp.PolynomialError):
        (number, above), (under, below) = map(sp.factor_list, sp.fraction(sp.together(expression)))
        powers = [*above, *((factor, -power) for factor, power in below)]
        if all(sp.Integer(power) == power for _, power in powers):
            return number / under, [(factor, int(power)) for factor, power in powers]
    try:
        return factored(expression)
    except TooLong:
        return sp.S.One, [(expression, 1)]


class Quotients:
    """Expression as a quotient of polynomials in its atoms."""

    def __init__(self, expression: sp.Expr) -> None:
        degrees: dict[sp.Expr, int] = {}
        for node in outer_nodes(expression):
            base, exponent = _rational_power(node)
            if not _is_inner(base):
                degrees[base] = lcm(degrees.get(base, 1), int(exponent.q))
            elif exponent.q != 1:
                degrees.setdefault(base, int(exponent.q))
        self._degrees, self._bases = degrees, list(degrees)
        names = tuple(f"g{i}" for i in range(max(1, len(degrees))))
        self._context = fmpq_mpoly_ctx.get(names, Ordering.lex)
        self._atoms = dict(zip(self._bases, self._context.gens(), strict=False))
        self._found: dict[sp.Expr, tuple[fmpq_mpoly, fmpq_mpoly]] = {}
        self._one = self._context.constant(1)
        self.above, self.below = self._quotient(expression)

    def factors(self) -> tuple[sp.Rational, Powers]:
        """Return a number, and the powers of the irreducible factors."""
        (unit, powers), (under, below) = self.above.factor(), self.below.factor()
        factors = [(self.written(part), int(n)) for part, n in powers]
        factors += [(self.written(part), -int(n)) for part, n in below]
        return rational(unit / under), factors

    def squares(self) -> sp.Expr | None:
        """Write the numerator as a sum of squares and even powers; None if that fails.

        >>> x, y = sp.symbols("x y", real=True)
        >>> Quotients(x**2 + 2 * x * y + 2 * y**2 + 3).squares()
        y**2 + (x + y)**2 + 3
        """
        rest, squares = self.above, []
        for place, gen in enumerate(self._context.gens()):
            if int(rest.degrees()[place]) != 2 or self._is_even(rest):
                continue
            name = f"g{place}"
            second = rest.derivative(name).derivative(name) / 2
            first = rest.derivative(name) - 2 * second * gen
            if len(second) != 1 or not self._is_even(second):
                continue
            number = second.leading_coefficient()
            root = (second / number).sqrt()
            shift, remainder = divmod(first, 2 * number * root)
            if remainder.is_zero():
                square = root * gen + shift
                squares.append(rational(number) * self.written(square) ** 2)
                rest -= number * square**2
        return sp.Add(*squares, self.written(rest)) if self._is_even(rest) else None

    @staticmethod
    def _is_even(polynomial: fmpq_mpoly) -> bool:
        return all(c > 0 and not any(n % 2 for n in powers) for powers, c in polynomial.terms())

    def linear_in(self, base: sp.Expr) -> tuple[sp.Expr, sp.Expr] | None:
        """Return a and b if the numerator is a + b * (root of ``base``); else None."""
        place = self._bases.index(base)
        if int(self.above.degrees()[place]) != 1:
            return None
        slope = self.above.derivative(f"g{place}")
        return self.written(self.above - slope * self._atoms[base]), self.written(slope)

    @property
    def square_roots(self) -> list[tuple[sp.Expr, sp.Expr]]:
        """Pairs of an atom whose square is known and that square."""
        roots = [(base, base) for base, degree in self._degrees.items() if degree == 2]
        return roots + [(b, sp.S.NegativeOne) for b in self._bases if b is sp.I]

    def written(self, polynomial: fmpq_mpoly) -> sp.Expr:
        """Return a polynomial in the atoms as an expression."""
        roots = [sp.Pow(b, sp.Rational(1, self._degrees[b])) for b in self._bases]
        return written(polynomial, roots)

    def _quotient(self, node: sp.Expr) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        if node not in self._found:
            above, below = self._build(node)
            length = max(len(above), len(below))
            if length > MOST_TERMS or max(above.total_degree(), below.total_degree()) > MOST_DEGREE:
                raise TooLong(f"{length} terms")
            if length > 1 and not below.is_constant():
                common = above.gcd(below)
                above, below = above / common, below / common
            self._found[node] = above, below
        return self._found[node]

    def _build(self, node: sp.Expr) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        one = self._one
        if node.is_Rational:
            return self._context.constant(exact(node)), one
        if node.is_Add:
            above, below = self._context.constant(0), one
            for a, b in map(self._quotient, node.args):
                same = b == below
                above, below = (above + a, b) if same else (above * b + a * below, below * b)
            return above, below
        if node.is_Mul:
            numerators, denominators = zip(*map(self._quotient, node.args), strict=True)
            return prod(numerators, start=one), prod(denominators, start=one)
        base, exponent = _rational_power(node)
        if base in self._atoms and (exponent.q != 1 or not _is_inner(base)):
            above, below = self._atoms[base], one
            power = int(exponent * self._degrees[base])
        else:
            above, below = self._quotient(base)
            power = int(exponent)
        if abs(power) * max(above.total_degree(), below.total_degree()) > MOST_DEGREE:
            raise TooLong(f"degree of {node}")
        return (above**power, below**power) if power >= 0 else (below**-power, above**-power)


def rational(value: fmpq) -> sp.Rational:
    """Convert a FLINT number to SymPy."""
    return sp.Rational(int(value.p), int(value.q))


def exact(value: sp.Rational) -> fmpq:
    """Convert a SymPy number to FLINT."""
    return fmpq(int(value.p), int(value.q))


def written(polynomial: fmpq_mpoly, atoms: Sequence[sp.Expr]) -> sp.Expr:
    """Return a polynomial as an expression, with ``atoms`` for its generators."""
    terms = []
    for exponents, c in polynomial.terms():
        powers = (atom ** int(n) for atom, n in zip(atoms, exponents, strict=False) if n)
        terms.append(sp.Mul(rational(c), *powers))
    return sp.Add(*terms)


def _rational_power(node: sp.Expr) -> tuple[sp.Expr, sp.Rational]:
    """Return base and exponent of a rational power; any other node has the exponent 1."""
    base, exponent = node.as_base_exp() if node.is_Pow else (node, sp.S.One)
    return (base, exponent) if exponent.is_Rational else (node, sp.S.One)


def _is_inner(node: sp.Expr) -> bool:
    """Return whether a node is a sum, product, number or integer power, and so not an atom."""
    whole = node.is_Pow and node.exp.is_Integer
    return bool(whole or node.is_Add or node.is_Mul or node.is_Rational)
