"""The bilinear equations of the rational solutions' tau functions, as polynomial identities.

With ``f = A + i B``, real A and B, and ``f*`` its conjugate (issue: every order at once is open,
each order is a finite identity):

    D_x**2 f.f* = 2 i D_x f.f*,    (D_t + D_x**3) f.f* = 0,

where ``D_x**n f.g`` is the Hirota derivative.  The first is real, the second imaginary, so each is
one identity between A and B.
"""

from __future__ import annotations

import time

from flint import fmpq_mpoly

from solutions.rational import rational_tau
from verify.verdict import Outcome

from .verdict import ProofVerdict

METHOD = "bilinear identities"
EQUATION = "D_x^2 f.f* = 2i D_x f.f*, (D_t + D_x^3) f.f* = 0"


def prove_bilinear(order: int, free: tuple[int, ...] = ()) -> ProofVerdict:
    """Decide the bilinear equations of the rational tau function of ``order``.

    ``free`` lists the shifts tau_5, tau_7, ... kept symbolic.  Raises ValueError as
    `solutions.rational.rational_tau` does.

    >>> prove_bilinear(2).outcome
    <Outcome.PROVED: 'PROVED'>
    """
    start = time.perf_counter()
    family = rational_tau(order, free)
    left = {"space": space_residual(family.A, family.B), "time": time_residual(family.A, family.B)}
    failed = [name for name, residual in left.items() if not residual.is_zero()]
    outcome = Outcome.UNDECIDED if failed else Outcome.PROVED
    detail = f"left over: {', '.join(failed)}" if failed else "both vanish identically"
    return ProofVerdict(
        f"rational_{order}",
        EQUATION,
        METHOD,
        outcome,
        detail,
        residual=None if failed else 0.0,
        seconds=time.perf_counter() - start,
    )


def space_residual(A: fmpq_mpoly, B: fmpq_mpoly) -> fmpq_mpoly:
    """Half of ``D_x**2 f.f* - 2 i D_x f.f*`` (a real polynomial in x, t, ...)."""
    A_x, B_x = A.derivative("x"), B.derivative("x")
    A_xx, B_xx = A_x.derivative("x"), B_x.derivative("x")
    return A * A_xx + B * B_xx - A_x * A_x - B_x * B_x - 2 * (A_x * B - A * B_x)


def time_residual(A: fmpq_mpoly, B: fmpq_mpoly) -> fmpq_mpoly:
    """``(D_t + D_x**3) f.f*`` divided by ``2 i``."""
    A_x, B_x = A.derivative("x"), B.derivative("x")
    A_xx, B_xx = A_x.derivative("x"), B_x.derivative("x")
    third = B_xx.derivative("x") * A - B * A_xx.derivative("x") - 3 * (B_xx * A_x - B_x * A_xx)
    return B.derivative("t") * A - B * A.derivative("t") + third
