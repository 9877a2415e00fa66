"""All kinds of statements in text, and the one of a kind, a seed and a number."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from searches.texts import (
    complex_statements,
    composition_statements,
    shift_statements,
    special_statements,
    system_statements,
)
from searches.texts.text_statement import TextStatement

Maker = Callable[[random.Random], TextStatement | None]

TEXT_KINDS: Mapping[str, Sequence[tuple[Maker, float]]] = {
    "systems": system_statements.MAKERS,
    "complex": complex_statements.MAKERS,
    "compositions": composition_statements.MAKERS,
    "shifts": shift_statements.MAKERS,
    "special": special_statements.MAKERS,
}
"""The makers of each kind with their shares."""


def text_statement(kind: str, seed: int, index: int) -> TextStatement:
    """The statement number ``index`` of a kind in the search with ``seed``, the same each time.

    >>> text_statement("shifts", 0, 3) == text_statement("shifts", 0, 3)
    True
    """
    draw = random.Random(f"{kind}:{seed}:{index}")
    makers, weights = zip(*TEXT_KINDS[kind], strict=True)
    while True:
        (maker,) = draw.choices(makers, weights)
        found = maker(draw)
        if found is not None:
            return replace(found, seed=seed, index=index)
