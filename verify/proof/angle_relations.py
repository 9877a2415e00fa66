"""Relations between inverse functions: 4 atan(1/5) - atan(1/239) = pi/4, asin f = 2 atan g.

Relations with small integer coefficients are guessed by lattice reduction (LLL) from values at a
few points; the checker decides whether they hold.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import sympy as sp
from flint import acb, ctx, fmpz_mat

from longwave.verify.subexpressions import distinct_nodes

from .balls import ball_value
from .domains import Point

ARCS = (sp.atan, sp.asin)
UNIT = sp.pi / 12
"""The constant term of a relation is an integer multiple of this angle."""

BITS, SHIFT = 400, 160
"""Working precision in bits, and the power of 2 that scales values to integers for LLL."""

LARGEST_INTEGER, MOST_FUNCTIONS, SAMPLE_POINTS = 60, 8, 3
"""Limits: integers in a relation, functions in all relations, and sample points."""


def angle_values(expressions: Iterable[sp.Expr], points: Sequence[Point]) -> dict[sp.Expr, sp.Expr]:
    """Map functions in the expressions to sums of other functions that they equal numerically.

    >>> a, b = sp.atan(sp.Rational(1, 5)), sp.atan(sp.Rational(1, 239))
    >>> angle_values([a + b], [{}])
    {atan(1/239): -pi/4 + 4*atan(1/5)}
    """
    nodes = {node for e in expressions for node in distinct_nodes(e)}
    nodes |= {sp.asin(node.args[0]) for node in nodes if isinstance(node, sp.acos)}
    arcs = {arc for arc in nodes if isinstance(arc, ARCS)}
    remaining = sorted(arcs, key=lambda arc: (arc.count_ops(), sp.default_sort_key(arc)))
    values: dict[sp.Expr, sp.Expr] = {}
    if not 1 < len(remaining) <= MOST_FUNCTIONS:
        return values
    while (relation := _relation(remaining, points)) is not None:
        pivot = max(i for i, n in enumerate(relation[:-1]) if abs(n) == 1)
        *factors, constant = [-n * relation[pivot] for n in relation]
        arc = remaining.pop(pivot)
        del factors[pivot]
        products = (n * other for n, other in zip(factors, remaining, strict=True))
        values[arc] = sp.Add(*products, constant * UNIT)
    return values


def _relation(arcs: Sequence[sp.Expr], points: Sequence[Point]) -> list[int] | None:
    """Return integers n_i, one +-1, and n such that sum n_i arcs_i + n `UNIT` is 0 numerically."""
    columns = [[_value(part, point) for part in (*arcs, UNIT)] for point in points[:SAMPLE_POINTS]]
    known = [[v for v in column if v is not None] for column in columns if None not in column]
    count = len(arcs) + 1
    with ctx.workprec(BITS):
        scaled = [[int((v * 2**SHIFT).real.mid().floor().unique_fmpz()) for v in c] for c in known]
    table = [[int(i == j) for j in range(count)] + [c[i] for c in scaled] for i in range(count)]
    for row in fmpz_mat(table).lll().table() if known else []:
        integers = [int(n) for n in row[:count]]
        if max(map(abs, integers)) > LARGEST_INTEGER or not any(abs(n) == 1 for n in integers[:-1]):
            continue
        with ctx.workprec(BITS):
            products = [[n * v for n, v in zip(integers, c, strict=True)] for c in known]
            if all(sum(terms, acb(0)).contains(0) for terms in products):
                return integers
    return None


def _value(expression: sp.Expr, point: Point) -> acb | None:
    try:
        ball = ball_value(expression, point, BITS)
    except (ValueError, ZeroDivisionError):
        return None
    return ball if ball.is_finite() and ball.imag.contains(0) else None
