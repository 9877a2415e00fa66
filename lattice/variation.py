"""What differs from cell to cell of a lattice, as kernels and their streams are told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from longwave.lattice.force_program import ForceProgram

MassKind = Literal["displacements", "strains"]
"""What moves: masses themselves, or the strains between them."""

Pulse = tuple[int, ForceProgram | None]
"""A field that is kicked from outside, and by what of itself its kick is multiplied, if any."""


@dataclass(frozen=True)
class Variation:
    """What differs from cell to cell: the ``masses``, or parts ``c G`` of the bonds' ``forces``.

    ``masses`` says what a cell's fields are, None if masses are equal; ``forces`` has an entry for
    each bond, None where it is the same in all cells. ``bound`` is the largest deviation. Those
    that are ``pulsed`` are kicked from outside in some cells. Every drift shrinks the velocities
    of ``damped`` fields at these rates, and spreads them if bonds have ``dashpots``. Walls are
    where inverse masses are 0, or, if it is ``walled``, where a last row of deviations is -1.
    """

    bound: float
    masses: MassKind | None = None
    forces: tuple[ForceProgram | None, ...] = ()
    pulsed: tuple[Pulse, ...] = ()
    damped: tuple[float, ...] = ()
    dashpots: tuple[float, ...] = ()
    walled: bool = False

    def rows(self, fields: int) -> int:
        """The deviations of a cell, of a lattice with so many fields."""
        return self.mass_rows(fields) + sum(f is not None for f in self.forces) + self.walled

    def added_fields(self, fields: int) -> int:
        """Fields that hold what differs, behind the lattice's: its rows, and where pulses act."""
        return self.rows(fields) + len(self.pulsed)

    def mass_rows(self, fields: int) -> int:
        """Those of masses, which come first."""
        return fields if self.masses else 0
