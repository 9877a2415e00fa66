"""The residual of a polynomial differential equation at an element of a differential field."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping

import sympy as sp

from .algebra import DifferentialField
from .fraction import Fraction, common_denominator
from .generator import Unsupported

Order = tuple[tuple[sp.Symbol, int], ...]


class Jets:
    """The derivatives of an element, each made once from a lower one."""

    def __init__(self, field: DifferentialField, element: Fraction) -> None:
        self._field = field
        self._found: dict[Order, Fraction] = {(): element}

    def derivative(self, counts: Mapping[sp.Symbol, int]) -> Fraction:
        """The derivative taken ``counts[v]`` times in each variable v."""
        order: Order = tuple((v, n) for v, n in sorted(counts.items(), key=str) if n)
        if order not in self._found:
            variable = order[-1][0]
            lower = dict(order) | {variable: order[-1][1] - 1}
            self._found[order] = self._field.derivations[variable](self.derivative(lower))
        return self._found[order]


class EquationImage:
    """A polynomial in an unknown function, its derivatives and known elements."""

    def __init__(self, field: DifferentialField, unknown: sp.Expr, element: Fraction) -> None:
        self.field = field
        self.unknown = unknown
        self.jets = Jets(field, element)

    def residual(self, equation: sp.Expr) -> Fraction:
        """``equation`` at the element; the sum is formed over one common denominator."""
        parts = [self._term(term) for term in sp.Add.make_args(sp.expand(equation))]
        common = common_denominator(parts)
        total = self.field.ring.constant(0)
        for part in parts:
            total += part.over(common)
        return Fraction(self.field.ring, total, common)

    def _term(self, term: sp.Expr) -> Fraction:
        factors: Counter[sp.Expr] = Counter()
        for factor in sp.Mul.make_args(term):
            base, exponent = factor.as_base_exp()
            if exponent.is_Integer and exponent > 0 and base.has(self.unknown):
                factors[base] += int(exponent)
            else:
                factors[factor] += 1
        total = self.field.number(sp.S.One)
        for factor, count in factors.items():
            value = self._factor(factor)
            for _ in range(count):
                total = total * value
        return total

    def _factor(self, factor: sp.Expr) -> Fraction:
        if factor == self.unknown:
            return self.jets.derivative({})
        if isinstance(factor, sp.Derivative) and factor.expr == self.unknown:
            return self.jets.derivative({v: int(n) for v, n in factor.variable_count})
        if factor.has(self.unknown):
            raise Unsupported(f"the equation must be polynomial in {self.unknown}, got {factor}")
        return self.field.element(factor)


def coefficients(equation: sp.Expr, unknown: sp.Expr) -> list[sp.Expr]:
    """The factors of the terms of ``equation`` that are free of ``unknown``."""
    terms = sp.Add.make_args(sp.expand(equation))
    factors = [factor for term in terms for factor in sp.Mul.make_args(term)]
    return [factor for factor in dict.fromkeys(factors) if not factor.has(unknown)]
