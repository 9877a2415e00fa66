"""LaTeX of SymPy expressions as the field writes them.

Terms and factors stand in the field's order, derivatives are subscripts, and elliptic functions
carry the modulus.
"""

from collections.abc import Iterable, Sequence

import sympy as sp
from sympy.printing.latex import LatexPrinter

from reports.formulas.order import function_name, ordered_factors, ordered_terms, runs_left

NAMES: dict[type[sp.Expr], str] = {
    sp.sin: r"\sin", sp.cos: r"\cos", sp.sinh: r"\sinh", sp.cosh: r"\cosh", sp.tanh: r"\tanh",
    sp.sech: r"\mathrm{sech}",
}  # fmt: skip
"""Names of functions that stand before a single symbol without brackets."""


def latex(expression: sp.Basic) -> str:
    r"""Return the expression's LaTeX.

    >>> from solutions.functions import jacobi_sn
    >>> from solutions.symbols import k, tau, xi
    >>> latex(xi - (2 * k**2 - 1) * tau), latex(1 - k**2), latex(jacobi_sn(xi, k**2))
    ('\\xi - \\left(2 k^{2} - 1\\right) \\tau', '1 - k^{2}', '\\mathrm{sn}(\\xi;k)')
    """
    return str(_Printer({"fold_func_brackets": True}).doprint(expression))


def sum_latex(terms: Iterable[sp.Expr]) -> str:
    """Return the LaTeX of the terms' sum, in the order given."""
    text = ""
    for term in terms:
        negative = bool(term.as_coeff_Mul()[0].is_negative)
        body = latex(-term if negative else term)
        sign = "-" if negative else "+"
        text += f" {sign} {body}" if text else f"- {body}" if negative else body
    return text


def is_even(function: sp.Expr) -> bool:
    """Tell whether the function's sign does not depend on that of its first argument."""
    parity = getattr(function, "parity", 0)
    return parity == 1 or isinstance(function, sp.cos | sp.cosh | sp.sech)


def _has_fraction(total: sp.Expr) -> bool:
    return any(sp.fraction(term, exact=True)[1] != 1 for term in total.args)


def _product(factors: list[str]) -> str:
    """Return the factors side by side, a function's name with a space before it."""
    return " ".join(
        rf"\, {factor}" if place and factor.startswith((r"\mathrm", r"\mathcal")) else factor
        for place, factor in enumerate(factors)
    )


class _Printer(LatexPrinter):
    """SymPy's printer with the field's order and names."""

    printmethod = "_paper_latex"

    def _print_Add(self, expr: sp.Expr, order: str | None = None) -> str:
        return sum_latex(ordered_terms(expr))

    def _print_Mul(self, expr: sp.Expr) -> str:
        numerator, denominator = sp.fraction(expr, exact=True)
        if denominator != 1:
            return self._fraction(numerator, denominator)
        coefficient, rest = expr.as_coeff_Mul()
        texts = [self._factor(factor) for factor in ordered_factors(rest)]
        if coefficient == -1:
            return f"- {_product(texts)}"
        return _product(texts if coefficient == 1 else [self._print(coefficient), *texts])

    def _fraction(self, numerator: sp.Expr, denominator: sp.Expr) -> str:
        """A numerator's sums of fractions stand behind the fraction."""
        if numerator.as_coeff_Mul()[0].is_negative:
            return f"- {self._fraction(-numerator, denominator)}"
        factors = sp.Mul.make_args(numerator)
        behind = [factor for factor in factors if factor.is_Add and _has_fraction(factor)]
        above = sp.Mul(*(factor for factor in factors if factor not in behind))
        text = rf"\frac{{{self._print(above)}}}{{{self._print(denominator)}}}"
        return " ".join([text, *map(self._factor, behind)])

    def _factor(self, factor: sp.Expr) -> str:
        text = str(self._print(factor))
        return rf"\left({text}\right)" if factor.is_Add else text

    def _print_Function(self, expr: sp.Expr, exp: str | None = None) -> str:
        elliptic = hasattr(expr, "latex_symbol")
        name = function_name(expr) if elliptic else NAMES.get(expr.func, "")
        if not name:
            return str(super()._print_Function(expr, exp))
        argument, *parameter = expr.args
        if is_even(expr) and runs_left(argument):
            argument = -argument
        power = f"^{{{exp}}}" if exp else ""
        if argument.is_Symbol and not parameter:
            return rf"{name}{power} {self._print(argument)}"
        modulus = f";{self._print(sp.sqrt(parameter[0]))}" if parameter else ""
        return rf"{name}{power}({self._print(argument)}{modulus})"

    _print_cos = _print_sin = _print_Function
    _print_cosh = _print_sinh = _print_tanh = _print_sech = _print_Function

    def _print_elliptic_k(self, expr: sp.Expr, exp: str | None = None) -> str:
        power = f"^{{{exp}}}" if exp else ""
        return rf"K{power}({self._print(sp.sqrt(expr.args[0]))})"

    def _print_AppliedUndef(self, expr: sp.Expr, exp: str | None = None) -> str:
        return f"{expr.func.__name__}^{{{exp}}}" if exp else str(expr.func.__name__)

    def _print_Derivative(self, expr: sp.Expr) -> str:
        axes = " ".join(map(self._print, expr.variables))
        return f"{self._print(expr.expr)}_{{{axes}}}"


def equation_latex(residual: sp.Expr, unknown: sp.Expr, time: sp.Symbol) -> str:
    """Return ``residual = 0``: the time derivative first, then by falling degree."""

    def rank(term: sp.Expr) -> tuple[bool, int]:
        powers = term.as_powers_dict()
        degree = sum(int(powers[base]) for base in powers if base.has(unknown.func))
        return not any(time in d.variables for d in term.atoms(sp.Derivative)), -degree

    return f"{sum_latex(sorted(sp.Add.make_args(residual), key=rank))} = 0"


def joined(lines: Sequence[str]) -> str:
    """Return the lines as an `align*` environment."""
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}"
