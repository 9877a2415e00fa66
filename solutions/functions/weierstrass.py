"""Weierstrass' elliptic function and its derivative as SymPy functions of (z, g2, g3).

Invariants may be any, also those of a degenerate lattice.  Derivatives are with respect to z.
"""

from typing import Any

from sympy import Expr, Function
from sympy.core.function import ArgumentIndexError


class WeierstrassFunction(Function):
    """Base of p (even in z) and p' (odd); both are real for real arguments."""

    nargs = 3
    parity = 1
    latex_symbol = r"\wp"

    @classmethod
    def eval(cls, z: Expr, g2: Expr, g3: Expr) -> Expr | None:
        """Move a minus sign out of z; None if z has none."""
        return cls.parity * cls(-z, g2, g3) if z.could_extract_minus_sign() else None

    def fdiff(self, argindex: int = 1) -> Expr:
        """Return the derivative in z. Raises ArgumentIndexError for one in the invariants."""
        if argindex != 1:
            raise ArgumentIndexError(self, argindex)
        return self._slope(*self.args)

    def _slope(self, z: Expr, g2: Expr, g3: Expr) -> Expr:
        raise NotImplementedError

    def _eval_is_extended_real(self) -> bool | None:
        return True if all(argument.is_real for argument in self.args) else None

    def _eval_conjugate(self) -> Expr:
        return self.func(*(argument.conjugate() for argument in self.args))

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        z, *invariants = map(printer._print, self.args)
        power = "" if exp is None else f"^{{{exp}}}"
        return rf"{self.latex_symbol}{power}\left({z}; {', '.join(invariants)}\right)"


class weierstrass_p(WeierstrassFunction):
    r"""Weierstrass' p(z; g2, g3), with p'**2 = 4 p**3 - g2 p - g3.

    >>> from sympy import latex, symbols
    >>> z, g, h = symbols("z g h")
    >>> weierstrass_p(-z, g, h).diff(z, 2)
    -g/2 + 6*weierstrass_p(z, g, h)**2
    >>> print(latex(weierstrass_p(z, g, h)))
    \wp\left(z; g, h\right)
    """

    def _slope(self, z: Expr, g2: Expr, g3: Expr) -> Expr:
        return weierstrass_p_prime(z, g2, g3)


class weierstrass_p_prime(WeierstrassFunction):
    """The derivative of `weierstrass_p` in z."""

    parity = -1
    latex_symbol = r"\wp'"

    def _slope(self, z: Expr, g2: Expr, g3: Expr) -> Expr:
        return 6 * weierstrass_p(z, g2, g3) ** 2 - g2 / 2
