"""The reduced equation in its normal form."""

from dataclasses import dataclass

import sympy as sp

from solutions.symbols import tau, xi

__all__ = ["DEFOCUSING_MKDV", "FOCUSING_MKDV", "Equation"]


@dataclass(frozen=True)
class Equation:
    """``U_tau + 6 s U**2 U_xi + U_xixixi = 0``, with ``s`` the sign of K4.

    The paper's eq. (1) in its normal form.

    >>> from sympy import tanh
    >>> DEFOCUSING_MKDV.residual(tanh(xi + 2 * tau)).simplify()
    0
    """

    name: str
    s: int
    xi: sp.Symbol = xi
    tau: sp.Symbol = tau

    def residual(self, U: sp.Expr) -> sp.Expr:
        """The left-hand side of the equation at ``U``, unsimplified."""
        transport = 6 * self.s * U**2 * sp.diff(U, self.xi)
        return sp.diff(U, self.tau) + transport + sp.diff(U, self.xi, 3)


FOCUSING_MKDV = Equation("focusing mKdV", +1)
DEFOCUSING_MKDV = Equation("defocusing mKdV", -1)
