"""All kinds of statements, and the one of a seed and an index."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping

import sympy as sp

from verify.subexpressions import distinct_nodes

from . import branches, complexes, constants, equations, near, vanishing, waves, wrapped
from .record import Statement
from .setting import Setting, random_setting

LONGEST = 160
"""Operations of a statement; longer ones took the prover seconds, a few of them a minute."""

Maker = Callable[[Setting], Statement | None]

KINDS: Mapping[str, tuple[Maker, float]] = {
    "source": (equations.with_source, 14),
    "annihilator": (equations.with_annihilator, 8),
    "travelling": (equations.travelling_wave, 5),
    "logarithmic": (equations.logarithmic, 4),
    "identity": (equations.identity, 12),
    "tiny change": (near.tiny_change, 10),
    "hidden term": (near.hidden_term, 14),
    "by sign": (branches.by_sign, 14),
    "by interval": (branches.by_interval, 5),
    "sliver": (branches.by_sliver, 1),
    "nested roots": (constants.nested_roots, 4),
    "nowhere defined": (vanishing.nowhere_defined, 4),
    "nearly nowhere": (vanishing.nearly_nowhere, 2),
    "conjugates": (complexes.conjugates, 4),
    "plane wave": (complexes.plane_wave, 2),
    "wrapped": (wrapped.wrapped, 2),
    "opaque": (wrapped.opaque, 0.5),
    "catalogue": (waves.catalogue_form, 2),
    "textbook": (waves.known_solution, 2),
}
"""The makers by name, each with its share."""


def statement(seed: int, index: int, kinds: tuple[str, ...] = ()) -> Statement:
    """The statement number ``index`` of the search with ``seed``, the same each time.

    ``kinds`` restricts it to some makers.

    >>> statement(0, 5) == statement(0, 5)
    True
    """
    draw = random.Random(f"{seed}:{index}")
    names = kinds or tuple(KINDS)
    while True:
        (name,) = draw.choices(names, [KINDS[name][1] for name in names])
        maker, _ = KINDS[name]
        found = maker(random_setting(draw))
        if found is not None and _is_short(found) and _is_plain(found):
            return found.numbered(seed, index)


def _is_short(found: Statement) -> bool:
    """Whether a verdict may be expected within a part of a second."""
    return bool(found.left.count_ops() + found.right.count_ops() <= LONGEST)


def _is_plain(found: Statement) -> bool:
    """Whether SymPy left no derivative of a known function, and none of a sign, behind."""
    undone = (sp.Derivative, sp.Subs, sp.DiracDelta)
    nodes = (node for side in (found.left, found.right) for node in distinct_nodes(side))
    left = (node for node in nodes if isinstance(node, undone))
    return all(found.unknown is not None and node.has(found.unknown) for node in left)
