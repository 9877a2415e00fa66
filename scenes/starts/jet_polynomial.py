"""Differential polynomials with numbers in: evaluated at arrays of jets."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import mpmath
import numpy as np
from numpy.typing import NDArray
from sympy import Expr, Symbol

from longwave.derive.algebra.jets import DifferentialPolynomial, EpsSeries
from longwave.derive.algebra.rational_functions import RationalFunction

Array = NDArray[np.float64]

DIGITS = 40
"""Of the constants, in coefficients whose terms may cancel."""

_EXACT = mpmath.MPContext()
_EXACT.dps = DIGITS


@dataclass(frozen=True)
class JetPolynomial:
    """``sum coefficient prod U_{iX}**times``: terms of a coefficient and pairs (i, times).

    >>> square = JetPolynomial(((3.0, ((1, 2),)), (1.0, ())))
    >>> square(np.array([[5.0], [2.0]]))
    array([13.])
    """

    terms: tuple[tuple[float, tuple[tuple[int, int], ...]], ...]

    @property
    def highest(self) -> int:
        """The highest X-derivative in it, 0 if there is none."""
        return max((count for _, factors in self.terms for count, _ in factors), default=0)

    def __call__(self, jets: Array) -> Array:
        """Its values where the unknown and its X-derivatives are ``jets``, (derivative, *points).

        More jets than it needs may be given.
        """
        total = np.zeros(jets.shape[1:])
        for coefficient, factors in self.terms:
            total += math.prod((jets[i] ** times for i, times in factors), start=coefficient)
        return total

    def variation(self, jets: Array) -> list[Array]:
        """Its derivative by each of the jets that are given, at these values."""
        found = [np.zeros(jets.shape[1:]) for _ in jets]
        for coefficient, factors in self.terms:
            for i, times in factors:
                others = (jets[j] ** (n - (j == i)) for j, n in factors)
                found[i] += math.prod(others, start=coefficient * times)
        return found

    def slope(self) -> JetPolynomial:
        """Its derivative by X.

        >>> JetPolynomial(((3.0, ((0, 2),)),)).slope()
        JetPolynomial(terms=((6.0, ((0, 1), (1, 1))),))
        """
        total: dict[tuple[tuple[int, int], ...], float] = {}
        for coefficient, factors in self.terms:
            for i, times in factors:
                counts = Counter(dict(factors))
                counts.subtract({i: 1})
                counts.update({i + 1: 1})
                key = tuple(sorted(item for item in counts.items() if item[1]))
                total[key] = total.get(key, 0.0) + coefficient * times
        return JetPolynomial(tuple((value, key) for key, value in sorted(total.items())))

    @property
    def linear(self) -> dict[int, float]:
        """The coefficients of the terms with one jet, by its X-derivatives."""
        return {
            factors[0][0]: coefficient
            for coefficient, factors in self.terms
            if len(factors) == 1 and factors[0][1] == 1
        }


def with_numbers(
    series: EpsSeries | DifferentialPolynomial, values: Mapping[Symbol, Expr], eps: float = 1.0
) -> JetPolynomial:
    """A series at eps, or one polynomial, at values of the constants.

    Raises ValueError for jets with derivatives other than by X, and for a constant without a value.
    """
    parts = {0: series} if isinstance(series, DifferentialPolynomial) else series.parts
    numbers = {symbol: _number(value) for symbol, value in values.items()}
    total: dict[tuple[tuple[int, int], ...], Any] = {}
    for order, part in parts.items():
        for monomial, value in part.terms.items():
            if any(any(jet[1:]) for jet in monomial):
                raise ValueError(
                    f"jets must have derivatives by X alone, got {monomial} (replace those by T "
                    "along the flow)"
                )
            key = tuple(sorted(Counter(jet[0] for jet in monomial).items()))
            term = _at(value, numbers) * _EXACT.mpf(eps) ** order
            total[key] = total[key] + term if key in total else term
    return JetPolynomial(tuple((float(value), key) for key, value in sorted(total.items())))


def _number(value: Expr) -> Any:
    return _EXACT.mpf(str(value.evalf(DIGITS)))


def _at(element: RationalFunction, numbers: Mapping[Symbol, Any]) -> Any:
    """A rational function of the constants at their values."""
    above, below = (_sum(element, line, numbers) for line in (False, True))
    return above / below


def _sum(element: RationalFunction, below: bool, numbers: Mapping[Symbol, Any]) -> Any:
    total = _EXACT.mpf(0)
    for exponents, coefficient in element.terms(below=below):
        product = _EXACT.mpf(coefficient)
        for symbol, power in zip(element.field.symbols, exponents, strict=True):
            if not power:
                continue
            if symbol not in numbers:
                raise ValueError(f"constant {symbol} must have a value, got none (give it)")
            product *= numbers[symbol] ** power
        total += product
    return total
