"""Arguments of exponentials and elliptic functions as integer combinations of a few."""

from __future__ import annotations

from collections.abc import Iterable
from math import lcm

import sympy as sp
from flint import fmpz_mat

Vector = dict[sp.Expr, sp.Rational]

LONGEST = 60
"""Operations of a quotient that common factors are looked for in."""


def terms(expression: sp.Expr) -> Vector:
    """The expanded terms of ``expression`` with their rational coefficients.

    >>> x, y = sp.symbols("x y")
    >>> terms(2 * (x - y / 3))
    {x: 2, y: -2/3}
    """
    found: Vector = {}
    for term in sp.Add.make_args(sp.expand(cancelled(expression))):
        coefficient, rest = term.as_coeff_Mul(rational=True)
        found[rest] = found.get(rest, sp.S.Zero) + coefficient
    return {rest: value for rest, value in found.items() if value != 0}


def cancelled(expression: sp.Expr) -> sp.Expr:
    """A quotient of short sums with common factors divided out.

    >>> x = sp.Symbol("x")
    >>> cancelled((x**2 - 1) / (x + 1))
    x - 1
    """
    below = (node.base for node in expression.atoms(sp.Pow) if node.exp.is_negative)
    if not any(base.is_Add for base in below) or expression.count_ops() > LONGEST:
        return expression
    found: sp.Expr = sp.cancel(expression)
    return found


def without_logarithms(exponent: sp.Expr) -> tuple[sp.Expr, Vector]:
    """``exponent`` less its multiples of logarithms and of i atan, and these.

    >>> x, y = sp.symbols("x y")
    >>> without_logarithms(2 * x - sp.log(y) / 2)
    (2*x, {log(y): -1/2})
    """
    found = terms(exponent)
    logarithms = {term: value for term, value in found.items() if _is_logarithm(term, value)}
    if not logarithms:
        return exponent, {}
    rest = sp.Add(*(value * term for term, value in found.items() if term not in logarithms))
    return rest, logarithms


def _is_logarithm(term: sp.Expr, value: sp.Rational) -> bool:
    """Whether the exponential of ``value * term`` is algebraic: of log f, or of 2 i atan f."""
    is_phase = term.is_Mul and len(term.args) == 2 and term.has(sp.I)
    turned = is_phase and isinstance(term / sp.I, sp.atan) and value % 2 == 0
    return bool(isinstance(term, sp.log) or turned)


class ArgumentLattice:
    """A basis of the integer combinations of ``arguments``.

    >>> x, y = sp.symbols("x y")
    >>> lattice = ArgumentLattice([2 * x, 3 * x + 3 * y, -3 * y])
    >>> lattice.basis
    (x, 3*y)
    >>> lattice.coordinates(x - 6 * y)
    (1, -2)
    """

    def __init__(self, arguments: Iterable[sp.Expr]) -> None:
        given = list(dict.fromkeys(arguments))
        vectors = [terms(argument) for argument in given]
        monomials = {monomial for vector in vectors for monomial in vector}
        self._monomials = sorted(monomials, key=sp.default_sort_key)
        self._scale = lcm(*(int(value.q) for vector in vectors for value in vector.values()))
        self._rows = self._hermite([self._integers(vector) for vector in vectors])
        self.basis = tuple(self._written(row, given, vectors) for row in self._rows)

    def coordinates(self, argument: sp.Expr) -> tuple[int, ...]:
        """The integers whose combination of the basis is ``argument``.

        Raises ValueError if there are none.
        """
        rest, found = self._integers(terms(argument)), []
        for row in self._rows:
            pivot = next(i for i, value in enumerate(row) if value)
            multiple = rest[pivot] // row[pivot]
            rest = [value - multiple * step for value, step in zip(rest, row, strict=True)]
            found.append(multiple)
        if any(rest):
            raise ValueError(
                f"argument must be a combination of {self.basis}, got {argument} (extend the basis)"
            )
        return tuple(found)

    def _integers(self, vector: Vector) -> list[int]:
        unknown = [monomial for monomial in vector if monomial not in self._monomials]
        if unknown:
            raise ValueError(
                f"argument must be made of {self._monomials}, got {unknown[0]} (extend the basis)"
            )
        return [int(vector.get(m, sp.S.Zero) * self._scale) for m in self._monomials]

    @staticmethod
    def _hermite(rows: list[list[int]]) -> list[list[int]]:
        if not rows or not rows[0]:
            return []
        table = fmpz_mat(rows).hnf().table()
        return [[int(value) for value in row] for row in table if any(row)]

    def _written(self, row: list[int], given: list[sp.Expr], vectors: list[Vector]) -> sp.Expr:
        """A basis vector as it was given, if it was, up to its sign."""
        for argument, vector in zip(given, vectors, strict=True):
            integers = self._integers(vector)
            if integers == row:
                return argument
            if [-value for value in integers] == row:
                return -argument
        values = zip(row, self._monomials, strict=True)
        return sp.Add(*(sp.Rational(value, self._scale) * monomial for value, monomial in values))
