"""Complex-valued formulas: conjugates, real and imaginary parts, moduli."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import sympy as sp

from verify.studies.statements.equations import true_equality, true_equation
from verify.studies.statements.formulas import constant, formula, phase, positive
from verify.studies.statements.labels import with_counterexample
from verify.studies.statements.near import shown_at
from verify.studies.statements.paraphrase import rewritten
from verify.studies.statements.record import Statement, Truth
from verify.studies.statements.setting import Setting

Sides = Callable[[sp.Expr, sp.Expr, sp.Expr], tuple[sp.Expr, sp.Expr]]


def _turned(s: sp.Expr) -> sp.Expr:
    return sp.exp(sp.I * s)


PAIRS: dict[str, tuple[Sides, bool]] = {
    "re of a phase": (lambda s, p, f: (sp.re(f * _turned(s)), f * sp.cos(s)), True),
    "im of a phase": (lambda s, p, f: (sp.im(f * _turned(s)), f * sp.sin(s)), True),
    "im, wrong": (lambda s, p, f: (sp.im(f * _turned(s)), f * sp.cos(s)), False),
    "conjugate": (lambda s, p, f: (sp.conjugate(f * _turned(s)), f / _turned(s)), True),
    "conjugate, forgotten": (
        lambda s, p, f: (sp.conjugate(f * _turned(s)), f * _turned(s)),
        False,
    ),
    "square of a modulus": (lambda s, p, f: (sp.Abs(f + sp.I * s) ** 2, f**2 + s**2), True),
    "square of a modulus, wrong": (
        lambda s, p, f: (sp.Abs(f + sp.I * s) ** 2, sp.expand((f + sp.I * s) ** 2)),
        False,
    ),
    "modulus": (lambda s, p, f: (sp.Abs(p * _turned(s)), p), True),
    "modulus, wrong": (lambda s, p, f: (sp.Abs(p * (1 + _turned(s))), 2 * p), False),
    "product with the conjugate": (
        lambda s, p, f: ((f + sp.I * s) * sp.conjugate(f + sp.I * s), f**2 + s**2),
        True,
    ),
    "polar": (lambda s, p, f: (sp.sqrt(p) * sp.sqrt(-p), sp.I * p), True),
    "polar, wrong": (lambda s, p, f: (sp.sqrt(-p) * sp.sqrt(-p), p), False),
    "hyperbolic": (
        lambda s, p, f: (
            sp.cosh(sp.I * s + p),
            sp.cosh(p) * sp.cos(s) + sp.I * sp.sinh(p) * sp.sin(s),
        ),
        True,
    ),
    "Moebius": (
        lambda s, p, f: ((1 + sp.I * s) / (1 - sp.I * s), sp.exp(2 * sp.I * sp.atan(s))),
        True,
    ),
    "log of a phase": (lambda s, p, f: (sp.re(sp.log(p * _turned(s))), sp.log(p)), True),
}
"""Two formulas each of a real s, a positive p and a real f, and whether they are equal."""


def conjugates(setting: Setting) -> Statement | None:
    """An identity of complex-valued formulas, true or false."""
    draw = setting.draw
    name = draw.choice(list(PAIRS))
    sides, holds = PAIRS[name]
    left, right = sides(phase(setting), positive(setting), formula(setting, 1))
    if left == right or (left - right).has(sp.nan, sp.zoo, sp.oo):
        return None
    point = None if holds else shown_at(left - right, setting, 40)
    if not holds and point is None:
        return None
    kind = f"complex: {name}"
    if draw.random() < 0.5:
        made = true_equality(kind, setting, left, right)
    else:
        made = true_equation(kind, setting, setting.unknown - left, right)
    return made if holds else replace(made, truth=Truth.FALSE, counterexample=point)


def plane_wave(setting: Setting) -> Statement | None:
    """A linear equation with complex coefficients and its plane wave."""
    draw, unknown = setting.draw, setting.unknown
    v, w = draw.choice(setting.variables), setting.variables[-1]
    n, k = draw.choice((1, 2, 3)), constant(setting)
    solution = (
        constant(setting) * sp.exp(sp.I * k * v) * (1 if v == w else sp.exp(sp.I**n * k**n * w))
    )
    left = unknown.diff(v, n) - (sp.I * k) ** n * unknown
    if v != w:
        left = sp.diff(unknown, w) - sp.diff(unknown, v, n) * sp.I**n * k**n / (sp.I * k) ** n
    holds = draw.random() < 0.6
    made = true_equation("plane wave", setting, left, rewritten(solution, draw, 1))
    if holds:
        return made
    factor = (1 + sp.I) * constant(setting) / 10 ** draw.choice((0, 0, 40))
    changed = replace(
        made,
        truth=Truth.FALSE,
        left=left + factor * unknown,
        change=factor * solution,
    )
    return with_counterexample(changed, draw)
