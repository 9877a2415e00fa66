"""Solve the rules of a case for their symbols, by quotients and explicit real roots."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import sympy as sp

from .case_tree import Constants, SystemCase
from .factors import factors_of

MOST_RELATIONS = 3
"""Most algebraic constants of which products are tried in order to write a square root."""

LONGEST_SIMPLIFIED = 60
"""Most operations of a quotient of exponentials in which hyperbolic functions are sought."""

Values = dict[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class Explicit:
    """Values of symbols, and ``implicit`` polynomials that must vanish but could not be solved."""

    values: Values
    implicit: tuple[sp.Expr, ...] = ()


def explicit_values(branch: SystemCase, constants: Constants) -> Iterator[Explicit]:
    """Yield the values that the rules of a branch give, solved from the last rule to the first."""
    known = [(i, value) for i, (degree, value) in constants.relations.items() if degree == 2]
    squares = [(constants.all[i], constants.written(value)) for i, value in known[:MOST_RELATIONS]]
    waiting = [(len(branch.rules), Explicit({}))]
    while waiting:
        count, partial = waiting.pop(0)
        if count == 0:
            values = {s: in_squares(value, squares) for s, value in partial.values.items()}
            yield Explicit(values, partial.implicit)
            continue
        rule = branch.rules[count - 1]
        coefficients = constants.coefficients(rule.polynomial, constants.places[rule.symbol])
        rows = [tidy(constants.written(row).xreplace(partial.values)) for row in coefficients]
        while rows and rows[-1] == 0:
            rows.pop()
        for root in _roots(rows, rule.symbol, squares):
            values, implicit = partial.values, partial.implicit
            if isinstance(root, _Implicit):
                implicit = (*implicit, root.polynomial)
            else:
                values = {rule.symbol: root, **values}
            waiting.append((count - 1, Explicit(values, implicit)))


@dataclass(frozen=True)
class _Implicit:
    """Polynomial whose roots are not written explicitly."""

    polynomial: sp.Expr


Squares = Sequence[tuple[sp.Expr, sp.Expr]]
"""Pairs of an algebraic constant and its square."""


def _roots(
    rows: Sequence[sp.Expr], symbol: sp.Symbol, squares: Squares
) -> list[sp.Expr | _Implicit]:
    """Return the real roots of a polynomial in ``symbol``, from its coefficients, lowest first."""
    powers = [power for power, row in enumerate(rows) if row != 0]
    if not powers or powers == [0]:
        return []
    if powers[0] > 0:
        return [sp.S.Zero, *_roots(rows[powers[0] :], symbol, squares)]
    if len(rows) == 2:
        return [tidy(-rows[0] / rows[1])]
    step = sp.igcd(*powers)
    if len(rows) == 3 and step == 1:
        inner = tidy(rows[1] ** 2 - 4 * rows[2] * rows[0])
        roots = _square_roots(inner, squares)
        return [tidy((-rows[1] + root) / (2 * rows[2])) for root in roots]
    if step % 2 == 0:
        return _even(rows, symbol, squares)
    if step == len(rows) - 1 and not (number := -rows[0] / rows[-1]).free_symbols:
        magnitude = sp.Pow(abs(number), sp.Rational(1, step))
        return [magnitude if number > 0 else -magnitude]
    polynomial = sp.Add(*(row * symbol**power for power, row in enumerate(rows)))
    return [_Implicit(sp.expand(polynomial))]


def _even(
    rows: Sequence[sp.Expr], symbol: sp.Symbol, squares: Squares
) -> list[sp.Expr | _Implicit]:
    """Return the real roots of a polynomial in ``symbol**2``."""
    roots: list[sp.Expr | _Implicit] = []
    for root in _roots(rows[::2], symbol, squares):
        if isinstance(root, _Implicit):
            roots.append(_Implicit(root.polynomial.xreplace({symbol: symbol**2})))
        else:
            roots += _square_roots(root, squares)
    return roots


def _square_roots(radicand: sp.Expr, squares: Squares) -> list[sp.Expr]:
    """Return both square roots, written in algebraic constants with known squares if possible."""
    if radicand == 0:
        return [sp.S.Zero]
    candidates: list[tuple[int, int, sp.Expr, sp.Expr]] = []
    for powers in product((0, 1, -1), repeat=len(squares)):
        pairs = list(zip(squares, powers, strict=True))
        root, odd = _split_square(radicand / sp.Mul(*(square**n for (_, square), n in pairs)))
        root *= sp.Mul(*(g**n for (g, _), n in pairs))
        size = len(odd.atoms(sp.Function)), odd.count_ops() + root.count_ops()
        candidates.append((*size, odd, root))
    _, _, odd, root = min(candidates, key=lambda candidate: candidate[:2])
    value = _root_of_quotient(odd) * tidy(root)
    return [value, -value]


def _root_of_quotient(quotient: sp.Expr) -> sp.Expr:
    """Return a square root of a nonnegative quotient, up to its sign."""
    above, below = sp.fraction(quotient)
    above, below = sp.expand(above), sp.expand(below)
    if above.is_number and above.is_negative:
        above, below = -above, -below
    if above.is_number or below.is_number:
        return _root_of_sum(above) / _root_of_sum(below)
    return _root_of_sum(sp.expand(above * below)) / below


def _root_of_sum(total: sp.Expr) -> sp.Expr:
    number, rest = total.primitive()
    root = sp.sqrt(number)
    return root * sp.sqrt(rest) if root.is_Rational else sp.sqrt(total)


def _split_square(quotient: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """Return r and q with ``quotient = r**2 * q``."""
    above, below = sp.fraction(sp.cancel(sp.together(quotient)))
    if not (above.free_symbols | below.free_symbols):
        return sp.S.One, above / below
    (number, above_factors), (under, below_factors) = factors_of(above), factors_of(below)
    root, odd = sp.S.One, number / under
    for factors, side in ((above_factors, 1), (below_factors, -1)):
        for factor, power in factors:
            half, rest = divmod(power, 2)
            root *= factor ** (side * half)
            odd *= factor ** (side * rest)
    return root, odd


def tidy(expression: sp.Expr) -> sp.Expr:
    """Simplify to a quotient of factors, with roots of numbers moved out of denominators.

    >>> k = sp.Symbol("k")
    >>> tidy(sp.exp(k) / 2 - sp.exp(-k) / 2)
    sinh(k)
    """
    powers = (p for p in expression.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2)
    names = {sp.sqrt(p.base): sp.Dummy(positive=True) for p in powers if p.free_symbols}
    below = {1 / root: 1 / name for root, name in names.items()}
    result = expression.xreplace(names).xreplace(below)
    result = sp.factor(sp.cancel(sp.together(result)))
    result = result.xreplace({name: root for root, name in names.items()})
    if names:
        number, factors = factors_of(result)
        whole = number * sp.Mul(*(factor**power for factor, power in factors))
        result = min(result, whole, key=lambda e: e.count_ops())
    if result.has(sp.exp) and result.count_ops() <= LONGEST_SIMPLIFIED:
        return min(result, sp.simplify(result), key=lambda e: e.count_ops())
    if result.is_number or any(p.base.is_Rational for p in result.atoms(sp.Pow) if p.exp.q != 1):
        result = sp.radsimp(result)
        factored = sp.factor(result)
        return factored if factored.count_ops() <= result.count_ops() else result
    return result


def in_squares(value: sp.Expr, squares: Squares) -> sp.Expr:
    """Write a value in algebraic constants instead of their squares, if that is shorter."""
    best = value
    for constant, square in squares:
        for factor, power in factors_of(square)[1]:
            if power != 1 or not factor.has(sp.Function):
                continue
            other = sp.cancel(constant**2 * factor / square)
            images = [tidy(best.subs(number * factor, number * other)) for number in (1, -1)]
            images += [_divided(image, factor, other) for image in (best, *images)]
            best = min(best, *images, key=lambda v: v.count_ops())
    return best


def _divided(value: sp.Expr, factor: sp.Expr, other: sp.Expr) -> sp.Expr:
    """Replace ``factor`` in the numerator by ``other``, which equals it, by division with rest."""
    above, below = sp.fraction(value)
    function = min(factor.atoms(sp.Function), key=sp.default_sort_key)
    if not above.is_polynomial(function):
        return value
    quotient, rest = sp.div(sp.expand(above), factor, function)
    return tidy(quotient * other / below) + tidy(rest / below)
