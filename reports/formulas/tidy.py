"""A formula's rows without nested fractions, as products where that is shorter, and their parts."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache

import sympy as sp

from reports.formulas.printing import is_phase, latex, measure, nesting, runs_left
from solutions.symbols import xi

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


OFTEN = 2
"""A part of a wide formula gets a name if it occurs this many times."""

WORTH = 10.0
"""Narrowest part that gets a name for being repeated."""


def shared_arguments(expression: sp.Expr) -> bool:
    """Tell whether functions share an argument that is no symbol."""
    counted = Counter(
        node.args[0] for node in expression.atoms(sp.Function, sp.exp) if not node.args[0].is_Atom
    )
    return any(times >= OFTEN for times in counted.values())


Change = Callable[[sp.Dummy], sp.Expr]
"""A function in terms of its argument's name."""


def based(node: sp.Expr, bases: Iterable[sp.Expr]) -> tuple[sp.Expr, Change]:
    """Return what to name in a function's argument, and the function in terms of the name."""
    argument, *rest = node.args
    for base in bases:
        for sign in (1, -1):
            if not (argument - sign * base).has(xi):
                return base, _changed(node.func, sign, argument - sign * base, rest)
    number, factor = argument.as_coeff_Mul()
    if runs_left(factor):
        number, factor = -number, -factor
    return factor, _changed(node.func, number, sp.S.Zero, rest)


def _changed(
    function: Callable[..., sp.Expr], number: sp.Expr, shift: sp.Expr, rest: Iterable[sp.Expr]
) -> Change:
    return lambda name: function(number * name + shift, *rest)


def atoms(expression: sp.Expr, *kinds: type[sp.Expr]) -> list[sp.Expr]:
    """Return the parts of these kinds, in the same order each time."""
    return sorted(expression.atoms(*kinds), key=sp.default_sort_key)


def with_phase(total: sp.Expr, phase: sp.Expr, name: sp.Dummy) -> sp.Expr | None:
    """Return the sum with the name for a number times the phase; None if that is no part of it."""
    number = total.coeff(xi)
    scaled = {number * term for term in sp.Add.make_args(phase)}
    if not number or not number.is_number or not scaled <= set(total.args):
        return None
    return sp.Add(number * name, *(term for term in total.args if term not in scaled))


def is_worth_a_name(part: sp.Expr) -> bool:
    """Tell whether a name for the part saves anything."""
    return is_wide(part, WORTH) or is_phase(part)


@cache
def occurrences(expression: sp.Expr) -> Counter[sp.Expr]:
    """Count the sums and square roots in the expression that depend on something."""
    found: Counter[sp.Expr] = Counter()
    for arg in expression.args:
        found.update(occurrences(arg))
    root = expression.is_Pow and expression.exp == sp.Rational(1, 2)
    if expression.free_symbols and (expression.is_Add or root):
        found[expression] += 1
    return found


def sums(term: sp.Expr) -> list[sp.Expr]:
    """Return the sums that are factors of the term, or below a factor's power."""
    bases = (factor.base if factor.is_Pow else factor for factor in sp.Mul.make_args(term))
    return [base for base in bases if base.is_Add]


def product_roots(row: sp.Expr) -> Iterator[sp.Expr]:
    """Yield the products of two sums or more whose power stands in the row."""
    for node in atoms(row, sp.Mul):
        powers = node.as_coeff_Mul()[1].as_powers_dict()
        exponents = set(powers.values())
        named = [base for base in powers if base.is_Add or isinstance(base, sp.Dummy)]
        sums = any(base.is_Add for base in named)
        if len(exponents) == 1 and min(exponents) > 1 and sums and len(named) >= OFTEN:
            yield sp.Mul(*powers)


def divided(node: sp.Expr, product: sp.Expr, name: sp.Dummy) -> sp.Expr | None:
    """Return the node with the product's power as that of the name; None if it is no factor."""
    powers = node.as_powers_dict()
    exponents = {powers.get(base, sp.S.Zero) for base in sp.Mul.make_args(product)}
    if len(exponents) != 1 or not (power := exponents.pop()).is_positive:
        return None
    return node / product**power * name**power


def uses(expression: sp.Expr, name: sp.Dummy) -> int:
    """Count how often the name stands in the expression."""
    if expression == name:
        return 1
    return sum(uses(arg, name) for arg in expression.args)
