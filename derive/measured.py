"""Constants as they were measured: their values, and the covariance of their errors."""

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

ROUNDING = 1e-9
"""Below this a negative eigenvalue of the correlations is rounding."""


@dataclass(frozen=True)
class Measured:
    """Values of constants by name, and the covariance of their errors in the same order."""

    values: tuple[tuple[str, Expr], ...]
    covariance: tuple[tuple[float, ...], ...]

    @classmethod
    def of(
        cls, values: Mapping[str, Number], covariance: Mapping[str, Mapping[str, float]]
    ) -> Measured:
        """The values with covariances by names of both constants; what is not named is exact.

        Raises ValueError for a name without a value, and for what is no covariance.

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
            one: {two: _entry(one, two, covariance.get(one, {}).get(two, 0)) for two in values}
            for one in values
        }
        for one, two in combinations(values, 2):
            there, back = rows[one][two], rows[two][one]
            if there != back:
                raise ValueError(
                    f"covariance must be symmetric, got {there:g} for {one} with {two} and "
                    f"{back:g} for {two} with {one} (write the same number)"
                )
            if there and not (rows[one][one] and rows[two][two]):
                raise ValueError(
                    f"covariance of {one} with {two} must be 0 where one of them is exact, got "
                    f"{there:g} (give both their variances)"
                )
        exact = tuple((name, number_value(name, value)) for name, value in values.items())
        found = cls(exact, tuple(tuple(row.values()) for row in rows.values()))
        least = min(found._modes[0], default=0.0)
        if least < -ROUNDING:
            raise ValueError(
                "covariance must be positive semidefinite, got correlations with the eigenvalue "
                f"{least:.3g} (no measurement has it)"
            )
        return found

    @property
    def deviations(self) -> dict[str, float]:
        """The standard deviation of each constant; 0 for one that is exact."""
        return {name: math.sqrt(self.covariance[i][i]) for i, (name, _) in enumerate(self.values)}

    def with_exact(self, values: Mapping[str, Expr]) -> Measured:
        """The same with other values, or values of other constants, that have no error."""
        mine = dict(self.values)
        kept = {name: row for name, row in self.table.items() if name not in values}
        inner = {name: {o: v for o, v in row.items() if o in kept} for name, row in kept.items()}
        return Measured.of({**mine, **values}, inner)

    @property
    def table(self) -> dict[str, dict[str, float]]:
        """The covariance by the names of both constants."""
        names = [name for name, _ in self.values]
        rows = zip(names, self.covariance, strict=True)
        return {name: dict(zip(names, row, strict=True)) for name, row in rows}

    @cached_property
    def _modes(self) -> tuple[list[float], list[list[float]]]:
        """Eigenvalues of the correlations, and the eigenvectors in the constants' own units."""
        scales = list(self.deviations.values())
        moving = [i for i, scale in enumerate(scales) if scale]
        if not moving:
            return [], [[] for _ in scales]
        context = MPContext()
        found, vectors = context.eigsy(
            context.matrix(
                [[self.covariance[i][j] / scales[i] / scales[j] for j in moving] for i in moving]
            )
        )
        rows = dict(zip(moving, vectors.tolist(), strict=True))
        return [float(value) for value in found], [
            [scale * float(part) for part in rows.get(i, ())] for i, scale in enumerate(scales)
        ]

    def samples(self, count: int, seed: int = 0) -> list[tuple[float, ...]]:
        """Draws of the constants, in the order of ``values``, as if the errors were normal."""
        eigenvalues, vectors = self._modes
        sizes = [math.sqrt(max(value, 0.0)) for value in eigenvalues]
        normal = random.Random(seed).gauss
        rows = [
            (float(value), [part * size for part, size in zip(vector, sizes, strict=False)])
            for (_, value), vector in zip(self.values, vectors, strict=True)
        ]
        found = []
        for _ in range(count):
            drawn = [normal(0.0, 1.0) for _ in sizes]
            found.append(
                tuple(v + sum(map(float.__mul__, row, drawn)) if row else v for v, row in rows)
            )
        return found


def _entry(one: str, two: str, value: object) -> float:
    """A covariance as a float, if it is a finite number, and no variance below 0."""
    wrong = isinstance(value, bool) or not isinstance(value, int | float)
    if wrong or not abs(value) < 1e100 or (one == two and value < 0):  # type: ignore[arg-type, operator]
        raise ValueError(
            f"covariance of {one} with {two} must be a finite number, and no variance below 0, "
            f"got {shown(value)} (such as 1e-4)"
        )
    return float(value)  # type: ignore[arg-type]
