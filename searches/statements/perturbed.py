"""True statements changed so that it is hard to see: by a small or hidden term, by a division by 0.

In some equations the unknown stands inside a function, a derivative or a modulus. Where a prover
cannot take such an equation it must say so, and not read it as another one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import sympy as sp

from longwave.solutions.functions import jacobi
from searches.statements.formulas import (
    constant,
    formula,
    number,
    phase,
    polynomial,
    positive,
)
from searches.statements.random_statement import RandomStatement, Setting
from searches.statements.solvable import (
    identity,
    logarithmic,
    travelling_wave,
    with_annihilator,
    with_source,
)
from searches.texts.text_statement import Truth

TINY = (20, 60, 200)
TRUE = (with_source, with_source, with_annihilator, travelling_wave, logarithmic, identity)
PRIME = 1009
SMALLEST = 10**-30


def perturbed(
    kind: str, setting: Setting, statement: RandomStatement, term: sp.Expr
) -> RandomStatement:
    """Return ``statement`` with ``term``, free of the unknown, added."""
    return replace(
        statement,
        kind=kind,
        truth=Truth.FALSE,
        left=statement.left + term,
        ranges=tuple(setting.ranges.values()),
    )


def tiny_change(setting: Setting) -> RandomStatement:
    """One coefficient of the equation, or one side, times 1 + 10**-20, -60 or -200."""
    draw = setting.draw
    statement = draw.choice(TRUE)(setting)
    digits = draw.choice(TINY)
    terms = sp.Add.make_args(statement.left)
    change = sp.Rational(1, 10**digits) * draw.choice(terms)
    return replace(
        statement,
        kind="tiny change",
        truth=Truth.FALSE,
        left=sp.Add(*terms, change),
        ranges=tuple(setting.ranges.values()),
    )


def hidden_term(setting: Setting) -> RandomStatement:
    """A term that vanishes where one may look."""
    draw = setting.draw
    statement = draw.choice(TRUE)(setting)
    kind = draw.choice(list(HIDDEN))
    return perturbed(kind, setting, statement, HIDDEN[kind](setting))


def _at_rationals(setting: Setting) -> sp.Expr:
    """Vanishes at the multiples of 1/2, 1/3 and 1/5 up to 4."""
    v = _symbol(setting)
    q = setting.draw.choice((2, 3, 5))
    return sp.Mul(*(q * v - p for p in range(-2 * q, 2 * q + 1)))


def _at_lattice(setting: Setting) -> sp.Expr:
    """Vanishes at every rational number whose denominator divides a large one."""
    v = _symbol(setting)
    return sp.sin(sp.pi * setting.draw.choice((1, 60, PRIME, 64 * PRIME, 1000)) * v)


def _at_a_value(setting: Setting) -> sp.Expr:
    """Vanishes at one value of a symbol."""
    return _symbol(setting) - sp.Rational(setting.draw.randint(-9, 9), setting.draw.randint(1, 6))


def _on_a_curve(setting: Setting) -> sp.Expr:
    symbols = list(setting.ranges)
    if len(symbols) < 2:
        return symbols[0] ** 2 - 1
    a, b = setting.draw.sample(symbols, 2)
    return setting.draw.choice((a - b, a + b, a * b - 1, a**2 + b**2 - 1, a**2 - b**2))


def _of_one_sign(setting: Setting) -> sp.Expr:
    """Vanishes where a formula is positive."""
    s = setting.draw.choice((_symbol(setting), phase(setting)))
    forms = (sp.Abs(s) - s, sp.sqrt(sp.expand(s**2)) - s, 1 - sp.sign(s), s * sp.Abs(s) - s**2)
    return setting.draw.choice(forms)


def _small(setting: Setting) -> sp.Expr:
    """Small, though never 0."""
    v = setting.draw.choice(setting.variables)
    n = setting.draw.choice((5, 20))
    forms = (sp.exp(-n * (1 + v**2)), sp.sech(n * v), 1 - sp.tanh(n * v), sp.exp(-n * sp.cosh(v)))
    return setting.draw.choice(forms)


def _high_power(setting: Setting) -> sp.Expr:
    """Nearly 0 on most of an interval."""
    v = _symbol(setting)
    return constant(setting) * (v / 10) ** setting.draw.choice((8, 12, 20))


def _symbol(setting: Setting) -> sp.Symbol:
    return setting.draw.choice(list(setting.ranges))


HIDDEN = {
    "at rationals": _at_rationals,
    "at a lattice": _at_lattice,
    "at a value": _at_a_value,
    "on a curve": _on_a_curve,
    "of one sign": _of_one_sign,
    "small": _small,
    "high power": _high_power,
}


Zero = Callable[[sp.Expr, sp.Expr, sp.Expr], sp.Expr]
sn, cn = jacobi.jacobi_sn, jacobi.jacobi_cn
m = sp.Rational(1, 3)

ZEROS: tuple[Zero, ...] = (
    lambda s, p, v: sp.sin(s) ** 2 + sp.cos(s) ** 2 - 1,
    lambda s, p, v: sp.cosh(s) ** 2 - sp.sinh(s) ** 2 - 1,
    lambda s, p, v: sp.sqrt(sp.expand(p**2)) - p,
    lambda s, p, v: sp.expand((s + 1) ** 2) - (s + 1) ** 2,
    lambda s, p, v: sp.tanh(s) - sp.sinh(s) / sp.cosh(s),
    lambda s, p, v: sp.exp(s) - sp.cosh(s) - sp.sinh(s),
    lambda s, p, v: sn(v, m) ** 2 + cn(v, m) ** 2 - 1,
    lambda s, p, v: sp.sqrt(p) ** 2 - p + sp.tan(s) - sp.sin(s) / sp.cos(s),
    lambda s, p, v: sp.sqrt(3 + 2 * sp.sqrt(2)) - 1 - sp.sqrt(2),
    lambda s, p, v: sp.Abs(sp.expand(p * (1 + p))) - p - p**2,
)
"""0 in other words, of a real s, a positive p and a variable v."""


def _zero(setting: Setting) -> sp.Expr:
    made = setting.draw.choice(ZEROS)
    found = made(phase(setting), positive(setting), setting.variables[0])
    return found if found != 0 else _zero(setting)


def nowhere_defined(setting: Setting) -> RandomStatement | None:
    """A formula that is divided by 0 everywhere."""
    draw = setting.draw
    zero = _zero(setting)
    over = zero ** draw.choice((-1, -1, -2)) * draw.choice((sp.S.One, polynomial(setting), zero**2))
    made = draw.choice((with_source, identity))(setting)
    if made.unknown is not None:
        made = replace(made, right=made.right + over)
    else:
        made = replace(made, left=made.left + over, right=made.right + over)
    whole = made.right if made.unknown is not None else made.left
    if not whole.has(1 / zero):
        return None
    return replace(
        made, kind="nowhere defined", truth=Truth.VOID, ranges=tuple(setting.ranges.values())
    )


def nearly_nowhere(setting: Setting) -> RandomStatement:
    """Division by a number that is nearly 0 but is none."""
    draw = setting.draw
    tiny = sp.Rational(1, 10 ** draw.choice((10, 60)))
    below = _zero(setting) + tiny
    f, v = formula(setting, 1), draw.choice(setting.variables)
    left = setting.unknown.diff(v) - f.diff(v) / tiny
    made = setting.equation("nearly nowhere", left, f / below)
    if draw.random() < 0.5:
        made = setting.equality("nearly nowhere", f / below, f / tiny)
    return made


Wrap = Callable[[sp.Expr, sp.Symbol], sp.Expr]

WRAPS: dict[str, Wrap] = {
    "derivative of a square": lambda u, v: sp.Derivative(u**2, v),
    "derivative of a product": lambda u, v: sp.Derivative(v * u, v),
    "derivative twice": lambda u, v: sp.Derivative(u * sp.Derivative(u, v), v),
    "sine": lambda u, v: sp.sin(u),
    "exponential": lambda u, v: sp.exp(u),
    "quotient": lambda u, v: v / u,
    "root": lambda u, v: sp.sqrt(u),
    "modulus": lambda u, v: sp.Abs(u),
    "square of a modulus": lambda u, v: sp.Abs(u) ** 2 * u,
    "conjugate": lambda u, v: u * sp.conjugate(u),
    "real part": lambda u, v: sp.re(u),
    "gamma": lambda u, v: sp.gamma(u),
    "floor": lambda u, v: sp.floor(u) + u,
    "value at 0": lambda u, v: 2 * u + sp.Subs(u, v, 0),
}
READABLE = tuple(WRAPS)[:11]
"""Those that SymPy can differentiate and write out at a formula."""


def wrapped(setting: Setting) -> RandomStatement | None:
    """w(u) = w(f) for u = f, or w(u) = w(f) read as u = w(f): true and false."""
    draw, unknown = setting.draw, setting.unknown
    name, v = draw.choice(READABLE), draw.choice(setting.variables)
    solution = formula(setting, 1)
    if draw.random() < 0.3:
        solution *= sp.exp(sp.I * phase(setting))
    left, right = WRAPS[name](unknown, v), WRAPS[name](solution, v).doit()
    if right.has(sp.nan, sp.zoo, sp.oo, sp.Derivative):
        return None
    made = setting.equation(f"wrapped: {name}", left - right, solution)
    if draw.random() < 0.5:
        return made
    changed = draw.choice((left - solution, left - number(setting) * right))
    return replace(made, truth=Truth.FALSE, left=changed)


def opaque(setting: Setting) -> RandomStatement:
    """Return an equation in functions that the grammar does not have: nothing can be said of it."""
    draw, unknown = setting.draw, setting.unknown
    name = draw.choice(tuple(WRAPS)[len(READABLE) :])
    v = draw.choice(setting.variables)
    solution = draw.choice((v, formula(setting, 1)))
    factor = draw.choice((sp.S.One, sp.Derivative(unknown, v), unknown))
    left = WRAPS[name](unknown, v) * factor - factor.subs(unknown, solution).doit() * solution
    made = setting.equation(f"opaque: {name}", left, solution)
    return replace(made, truth=Truth.VOID)
