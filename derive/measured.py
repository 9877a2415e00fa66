"""Measured constants: their values, and the covariance of their errors."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

from mpmath import MPContext
from sympy import Expr

from longwave.derive.algebra.exact_numbers import Number
from longwave.derive.symbols import number_value
from longwave.support.known_names import one_of
from longwave.support.user_files import shown

EIGENVALUE_TOLERANCE = 1e-9
"""Largest magnitude of a negative eigenvalue of the correlations that counts as rounding error."""


@dataclass(frozen=True)
class Measured:
    """Values of constants by name, and the covariance of their errors in the same order."""

    values: tuple[tuple[str, Expr], ...]
    covariance: tuple[tuple[float, ...], ...]

    @classmethod
    def of(
        cls, values: Mapping[str, Number], covariance: Mapping[str, Mapping[str, float]]
    ) -> Measured:
        """Build from values and a table of covariances; constants without one are exact.

        Raises ValueError for a name without a value, and for an invalid covariance.

        >>> Measured.of({"K2": 1, "K4": "1/2"}, {"K4": {"K4": 0.04}}).deviations
        {'K2': 0.0, 'K4': 0.2}
        """
        for name in {*covariance, *(other for row in covariance.values() for other in row)}:
            if name not in values:
                raise ValueError(
                    f"covariance must name constants that have a value, got {shown(name)} "
                    f"({one_of(name, values)})"
                )
        rows = {
            row: {name: _entry(row, name, covariance.get(row, {}).get(name, 0)) for name in values}
            for row in values
        }
        for first, second in combinations(values, 2):
            value, transposed = rows[first][second], rows[second][first]
            if value != transposed:
                raise ValueError(
                    f"covariance must be symmetric, got {value:g} for {first} with {second} and "
                    f"{transposed:g} for {second} with {first} (write the same number)"
                )
            if value and not (rows[first][first] and rows[second][second]):
                raise ValueError(
                    f"covariance of {first} with {second} must be 0 where one of them is exact, "
                    f"got {value:g} (give both their variances)"
                )
        exact = tuple((name, number_value(name, value)) for name, value in values.items())
        result = cls(exact, tuple(tuple(row.values()) for row in rows.values()))
        least = min(result._modes[0], default=0.0)
        if least < -EIGENVALUE_TOLERANCE:
            raise ValueError(
                "covariance must be positive semidefinite, got correlations with the eigenvalue "
                f"{least:.3g} (no measurement has it)"
            )
        return result

    @property
    def deviations(self) -> dict[str, float]:
        """Standard deviation of each constant; 0 for an exact one."""
        return {name: math.sqrt(self.covariance[i][i]) for i, (name, _) in enumerate(self.values)}

    def with_exact(self, values: Mapping[str, Expr]) -> Measured:
        """Return a copy in which the constants in ``values`` have these values, without error."""
        remaining = {name: row for name, row in self.table.items() if name not in values}
        for row in remaining.values():
            for name in values.keys() & row.keys():
                del row[name]
        return Measured.of({**dict(self.values), **values}, remaining)

    @property
    def table(self) -> dict[str, dict[str, float]]:
        """Covariances as a nested table: name of one constant -> name of another -> covariance."""
        names = [name for name, _ in self.values]
        rows = zip(names, self.covariance, strict=True)
        return {name: dict(zip(names, row, strict=True)) for name, row in rows}

    @cached_property
    def _modes(self) -> tuple[list[float], list[list[float]]]:
        """Eigenvalues of the correlations, and the eigenvectors in the constants' own units."""
        scales = list(self.deviations.values())
        uncertain = [i for i, scale in enumerate(scales) if scale]
        if not uncertain:
            return [], [[] for _ in scales]
        context = MPContext()
        correlations = [
            [self.covariance[i][j] / scales[i] / scales[j] for j in uncertain] for i in uncertain
        ]
        eigenvalues, columns = context.eigsy(context.matrix(correlations))
        rows = dict(zip(uncertain, columns.tolist(), strict=True))
        vectors = [[scale * float(v) for v in rows.get(i, ())] for i, scale in enumerate(scales)]
        return [float(value) for value in eigenvalues], vectors

    def samples(self, count: int, seed: int = 0) -> list[tuple[float, ...]]:
        """Draw samples of the constants, in the order of ``values``, with normal errors."""
        eigenvalues, vectors = self._modes
        deviations = [math.sqrt(max(value, 0.0)) for value in eigenvalues]
        normal = random.Random(seed).gauss
        factors = ([v * d for v, d in zip(row, deviations, strict=False)] for row in vectors)
        rows = list(zip((float(value) for _, value in self.values), factors, strict=True))
        samples = []
        for _ in range(count):
            normals = [normal(0.0, 1.0) for _ in deviations]
            samples.append(
                tuple(v + sum(map(float.__mul__, row, normals)) if row else v for v, row in rows)
            )
        return samples


def _entry(first: str, second: str, value: object) -> float:
    """Return a covariance as a float; raise ValueError if it is not finite, or a variance < 0."""
    wrong = isinstance(value, bool) or not isinstance(value, int | float)
    if wrong or not abs(value) < 1e100 or (first == second and value < 0):  # type: ignore[arg-type, operator]
        raise ValueError(
            f"covariance of {first} with {second} must be a finite number, and a variance at least "
            f"0, got {shown(value)} (such as 1e-4)"
        )
    return float(value)  # type: ignore[arg-type]
