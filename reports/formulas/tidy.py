"""A formula's rows without nested fractions, as products where that is shorter, and their parts."""

from collections.abc import Iterator
from functools import cache

import sympy as sp

from reports.formulas.printing import is_phase, latex, measure, nesting

LINE = 76.0
"""Widest display line, in characters as `measure` counts them."""

HUGE = 200
"""An expression of more nodes than this is wide; it is not printed to find out."""

GAIN = 0.9
"""A row is written in another form if that is narrower by this factor."""


@cache
def size(expression: sp.Expr) -> int:
    """Return the number of nodes of the expression's tree."""
    return 1 + sum(size(arg) for arg in expression.args)


@cache
def width(expression: sp.Expr) -> float:
    """Return about how many characters wide the expression is when it is set.

    >>> x, y = sp.symbols("x y")
    >>> width(x / (x + y))
    4.0
    """
    return measure(latex(expression))


def is_wide(expression: sp.Expr, line: float = LINE) -> bool:
    """Tell whether the expression needs more than one line."""
    return size(expression) > HUGE or width(expression) > line


@cache
def tidied(row: sp.Expr) -> sp.Expr:
    """Return the row, or an equal form of it with fewer nested fractions or less wide.

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
    """Return a term or factor with the sums in it tidied."""
    if part.is_Add:
        return tidied(part)
    if part.is_Mul:
        return sp.Mul(*(factor for arg in part.args for factor in _content(_tidied_inside(arg))))
    if part.is_Pow and part.exp.is_Integer:
        return part.func(*map(_tidied_inside, part.args))
    return part


def _content(factor: sp.Expr) -> tuple[sp.Expr, ...]:
    """Return a sum's number factor, negative if all its terms are, and the rest."""
    if not factor.is_Add:
        return (factor,)
    number, rest = factor.primitive()
    if all(term.as_coeff_Mul()[0].is_negative for term in rest.args):
        number, rest = -number, -rest
    return number, rest


def _clumsiness(form: sp.Expr) -> tuple[int, float]:
    """Return how deep fractions are nested, one level being none, and the width."""
    return max(nesting(latex(form)), 1), width(form)


def _forms(rational: sp.Expr) -> Iterator[sp.Expr]:
    """Yield ways to write a rational expression; a sum's terms are not put on one fraction."""
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
    """Return the product with a minus sign moved into its sum, if that has more of them."""
    for total in product.args if product.is_Mul else ():
        minus = sum(bool(term.as_coeff_Mul()[0].is_negative) for term in total.args)
        if total.is_Add and 2 * minus > len(total.args):
            return product / total * -1 * -total
    return product
