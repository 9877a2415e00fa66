"""A state of a lattice on a ring of cells."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.trial import nudged

Array = NDArray[np.float64]


@dataclass(frozen=True)
class InitialCells:
    """A state on a ring of ``cells``, consecutive along each axis; ``f``, ``v``: (fields, *sites).

    ``f`` is periodic: of displacements it is what ``mean_strain`` times the cells leaves, and
    ``lattice`` has its bonds stretched by that.  A kernel is given ``lattice``, ``f`` and ``v``.
    """

    lattice: NumericLattice
    mean_strain: tuple[float, ...]
    cells: Array
    t: float
    f: Array
    v: Array

    @property
    def slopes(self) -> list[Array]:
        """The slope of each bond's force in each cell."""
        return self.lattice.slopes(self.lattice.stretches(self.f))

    def smoothed(self, room: int) -> InitialCells:
        """A chain of displacements whose strain and velocity pass smoothly from end to end.

        They do so within ``room`` cells of the seam; the mean strain stays.
        """
        if not room:
            return self
        share = np.sin(np.pi / 4 * (np.arange(room) + 0.5) / room) ** 2
        f, v = self.f.copy(), self.v.copy()
        strains = (f[:, 1] - f[:, 0]) - (f[:, -1] - f[:, -2])
        moved = np.cumsum(strains[:, np.newaxis] * share, axis=1)
        turned = (v[:, 0] - v[:, -1])[:, np.newaxis] * share
        f[:, -room:] += moved
        f[:, :room] += moved[:, ::-1]
        v[:, -room:] += turned
        v[:, :room] -= turned[:, ::-1]
        return replace(self, f=f, v=v)

    def nudged(self, times: float = 1.0) -> InitialCells:
        """The ring with the last digits of its state changed (`trial.nudged`)."""
        f, v = nudged(self.f, self.v, times=times)
        return replace(self, f=f, v=v)
