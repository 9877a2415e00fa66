"""A rational solution with numbers in, from its polynomials A and B."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from longwave.solutions.run.bounded import PARTS
from longwave.solutions.run.doubledouble import check_range, split
from longwave.solutions.run.linear_phase import LinearPhase, Variables, as_pairs, long_number
from longwave.solutions.run.rational_kernel import rational_loop, scales_of, workspace

if TYPE_CHECKING:
    import sympy as sp
    from flint import fmpq_mpoly

    from longwave.solutions.forms.tau_polynomials import RationalTau

Array = NDArray[np.float64]


class RationalEvaluator:
    """U and its xi and tau derivatives at given shifts.

    Raises OverflowError for a coefficient beyond 1e-250 .. 1e250.
    """

    def __init__(self, family: RationalTau, shifts: Mapping[sp.Symbol, sp.Expr]) -> None:
        degree = family.order * (family.order + 1) // 2
        numbers = [shifts[symbol] for symbol in family.symbols[2:]]
        tables = [_coefficients(part, numbers) for part in (family.A, family.B)]
        self._tables = np.stack([_pairs(table, degree) for table in tables])
        self._parities = np.array([_parity(table) for table in tables])
        self._sign = float((-1) ** family.order)

    def phases(self, variables: Variables) -> list[LinearPhase]:
        """``x = xi - 6 tau`` and ``t = tau`` in the caller's variables."""
        return [variables.phase(1, -6, 0), variables.phase(0, 1, 0)]

    def __call__(self, phases: list[LinearPhase], *points: Array) -> Array:
        """Value, xi derivative and tau derivative at the points (x, t): an array (3, 3, points)."""
        place, time = (as_pairs(phase(*points)) for phase in phases)
        out = np.empty((3, PARTS, points[0].size))
        space = workspace(self._tables.shape[1] - 1)
        scales = scales_of(place[0], time[0])
        rational_loop(self._tables, self._parities, self._sign, place, time, scales, space, out)
        return out


def _coefficients(part: fmpq_mpoly, shifts: list[sp.Expr]) -> dict[tuple[int, int], Any]:
    """The exact coefficients of ``x**i t**j``, the shifts put in."""
    import sympy as sp

    table: dict[tuple[int, int], Any] = {}
    for exponents, number in part.terms():
        i, j, *powers = (int(exponent) for exponent in exponents)
        factors = [shift**power for shift, power in zip(shifts, powers, strict=True)]
        term = sp.Rational(int(number.p), int(number.q)) * sp.Mul(*factors)
        table[i, j] = table.get((i, j), sp.S.Zero) + term
    return {powers: number for powers, number in table.items() if number != 0}


def _parity(table: Mapping[tuple[int, int], Any]) -> int:
    """The common parity of ``i + j``, or -1."""
    found = {(i + j) % 2 for i, j in table}
    return found.pop() if len(found) == 1 else -1


def _pairs(table: Mapping[tuple[int, int], Any], degree: int) -> Array:
    pairs = np.zeros((degree + 1, degree // 3 + 1, 2))
    for (i, j), number in table.items():
        pairs[i, j] = split(check_range(long_number(number)))
    return pairs
