"""The face of every wave on a lattice: what to start the lattice from, what to compare it with.

Cells are real numbers: an array (sites,) on a chain, (axes, *sites) on a lattice of more axes.
"""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from longwave.lattice.numeric_lattice import NumericLattice, place_text
from longwave.lattice.seam import Fading
from longwave.lattice.state import Sites
from longwave.scenes.starts.initial_cells import InitialCells

if TYPE_CHECKING:
    from longwave.scenes.description.losses import LossRates
    from longwave.scenes.starts.disordered_wave import WaveDisorder

Array = NDArray[np.float64]


class LatticeWave(ABC):
    """A long wave or an envelope on a lattice with numbers.

    ``lattice``: without mean strain.  ``eps``, ``order``: the ansatz, one of `ORDERS`.  ``power``:
    what is compared is of the size ``eps**power``.  ``slow``: ``T = eps**slow t``.  ``speed``: the
    frame moves so many cells a unit of time along the first axis.  ``disorder`` is that of its
    rings, and of ``lattice``, which then has no cells: it tells of frequencies and speeds alone.
    So are the ``losses``.  ``watches_strains``: whether a run ends where waves about some strain
    cease to exist, and tells the strains that it met.
    """

    lattice: NumericLattice
    eps: float
    order: str
    power: int
    slow: int
    speed: float
    disorder: WaveDisorder | None = None
    losses: LossRates | None = None
    watches_strains: bool = False

    @abstractmethod
    def state(self, cells: ArrayLike, t: float) -> tuple[Array, Array]:
        """Fields and their time derivatives, (fields, *sites): data at the first time.

        Of displacements all of them, with what grows with the cell.
        """

    @abstractmethod
    def strain(self, cells: ArrayLike, t: float) -> Array:
        """What is compared, (quantities, *sites): the theory at a time."""

    @property
    def quantities(self) -> tuple[str, ...]:
        """What is compared, as lattice files write it: the fields themselves unless overridden."""
        here = (0,) * self.lattice.dimension
        return tuple(place_text(name, here) for name in self.lattice.fields)

    @abstractmethod
    def measured(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """The same from the periodic parts of the fields on a ring with this mean strain."""

    @cached_property
    def turn(self) -> float:
        """The unit of rates: the carrier's frequency, or the lattice's highest."""
        return self.frequency or self.lattice.highest_frequency(self.lattice.rest_slopes())

    def seen(self, f: Array, v: Array, mean_strain: tuple[float, ...]) -> Array:
        """What is compared, and its rate in the same unit: (2, quantities, *sites)."""
        rates = self.measured(v, (0.0,) * len(mean_strain)) / self.turn
        return np.stack([self.measured(f, mean_strain), rates])

    def seen_at(
        self, f: Array, v: Array, mean_strain: tuple[float, ...], places: Sequence[slice]
    ) -> Array:
        """The same in some of the cells of a ring, none of which is at its ends."""
        wide, inner = self.beside(places)
        return np.asarray(self.seen(f[:, *wide], v[:, *wide], mean_strain)[:, :, *inner])

    def beside(self, places: Sequence[slice]) -> tuple[list[slice], list[slice]]:
        """These places with those that their bonds reach, and where they are among them."""
        reach = self.lattice.reach
        wide = [slice(max(0, one.start - reach), one.stop + reach) for one in places]
        starts = [one.start - more.start for one, more in zip(places, wide, strict=True)]
        lengths = [one.stop - one.start for one in places]
        return wide, [slice(s, s + n) for s, n in zip(starts, lengths, strict=True)]

    @abstractmethod
    def support(self, t: float) -> tuple[float, float]:
        """The cells, along the first axis, between which there is a wave; infinite where it fills
        the line.
        """

    @abstractmethod
    def strained(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """The lattice about this uniform strain, one entry an axis."""

    def start(self, t: float) -> None:
        """Let what is solved for, of the next order, begin at this time; nothing unless overridden.

        To be called before anything is asked for.
        """
        return

    def crest(self, t: float) -> float | None:
        """The first quantity at the crest by the law of losses; None, unless overridden."""
        return None

    @property
    def name(self) -> str:
        """What messages call it."""
        return f"this wave on {self.lattice.name}"

    @property
    def scale(self) -> float:
        """The unit in which errors are told."""
        return float(self.eps**self.power)

    @property
    def frequency(self) -> float:
        """The carrier's; 0, unless overridden, where the wave itself is long."""
        return 0.0

    @abstractmethod
    def background(self, cells: ArrayLike, t: float) -> Array:
        """What the wave deviates from, as `strain`: the bare wave on its uniform strain."""

    def uniform(self) -> Array:
        """The strain of each quantity that the wave is added to; 0 unless overridden."""
        return np.zeros(len(self.strain(np.arange(3.0), 0.0)))

    def mean_strain(self, cells: Array, t: float) -> tuple[float, ...]:
        """What displacements grow by in a cell, on average over a ring of these cells.

        It makes their rest periodic: a soliton's displacement ends elsewhere than it began. Zero on
        every axis unless overridden.
        """
        return (0.0,) * self.lattice.dimension

    @property
    def growth_shares(self) -> tuple[float, ...]:
        """The share of the mean strain by which each field grows; all of it unless overridden."""
        return (1.0,) * len(self.lattice.fields)

    def ring(self, cells: ArrayLike, t: float) -> InitialCells:
        """The state at a time on a ring of these consecutive cells.

        Where the wave does not end, its ring has a seam, which must be farther from what is
        compared than signals come.
        """
        where = np.asarray(cells, dtype=np.float64)
        mean = self.mean_strain(where, t)
        f, v = self.state(where, t)
        axes = where if len(mean) > 1 else where[np.newaxis]
        grown = sum(slope * axis for slope, axis in zip(mean, axes, strict=True))
        f -= np.multiply.outer(self.growth_shares, grown)
        lattice = self.strained(mean)
        if self.disorder is not None:
            lattice = self.disorder.on(lattice, where)
        if self.losses is not None:
            lattice = self.losses.on(lattice, where.size)
        return InitialCells(lattice, mean, where, t, f, v)

    def seam_room(self, t: float) -> int:
        """Cells at either end of a ring in which the ends are made to meet; 0 unless overridden."""
        return 0

    def closed(self, ring: InitialCells, room: int) -> InitialCells:
        """The ring with ends that meet, made to within so many cells of either."""
        return ring.smoothed(room)

    def blended(self, ring: InitialCells, room: int) -> InitialCells:
        """A chain of strains that passes, within so many cells of either end, into its own copy.

        That is the wave as it goes on beyond the other end. Where it passes over moves with the
        wave.
        """
        if not room:
            return ring
        size, f, v = ring.cells.size, ring.f.copy(), ring.v.copy()
        angle = np.pi * (np.arange(room) + 0.5) / room
        share, slope = 0.25 * (1.0 + np.cos(angle)), -0.25 * np.pi / room * np.sin(angle)
        ends = (
            (slice(room), share, slope, size),
            (slice(-room, None), share[::-1], -slope[::-1], -size),
        )
        for near, weight, steepness, on in ends:
            copies = self.state(ring.cells[near] + on, ring.t)
            apart, turned = (copy - own[:, near] for copy, own in zip(copies, (f, v), strict=True))
            f[:, near] += weight * apart
            v[:, near] += weight * turned - self.speed * steepness * apart
        return replace(ring, f=f, v=v)

    def fading(self, t: float, speed: float) -> Fading | None:
        """What draws a ring to rest where signals of that speed have come from its seam since t.

        None unless overridden.
        """
        return None

    def amplifies_rounding(self, t: float) -> bool:
        """Whether perturbations may grow: where the wave does not end, unless overridden."""
        return math.isinf(max(map(abs, self.support(t))))

    @property
    def has_energy(self) -> bool:
        """Whether an energy of its rings is known."""
        return self.lattice.conserves_energy

    def energy(self, lattice: NumericLattice, f: Array, v: Array) -> float:
        """Kinetic and potential energy of a ring."""
        with np.errstate(all="ignore"):
            return lattice.energy(f, v)

    def far_field(self, sites: Sites, t: float) -> Array | None:
        """What is compared of the wave's true far field (quantities, sites); None where it is not
        told apart from the background."""
        return None

    def displaced(self, cells: Array, t: float) -> tuple[Array, Array, Array, Array]:
        """The first quantity of wave and background, then their slopes, which are differences."""
        at = [cells + apart for apart in (0.0, SLOPE_APART, -SLOPE_APART)]
        found = []
        for made in (self.strain, self.background):
            value, ahead, behind = (np.asarray(made(place, t)[0]) for place in at)
            found += [value, (ahead - behind) / (2.0 * SLOPE_APART)]
        return found[0], found[2], found[1], found[3]

    def stretch_range(self, times: Sequence[float]) -> Array | None:
        """The least and the largest stretch of a chain's bond at any of the times.

        None, unless overridden: they are then those of the data.
        """
        return None

    @property
    def far_speed(self) -> float | None:
        """The speed of small long waves far from the wave, with which its far field moves.

        None, unless overridden: a window that moves with the wave cannot be fed with that.
        """
        return None

    @property
    def far_fastest(self) -> float:
        """The largest group velocity of any wave far from the wave."""
        raise NotImplementedError

    @property
    def far_rates(self) -> tuple[Array, Array]:
        """What each field grows by far from the wave, from cell to cell and in a unit of time."""
        raise NotImplementedError

    def extent(self, times: Sequence[float], tolerance: float) -> tuple[float, float]:
        """Cells from the frame's origin between which a wave with a `far_speed` counts.

        At all times from the first to the last, with errors up to ``tolerance``.
        """
        raise NotImplementedError

    def rigid(self, offsets: Array, t: float) -> tuple[Array, Array]:
        """Fields without what they grow by, and their slopes from cell to cell (fields, cells).

        ``offsets`` are cells from the frame's origin at that time.
        """
        raise NotImplementedError

    def rest_slopes(self, ring: InitialCells) -> list[float]:
        """The slope of each bond's force beside the wave.

        A long wave is all but uniform about each cell, so that the ring's first one tells it.
        """
        corner = (0,) * ring.lattice.dimension
        return [float(found[corner]) for found in ring.slopes]


FARTHEST = 2.0**53
"""Cells are told apart by doubles."""


def nearest_cell(speed: float, t: float) -> int:
    """The cell nearest to where a frame has gone; ValueError if it is too far.

    >>> nearest_cell(2.0, -0.25), nearest_cell(2.0, 0.25)
    (0, 1)
    """
    place = speed * t + 0.5
    if not abs(place) < FARTHEST:
        raise ValueError(f"t must leave c t within 2^53 sites, got t = {t:g}")
    return math.floor(place)


def largest_group_velocity(lattice: NumericLattice, slopes: list[float], axis: int = 0) -> float:
    """max |dw/dk| along an axis over all branches of a lattice, forces linearised."""
    k = np.linspace(0.0, np.pi, WAVENUMBERS)
    waves = np.zeros((k.size, lattice.dimension))
    waves[:, axis] = k
    squares = lattice.squared_frequencies(waves, slopes)
    w = np.sqrt(np.maximum(squares, 0.0))
    return float(np.max(np.abs(np.diff(w, axis=0)))) / float(k[1])


def sound_speed(lattice: NumericLattice, slopes: Sequence[float], near: float) -> float:
    """The speed of waves along the first axis as they grow long: that nearest to ``near``.

    Forces are linearised with these slopes. It is extrapolated from waves of three lengths.
    """
    k = LONG_WAVE * np.array([1.0, 2.0, 4.0])
    waves = np.zeros((k.size, lattice.dimension))
    waves[:, 0] = k
    squares = lattice.squared_frequencies(waves, slopes)
    speeds = np.sqrt(np.maximum(squares, 0.0)) / k[:, np.newaxis]
    (one, two), (_, four) = itertools.pairwise(speeds)
    finer, coarser = (4.0 * one - two) / 3.0, (4.0 * two - four) / 3.0
    found = (16.0 * finer - coarser) / 15.0
    return float(found[np.argmin(np.abs(found - near))])


SLOPE_APART = 1e-3
"""Cells on either side of which the difference is a slope: a wave is much longer."""

LONG_WAVE = 0.02
"""The smallest wavenumber: what is left of dispersion is below 1e-11, of rounding 1e-12."""

WAVENUMBERS = 1025
"""Of a grid over half the zone; slopes are differences of neighbours."""
