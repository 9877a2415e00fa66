"""Equal parts of two formulas, so that an equality can be proved part by part.

If a sum in one formula has the value of another sum in the other formula at a point, the two may
be the same function.  Where that is proved, one symbol of which nothing is known takes the place
of both; if the formulas are equal with it, they are equal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp
from flint import acb, ctx

from verify.tree import distinct_nodes, replaced

from .balls import BallEvaluator, Point
from .compilation import BITS, Compilation, compile_expressions
from .dependence import Dependence
from .jet import Shape
from .signs import Signs

DIGITS = 40

Pair = tuple[sp.Expr, sp.Expr, acb]
"""A sum of either formula and the value of both."""


@dataclass(frozen=True)
class Lemma:
    """``left`` and ``right`` are to be proved equal; ``symbol`` stands for either.

    ``value`` is a rational number close to theirs at the point where they were found.
    """

    symbol: sp.Symbol
    left: sp.Expr
    right: sp.Expr
    value: sp.Rational


def find_lemmas(
    left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol], point: Point, signs: Signs
) -> list[Lemma]:
    """The largest proper sums that differ as formulas and agree at ``point``.

    None lies in another; a sum is passed over for a smaller one that it holds and that stands
    elsewhere too.
    """
    with ctx.workprec(BITS):
        balls = BallEvaluator(Shape([(0,)]), (), point)
        sums = [_values(formula, variables, balls, signs) for formula in (left, right)]
        pairs = [
            (own, other, value)
            for own, value in sums[0].items()
            for other, image in sums[1].items()
            if own not in sums[1] and other not in sums[0] and (value - image).contains(0)
        ]
    lemmas: list[Lemma] = []
    for own, other, value in sorted(pairs, key=lambda pair: -len(distinct_nodes(pair[0]))):
        symbol = sp.Symbol(f"part_{len(lemmas) + 1}", real=True)
        shorter = (replaced(left, own, symbol), replaced(right, other, symbol))
        if shorter[0] == left or shorter[1] == right:
            continue
        inner = [pair for pair in pairs if pair[0] != own and pair[0] in distinct_nodes(own)]
        if not _occurs(inner, *map(distinct_nodes, shorter)):
            lemmas.append(Lemma(symbol, own, other, _rational(value)))
            left, right = shorter
    return lemmas


def equal_by_lemmas(
    left: sp.Expr, right: sp.Expr, variables: Sequence[sp.Symbol], point: Point, signs: Signs
) -> tuple[Compilation, Mapping[sp.Expr, sp.Expr]] | None:
    """A compilation in which both formulas have the same image, and what its symbols stand for.

    None if there are no lemmas, if one is false, or if the formulas are not equal without what
    is known of the parts.  Raises as `compile_expressions` does.
    """
    lemmas = find_lemmas(left, right, variables, point, signs)
    for lemma in lemmas:
        compiled = compile_expressions([lemma.left, lemma.right], [], variables, point, signs)
        if not agree(compiled):
            return None
        left = replaced(left, lemma.left, lemma.symbol)
        right = replaced(right, lemma.right, lemma.symbol)
    if not lemmas:
        return None
    near = {**point, **{lemma.symbol: lemma.value for lemma in lemmas}}
    compiled = compile_expressions([left, right], [], variables, near, signs)
    return (compiled, {part.symbol: part.left for part in lemmas}) if agree(compiled) else None


def agree(compiled: Compilation) -> bool:
    """Whether the two expressions of a compilation have the same image."""
    return (compiled.elements[0] - compiled.elements[1]).is_zero


def _values(
    formula: sp.Expr, variables: Sequence[sp.Symbol], balls: BallEvaluator, signs: Signs
) -> dict[sp.Expr, acb]:
    """The values of the proper sums in ``formula`` that contain a variable and are real.

    A real symbol will stand for them, so they must be real on the whole of the domains.
    """
    dependence = Dependence(variables)
    sums = [node for node in distinct_nodes(formula)[1:] if node.is_Add and dependence.moves(node)]
    values = {node: balls.jet(node).value for node in sums}
    return {n: v for n, v in values.items() if v.is_finite() and signs.is_real(n)}


def _occurs(pairs: Sequence[Pair], left: Sequence[sp.Expr], right: Sequence[sp.Expr]) -> bool:
    return any(own in left or other in right for own, other, _ in pairs)


def _rational(value: acb) -> sp.Rational:
    return sp.Rational(value.real.mid().str(DIGITS, radius=False))
