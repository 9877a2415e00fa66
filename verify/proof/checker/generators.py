"""What a proof names of its own: generators, and which instances of the axioms to use."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from flint import fmpq, fmpq_mpoly

from .limits import CertificateError
from .ring import Element

Sum = tuple[tuple[fmpq, int], ...]
"""Coefficients and nodes."""


@dataclass(frozen=True)
class Hints:
    """Which axiom instances to use: nothing of this is believed, all of it is checked.

    ``sums[f(z)]`` writes the argument of exp, sn or theta as a combination of others,
    ``values[f]`` names what a root or an absolute value is, ``logs[log f]`` the factors of f,
    ``signs[f]`` a formula with the same image whose structure shows its sign.
    """

    sums: Mapping[int, Sum]
    values: Mapping[int, int]
    logs: Mapping[int, Sum]
    signs: Mapping[int, int]


@dataclass(frozen=True)
class Generator:
    """What a generator stands for: ``scale * node / below``, or a sum of products and a shift."""

    node: int
    scale: fmpq_mpoly | None = None
    below: int | None = None
    form: tuple[tuple[int, int], ...] = ()
    shift: int = 0

    @property
    def nodes(self) -> list[int]:
        """The nodes whose values make the generator's."""
        if self.form:
            return [self.shift, *(node for pair in self.form for node in pair)]
        return [self.node] if self.below is None else [self.node, self.below]


@dataclass(frozen=True)
class Form:
    """``factors`` of primitives, and what is added."""

    factors: tuple[int, ...]
    shift: int


def solved(table: list[list[Element]]) -> list[Element]:
    """The solution of linear equations, each row with its right-hand side; by elimination."""
    size = len(table)
    for column in range(size):
        pivot = next((i for i in range(column, size) if not table[i][column].is_zero), None)
        if pivot is None:
            raise CertificateError("linear forms must be independent")
        table[column], table[pivot] = table[pivot], table[column]
        unit = table[column][column].inverse()
        table[column] = [entry * unit for entry in table[column]]
        for i in range(size):
            factor = table[i][column]
            if i != column and not factor.is_zero:
                pairs = zip(table[i], table[column], strict=True)
                table[i] = [entry - factor * other for entry, other in pairs]
    return [row[-1] for row in table]
