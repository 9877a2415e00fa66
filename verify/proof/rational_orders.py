"""Direct proof that the rational solution of any order solves the equation.

In ``x = xi - 6 tau`` and ``t = tau`` the solution is ``U = N/D`` up to sign, with integer
polynomials ``D = A**2 + B**2`` and ``N = D - 2 (A B_x - A_x B)``, and the residual times ``D**4``
is a polynomial ``P(x, t)`` of degree at most 4 d in t, if N and D have degree at most d.  It is 0
if it vanishes, as a polynomial in x, at 4 d + 1 values of t: exact, and far cheaper than P.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

from flint import fmpq_mpoly, fmpz_poly

from solutions.equation import FOCUSING_MKDV
from solutions.rational import rational_tau
from verify.verdict import Outcome

from .verdict import ProofVerdict

METHOD = "exact at more points than the degree"

Rows = list[fmpz_poly]
"""Polynomials in x, the coefficients of the powers of t."""


def prove_rational(order: int) -> ProofVerdict:
    """Decide whether the rational solution of ``order``, without free shifts, is a solution.

    Raises ValueError if ``order`` is no positive integer.

    >>> prove_rational(3).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    start = time.perf_counter()
    N, D = wave_polynomials(order)
    return quotient_verdict(f"rational_{order}", N, D).timed(time.perf_counter() - start)


def quotient_verdict(name: str, N: Rows, D: Rows) -> ProofVerdict:
    """Decide whether ``N/D``, or minus that, is a solution; D must have no real zero."""
    points = 4 * (max(len(N), len(D)) - 1) + 1
    for t in _integers(points):
        residual = residual_at(N, D, t)
        if residual:
            x = next(x for x in _integers(residual.degree() + 1) if residual(x))
            return ProofVerdict(
                name,
                FOCUSING_MKDV.name,
                METHOD,
                Outcome.REFUTED,
                "the residual is not 0 at x = xi - 6 tau, t = tau",
                witness={"x": str(x), "t": str(t)},
            )
    detail = f"0 at {points} values of tau"
    return ProofVerdict(name, FOCUSING_MKDV.name, METHOD, Outcome.PROVED, detail, residual=0.0)


def wave_polynomials(order: int) -> tuple[Rows, Rows]:
    """``N`` and ``D`` of the solution of ``order`` (up to the sign of the solution)."""
    family = rational_tau(order)
    A, B = family.A, family.B
    D = A * A + B * B
    N = D - 2 * (A * B.derivative("x") - A.derivative("x") * B)
    return _rows(N), _rows(D)


def residual_at(N: Rows, D: Rows, t: int) -> fmpz_poly:
    """``D**4`` times the residual ``U_t + 6 (U**2 - 1) U_x + U_xxx`` at ``t``."""
    n, n_t = _value(N, t), _slope(N, t)
    d, d_t = _value(D, t), _slope(D, t)
    d_x = d.derivative()
    first = n.derivative() * d - n * d_x
    second = first.derivative() * d - 2 * first * d_x
    third = second.derivative() * d - 3 * second * d_x
    return (n_t * d - n * d_t) * d * d + 6 * (n * n - d * d) * first + third


def _rows(polynomial: fmpq_mpoly) -> Rows:
    rows: list[dict[int, int]] = []
    for (x_power, t_power, *_), coefficient in polynomial.terms():
        while len(rows) <= t_power:
            rows.append({})
        rows[t_power][int(x_power)] = int(coefficient.p)
    return [fmpz_poly([row.get(i, 0) for i in range(max(row, default=0) + 1)]) for row in rows]


def _value(rows: Sequence[fmpz_poly], t: int) -> fmpz_poly:
    total = fmpz_poly([0])
    for row in reversed(rows):
        total = total * t + row
    return total


def _slope(rows: Sequence[fmpz_poly], t: int) -> fmpz_poly:
    return _value([power * row for power, row in enumerate(rows)][1:], t)


def _integers(count: int) -> range:
    """``count`` integers around 0."""
    return range(-(count // 2), count - count // 2)
