"""Rules of a case solved for their symbols: quotients, and real roots of what can be written so."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import sympy as sp

from .case_tree import Constants, SystemCase
from .factors import factors_of

RELATIONS = 3
"""Most algebraic constants that a root is looked for in."""

SHORT = 60
"""Operations of a quotient of exponentials that hyperbolic functions are looked for in."""

Values = dict[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class Explicit:
    """Symbols with their values; ``implicit`` must vanish, too, and could not be solved."""

    values: Values
    implicit: tuple[sp.Expr, ...] = ()


def explicit_values(branch: SystemCase, constants: Constants) -> Iterator[Explicit]:
    """The values that the rules of a branch give, from the last one to the first."""
    squares = [
        (constants.all[place], constants.written(value))
        for place, (degree, value) in constants.relations.items()
        if degree == 2
    ][:RELATIONS]
    waiting = [(len(branch.rules), Explicit({}))]
    while waiting:
        place, found = waiting.pop(0)
        if place == 0:
            values = {s: in_squares(value, squares) for s, value in found.values.items()}
            yield Explicit(values, found.implicit)
            continue
        rule = branch.rules[place - 1]
        rows = [
            tidy(constants.written(row).xreplace(found.values))
            for row in constants.coefficients(rule.polynomial, constants.places[rule.symbol])
        ]
        while rows and rows[-1] == 0:
            rows.pop()
        for root in _roots(rows, rule.symbol, squares):
            new = (
                Explicit(found.values, (*found.implicit, root.polynomial))
                if isinstance(root, _Implicit)
                else Explicit({rule.symbol: root, **found.values}, found.implicit)
            )
            waiting.append((place - 1, new))


@dataclass(frozen=True)
class _Implicit:
    """A polynomial of which no roots are written."""

    polynomial: sp.Expr


Squares = Sequence[tuple[sp.Expr, sp.Expr]]
"""Algebraic constants with their squares."""


def _roots(
    rows: Sequence[sp.Expr], symbol: sp.Symbol, squares: Squares
) -> list[sp.Expr | _Implicit]:
    """The roots of a polynomial given by its coefficients, those of powers of a power too."""
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
        size = sp.Pow(abs(number), sp.Rational(1, step))
        return [size if number > 0 else -size]
    polynomial = sp.Add(*(row * symbol**power for power, row in enumerate(rows)))
    return [_Implicit(sp.expand(polynomial))]


def _even(
    rows: Sequence[sp.Expr], symbol: sp.Symbol, squares: Squares
) -> list[sp.Expr | _Implicit]:
    """The roots of a polynomial in the square."""
    found: list[sp.Expr | _Implicit] = []
    for root in _roots(rows[::2], symbol, squares):
        if isinstance(root, _Implicit):
            found.append(_Implicit(root.polynomial.xreplace({symbol: symbol**2})))
        else:
            found += _square_roots(root, squares)
    return found


def _square_roots(radicand: sp.Expr, squares: Squares) -> list[sp.Expr]:
    """Both square roots; in algebraic constants of which the squares are known, if it is one."""
    if radicand == 0:
        return [sp.S.Zero]
    candidates: list[tuple[int, int, sp.Expr, sp.Expr]] = []
    for powers in product((0, 1, -1), repeat=len(squares)):
        pairs = list(zip(squares, powers, strict=True))
        root, odd = _parted(radicand / sp.Mul(*(square**n for (_, square), n in pairs)))
        root *= sp.Mul(*(g**n for (g, _), n in pairs))
        size = len(odd.atoms(sp.Function)), odd.count_ops() + root.count_ops()
        candidates.append((*size, odd, root))
    _, _, odd, root = min(candidates, key=lambda candidate: candidate[:2])
    value = _root_of_quotient(odd) * tidy(root)
    return [value, -value]


def _root_of_quotient(quotient: sp.Expr) -> sp.Expr:
    """A root of a quotient that is not negative, up to its sign."""
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


def _parted(quotient: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    """A root and the rest: the quotient is the square of the first, times the second."""
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
    """The expression as a quotient of factors, with roots of numbers out of denominators.

    >>> k = sp.Symbol("k")
    >>> tidy(sp.exp(k) / 2 - sp.exp(-k) / 2)
    sinh(k)
    """
    powers = (p for p in expression.atoms(sp.Pow) if p.exp.is_Rational and p.exp.q == 2)
    names = {sp.sqrt(p.base): sp.Dummy(positive=True) for p in powers if p.free_symbols}
    below = {1 / root: 1 / name for root, name in names.items()}
    found = expression.xreplace(names).xreplace(below)
    found = sp.factor(sp.cancel(sp.together(found)))
    found = found.xreplace({name: root for root, name in names.items()})
    if names:
        number, factors = factors_of(found)
        whole = number * sp.Mul(*(factor**power for factor, power in factors))
        found = min(found, whole, key=lambda e: e.count_ops())
    if found.has(sp.exp) and found.count_ops() <= SHORT:
        return min(found, sp.simplify(found), key=lambda e: e.count_ops())
    if found.is_number or any(p.base.is_Rational for p in found.atoms(sp.Pow) if p.exp.q != 1):
        found = sp.radsimp(found)
        factored = sp.factor(found)
        return factored if factored.count_ops() <= found.count_ops() else found
    return found


def in_squares(value: sp.Expr, squares: Squares) -> sp.Expr:
    """The value in algebraic constants in the place of their squares, where that is shorter."""
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
    """The value with its numerator divided by a factor, which is ``other``: quotient and rest."""
    above, below = sp.fraction(value)
    function = min(factor.atoms(sp.Function), key=sp.default_sort_key)
    if not above.is_polynomial(function):
        return value
    quotient, rest = sp.div(sp.expand(above), factor, function)
    return tidy(quotient * other / below) + tidy(rest / below)
