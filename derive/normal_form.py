"""The map from a reduced mKdV equation to the form the closed solutions are written in.

It takes beta and delta = -gamma_3 of the paper's eq. (15) to a and b of the paper's eq. (22).

With ``Y(X, T) = U(xi, tau)``, ``xi = a X``, ``tau = b T``, the equation
``Y_T + beta Y^2 Y_X + delta Y_XXX = 0`` becomes ``U_tau + 6 s U^2 U_xi + U_xixixi = 0`` when
``b = delta a^3`` and ``beta a = 6 s b``: hence ``a^2 = |beta/(6 delta)|``, s its sign.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from sympy import Abs, Expr, S, sign, sqrt

from derive.differential import Monomial
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
    """Frame speed (negative for waves to the left) and the reduced equation's coefficients.

    ``terms`` holds the coefficient of each term of ``Y_T + ... = 0`` under the term's text.
    """

    c: Expr
    terms: Mapping[str, Expr]
    monomials: Mapping[str, Monomial] = field(repr=False)

    @property
    def nonlinear(self) -> Expr:
        """The coefficient of the one nonlinear term; ValueError unless there is exactly one."""
        found = [name for name, monomial in self.monomials.items() if len(monomial) > 1]
        if len(found) != 1:
            raise ValueError(
                f"the equation must have one nonlinear term, got {len(found)} in "
                f"{', '.join(self.terms)} (read the coefficients from .terms)"
            )
        return self.terms[found[0]]

    @property
    def dispersive(self) -> Expr:
        """The coefficient of Y_XXX, 0 if the equation has no such term."""
        return self.terms.get("Y_XXX", S.Zero)


def normal_form(pde: EvolutionEquation, values: Coefficients) -> NormalForm:
    """The normal form of ``pde`` at the given values of its coefficients.

    Raises ValueError unless the terms are Y^2 Y_X and Y_XXX and both coefficients are nonzero.
    """
    if not pde.is_mkdv:
        raise ValueError(
            f"the equation must have the terms Y^2 Y_X and Y_XXX alone, got {pde.text()} "
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
