"""Functions with independent derivatives: arbitrary ones of one argument, and theta functions.

The derivatives of ``f(z)`` in z are ``f'(z)``, ``f''(z)``, ..., each a SymPy function. Theta
functions of (z, q), with the nome q, are those of Jacobi: ``jacobi_theta_3(z, q)`` is the sum of
q**(n**2) cos(2 n z) over all integers n; they satisfy the heat equation -4 q f_q = f_zz.
"""

from functools import cache
from typing import Any, ClassVar

from sympy import Expr, Function

THETA = {"jacobi_theta_1": -1, "jacobi_theta_2": 1, "jacobi_theta_3": 1, "jacobi_theta_4": 1}
"""Theta function -> its parity in z: 1 if it is even, -1 if it is odd."""


class JetFunction(Function):
    """The derivative in z, ``order`` times, of the function named ``label``."""

    label: ClassVar[str]
    order: ClassVar[int]

    @classmethod
    def eval(cls, z: Expr, *nome: Expr) -> Expr | None:
        """Move a minus sign out of a theta function's z; None if there is none."""
        if not nome or not z.could_extract_minus_sign():
            return None
        return THETA[cls.label] * (-1) ** cls.order * cls(-z, *nome)

    def fdiff(self, argindex: int = 1) -> Expr:
        """Return the derivative in z, or in the nome by the heat equation."""
        derivative = jet_function(self.label, self.order + argindex)(*self.args)
        return derivative if argindex == 1 else -derivative / (4 * self.args[1])

    def _eval_is_extended_real(self) -> bool | None:
        z, *nome = self.args
        return True if z.is_real and all(q.is_positive for q in nome) else None

    def _eval_is_finite(self) -> bool | None:
        return self._eval_is_extended_real()

    def _eval_conjugate(self) -> Expr:
        return self.func(*(argument.conjugate() for argument in self.args))

    def _latex(self, printer: Any, exp: str | None = None) -> str:
        theta = rf"\theta_{{{self.label[-1]}}}"
        symbol = (theta if self.label in THETA else self.label) + "'" * self.order
        latex = f"{symbol}\\left({', '.join(map(printer._print, self.args))}\\right)"
        return latex if exp is None else rf"\left[{latex}\right]^{{{exp}}}"


@cache
def jet_function(label: str, order: int = 0) -> type[JetFunction]:
    """Return the SymPy function that is the ``order``-th derivative of the function ``label``.

    >>> from sympy import symbols
    >>> x, t = symbols("x t")
    >>> jet_function("f")(x - 2 * t).diff(x, t)
    -2*f''(-2*t + x)
    >>> jet_function("jacobi_theta_1")(-x, t).diff(t)
    jacobi_theta_1''(x, t)/(4*t)
    """
    members = {"label": label, "order": order, "nargs": 2 if label in THETA else 1}
    return type(label + "'" * order, (JetFunction,), members)
