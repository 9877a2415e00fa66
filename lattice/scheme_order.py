"""Order conditions of Nystroem methods, evaluated exactly.

A method with nodes c_i, inner weights a_ij, velocity weights b_i and position weights d_i has order
p when, for every tree t of special Nystroem type,

    sum_i b_i Phi_i(t) = int_0^1 phi_t,                  size(t) <= p
    sum_i d_i Phi_i(t) = int_0^1 (1 - u) phi_t(u) du,    size(t) <= p - 1

(Hairer, Norsett, Wanner, Solving ODEs I, section II.14). A tree is a number of velocity leaves and
a multiset of branches: Phi_i = c_i^leaves prod sum_j a_ij Phi_j(branch), and phi_t is the same with
the exact double integral instead of a, a monomial in u.

A symmetric splitting turns y'' = -y in a step z by the angle arccos p(z), where p is half the trace
of its step. It has phase-lag order q when p(z) = cos z + O(z^(q + 2)) (van der Houwen, Sommeijer,
SIAM J. Numer. Anal. 24 (1987) 595). Waves of small amplitude then have the right speed to that
order, whatever the order of the method.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from math import factorial, prod
from operator import mul
from typing import NamedTuple


class NystroemTable(NamedTuple):
    """A step h of y'' = f(y), exactly: g_i = f(y + nodes_i h s + h^2 sum_j inner_ij g_j),
    then y += h s + h^2 sum outer_i g_i and s += h sum weights_i g_i."""

    nodes: Sequence[Fraction]
    inner: Sequence[Sequence[Fraction]]
    outer: Sequence[Fraction]
    weights: Sequence[Fraction]


NystroemTree = tuple[int, tuple["NystroemTree", ...]]


def _size(tree: NystroemTree) -> int:
    """Return the order of a tree: the power of h that it has in the velocity."""
    leaves, branches = tree
    return 1 + leaves + sum(1 + _size(branch) for branch in branches)


@cache
def nystroem_trees(order: int) -> tuple[NystroemTree, ...]:
    """Return all trees of size ``order``.

    >>> [len(nystroem_trees(order)) for order in (1, 2, 3, 4, 5, 6)]
    [1, 1, 2, 3, 6, 10]
    """
    return tuple(
        (leaves, branches)
        for leaves in range(order)
        for branches in _forests(order - 1 - leaves, order)
    )


@cache
def _forests(weight: int, largest: int) -> tuple[tuple[NystroemTree, ...], ...]:
    """Return all multisets of branches of total weight ``weight``, none heavier than ``largest``.

    The weight of a branch is its size + 1.
    """
    if weight == 0:
        return ((),)
    forests: set[tuple[NystroemTree, ...]] = set()
    for first in range(2, min(weight, largest) + 1):
        for tree in nystroem_trees(first - 1):
            for rest in _forests(weight - first, first):
                forests.add(tuple(sorted((tree, *rest))))
    return tuple(sorted(forests))


def nystroem_defect(table: NystroemTable, order: int) -> float:
    """Return the largest deviation from the order conditions, in exact arithmetic.

    >>> half = Fraction(1, 2)
    >>> verlet = NystroemTable([half], [[]], [half], [Fraction(1)])
    >>> nystroem_defect(verlet, 2), nystroem_defect(verlet, 3)
    (0.0, 0.16666666666666666)
    """
    worst = Fraction(0)
    for size in range(1, order + 1):
        for tree in nystroem_trees(size):
            values, factor = _stages(tree, table)
            exact = factor / size
            worst = max(worst, abs(_dot(table.weights, values) - exact))
            if size < order:
                worst = max(worst, abs(_dot(table.outer, values) - exact / (size + 1)))
    return float(worst)


def _stages(tree: NystroemTree, table: NystroemTable) -> tuple[list[Fraction], Fraction]:
    """Return Phi_i at all stages, and the factor in the monomial phi_t = factor u^(size - 1)."""
    leaves, branches = tree
    factor, below = Fraction(1), []
    for branch in branches:
        values, part = _stages(branch, table)
        factor *= part / (_size(branch) * (_size(branch) + 1))
        below.append([_dot(row, values) for row in table.inner])
    return [
        prod((values[i] for values in below), start=node**leaves)
        for i, node in enumerate(table.nodes)
    ], factor


def _dot(weights: Sequence[Fraction], values: Sequence[Fraction]) -> Fraction:
    """Return the dot product; a row may be shorter than ``values``: missing weights are 0."""
    return sum(map(mul, weights, values), Fraction(0))


def phase_lag_defect(drifts: Sequence[Fraction], kicks: Sequence[Fraction], order: int) -> float:
    """Return the largest coefficient of p(z) - cos z up to z^order, in exact arithmetic.

    >>> half = Fraction(1, 2)
    >>> phase_lag_defect([half, half], [2 * half], 2), phase_lag_defect([half, half], [2 * half], 4)
    (0.0, 0.041666666666666664)
    """
    degree = order // 2
    yy, ys, sy, ss = ([Fraction(0)] * (degree + 1) for _ in range(4))
    yy[0] = ss[0] = Fraction(1)
    for drift, kick in zip(drifts, [*kicks, Fraction(0)], strict=True):
        for k in range(degree + 1):
            yy[k] += drift * sy[k]
            ys[k] += drift * ss[k]
        for k in range(degree, 0, -1):
            sy[k] -= kick * yy[k - 1]
            ss[k] -= kick * ys[k - 1]
    exact = [Fraction((-1) ** k, factorial(2 * k)) for k in range(degree + 1)]
    return float(max(abs((a + d) / 2 - c) for a, d, c in zip(yy, ss, exact, strict=True)))
