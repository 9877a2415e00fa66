r"""LaTeX of SymPy expressions as the field writes them, and how wide it is on the page.

Sums begin with the phase's $\xi$ or the highest power, products put parameters before variables
and functions last, derivatives are subscripts, and elliptic functions carry the modulus.
"""

import re
from collections.abc import Iterable, Sequence

import sympy as sp
from sympy.printing.latex import LatexPrinter

from solutions.special import jacobi_cn, jacobi_dn, jacobi_epsilon, jacobi_sn
from solutions.symbols import tau, xi

FUNCTIONS: tuple[type[sp.Expr], ...] = (jacobi_sn, jacobi_cn, jacobi_dn, jacobi_epsilon)
"""Functions in the order in which they stand in a product; others follow."""

FUNCTION_ORDER = [r"\mathrm{sn}", r"\mathrm{cn}", r"\mathrm{dn}", r"\mathcal{E}", r"\mathrm{Z}"]

NAMES: dict[type[sp.Expr], str] = {
    sp.sin: r"\sin", sp.cos: r"\cos", sp.sinh: r"\sinh", sp.cosh: r"\cosh", sp.tanh: r"\tanh",
    sp.sech: r"\mathrm{sech}",
}  # fmt: skip
"""Names of functions that stand before a single symbol without brackets."""

NARROW = 0.7
"""Width of a character in a sub- or superscript."""

_TOKEN = re.compile(r"\\[a-zA-Z]+|\\.|\S")


def latex(expression: sp.Basic) -> str:
    r"""Return the expression's LaTeX.

    >>> k = sp.Symbol("k", positive=True)
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


def ordered_terms(total: sp.Expr) -> list[sp.Expr]:
    """Return a sum's terms as they are printed, a positive one first where an end has one."""
    terms = sorted(sp.Add.make_args(total), key=_phase_rank if _is_linear(total) else _degree_rank)
    if len(terms) == 2 and terms[1].is_positive and terms[1].is_number:
        return terms[::-1]
    negative = [bool(term.as_coeff_Mul()[0].is_negative) for term in terms]
    return terms[::-1] if negative[0] and not negative[-1] else terms


def is_phase(total: sp.Expr) -> bool:
    """Tell whether the expression is of first degree in xi and tau, without named parts."""
    return _is_linear(total) and not total.atoms(sp.Dummy)


def _is_linear(total: sp.Expr) -> bool:
    if not total.has(xi):
        return False
    slopes = [term.as_independent(xi, tau)[1] for term in sp.Add.make_args(total)]
    return xi in slopes and set(slopes) <= {xi, tau, sp.S.One}


def runs_left(argument: sp.Expr) -> bool:
    """Tell whether a phase falls with xi."""
    return bool(is_phase(argument) and argument.coeff(xi).is_negative)


def is_even(function: sp.Expr) -> bool:
    """Tell whether the function's sign does not depend on that of its first argument."""
    parity = getattr(function, "parity", 0)
    return parity == 1 or isinstance(function, sp.cos | sp.cosh | sp.sech)


def measure(text: str) -> float:
    r"""Return about how many characters wide the LaTeX is when it is set.

    >>> measure("x + y"), measure(r"\frac{x + y}{2}"), measure(r"\mathrm{sn}^{2}")
    (4.0, 4.0, 2.7)
    """
    return round(_measure(_TOKEN.findall(text)), 6)


def nesting(text: str) -> int:
    r"""Return how deep fractions are nested in the LaTeX.

    >>> nesting("x"), nesting(r"\frac{1}{2} + \frac{x}{\frac{1}{y}}")
    (0, 2)
    """
    return _depth(_TOKEN.findall(text))


def _depth(tokens: list[str]) -> int:
    """Return the depth of fractions in the tokens to the end of the group, using them up."""
    deepest = 0
    while tokens:
        token = tokens.pop(0)
        if token == "}":
            break
        if token == "{":
            deepest = max(deepest, _depth(tokens))
        elif token == r"\frac":
            tokens.pop(0)
            above = _depth(tokens)
            tokens.pop(0)
            deepest = max(deepest, 1 + above, 1 + _depth(tokens))
    return deepest


def _measure(tokens: list[str]) -> float:
    """Measure and use up the tokens to the end of the group."""
    total = 0.0
    while tokens:
        token = tokens.pop(0)
        if token == "}":
            break
        total += _width(token, tokens)
    return total


def _width(token: str, tokens: list[str]) -> float:
    """Measure one token, using up its arguments."""
    if token == "{":
        return _measure(tokens)
    if token == r"\frac":
        return max(_width(tokens.pop(0), tokens), _width(tokens.pop(0), tokens))
    if token in ("^", "_"):
        return NARROW * _width(tokens.pop(0), tokens)
    if token in (r"\left", r"\right", r"\,", r"\mathrm", r"\operatorname", r"\mathcal", "&"):
        return 0.0
    if token in (r"\sqrt", "+", "-", "="):
        return 2.0
    if token in (r"\cosh", r"\sinh", r"\tanh", r"\cos", r"\sin"):
        return float(len(token))
    return 1.0


def _phase_rank(term: sp.Expr) -> tuple[bool, bool, str]:
    return not term.has(xi), not term.has(tau), str(term)


def _degree_rank(term: sp.Expr) -> tuple[bool, bool, float, float, float, str]:
    """Fractions last, then by falling powers of tau, of xi, of everything."""
    numerator, denominator = sp.fraction(term, exact=True)
    powers = numerator.as_powers_dict()
    explicit = (-float(powers.get(symbol, 0)) for symbol in (tau, xi))
    named = not any(isinstance(base, sp.Dummy) and base.name[:3] == "phi" for base in powers)
    return (bool(denominator.free_symbols), named, *explicit, -_degree(numerator), str(term))


def _degree(expression: sp.Expr) -> float:
    """Return the total degree, every function counting as one variable."""
    if expression.is_Add:
        return max(_degree(term) for term in expression.args)
    if expression.is_Mul:
        return sum(_degree(factor) for factor in expression.args)
    if expression.is_Pow and expression.exp.is_Rational:
        return float(expression.exp) * _degree(expression.base)
    return float(not expression.is_number)


def _factor_rank(factor: sp.Expr) -> tuple[int, int, str]:
    """Numbers, parameters, sums of parameters, variables, sums, functions, exponentials."""
    base = factor.base if factor.is_Pow and factor.exp.is_number else factor
    kind = 5
    if base.is_number:
        kind = 0
    elif isinstance(base, sp.Derivative):
        kind = 9
    elif base.is_Symbol:
        kind = 3 if base in (xi, tau) else _name_kind(base.name) if base.is_Dummy else 1
    elif base.is_Add or base.is_Pow:
        kind = 6 if base.has(xi, tau) or base.atoms(sp.Dummy) else 2
    elif isinstance(base, sp.exp):
        kind = 8
    place = FUNCTION_ORDER.index(base.name) if kind == 7 else len(FUNCTION_ORDER)
    if base.func in FUNCTIONS:
        place = FUNCTIONS.index(base.func)
    return (7 if base.is_Function and kind == 5 else kind), place, base.name if base.is_Symbol else str(base)


def _has_fraction(total: sp.Expr) -> bool:
    return any(sp.fraction(term, exact=True)[1] != 1 for term in total.args)


def _product(factors: list[str]) -> str:
    """Return the factors side by side, a function's name with a space before it."""
    return " ".join(
        rf"\, {factor}" if place and factor.startswith((r"\mathrm", r"\mathcal")) else factor
        for place, factor in enumerate(factors)
    )


def _name_kind(name: str) -> int:
    return 1 if name == "k'" else 7 if name in FUNCTION_ORDER else 4


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
        factors = sorted(sp.Mul.make_args(rest), key=_factor_rank)
        texts = [self._factor(factor) for factor in factors]
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
        name = getattr(expr, "latex_symbol", NAMES.get(expr.func, ""))
        name = name.replace("operatorname", "mathrm")
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
        axes = " ".join(self._print(axis) for axis, count in expr.variable_count for _ in range(count))
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
