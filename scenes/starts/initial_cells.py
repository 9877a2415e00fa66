"""Initial state of a lattice on a ring of cells."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.trial import nudged
from longwave.support.real_arrays import Array


@dataclass(frozen=True)
class InitialCells:
    """Initial state on a ring of ``cells``, consecutive along each axis.

    ``f`` and ``v`` are fields and velocities, (fields, *sites).  ``f`` is periodic: displacements
    have ``mean_strain`` times the cells subtracted, and the bonds of ``lattice`` are stretched by
    that strain instead.
    """

    lattice: NumericLattice
    mean_strain: tuple[float, ...]
    cells: Array
    t: float
    f: Array
    v: Array

    @property
    def slopes(self) -> list[Array]:
        """Slope of each bond's force in each cell."""
        return self.lattice.slopes(self.lattice.stretches(self.f))

    def smoothed(self, room: int) -> InitialCells:
        """Return a chain's state blended within ``room`` cells of the seam; same mean strain."""
        if not room:
            return self
        share = np.sin(np.pi / 4 * (np.arange(room) + 0.5) / room) ** 2
        f, v = self.f.copy(), self.v.copy()
        strains = (f[:, 1] - f[:, 0]) - (f[:, -1] - f[:, -2])
        shifts = np.cumsum(strains[:, np.newaxis] * share, axis=1)
        changes = (v[:, 0] - v[:, -1])[:, np.newaxis] * share
        f[:, -room:] += shifts
        f[:, :room] += shifts[:, ::-1]
        v[:, -room:] += changes
        v[:, :room] -= changes[:, ::-1]
        return replace(self, f=f, v=v)

    def nudged(self, times: float = 1.0) -> InitialCells:
        """Return the ring with its state perturbed by ``times`` the rounding `trial.NUDGE`."""
        f, v = nudged(self.f, self.v, times=times)
        return replace(self, f=f, v=v)
