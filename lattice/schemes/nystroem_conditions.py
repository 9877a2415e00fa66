"""Conditions of order and of phase lag of Nystroem methods, for splittings of y'' = f(y).

A method with nodes c_i, inner weights a_ij, velocity weights b_i and position weights b_i (1 - c_i)
has order p when, for every tree t of special Nystroem type,

    sum_i b_i Phi_i(t) = int_0^1 phi_t,                  size(t) <= p
    sum_i b_i (1 - c_i) Phi_i(t) = int_0^1 (1 - u) phi_t(u) du,    size(t) <= p - 1

(Hairer, Norsett, Wanner, Solving ODEs I, section II.14). A tree is a number of velocity leaves and
a multiset of branches: Phi_i = c_i^leaves prod sum_j a_ij Phi_j(branch), and phi_t is the same with
the exact double integral instead of a, a monomial in u.

A symmetric splitting turns y'' = -y in a step z by the angle arccos p(z), where p is half the trace
of its step. It has phase-lag order q when p(z) = cos z + O(z^(q + 2)) (van der Houwen, Sommeijer,
SIAM J. Numer. Anal. 24 (1987) 595); waves of small amplitude then run at the right speed to that
order, whatever the order of the method.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from itertools import accumulate
from math import factorial

NystroemTree = tuple[int, tuple["NystroemTree", ...]]


def size(tree: NystroemTree) -> int:
    """The power of h that the tree stands for in the velocity."""
    leaves, branches = tree
    return 1 + leaves + sum(1 + size(branch) for branch in branches)


@cache
def nystroem_trees(order: int) -> tuple[NystroemTree, ...]:
    """All trees of that size.

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
    """Multisets of branches; a branch weighs its size and one, at most ``largest``."""
    if weight == 0:
        return ((),)
    found: set[tuple[NystroemTree, ...]] = set()
    for first in range(2, min(weight, largest) + 1):
        for tree in nystroem_trees(first - 1):
            for rest in _forests(weight - first, first):
                found.add(tuple(sorted((tree, *rest))))
    return tuple(sorted(found))


def splitting_defect(drifts: Sequence[str], kicks: Sequence[str], order: int) -> float:
    """Largest deviation from the order conditions of a drift-kick splitting, in exact arithmetic.

    ``drifts`` (one longer than ``kicks``) and ``kicks`` are decimal literals.

    >>> splitting_defect(["0.5", "0.5"], ["1"], 2)
    0.0
    """
    nodes = list(accumulate(Fraction(drift) for drift in drifts))[: len(kicks)]
    weights = [Fraction(kick) for kick in kicks]
    worst = abs(sum(map(Fraction, drifts), Fraction(0)) - 1)
    for grown in range(1, order + 1):
        for tree in nystroem_trees(grown):
            values, factor = _stages(tree, nodes, weights)
            exact = factor / grown
            found = sum((b * value for b, value in zip(weights, values, strict=True)), Fraction(0))
            worst = max(worst, abs(found - exact))
            if grown < order:
                found -= sum(
                    b * c * value for b, c, value in zip(weights, nodes, values, strict=True)
                )
                worst = max(worst, abs(found - exact / (grown + 1)))
    return float(worst)


def _stages(
    tree: NystroemTree, nodes: list[Fraction], weights: list[Fraction]
) -> tuple[list[Fraction], Fraction]:
    """Phi_i at all stages, and the factor of the monomial phi_t = factor u^(size - 1)."""
    leaves, branches = tree
    values = [node**leaves for node in nodes]
    factor = Fraction(1)
    for branch in branches:
        inner, part = _stages(branch, nodes, weights)
        power = size(branch)
        factor *= part / (power * (power + 1))
        for i, node in enumerate(nodes):
            values[i] *= sum(
                (weights[j] * (node - nodes[j]) * inner[j] for j in range(i)), Fraction(0)
            )
    return values, factor


def phase_lag_defect(drifts: Sequence[str], kicks: Sequence[str], phase_order: int) -> float:
    """Largest coefficient of p(z) - cos z up to z^phase_order, in exact arithmetic.

    ``drifts`` (one longer than ``kicks``) and ``kicks`` are decimal literals.

    >>> phase_lag_defect(["0.5", "0.5"], ["1"], 2), phase_lag_defect(["0.5", "0.5"], ["1"], 4)
    (0.0, 0.041666666666666664)
    """
    degree = phase_order // 2
    turn = [[Fraction(0)] * (degree + 1) for _ in range(4)]
    yy, ys, sy, ss = turn
    yy[0] = ss[0] = Fraction(1)
    for drift, kick in zip(map(Fraction, drifts), map(Fraction, [*kicks, "0"]), strict=True):
        for k in range(degree + 1):
            yy[k] += drift * sy[k]
            ys[k] += drift * ss[k]
        for k in range(degree, 0, -1):
            sy[k] -= kick * yy[k - 1]
            ss[k] -= kick * ys[k - 1]
    exact = [Fraction((-1) ** k, factorial(2 * k)) for k in range(degree + 1)]
    return float(max(abs((a + d) / 2 - c) for a, d, c in zip(yy, ss, exact, strict=True)))
