"""Numbers written with nested roots: equal, nearly equal, or equal up to a branch."""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from verify.studies.statements.equations import true_equation
from verify.studies.statements.formulas import constant, formula, number
from verify.studies.statements.near import shown_at
from verify.studies.statements.record import Statement, Truth
from verify.studies.statements.setting import Setting


def _square_root(p: sp.Rational, q: sp.Rational, root: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    value = p + q * root
    return sp.sqrt(sp.expand(value**2)), value if sp.N(value) > 0 else -value


def _cube_root(p: sp.Rational, q: sp.Rational, root: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    value = abs(p) + abs(q) * root
    return sp.expand(value**3) ** sp.Rational(1, 3), value


def _gaussian_root(p: sp.Rational, q: sp.Rational, _: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    value = abs(p) + q * sp.I
    return sp.sqrt(sp.expand(value**2)), value


def _rationalised(p: sp.Rational, q: sp.Rational, root: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    return 1 / (p + q * root), (p - q * root) / (p**2 - q**2 * root**2)


def _sum_of_roots(p: sp.Rational, q: sp.Rational, _: sp.Expr) -> tuple[sp.Expr, sp.Expr]:
    a, b = abs(p) + 1, abs(q) + 2
    return sp.sqrt(a) + sp.sqrt(b), sp.sqrt(a + b + 2 * sp.sqrt(a * b))


PAIRS = (_square_root, _cube_root, _gaussian_root, _rationalised, _sum_of_roots)


def nested_roots(setting: Setting) -> Statement | None:
    """u_v = value f_v with value f for u, the two values in different words."""
    draw = setting.draw
    p, q = number(setting), number(setting)
    left, right = draw.choice(PAIRS)(p, q, sp.sqrt(draw.choice((2, 3, 5, 6))))
    if left.has(sp.zoo, sp.nan):
        return None
    change = draw.choice((0, 0, sp.Rational(1, 10**30), sp.Rational(1, 10**90), -2 * right))
    f, v = formula(setting, draw.choice((1, 2))), draw.choice(setting.variables)
    f = f if f.has(v) else f + constant(setting) * v
    slope = f.diff(v)
    equation = setting.unknown.diff(v) - left * slope
    made = true_equation("nested roots", setting, equation, (right + change) * f)
    if change == 0:
        return made
    point = shown_at(slope, setting, 40)
    if point is None:
        return None
    return replace(made, truth=Truth.FALSE, counterexample=point)
