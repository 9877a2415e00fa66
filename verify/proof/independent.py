"""Which linear forms of a proof are independent, and of which primitives they are made."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp
from flint import acb, ctx

from solutions.functions import jacobi_epsilon

from .balls import Point, ball_value
from .checker.check import FORMS
from .kernels import Kernels
from .linear import Form, linear_forms, pivot_columns, with_one_integral

BITS = 160


def visible(expressions: Iterable[sp.Expr], hidden: set[sp.Expr]) -> list[sp.Expr]:
    """The expressions with what one generator stands for left out."""
    names = {node: sp.Dummy() for node in hidden}
    return [expression.xreplace(names) for expression in expressions]


def independent_forms(
    expressions: Sequence[sp.Expr], kernels: Kernels, hidden: set[sp.Expr], point: Point
) -> tuple[list[sp.Basic], list[sp.Expr], list[list[sp.Expr]]]:
    """Pivots, other primitives, and independent linear forms: rows of factors of all of them.

    The primitives are variables and, for epsilon(u), the pair (u, m).  Independence is that of
    balls at ``point``: any choice makes generators.
    """
    written = with_one_integral(visible(expressions, hidden), kernels.dependence)
    forms = [_by_argument(f, kernels) for f in linear_forms(written, kernels.dependence)]
    primitives = sorted(
        {p for form in forms for p in form}, key=lambda p: (not isinstance(p, sp.Tuple), str(p))
    )
    rows: list[list[sp.Expr]] = []
    balls: list[list[acb]] = []
    with ctx.workprec(BITS):
        for form in forms:
            row = [form.get(p, sp.S.Zero) for p in primitives]
            values = [ball_value(value, point, BITS) for value in row]
            if len(pivot_columns([*balls, values])) > len(rows):
                rows.append(row)
                balls.append(values)
        pivots = pivot_columns(balls)
    if len(rows) == len(primitives) or len(rows) > FORMS:
        return [], [], []
    own = [primitives[i] for i in pivots]
    others = [p for p in primitives if p not in own]
    if any(isinstance(p, sp.Tuple) for p in others):
        return [], [], []
    order = [*pivots, *(primitives.index(p) for p in others)]
    return own, others, [[row[i] for i in order] for row in rows]


def _by_argument(form: Form, kernels: Kernels) -> dict[sp.Basic, sp.Expr]:
    """A linear form with the pairs (u, m) for epsilon(u) up to the sign of u."""
    found: dict[sp.Basic, sp.Expr] = {}
    for primitive, value in form.items():
        key: sp.Basic = primitive
        if isinstance(primitive, jacobi_epsilon):
            u, m = kernels.parts(primitive.args[0])[0], primitive.args[1]
            side = -1 if u.could_extract_minus_sign() else 1
            key, value = sp.Tuple(side * u, m), side * value
        found[key] = found.get(key, sp.S.Zero) + value
    return found
