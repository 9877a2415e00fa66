"""A contact that can open: ``contact(x)`` is x if x is positive, else 0."""

from __future__ import annotations

import sympy as sp


class _OpeningFunction(sp.Function):
    """Function of one argument that is 0 unless the argument is positive."""

    is_nonnegative = True

    @classmethod
    def eval(cls, x: sp.Expr) -> sp.Expr | None:
        """Return the value if the sign of x is known, else None."""
        if x.is_positive:
            return x if cls is contact else sp.Integer(1)
        return sp.Integer(0) if x.is_nonpositive else None


class contact(_OpeningFunction):  # as texts write it
    """The greater of x and 0; a derivation about a closed contact replaces it by x.

    >>> d = sp.Symbol("d", positive=True)
    >>> contact(d), contact(-d)
    (d, 0)
    """

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return the derivative, `touching` of x."""
        return touching(self.args[0])

    def _latex(self, printer: sp.printing.latex.LatexPrinter, exp: str | None = None) -> str:
        text = rf"\left({printer.doprint(self.args[0])}\right)_+"
        return text if exp is None else f"{text}^{{{exp}}}"


class touching(_OpeningFunction):
    """Derivative of `contact`: 1 if x is positive, else 0."""

    def fdiff(self, argindex: int = 1) -> sp.Expr:
        """Return 0, the derivative on either side of the opening."""
        return sp.Integer(0)
