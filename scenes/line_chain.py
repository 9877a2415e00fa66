"""Waves of a lattice of two axes that are constant along lines, run as a chain.

Where the lines are those of constant ``k = s n + r m``, s and r whole, so is the lattice's motion:
a bond to the cell (i, j) further is one to ``s i + r j`` further along k.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.derive.lattice import Lattice, Stencil
from longwave.lattice.numeric_lattice import Entry, NumericLattice
from longwave.scenes.lattice_wave import LatticeWave
from longwave.scenes.long_wave_data import LongWaveData

Array = NDArray[np.float64]


def lattice_along(lattice: Lattice, steps: tuple[int, ...]) -> Lattice:
    """The chain in k of a declared lattice, for waves constant along lines.

    >>> from longwave.derive import LATTICES
    >>> lattice_along(LATTICES["square"], (3, 4)).bonds[1].stretch[0]
    Stencil(shift=(4,), weight=1, field=0)
    """

    def moved(entries: tuple[Stencil, ...]) -> tuple[Stencil, ...]:
        return tuple(replace(e, shift=(_place(e.shift, steps),)) for e in entries)

    bonds = tuple(
        replace(bond, stretch=moved(bond.stretch), action=moved(bond.action))
        for bond in lattice.bonds
    )
    return replace(lattice, bonds=bonds)


def _place(shift: tuple[int, ...], steps: tuple[int, ...]) -> int:
    return sum(step * count for step, count in zip(steps, shift, strict=True))


class LineChain(LatticeWave):
    """A long wave on two axes, constant along lines of constant ``k = steps . cell``, on its chain.

    ``steps``: whole numbers, the first not 0.  What is compared is the strain along the first axis.
    """

    def __init__(self, wave: LongWaveData, steps: tuple[int, int]) -> None:
        self._wave, self._steps, self._along = wave, steps, steps[0]
        self.eps, self.order, self.power, self.slow = wave.eps, wave.order, wave.power, wave.slow
        self.speed = wave.speed * self._along
        self.lattice = self.strained((0.0,))

    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Fields and their time derivatives at places k."""
        first = np.asarray(cells, dtype=np.float64) / self._along
        return self._wave.state(np.stack([first, np.zeros_like(first)]), t)

    def strain(self, cells: ArrayLike, t: float) -> Array:
        """What the fields grow by from a cell to the next along the first axis."""
        here = np.asarray(cells, dtype=np.float64)
        return self.state(here + self._along, t)[0] - self.state(here, t)[0]

    def background(self, cells: ArrayLike, t: float) -> Array:
        """The same of the bare wave that the wave deviates from."""
        first = np.asarray(cells, dtype=np.float64) / self._along
        return self._wave.background(np.stack([first, np.zeros_like(first)]), t)[
            : len(self.lattice.fields)
        ]

    @property
    def quantities(self) -> tuple[str, ...]:
        """What fields grow by along the first axis of the plane."""
        return self.growths()

    def measured(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """The same from the periodic parts on a ring."""
        fields = np.asarray(f, dtype=np.float64)
        return np.roll(fields, -self._along, 1) - fields + mean_strain[0] * self._along

    def support(self, t: float) -> tuple[float, float]:
        """The places k between which there is a wave."""
        low, high = self._wave.support(t)
        return low * self._along, high * self._along

    def strained(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """The chain about this strain for a step of k."""
        slopes = tuple(mean_strain[0] * step for step in self._steps)
        lattice = self._wave.strained(slopes)

        def moved(entries: tuple[Entry, ...]) -> tuple[Entry, ...]:
            return tuple(replace(e, shift=(_place(e.shift, self._steps),)) for e in entries)

        bonds = tuple(
            replace(bond, stretch=moved(bond.stretch), action=moved(bond.action))
            for bond in lattice.bonds
        )
        return replace(lattice, bonds=bonds)

    def mean_strain(self, cells: Array, t: float) -> tuple[float, ...]:
        """What displacements grow by in a step of k, on average over a ring."""
        first, last = self.state(np.array([cells[0], cells[-1] + 1.0]), t)[0][0]
        return ((last - first) / cells.size,)
