"""The map from a reduced mKdV equation to the form the closed solutions are written in.

It takes beta and delta = -gamma_3 of the paper's eq. (15) to a and b of the paper's eq. (22).

With ``Y(X, T) = U(xi, tau)``, ``xi = a X``, ``tau = b T``, the equation
``Y_T + beta Y^2 Y_X + delta Y_XXX = 0`` becomes ``U_tau + 6 s U^2 U_xi + U_xixixi = 0`` when
``b = delta a^3`` and ``beta a = 6 s b``: hence ``a^2 = |beta/(6 delta)|``, s its sign.
"""

from __future__ import annotations

from dataclasses import dataclass

from sympy import Abs, Expr, latex, sign, sqrt

from derive.algebra.exact_numbers import exact


@dataclass(frozen=True)
class NormalForm:
    """``Y(X, T) = U(a X, b T)`` with ``X = eps (n - c t)``, ``T = eps^3 t``; s = +-1.

    s = +1 is the focusing equation (K4 > 0), s = -1 the defocusing one.  All four are exact
    SymPy expressions; numbers are made so.  Raises ValueError for anything else, and for a
    number s other than 1 and -1.
    """

    a: Expr
    b: Expr
    s: Expr
    c: Expr

    def __post_init__(self) -> None:
        for name in ("a", "b", "s", "c"):
            object.__setattr__(self, name, exact(name, getattr(self, name)))
        if self.s.is_number and self.s not in (1, -1):
            raise ValueError(f"s must be 1 or -1, got {self.s} (1 is the focusing equation)")

    def _repr_latex_(self) -> str:
        equation = r"U_\tau + 6 s U^2 U_\xi + U_{\xi\xi\xi} = 0,\quad Y(X, T) = U(a X, b T)"
        values = [f"{name} = {latex(getattr(self, name))}" for name in ("a", "b", "s", "c")]
        return rf"$\displaystyle {', '.join([equation, *values])}$"

    @classmethod
    def of_coefficients(cls, c: Expr, nonlinear: Expr, dispersive: Expr) -> NormalForm:
        """The normal form at the frame speed, and the coefficients of Y^2 Y_X and Y_XXX.

        Raises ValueError if one of the two coefficients is 0.

        >>> from sympy import Rational, S
        >>> NormalForm.of_coefficients(S(2), Rational(3, 4), Rational(1, 12))
        NormalForm(a=sqrt(6)/2, b=sqrt(6)/16, s=1, c=2)
        """
        for name, value in (("nonlinear", nonlinear), ("dispersive", dispersive)):
            if value.is_zero:
                raise ValueError(
                    f"the {name} coefficient must not vanish, got 0 "
                    "(take a nonzero cubic stiffness and a dispersive lattice)"
                )
        ratio = nonlinear / (6 * dispersive)
        a = sqrt(Abs(ratio))
        return cls(a=a, b=dispersive * a**3, s=sign(ratio), c=c)
