"""Expressions as text in the grammar that `derive.algebra.formula_text` reads."""

from typing import Any

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.str import StrPrinter


class FormulaPrinter(StrPrinter):
    """SymPy's text, with derivatives as ``u_xx``, sites as ``q[n+1]`` and ``abs``."""

    def _print_LambertW(self, node: sp.Expr) -> str:
        return f"lambert_w({self._print(node.args[0])})"

    def _print_AiryBase(self, node: sp.Expr) -> str:
        kind = type(node).__name__.removeprefix("airy")
        suffix = "_prime" if len(kind) > 2 else ""
        return f"airy_{kind[:2]}{suffix}({self._print(node.args[0])})"

    def _print_BesselBase(self, node: sp.Expr) -> str:
        kind = type(node).__name__
        return f"{kind[:-1]}_{kind[-1]}({', '.join(map(self._print, node.args))})"

    def _print_Abs(self, node: sp.Expr) -> str:
        return f"abs({self._print(node.args[0])})"

    def _print_Mul(self, node: sp.Expr) -> str:
        """Print x/(y + z)/2 for SymPy's x/(2*(y + z)), which would be read as x/(2*y + 2*z)."""
        number, factor = node.as_coeff_Mul()
        powers = [f for f in sp.Mul.make_args(factor) if f.is_Pow]
        divisors = [power for power in powers if power.base.is_Add and power.exp == -1]
        if divisors and number.is_Rational and number.q != 1:
            return f"{self._print(number.p * factor)}/{number.q}"
        return super()._print_Mul(node)

    def _print_Exp1(self, _: sp.Expr) -> str:
        return "exp(1)"

    def _print_Function(self, node: sp.Expr) -> str:
        if not isinstance(node, AppliedUndef):
            return super()._print_Function(node)
        return self._field(node, "")

    def _print_Derivative(self, node: Any) -> str:
        if isinstance(node.expr, AppliedUndef):
            steps = sorted(node.variables, key=node.expr.args.index)
            return self._field(node.expr, "_" + "".join(map(str, steps)))
        return f"diff({', '.join(map(self._print, (node.expr, *node.variables)))})"

    def _field(self, node: AppliedUndef, steps: str) -> str:
        sites = [a for a in node.args if a.is_integer]
        site = f"[{self._print(sites[0]).replace(' ', '')}]" if sites else ""
        return f"{node.func.__name__}{steps}{site}"


def formula_as_text(expression: sp.Expr) -> str:
    """Return the expression as text that is read back as the same object.

    >>> x, t = sp.symbols("x t")
    >>> u = sp.Function("u")(x, t)
    >>> formula_as_text(u.diff(t) + 6 * u * u.diff(x) + u.diff(x, 3))
    '6*u*u_x + u_t + u_xxx'
    """
    return FormulaPrinter().doprint(expression)
