"""A statement's formulas in the places of its unknowns, at shifted variables.

Substitution is done on nodes, so that nothing is simplified by it; what is left are the formulas'
own functions, and ``diff`` nodes, whose images the field finds.
"""

from __future__ import annotations

from collections.abc import Sequence

from .nodes import Nodes


class Substitution:
    """``formulas``, without derivatives and unknowns, for the unknowns of the same places."""

    def __init__(self, nodes: Nodes, variables: Sequence[int], formulas: Sequence[int]) -> None:
        self._nodes, self._variables, self._formulas = nodes, variables, formulas
        self._images: dict[int, int] = {}
        self._shifted: dict[tuple[tuple[int, ...], int], int] = {}

    def __call__(self, node: int) -> int:
        """The node with the formulas put in."""
        for inner in self._nodes.below([node]):
            match self._nodes.all[inner]:
                case ("unknown", place, shifts):
                    self._images[inner] = self.shifted(self._formulas[place], shifts)
                case _:
                    self._images[inner] = self._nodes.rebuilt(inner, self._images.__getitem__)
        return self._images[node]

    def shifted(self, node: int, shifts: tuple[int, ...]) -> int:
        """A formula with ``variable + shift`` for each variable."""
        if not any(shifts):
            return node
        for inner in self._nodes.below([node]):
            if (shifts, inner) not in self._shifted:
                self._shifted[shifts, inner] = self._moved(inner, shifts)
        return self._shifted[shifts, node]

    def _moved(self, node: int, shifts: tuple[int, ...]) -> int:
        if node in self._variables:
            step = shifts[self._variables.index(node)]
            return self._nodes.made("Add", node, self._nodes.rational(step)) if step else node
        return self._nodes.rebuilt(node, lambda inner: self._shifted[shifts, inner])
