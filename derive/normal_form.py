"""The map from a reduced mKdV equation to the form the closed solutions are written in.

It takes beta and delta = -gamma_3 of the paper's eq. (15) to a and b of the paper's eq. (22).

With ``Y(X, T) = U(xi, tau)``, ``xi = a X``, ``tau = b T``, the equation
``Y_T + beta Y^2 Y_X + delta Y_XXX = 0`` becomes ``U_tau + 6 s U^2 U_xi + U_xixixi = 0`` when
``b = delta a^3`` and ``beta a = 6 s b``: hence ``a^2 = |beta/(6 delta)|``, s its sign.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Abs, Expr, sign, sqrt

from derive.equations import EvolutionEquation


@dataclass(frozen=True)
class NormalForm:
    """``Y(X, T) = U(a X, b T)`` with ``X = eps (n - c t)``, ``T = eps^3 t``; s = +-1.

    s = +1 is the focusing equation (K4 > 0), s = -1 the defocusing one.  All four are exact
    SymPy expressions.
    """

    a: Expr
    b: Expr
    s: Expr
    c: Expr


@dataclass(frozen=True)
class Coefficients:
    """Frame speed, coefficient of the nonlinear term and of Y_XXX in the reduced equation."""

    c: Expr
    nonlinear: Expr
    dispersive: Expr


def normal_form(pde: EvolutionEquation, values: Coefficients) -> NormalForm:
    """The normal form of ``pde`` at the given values of its coefficients.

    Raises ValueError unless the nonlinear term is Y^2 Y_X and both coefficients are nonzero.
    """
    if not pde.is_mkdv:
        raise ValueError(
            f"the equation must have the nonlinear term Y^2 Y_X, got {pde.text()} "
            "(the normal form is that of mKdV)"
        )
    for name, value in (("nonlinear", values.nonlinear), ("dispersive", values.dispersive)):
        if value.is_zero:
            raise ValueError(
                f"the {name} coefficient must not vanish, got 0 in {pde.text()} "
                "(take a nonzero cubic stiffness and a dispersive lattice)"
            )
    ratio = values.nonlinear / (6 * values.dispersive)
    a = sqrt(Abs(ratio))
    return NormalForm(a=a, b=values.dispersive * a**3, s=sign(ratio), c=values.c)
