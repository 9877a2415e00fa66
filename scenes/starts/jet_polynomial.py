"""Differential polynomials with numeric coefficients, evaluated on arrays of derivatives."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass

import numpy as np

from longwave.support.real_arrays import Array


@dataclass(frozen=True)
class JetPolynomial:
    """Polynomial ``sum coefficient prod U_{iX}**power`` in an unknown U and its X-derivatives.

    Each term is a coefficient with a pair (i, power) for each factor.

    >>> square = JetPolynomial(((3.0, ((1, 2),)), (1.0, ())))
    >>> square(np.array([[5.0], [2.0]]))
    array([13.])
    """

    terms: tuple[tuple[float, tuple[tuple[int, int], ...]], ...]

    @property
    def highest(self) -> int:
        """Order of the highest X-derivative; 0 if there is none."""
        return max((count for _, factors in self.terms for count, _ in factors), default=0)

    def __call__(self, jets: Array) -> Array:
        """Return the polynomial's values from the unknown and its X-derivatives.

        ``jets`` has the shape (derivatives, *points); it may hold more derivatives than needed.
        """
        total = np.zeros(jets.shape[1:])
        for coefficient, factors in self.terms:
            total += math.prod((jets[i] ** power for i, power in factors), start=coefficient)
        return total

    def variation(self, jets: Array) -> list[Array]:
        """Return the partial derivatives by U, U_X, ..., one array for each row of ``jets``."""
        partials = [np.zeros(jets.shape[1:]) for _ in jets]
        for coefficient, factors in self.terms:
            for i, power in factors:
                others = (jets[j] ** (n - (j == i)) for j, n in factors)
                partials[i] += math.prod(others, start=coefficient * power)
        return partials

    def slope(self) -> JetPolynomial:
        """Return the X-derivative of the polynomial.

        >>> JetPolynomial(((3.0, ((0, 2),)),)).slope()
        JetPolynomial(terms=((6.0, ((0, 1), (1, 1))),))
        """
        total: dict[tuple[tuple[int, int], ...], float] = {}
        for coefficient, factors in self.terms:
            for i, power in factors:
                counts = Counter(dict(factors))
                counts.subtract({i: 1})
                counts.update({i + 1: 1})
                key = tuple(sorted(item for item in counts.items() if item[1]))
                total[key] = total.get(key, 0.0) + coefficient * power
        return JetPolynomial(tuple((value, key) for key, value in sorted(total.items())))

    @property
    def linear(self) -> dict[int, float]:
        """Coefficients of the linear terms, by the order of the X-derivative."""
        return {
            factors[0][0]: coefficient
            for coefficient, factors in self.terms
            if len(factors) == 1 and factors[0][1] == 1
        }
