"""The certificate of a proof: plain data from which `checker` repeats it.

It holds the equation as a polynomial in jets, the formula, the generators with their meanings,
slopes and relations, the image of the formula, and a point at which no denominator vanishes.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from flint import fmpq_mpoly

from .balls import Point
from .compilation import Compilation
from .digest import FORMAT, digest
from .field import PolynomialRing
from .fraction import Fraction
from .generator import Generator
from .jets import coefficients
from .problem import Problem
from .tree import NodeTable

Data = dict[str, Any]


def make_certificate(problem: Problem, compiled: Compilation, point: Point) -> Data:
    """The certificate of a formula whose residual reduced to 0."""
    field, table = compiled.field, NodeTable()
    known = [c for c in coefficients(problem.left, problem.unknown) if not c.is_Rational]
    fractions = _Fractions(field.ring)
    body: Data = {
        "format": FORMAT,
        "name": problem.name,
        "variables": [table.place(variable) for variable in problem.variables],
        "equation": _terms(problem, table),
        "expression": table.place(problem.expression),
        "image": fractions.data(compiled.elements[0]),
        "coefficients": [[table.place(c), fractions.data(field.element(c))] for c in known],
        "generators": [_generator(g, compiled, table, fractions) for g in field.generators],
        "factors": fractions.factors,
        "point": [[table.place(symbol), str(value)] for symbol, value in point.items()],
    }
    body["nodes"] = table.nodes
    return body | {"digest": digest(body)}


def polynomial_data(polynomial: fmpq_mpoly) -> list[list[Any]]:
    """Terms ``[coefficient, exponents]``, the generators in their order."""
    return [
        [str(coefficient), [int(e) for e in reversed(exponents)]]
        for exponents, coefficient in polynomial.terms()
    ]


class _Fractions:
    """Fractions as data, with one list of the factors of all denominators."""

    def __init__(self, ring: PolynomialRing) -> None:
        self._ring = ring
        self._places: dict[int, int] = {}
        self.factors: list[list[list[Any]]] = []

    def data(self, fraction: Fraction) -> Data:
        """Numerator, and the denominator as pairs (place of a factor, power)."""
        powers = [[self._place(i), power] for i, power in sorted(fraction.powers.items())]
        return {"numerator": polynomial_data(fraction.numerator), "denominator": powers}

    def _place(self, i: int) -> int:
        if i not in self._places:
            self._places[i] = len(self.factors)
            self.factors.append(polynomial_data(self._ring.factors[i]))
        return self._places[i]


def _generator(
    generator: Generator, compiled: Compilation, table: NodeTable, fractions: _Fractions
) -> Data:
    field = compiled.field
    place = field.generators.index(generator)
    relations = [r for r in field.ring.relations if r.generator == place]
    return {
        "name": generator.symbol.name,
        "meaning": table.place(generator.meaning),
        "slopes": [fractions.data(field.slope(generator, v)) for v in field.derivations],
        "relation": [[r.degree, polynomial_data(r.value)] for r in relations],
    }


def _terms(problem: Problem, table: NodeTable) -> list[list[Any]]:
    """Each term: a rational number, known factors, and derivatives by their orders."""
    return [_term(term, problem, table) for term in sp.Add.make_args(sp.expand(problem.left))]


def _term(term: sp.Expr, problem: Problem, table: NodeTable) -> list[Any]:
    number, known, jets = sp.S.One, [], []
    for factor in sp.Mul.make_args(term):
        if factor.is_Rational:
            number *= factor
        elif not factor.has(problem.unknown):
            known.append(table.place(factor))
        else:
            base, power = factor.as_base_exp()
            jets += [_orders(base, problem)] * int(power)
    return [str(number), known, jets]


def _orders(jet: sp.Expr, problem: Problem) -> list[int]:
    pairs = jet.variable_count if isinstance(jet, sp.Derivative) else ()
    counts = {symbol: int(count) for symbol, count in pairs}
    return [counts.get(variable, 0) for variable in problem.variables]
