"""The lab variables X, T and constants K2, K4, parametrised so that no square root is left.

The normal form's variables are ``xi = a X``, ``tau = b T`` with square roots of K2 and K4 in a and
b.  In the generators c > 0 and a > 0 everything is rational: K2, the sign-fixed K4 and b follow
from the derivation's own record, and (K2, |K4|) <-> (c, a) is one to one.  What holds identically
in X, T, a, c therefore holds for all X, T, K2 > 0 and K4 of that sign.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import sympy as sp

from derive import mkdv_normal_form, mkdv_reduction
from derive.symbols import K2, K4, T, X, c

a = sp.Symbol("a", positive=True)


@dataclass(frozen=True)
class LabFrame:
    """K2, K4, xi and tau as rational functions of X, T, a and c, for K4 of the sign ``s``."""

    s: int
    K2: sp.Expr
    K4: sp.Expr
    xi: sp.Expr
    tau: sp.Expr

    @property
    def generators(self) -> tuple[sp.Symbol, sp.Symbol]:
        """The symbols that stand for K2 and K4."""
        return (c, a)

    def constants(self) -> dict[sp.Symbol, sp.Expr]:
        """The lattice constants in the generators."""
        return {K2: self.K2, K4: self.K4}


@functools.cache
def lab_frame(s: int) -> LabFrame:
    """The parametrisation for K4 of the sign ``s`` (+1 or -1), from the normal-form record."""
    size = sp.Symbol("size", positive=True)
    record = mkdv_normal_form(K2, s * size)
    stiffness = sp.solve(record.c**2 - c**2, K2)[0]
    cubic = sp.solve(record.a**2 - a**2, size)[0].subs(K2, stiffness)
    rate = record.b.subs({size: cubic, K2: stiffness})
    return LabFrame(s, stiffness, s * cubic, a * X, rate * T)


@dataclass(frozen=True)
class LabEquation:
    """The reduced equation in X and T with the derivation's coefficients, in the generators."""

    frame: LabFrame

    @property
    def name(self) -> str:
        """The name of the equation."""
        return f"mKdV in X, T, K4 {'>' if self.frame.s > 0 else '<'} 0"

    @property
    def xi(self) -> sp.Symbol:
        """The space variable X."""
        return X

    @property
    def tau(self) -> sp.Symbol:
        """The time variable T."""
        return T

    def residual(self, U: sp.Expr) -> sp.Expr:
        """The left-hand side ``Y_T + beta Y^2 Y_X + delta Y_XXX`` at ``U``."""
        pde, constants = mkdv_reduction().pde, self.frame.constants()
        nonlinear = pde.nonlinear_coefficient.subs(constants)
        dispersive = pde.dispersive_coefficient.subs(constants)
        return sp.diff(U, T) + nonlinear * U**2 * sp.diff(U, X) + dispersive * sp.diff(U, X, 3)
