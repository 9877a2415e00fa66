"""All kinds of statements, and the one of a seed and an index."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import replace

import sympy as sp

from longwave.verify.subexpressions import distinct_nodes
from searches.statements import branches, perturbed, solvable
from searches.statements.random_statement import RandomStatement, Setting, random_setting
from searches.texts.drafts import shown_false
from searches.texts.text_statement import TextStatement, Truth

LONGEST = 160
"""Operations of a statement; longer ones took the prover seconds, a few of them a minute."""

Maker = Callable[[Setting], RandomStatement | None]

KINDS: Mapping[str, tuple[Maker, float]] = {
    "source": (solvable.with_source, 14),
    "annihilator": (solvable.with_annihilator, 8),
    "travelling": (solvable.travelling_wave, 5),
    "logarithmic": (solvable.logarithmic, 4),
    "identity": (solvable.identity, 12),
    "tiny change": (perturbed.tiny_change, 10),
    "hidden term": (perturbed.hidden_term, 14),
    "by sign": (branches.by_sign, 14),
    "by interval": (branches.by_interval, 5),
    "sliver": (branches.by_sliver, 1),
    "nested roots": (branches.nested_roots, 4),
    "nowhere defined": (perturbed.nowhere_defined, 4),
    "nearly nowhere": (perturbed.nearly_nowhere, 2),
    "conjugates": (branches.conjugates, 4),
    "plane wave": (branches.plane_wave, 2),
    "wrapped": (perturbed.wrapped, 2),
    "opaque": (perturbed.opaque, 0.5),
    "catalogue": (solvable.catalogue_form, 2),
    "textbook": (solvable.known_solution, 2),
}
"""The makers by name, each with its share."""


def statement(seed: int, index: int, kinds: tuple[str, ...] = ()) -> TextStatement:
    """Return the statement number ``index`` of the search with ``seed``, the same each time.

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
        if found is None or not _is_short(found) or not _is_plain(found):
            continue
        made: TextStatement | None = found.text()
        if made and made.truth is Truth.FALSE:
            made = shown_false(made, draw, made.counterexample)
        if made:
            return replace(made, seed=seed, index=index)


def _is_short(found: RandomStatement) -> bool:
    """Whether a verdict may be expected within a part of a second."""
    return bool(found.left.count_ops() + found.right.count_ops() <= LONGEST)


def _is_plain(found: RandomStatement) -> bool:
    """Whether SymPy left no derivative of a known function, and none of a sign, behind."""
    undone = (sp.Derivative, sp.Subs, sp.DiracDelta)
    nodes = (node for side in (found.left, found.right) for node in distinct_nodes(side))
    left = (node for node in nodes if isinstance(node, undone))
    return all(found.unknown is not None and node.has(found.unknown) for node in left)
