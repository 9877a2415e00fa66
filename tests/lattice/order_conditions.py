"""Order conditions of time-stepping tables for any equation, not only y'' = f(y).

Two kinds of table, two algebras:

* a composition of a symmetric second-order step. The step is exp(h a_1 + h^3 a_3 + ...) with
  non-commuting a_i; the composition with the weights g_i has order p when every word in
  a_1, a_3, ... of weight <= p has in prod_i exp(g_i a_1 + g_i^3 a_3 + ...) the coefficient that
  it has in exp(a_1) (Hairer, Lubich, Wanner, Geometric Numerical Integration, III.3 and V.3);
* a Runge-Kutta table: sum_i b_i Phi_i(tree) = 1/gamma(tree) for every rooted tree of at most p
  vertices (Butcher; the same book, III.1).

Both functions return the largest defect.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from math import factorial, prod
from operator import mul

import mpmath

Word = tuple[int, ...]
Tree = tuple["Tree", ...]

DIGITS = 60


@cache
def words(weight: int) -> tuple[Word, ...]:
    """All words of odd letters with the given weight (sum of letters).

    >>> words(3)
    ((1, 1, 1), (3,))
    """
    if weight == 0:
        return ((),)
    letters = range(1, weight + 1, 2)
    return tuple((first, *rest) for first in letters for rest in words(weight - first))


def composition_defect(gammas: Sequence[str], order: int) -> float:
    """Largest deviation from the order conditions of a composition of symmetric steps.

    ``gammas`` are decimal literals, used with all their digits.

    >>> composition_defect(["1"], 2)
    0.0
    >>> composition_defect(["1"], 3)
    1.0
    """
    context = mpmath.mp.clone()
    context.dps = DIGITS
    targets = [word for weight in range(1, order + 1) for word in words(weight)]
    series = {word: context.mpf(0) for word in targets} | {(): context.mpf(1)}
    for literal in gammas:
        series = _times_exponential(series, context.mpf(literal), context)
    exact = {word: context.mpf(set(word) == {1}) / factorial(len(word)) for word in targets}
    return max(float(abs(series[word] - exact[word])) for word in targets)


def _times_exponential(
    series: dict[Word, mpmath.mpf], gamma: mpmath.mpf, context: mpmath.ctx_mp.MPContext
) -> dict[Word, mpmath.mpf]:
    """``series`` times exp(gamma a_1 + gamma^3 a_3 + ...), to the words that it holds."""
    return {
        word: context.fsum(
            series[word[:cut]] * gamma ** sum(word[cut:]) / factorial(len(word) - cut)
            for cut in range(len(word) + 1)
        )
        for word in series
    }


@cache
def trees(vertices: int) -> frozenset[Tree]:
    """All rooted trees with that many vertices; a tree is the sorted tuple of its branches.

    >>> [len(trees(n)) for n in (1, 2, 3, 4, 5)]
    [1, 1, 2, 4, 9]
    """
    if vertices == 1:
        return frozenset({()})
    return frozenset(grown for tree in trees(vertices - 1) for grown in _with_one_more_vertex(tree))


def _with_one_more_vertex(tree: Tree) -> set[Tree]:
    grown: set[Tree] = {tuple(sorted((*tree, ())))}
    for place, branch in enumerate(tree):
        others = tree[:place] + tree[place + 1 :]
        grown |= {tuple(sorted((*others, new))) for new in _with_one_more_vertex(branch)}
    return grown


def runge_kutta_defect(
    A: Sequence[Sequence[Fraction]], b: Sequence[Fraction], order: int
) -> Fraction:
    """Largest deviation from the order conditions of a Runge-Kutta table, exactly.

    >>> zero, half, one = Fraction(0), Fraction(1, 2), Fraction(1)
    >>> midpoint = ([[zero, zero], [half, zero]], [zero, one])
    >>> runge_kutta_defect(*midpoint, 2), runge_kutta_defect(*midpoint, 3)
    (Fraction(0, 1), Fraction(1, 6))
    """
    return max(
        abs(_dot(b, _weights(tree, A)) - Fraction(1, _density(tree)))
        for vertices in range(1, order + 1)
        for tree in trees(vertices)
    )


def _dot(left: Sequence[Fraction], right: Sequence[Fraction]) -> Fraction:
    return sum(map(mul, left, right), Fraction(0))


def _weights(tree: Tree, A: Sequence[Sequence[Fraction]]) -> list[Fraction]:
    """Elementary weights Phi_i(tree) of all stages i."""
    branches = [_weights(branch, A) for branch in tree]
    return [prod((_dot(row, inner) for inner in branches), start=Fraction(1)) for row in A]


def _size(tree: Tree) -> int:
    return 1 + sum(_size(branch) for branch in tree)


def _density(tree: Tree) -> int:
    return _size(tree) * prod(_density(branch) for branch in tree)
