"""SymPy's expressions as text and LaTeX.

`formula_as_text` writes the grammar that `derive.algebra.formula_text` reads, `text_of` and
`latex_of` write constants as they are displayed.
"""

import re
from collections.abc import Callable
from typing import Any, TypeAlias

import sympy as sp
from sympy.core.function import AppliedUndef
from sympy.printing.latex import LatexPrinter
from sympy.printing.str import StrPrinter


class FormulaPrinter(StrPrinter):
    """Printer like SymPy's, but ``u_xx`` for derivatives, ``q[n+1]`` for sites, ``abs`` for Abs."""

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


Printed: TypeAlias = Callable[[sp.Expr], str]
"""Formatter of constants: `text_of` or `latex_of`."""

LATEX_NAMES = {"ybar": r"\overline{y}", "eps": r"\epsilon"}


class _TextPrinter(StrPrinter):
    """SymPy's text with sums in their natural order, ``c^2 - K2``."""

    def _print_Add(self, expr: sp.Expr, order: str | None = None) -> str:
        return str(super()._print_Add(expr, order="none"))


class ExpressionLatexPrinter(LatexPrinter):
    """SymPy's LaTeX with sums in their natural order and the project's names of symbols."""

    def _print_Symbol(self, expr: sp.Expr, style: str = "plain") -> str:
        name = str(expr)
        if name.endswith("~"):
            letter, index = re.fullmatch(r"(.[a-z]*)(.*)~", name).groups()  # type: ignore[union-attr]
            subscript = f"_{{{index}}}" if index else ""
            return rf"\tilde{{{latex_of(sp.Symbol(letter))}}}{subscript}"
        return LATEX_NAMES.get(name) or str(super()._print_Symbol(expr, style))

    def _print_Add(self, expr: sp.Expr, order: str | None = None) -> str:
        return str(super()._print_Add(expr, order="none"))


def text_of(expression: sp.Expr) -> str:
    """Return a constant in plain text.

    >>> from longwave.derive.symbols import K4, c
    >>> text_of(3 * K4 / (2 * c))
    '3 K4/(2 c)'
    """
    return str(_TextPrinter().doprint(expression)).replace("**", "^").replace("*", " ")


def latex_of(expression: sp.Expr) -> str:
    """Return a constant in LaTeX, with the project's names."""
    return str(ExpressionLatexPrinter().doprint(expression))
