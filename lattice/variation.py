"""Description of what differs from cell to cell of a lattice, for kernels and their streams."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from longwave.lattice.force_program import ForceProgram

MassKind = Literal["displacements", "strains"]
"""Kind of fields: displacements of masses, or strains between them."""

Pulse = tuple[int, ForceProgram | None]
"""A field that is kicked from outside, and the factor on the kick as a function of the field."""


@dataclass(frozen=True)
class Variation:
    """Variation from cell to cell: of the ``masses``, or of parts ``c G`` of the bonds' ``forces``.

    ``masses`` is the kind of the fields, None if masses are equal. ``forces`` has an entry for each
    bond, None for a bond with the same force in all cells. ``bound`` is the largest abs(deviation).
    The ``pulsed`` fields are kicked from outside in some cells. ``damped`` are the decay rates of
    the fields' velocities, ``dashpots`` the coefficients of the bonds' dashpots; either may be
    empty. Walls are cells with inverse mass 0 or, if ``walled``, cells where a last row of
    deviations is -1.
    """

    bound: float
    masses: MassKind | None = None
    forces: tuple[ForceProgram | None, ...] = ()
    pulsed: tuple[Pulse, ...] = ()
    damped: tuple[float, ...] = ()
    dashpots: tuple[float, ...] = ()
    walled: bool = False

    def rows(self, fields: int) -> int:
        """Return the number of deviations of a cell, for a lattice of ``fields`` fields."""
        return self.mass_rows(fields) + sum(f is not None for f in self.forces) + self.walled

    def mass_rows(self, fields: int) -> int:
        """Return the number of deviations of masses, which come first."""
        return fields if self.masses else 0
