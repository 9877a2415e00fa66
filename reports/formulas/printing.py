r"""LaTeX of SymPy expressions in the field's notation, its width, and narrower forms.

Sums begin with the phase's $\xi$ or the highest power; products put parameters before variables,
functions last; derivatives are subscripts, and elliptic functions show the modulus. A row of a
formula is tidied: it has no nested fractions, or is a product if that is shorter.
"""

import enum
from collections.abc import Iterable, Iterator, Sequence
from functools import cache

import sympy as sp

from longwave.derive.algebra.formula_printing import ExpressionLatexPrinter
from longwave.derive.algebra.latex_width import measure, nesting
from longwave.solutions.symbols import tau, xi

FUNCTION_ORDER = (r"\mathrm{sn}", r"\mathrm{cn}", r"\mathrm{dn}", r"\mathcal{E}", r"\mathrm{Z}")
"""Elliptic functions in their order within a product; others follow."""


class Kind(enum.IntEnum):
    """Kinds of factors, in their order within a product."""

    NUMBER = enum.auto()
    PARAMETER = enum.auto()
    COEFFICIENT = enum.auto()
    VARIABLE = enum.auto()
    PART = enum.auto()
    OTHER = enum.auto()
    SUM = enum.auto()
    FUNCTION = enum.auto()
    EXPONENTIAL = enum.auto()
    DERIVATIVE = enum.auto()


def function_name(function: sp.Expr) -> str:
    """Return the name of an elliptic function as LaTeX."""
    return str(function.latex_symbol).replace("operatorname", "mathrm")


def ordered_terms(total: sp.Expr) -> list[sp.Expr]:
    """Return a sum's terms in printing order, reversed if that avoids a leading minus sign.

    >>> k = sp.Symbol("k")
    >>> ordered_terms(k**2 - 1 + k), ordered_terms(1 - k**2), ordered_terms(tau * k + xi)
    ([k**2, k, -1], [1, -k**2], [xi, k*tau])
    """
    terms: list[sp.Expr] = list(sp.Add.make_args(total))
    if is_linear(total):
        terms.sort(key=lambda term: (not term.has(xi), not term.has(tau), str(term)))
    else:
        terms.sort(key=_degree_rank)
    if len(terms) == 2 and terms[1].is_positive and terms[1].is_number:
        return terms[::-1]
    negative = [bool(term.as_coeff_Mul()[0].is_negative) for term in terms]
    return terms[::-1] if negative[0] and not negative[-1] else terms


def is_linear(total: sp.Expr) -> bool:
    """Return whether the expression is p xi + q tau + r with p, q, r free of both and p not 0."""
    if not total.has(xi):
        return False
    slopes = [term.as_independent(xi, tau)[1] for term in sp.Add.make_args(total)]
    return xi in slopes and set(slopes) <= {xi, tau, sp.S.One}


def is_phase(total: sp.Expr) -> bool:
    """Return whether an expression `is_linear` and has no named parts."""
    return is_linear(total) and not total.atoms(sp.Dummy)


def runs_left(argument: sp.Expr) -> bool:
    """Return whether an argument is a sum in which xi has a negative coefficient."""
    return bool(argument.is_Add and argument.coeff(xi).is_negative)


def _degree_rank(term: sp.Expr) -> tuple[object, ...]:
    """Return a sort key of terms: fractions last, a named phase first, then falling powers."""
    numerator, denominator = sp.fraction(term, exact=True)
    powers = numerator.as_powers_dict()
    phase = any(isinstance(base, sp.Dummy) and base.name.startswith("phi") for base in powers)
    explicit = (-float(powers.get(symbol, 0)) for symbol in (tau, xi))
    return (bool(denominator.free_symbols), not phase, *explicit, -_degree(numerator), str(term))


def _degree(expression: sp.Expr) -> float:
    """Return the total degree of an expression, in which every function counts as one variable."""
    if expression.is_Add:
        return max(_degree(term) for term in expression.args)
    if expression.is_Mul:
        return sum(_degree(factor) for factor in expression.args)
    if expression.is_Pow and expression.exp.is_Rational:
        return float(expression.exp) * _degree(expression.base)
    return float(not expression.is_number)


def _factor_rank(factor: sp.Expr) -> tuple[int, int, str]:
    base = factor.base if factor.is_Pow and factor.exp.is_number else factor
    name = function_name(base) if hasattr(base, "latex_symbol") else getattr(base, "name", "")
    known = name in FUNCTION_ORDER
    place = FUNCTION_ORDER.index(name) if known else len(FUNCTION_ORDER)
    return _kind(base), place, base.name if base.is_Symbol else str(base)


def _kind(base: sp.Expr) -> Kind:
    if base.is_number:
        return Kind.NUMBER
    if base.is_Symbol:
        return _symbol_kind(base)
    if base.is_Add or base.is_Pow:
        varies = base.has(xi, tau) or base.atoms(sp.Dummy)
        return Kind.SUM if varies else Kind.COEFFICIENT
    classes = (
        (sp.exp, Kind.EXPONENTIAL),
        (sp.Function, Kind.FUNCTION),
        (sp.Derivative, Kind.DERIVATIVE),
    )
    return next((kind for cls, kind in classes if isinstance(base, cls)), Kind.OTHER)


def _symbol_kind(symbol: sp.Symbol) -> Kind:
    if symbol in (xi, tau):
        return Kind.VARIABLE
    if not symbol.is_Dummy or symbol.name == "k'":
        return Kind.PARAMETER
    return Kind.FUNCTION if symbol.name in FUNCTION_ORDER else Kind.PART


NAMES: dict[type[sp.Expr], str] = {
    sp.sin: r"\sin", sp.cos: r"\cos", sp.sinh: r"\sinh", sp.cosh: r"\cosh", sp.tanh: r"\tanh",
    sp.sech: r"\mathrm{sech}",
}  # fmt: skip
"""LaTeX of functions that are written without brackets before a single symbol."""


def latex(expression: sp.Basic) -> str:
    r"""Return the expression's LaTeX.

    >>> from longwave.solutions.functions.jacobi import jacobi_sn
    >>> from longwave.solutions.symbols import k, tau, xi
    >>> latex(xi - (2 * k**2 - 1) * tau), latex(1 - k**2), latex(jacobi_sn(xi, k**2))
    ('\\xi - \\left(2 k^{2} - 1\\right) \\tau', '1 - k^{2}', '\\mathrm{sn}(\\xi;k)')
    """
    return str(_Printer({"fold_func_brackets": True}).doprint(expression))


def sum_latex(terms: Iterable[sp.Expr]) -> str:
    """Return the LaTeX of the terms' sum, in the given order."""
    text = ""
    for term in terms:
        negative = bool(term.as_coeff_Mul()[0].is_negative)
        body = latex(-term if negative else term)
        sign = "-" if negative else "+"
        text += f" {sign} {body}" if text else f"- {body}" if negative else body
    return text


def is_even(function: sp.Expr) -> bool:
    """Return whether the function is even in its first argument."""
    parity = getattr(function, "parity", 0)
    return parity == 1 or isinstance(function, sp.cos | sp.cosh | sp.sech)


def _has_fraction(total: sp.Expr) -> bool:
    return any(sp.fraction(term, exact=True)[1] != 1 for term in total.args)


def _product(factors: list[str]) -> str:
    """Join the LaTeX of factors, with a thin space before a function's upright name."""
    return " ".join(
        rf"\, {factor}" if index and factor.startswith((r"\mathrm", r"\mathcal")) else factor
        for index, factor in enumerate(factors)
    )


class _Printer(ExpressionLatexPrinter):
    """Printer of expressions with the field's order of terms and factors."""

    printmethod = "_paper_latex"

    def _print_Add(self, expr: sp.Expr, order: str | None = None) -> str:
        return sum_latex(ordered_terms(expr))

    def _print_Mul(self, expr: sp.Expr) -> str:
        numerator, denominator = sp.fraction(expr, exact=True)
        if denominator != 1:
            return self._fraction(numerator, denominator)
        coefficient, rest = expr.as_coeff_Mul()
        texts = [
            self._factor(factor) for factor in sorted(sp.Mul.make_args(rest), key=_factor_rank)
        ]
        if coefficient == -1:
            return f"- {_product(texts)}"
        return _product(texts if coefficient == 1 else [self._print(coefficient), *texts])

    def _fraction(self, numerator: sp.Expr, denominator: sp.Expr) -> str:
        """Return a fraction's LaTeX; factors above that contain fractions are written after it."""
        if numerator.as_coeff_Mul()[0].is_negative:
            return f"- {self._fraction(-numerator, denominator)}"
        factors = sp.Mul.make_args(numerator)
        fraction_sums = [factor for factor in factors if factor.is_Add and _has_fraction(factor)]
        remaining_numerator = sp.Mul(*(factor for factor in factors if factor not in fraction_sums))
        text = rf"\frac{{{self._print(remaining_numerator)}}}{{{self._print(denominator)}}}"
        return " ".join([text, *map(self._factor, fraction_sums)])

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

    def _print_ImaginaryUnit(self, expr: sp.Expr) -> str:
        return "i"

    def _print_elliptic_k(self, expr: sp.Expr, exp: str | None = None) -> str:
        power = f"^{{{exp}}}" if exp else ""
        return rf"K{power}({self._print(sp.sqrt(expr.args[0]))})"

    def _print_AppliedUndef(self, expr: sp.Expr, exp: str | None = None) -> str:
        return f"{expr.func.__name__}^{{{exp}}}" if exp else str(expr.func.__name__)

    def _print_Derivative(self, expr: sp.Expr) -> str:
        axes = " ".join(map(self._print, expr.variables))
        return f"{self._print(expr.expr)}_{{{axes}}}"


def equation_latex(residual: sp.Expr, unknown: sp.Expr, time: sp.Symbol) -> str:
    """Return the LaTeX of ``residual = 0``: time derivative first, others by falling degree."""

    def sort_key(term: sp.Expr) -> tuple[bool, int]:
        powers = term.as_powers_dict()
        degree = sum(int(powers[base]) for base in powers if base.has(unknown.func))
        return not any(time in d.variables for d in term.atoms(sp.Derivative)), -degree

    return f"{sum_latex(sorted(sp.Add.make_args(residual), key=sort_key))} = 0"


def joined(lines: Sequence[str]) -> str:
    """Return the lines as an `align*` environment."""
    return "\\begin{align*}\n" + " \\\\\n".join(lines) + "\n\\end{align*}"


LINE = 76.0
"""Widest line of a display, in characters as `width` counts them."""

HUGE = 200
"""Number of tree nodes above which an expression counts as wide without being measured."""

GAIN = 0.9
"""Ratio of widths, new to old, below which an equal form with the same nesting replaces a row."""


@cache
def size(expression: sp.Expr) -> int:
    """Return the number of nodes in the expression's tree."""
    return 1 + sum(size(arg) for arg in expression.args)


@cache
def width(expression: sp.Expr) -> float:
    """Return the approximate width of the typeset expression, in characters.

    >>> x, y = sp.symbols("x y")
    >>> width(x / (x + y))
    4.0
    """
    return measure(latex(expression))


def is_wide(expression: sp.Expr, line: float = LINE) -> bool:
    """Return whether the expression needs more than one line."""
    return size(expression) > HUGE or width(expression) > line


@cache
def tidied(row: sp.Expr) -> sp.Expr:
    """Return the row, or an equal form that is narrower or has fewer nested fractions.

    Only rational operations on its symbols and functions are used.
    """
    if size(row) > HUGE or is_phase(row) or any(is_phase(factor) for factor in row.args):
        return row
    row = sp.Add(*map(_tidied_inside, sp.Add.make_args(row)))
    generators = {
        node: sp.Dummy(real=True)
        for node in row.atoms(sp.Function, sp.exp, sp.Pow)
        if not (node.is_Pow and node.exp.is_Integer)
    }
    back = {symbol: node for node, symbol in generators.items()}
    forms = [form.xreplace(back) for form in _forms(row.xreplace(generators))]
    best = min(forms, key=_clumsiness)
    return best if _clumsiness(best) < (_clumsiness(row)[0], GAIN * width(row)) else row


def _tidied_inside(part: sp.Expr) -> sp.Expr:
    """Return a term or factor with each sum inside it replaced by its `tidied` form."""
    if part.is_Add:
        return tidied(part)
    if part.is_Mul:
        return sp.Mul(*(factor for arg in part.args for factor in _content(_tidied_inside(arg))))
    if part.is_Pow and part.exp.is_Integer:
        return part.func(*map(_tidied_inside, part.args))
    return part


def _content(factor: sp.Expr) -> tuple[sp.Expr, ...]:
    """Split a sum into its numerical factor and the rest; other factors are returned alone.

    The numerical factor is negative if all terms of the sum are.
    """
    if not factor.is_Add:
        return (factor,)
    number, rest = factor.primitive()
    if all(term.as_coeff_Mul()[0].is_negative for term in rest.args):
        number, rest = -number, -rest
    return number, rest


def _clumsiness(form: sp.Expr) -> tuple[int, float]:
    """Return a sort key that prefers less nested fractions, then narrower forms."""
    return max(nesting(latex(form)), 1), width(form)


def _forms(rational: sp.Expr) -> Iterator[sp.Expr]:
    """Yield equal forms of a rational expression; terms of a sum stay separate fractions."""
    if rational.is_polynomial():
        yield _factored(rational)
        content = _without_sign(sp.factor_terms(rational))
        yield content
        common, rest = content.as_independent(sp.Add) if content.is_Mul else (sp.S.One, rational)
        for symbol in sorted(rest.free_symbols, key=sp.default_sort_key):
            yield common * sp.collect(sp.expand(rest), symbol, sp.factor_terms)
    else:
        together = [sp.together(term) for term in sp.Add.make_args(rational)]
        yield sp.Add(*together)
        yield sp.Add(*map(_factored, together))


def _factored(rational: sp.Expr) -> sp.Expr:
    above, below = (sp.factor(sp.factor_terms(part)) for part in sp.fraction(rational))
    return above / below


def _without_sign(product: sp.Expr) -> sp.Expr:
    """Return the product with its minus sign moved into a sum that is mostly negative."""
    for total in product.args if product.is_Mul else ():
        minus = sum(bool(term.as_coeff_Mul()[0].is_negative) for term in total.args)
        if total.is_Add and 2 * minus > len(total.args):
            return product / total * -1 * -total
    return product
