"""What one stage computes for a lattice of two dimensions, row by row: from its data alone.

A stage drifts and kicks row after row. At the front a row is drifted; the forces of the bonds of a
row follow as soon as the last row that stretches them has drifted, the kick of a row as soon as its
last force is there. A bond's forces are kept for as many rows as they are needed.

Constants go into ``numbers``, as in `lattice.kernels.streams`; what is absent has no place.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

from longwave.lattice.kernels.streams import Law, law_of

if TYPE_CHECKING:
    from longwave.lattice.numeric_lattice import Entry, NumericLattice


class Part(NamedTuple):
    """A row's values in a sum: those of ``source`` at so many rows and columns away.

    The factor is ``sign``, or what stands in the numbers.
    """

    source: int
    row: int
    column: int
    sign: float
    number: int | None


class PlaneBond(NamedTuple):
    """A bond's force; ``depth`` is the number of rows of it that are kept."""

    stretch: tuple[Part, ...]
    offset: int | None
    law: Law
    depth: int


class Push(NamedTuple):
    """The sum of forces of one bond that kicks a ``field``, times a factor in the numbers."""

    field: int
    factor: int
    forces: tuple[Part, ...]


class PlaneFlow(NamedTuple):
    """A stage; hashable. ``rise`` and ``fall`` are the rows above and below that a kick feels.

    ``high`` is the highest row above its own that stretches any bond: forces stay so far behind the
    front. ``skew`` is the number of rows by which one stage stays behind the one before.
    ``stretched`` and ``acted`` are the columns that a force and a kick feel on either side.
    """

    fields: int
    bonds: tuple[PlaneBond, ...]
    pushes: tuple[Push, ...]
    high: int
    rise: int
    fall: int
    skew: int
    stretched: int
    acted: int

    @property
    def kept(self) -> int:
        """Rows of forces that a stage keeps."""
        return sum(bond.depth for bond in self.bonds)

    @property
    def operations(self) -> int:
        """Arithmetic instructions a cell and stage; a fused multiply-add counts once."""
        total = self.fields
        for bond in self.bonds:
            total += len(bond.stretch) - 1 + (bond.offset is not None)
            total += len(bond.law.program) or len(bond.law.factors) + bool(
                bond.law.factors and (bond.law.factors[0] is not None or bond.law.leading)
            )
        return total + sum(len(push.forces) for push in self.pushes)


@lru_cache(maxsize=64)
def plane_flow(lattice: NumericLattice) -> tuple[PlaneFlow, tuple[float, ...]]:
    """The stage of a lattice of two dimensions, and the numbers that it takes.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> names = "K2 K3 K4 H2 H3 H4".split()
    >>> square = numeric_lattice(LATTICES["square"], dict.fromkeys(names, 1))
    >>> flow, numbers = plane_flow(square)
    >>> flow.operations, flow.skew, flow.stretched, flow.acted, numbers
    (13, 1, 1, 1, (1.0,))
    """
    numbers: list[float] = []

    def number(value: float) -> int:
        if value not in numbers:
            numbers.append(value)
        return numbers.index(value)

    def parts(entries: list[Entry], sources: list[int]) -> tuple[Part, ...]:
        """The entries merged, those that cancel left out."""
        weights: dict[tuple[int, int, int], float] = {}
        for entry, source in zip(entries, sources, strict=True):
            row, column = entry.shift
            place = (source, row, column)
            weights[place] = weights.get(place, 0.0) + entry.weight
        found = []
        for place, weight in sorted(weights.items(), key=lambda item: (-item[1], item[0])):
            whole = abs(weight) == 1.0
            if weight != 0.0:
                sign = weight if whole else 1.0
                found.append(Part(*place, sign, None if whole else number(weight)))
        return tuple(found)

    bent: list[tuple[tuple[Part, ...], int | None, Law]] = []
    pushed: list[Push] = []
    for bond in lattice.bonds:
        law, unit = law_of(bond.force, number)
        if law is None:
            continue
        stretch = parts(list(bond.stretch), [entry.field for entry in bond.stretch])
        offset = number(bond.offset) if bond.offset else None
        for field, mass in enumerate(lattice.masses):
            acting = [entry for entry in bond.action if entry.field == field]
            forces = parts(acting, [len(bent)] * len(acting))
            if forces:
                pushed.append(Push(field, number(unit / mass), forces))
        bent.append((stretch, offset, law))
    return _skewed(len(lattice.fields), bent, pushed), tuple(numbers)


def _skewed(
    fields: int, bent: list[tuple[tuple[Part, ...], int | None, Law]], pushed: list[Push]
) -> PlaneFlow:
    """The stage, with what follows for its rows."""
    rows = [part.row for stretch, _, _ in bent for part in stretch]
    high, low = max([0, *rows]), min([0, *rows])
    acting = [
        [part.row for push in pushed for part in push.forces if part.source == place]
        for place in range(len(bent))
    ]
    acted = [row for found in acting for row in found]
    rise = high + max([0, *acted])
    fall = -low - min([0, *acted])
    bonds = tuple(
        PlaneBond(*bond, rise - high - min(found, default=0) + 1)
        for bond, found in zip(bent, acting, strict=True)
    )
    parts = [part for bond in bonds for part in bond.stretch]
    ends = [part for push in pushed for part in push.forces]
    columns = [max([0, *(abs(part.column) for part in found)]) for found in (parts, ends)]
    skew = max(1, rise, high - low)
    return PlaneFlow(fields, bonds, tuple(pushed), high, rise, fall, skew, *columns)
