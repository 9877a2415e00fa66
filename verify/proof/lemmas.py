"""Equal parts of two formulas, so that an equality can be proved part by part.

If a sum in one formula has the value of another sum in the other formula at a point, the two may
be the same function.  Where that is proved, one generator of which nothing is known takes the
place of both; if the formulas are equal with it, they are equal.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp
from flint import acb, ctx

from verify.tree import distinct_nodes, replaced

from .balls import BallEvaluator, Point
from .dependence import Dependence
from .jet import Shape

BITS = 320

Pair = tuple[sp.Expr, sp.Expr]
"""A sum of either formula."""


def find_lemmas(
    left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol], point: Point
) -> list[Pair]:
    """The largest proper sums that differ as formulas and agree at ``point``.

    None lies in another; a sum is passed over for a smaller one that it holds and that stands
    elsewhere too.
    """
    with ctx.workprec(BITS):
        balls = BallEvaluator(Shape([(0,)]), (), point)
        sums = [_values(formula, variables, balls) for formula in (left, right)]
        pairs = [
            (own, other)
            for own, value in sums[0].items()
            for other, image in sums[1].items()
            if own not in sums[1] and other not in sums[0] and (value - image).contains(0)
        ]
    lemmas: list[Pair] = []
    for own, other in sorted(pairs, key=lambda pair: -len(distinct_nodes(pair[0]))):
        symbol = sp.Dummy()
        shorter = (replaced(left, own, symbol), replaced(right, other, symbol))
        if shorter[0] == left or shorter[1] == right:
            continue
        inner = [pair for pair in pairs if pair[0] != own and pair[0] in distinct_nodes(own)]
        if not _occurs(inner, *map(distinct_nodes, shorter)):
            lemmas.append((own, other))
            left, right = shorter
    return lemmas


def _values(
    formula: sp.Expr, variables: Sequence[sp.Symbol], balls: BallEvaluator
) -> dict[sp.Expr, acb]:
    """The values of the proper sums in ``formula`` that contain a variable."""
    dependence = Dependence(variables)
    sums = [node for node in distinct_nodes(formula)[1:] if node.is_Add and dependence.moves(node)]
    values = {node: balls.jet(node).value for node in sums}
    return {node: value for node, value in values.items() if value.is_finite()}


def _occurs(pairs: Sequence[Pair], left: Sequence[sp.Expr], right: Sequence[sp.Expr]) -> bool:
    return any(own in left or other in right for own, other in pairs)
