"""What can have a name of its own in a formula, and the formula with the name in its place."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import cache

import sympy as sp

from reports.formulas.order import is_phase, runs_left
from reports.formulas.tidy import is_wide
from solutions.symbols import xi

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
