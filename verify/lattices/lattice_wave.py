"""The face of every wave on a lattice: what to start the lattice from, what to compare it with.

Cells are real numbers: an array (sites,) on a chain, (axes, *sites) on a lattice of more axes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lattice.numeric_lattice import NumericLattice

Array = NDArray[np.float64]

ORDERS = ("leading", "slaved", "corrected")
"""What the data hold: the wave alone; the fields that follow it too; the next order as well."""


@dataclass(frozen=True)
class RingState:
    """A state on a ring of cells: ``cells`` are consecutive along each axis, ``f`` and ``v`` of
    shape (fields, *sites).

    ``f`` is periodic: of displacements it is what ``mean_strain`` times the cells leaves, and
    ``lattice`` has the bonds stretched by it. A kernel is given ``lattice``, ``f`` and ``v``.
    """

    lattice: NumericLattice
    mean_strain: tuple[float, ...]
    cells: Array
    t: float
    f: Array
    v: Array

    def whole(self, f: ArrayLike) -> Array:
        """The fields where their periodic parts, of this ring at a later time, are ``f``."""
        return np.asarray(f, dtype=np.float64) + _growth(self.mean_strain, self.cells)


class LatticeWave(ABC):
    """A long wave or an envelope on a lattice with numbers.

    ``lattice``: without mean strain.  ``eps``, ``order``: the ansatz, one of `ORDERS`.  ``power``:
    errors of what is compared are told in units of ``eps**power``, that of the wave itself.
    ``slow``: the power of eps in ``T = eps**slow t``.  ``speed``: the frame moves so many cells a
    unit of time along the first axis.
    """

    lattice: NumericLattice
    eps: float
    order: str
    power: int
    slow: int
    speed: float

    @abstractmethod
    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Fields and their time derivatives, (fields, *sites), at cells and a time: the data at
        the first time, the theory at later ones.

        Of displacements all of them, with what grows with the cell.
        """

    @abstractmethod
    def compared(self, f: Array) -> Array:
        """What is compared, from all fields on consecutive cells: an array (quantities, *sites)."""

    @abstractmethod
    def support(self, t: float) -> tuple[float, float]:
        """The cells, the first and the last along the first axis, between which there is a wave.

        Infinite where the wave fills the line.
        """

    @abstractmethod
    def strained(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """The lattice about this uniform strain, one entry an axis."""

    def mean_strain(self, cells: Array, t: float) -> tuple[float, ...]:
        """What displacements grow by in a cell, on average over a ring of these cells.

        It makes their rest periodic: a soliton's displacement ends elsewhere than it began. Zero on
        every axis unless overridden.
        """
        return (0.0,) * self.lattice.dimension

    def ring(self, cells: ArrayLike, t: float) -> RingState:
        """The state at a time on a ring of these consecutive cells.

        Where the wave does not end, its ring has a seam: it is then as long as signals need.
        """
        where = np.asarray(cells, dtype=np.float64)
        mean = self.mean_strain(where, t)
        f, v = self.state(where, t)
        return RingState(self.strained(mean), mean, where, t, f - _growth(mean, where), v)

    def error(self, ring: RingState, f: ArrayLike, t: float, within: NDArray[np.bool_]) -> float:
        """sup |lattice - theory| / eps**power over the cells ``within`` at a later time.

        ``f`` are the ring's periodic parts then; ``within`` says of each of its cells whether it
        is compared.
        """
        theory = self.compared(self.state(ring.cells, t)[0])
        apart = np.abs(self.compared(ring.whole(f)) - theory) / self.eps**self.power
        kept = within[tuple(slice(0, size) for size in apart.shape[1:])]
        return float(np.max(apart[:, kept]))

    def signal_speed(self, f: Array, mean_strain: tuple[float, ...]) -> float:
        """The largest group velocity of any wave about a state's stiffest and softest bonds.

        It bounds, but for tails that fall faster than exponentially, how fast a change spreads.
        """
        lattice = self.strained(mean_strain)
        stretches = lattice.stretches(f)
        pairs = zip(lattice.bonds, stretches, strict=True)
        slopes = [np.asarray(bond.force.slope(stretch)) for bond, stretch in pairs]
        ends = [[float(choose(slope)) for slope in slopes] for choose in (np.max, np.min)]
        return max(largest_group_velocity(lattice, found) for found in ends)


def _growth(mean_strain: tuple[float, ...], cells: Array) -> Array:
    axes = cells if len(mean_strain) > 1 else cells[np.newaxis]
    parts = [slope * axis for slope, axis in zip(mean_strain, axes, strict=True)]
    return np.asarray(sum(parts))


def largest_group_velocity(lattice: NumericLattice, slopes: list[float]) -> float:
    """max |dw/dk| along the first axis over all branches of a lattice, forces linearised."""
    k = np.linspace(0.0, np.pi, WAVENUMBERS)
    waves = np.zeros((k.size, lattice.dimension))
    waves[:, 0] = k
    squares = lattice.squared_frequencies(waves, slopes)
    w = np.sqrt(np.maximum(squares, 0.0))
    return float(np.max(np.abs(np.diff(w, axis=0)))) / float(k[1])


WAVENUMBERS = 1025
"""Of a grid over half the zone; slopes are differences of neighbours."""
