"""Order conditions of explicit Nystroem methods, for splittings of y'' = f(y).

A method with nodes c_i, inner weights a_ij, velocity weights b_i and position weights b_i (1 - c_i)
has order p when, for every tree t of special Nystroem type,

    sum_i b_i Phi_i(t) = int_0^1 phi_t,                  size(t) <= p
    sum_i b_i (1 - c_i) Phi_i(t) = int_0^1 (1 - u) phi_t(u) du,    size(t) <= p - 1

(Hairer, Norsett, Wanner, Solving ODEs I, section II.14). A tree is a number of velocity leaves and
a multiset of branches: Phi_i = c_i^leaves prod sum_j a_ij Phi_j(branch), and phi_t is the same with
the exact double integral instead of a, a monomial in u.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from itertools import accumulate

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
