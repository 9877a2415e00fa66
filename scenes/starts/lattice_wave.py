"""Base class of waves on a lattice: initial data, and reference values for the comparison.

Cells are real numbers: an array (sites,) on a chain, (axes, *sites) on a lattice of several axes.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from longwave.lattice.numeric_lattice import NumericLattice, place_text
from longwave.lattice.seam import Fading
from longwave.lattice.state import Sites
from longwave.scenes.starts.initial_cells import InitialCells
from longwave.support.real_arrays import Array

if TYPE_CHECKING:
    from longwave.scenes.description.losses import LossRates
    from longwave.scenes.starts.disordered_wave import WaveDisorder


class LatticeWave(ABC):
    """Long wave or envelope on a lattice with numeric constants.

    ``lattice`` has no mean strain. ``order`` is one of `ORDERS`. The compared quantities have the
    size ``eps**power``; the slow time is ``T = eps**slow t``. ``speed`` is that of the frame along
    the first axis, in cells per unit of time. With ``disorder`` or ``losses`` runs take place on
    rings that have these, and ``lattice`` only gives frequencies and speeds. ``watches_strains``:
    whether a run ends when linear waves about some strain become unstable, and records its smallest
    and largest strain.
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
        """Return fields and time derivatives, (fields, *sites); mean growth is included."""

    @abstractmethod
    def strain(self, cells: ArrayLike, t: float) -> Array:
        """Return the theory's compared quantities at cells and a time, (quantities, *sites)."""

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the compared quantities, as in lattice files: the fields unless overridden."""
        here = (0,) * self.lattice.dimension
        return tuple(place_text(name, here) for name in self.lattice.fields)

    @abstractmethod
    def quantity_values(self, f: ArrayLike, mean_strain: tuple[float, ...]) -> Array:
        """Return the compared quantities of a ring with periodic fields and a mean strain."""

    @cached_property
    def rate_unit(self) -> float:
        """Unit of rates: the carrier's frequency, or the lattice's highest for a long wave."""
        return self.frequency or self.lattice.highest_frequency(self.lattice.rest_slopes())

    def values_and_rates(self, f: Array, v: Array, mean_strain: tuple[float, ...]) -> Array:
        """Return compared quantities, and their rates over `rate_unit`: (2, quantities, *sites)."""
        rates = self.quantity_values(v, (0.0,) * len(mean_strain)) / self.rate_unit
        return np.stack([self.quantity_values(f, mean_strain), rates])

    def values_and_rates_at(
        self, f: Array, v: Array, mean_strain: tuple[float, ...], slices: Sequence[slice]
    ) -> Array:
        """Return `values_and_rates` in a block of a ring's cells, away from the ring's ends."""
        wide, inner = self.with_neighbours(slices)
        return np.asarray(
            self.values_and_rates(f[:, *wide], v[:, *wide], mean_strain)[:, :, *inner]
        )

    def with_neighbours(self, slices: Sequence[slice]) -> tuple[list[slice], list[slice]]:
        """Return slices widened by the reach of bonds, and the given slices relative to those."""
        reach = self.lattice.reach
        wide = [slice(max(0, cells.start - reach), cells.stop + reach) for cells in slices]
        starts = [cells.start - more.start for cells, more in zip(slices, wide, strict=True)]
        lengths = [cells.stop - cells.start for cells in slices]
        return wide, [slice(s, s + n) for s, n in zip(starts, lengths, strict=True)]

    @abstractmethod
    def support(self, t: float) -> tuple[float, float]:
        """Return the wave's first and last cell on the first axis; infinite if it has no ends."""

    @abstractmethod
    def strained_lattice(self, mean_strain: tuple[float, ...]) -> NumericLattice:
        """Return the lattice about a uniform strain, which has one entry for each axis."""

    def start(self, t: float) -> None:
        """Start the next order's correction from 0 at time t; no effect unless overridden.

        Must be called before other methods of a corrected wave.
        """
        return

    def crest(self, t: float) -> float | None:
        """Return a damped soliton's first quantity at the crest by its law; None by default."""
        return None

    @property
    def name(self) -> str:
        """Name of the wave in messages."""
        return f"this wave on {self.lattice.name}"

    @property
    def scale(self) -> float:
        """Unit of errors, ``eps**power``."""
        return float(self.eps**self.power)

    @property
    def frequency(self) -> float:
        """Frequency of the carrier; 0 for a long wave."""
        return 0.0

    @abstractmethod
    def background(self, cells: ArrayLike, t: float) -> Array:
        """Return the compared quantities of the wave's background on its uniform strain."""

    def uniform(self) -> Array:
        """Return the uniform strain of each quantity; 0 unless overridden."""
        return np.zeros(len(self.strain(np.arange(3.0), 0.0)))

    def mean_strain(self, cells: Array, t: float) -> tuple[float, ...]:
        """Return the mean growth of displacements per cell over a ring of these cells.

        Displacements less this growth are periodic on the ring; a soliton's displacement, for
        example, differs between its two sides. Zero on every axis unless overridden.
        """
        return (0.0,) * self.lattice.dimension

    @property
    def growth_shares(self) -> tuple[float, ...]:
        """Ratio of each field's growth per cell to the mean strain; 1 unless overridden."""
        return (1.0,) * len(self.lattice.fields)

    def ring(self, cells: ArrayLike, t: float) -> InitialCells:
        """Return the initial state at a time on a ring of these consecutive cells.

        The ring of an infinite wave has a seam, whose signals must not reach the compared cells.
        """
        n = np.asarray(cells, dtype=np.float64)
        mean = self.mean_strain(n, t)
        f, v = self.state(n, t)
        axes = n if len(mean) > 1 else n[np.newaxis]
        growth = sum(slope * axis for slope, axis in zip(mean, axes, strict=True))
        f -= np.multiply.outer(self.growth_shares, growth)
        lattice = self.strained_lattice(mean)
        if self.disorder is not None:
            lattice = self.disorder.on(lattice, n)
        if self.losses is not None:
            lattice = self.losses.on(lattice, n.size)
        return InitialCells(lattice, mean, n, t, f, v)

    def seam_room(self, t: float) -> int:
        """Return the number of cells blended at either end of a ring; 0 unless overridden."""
        return 0

    def closed_ring(self, ring: InitialCells, room: int) -> InitialCells:
        """Return the ring with its ends blended within ``room`` cells of the seam."""
        return ring.smoothed(room)

    def blended_ring(self, ring: InitialCells, room: int) -> InitialCells:
        """Return a ring of strains, blended within ``room`` cells of either end.

        Each end is blended with the wave beyond the other end, by weights that move with the wave.
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
        for near, weight, steepness, shift in ends:
            copies = self.state(ring.cells[near] + shift, ring.t)
            df, dv = (copy - own[:, near] for copy, own in zip(copies, (f, v), strict=True))
            f[:, near] += weight * df
            v[:, near] += weight * dv - self.speed * steepness * df
        return replace(ring, f=f, v=v)

    def fading(self, t: float, speed: float) -> Fading | None:
        """Return the damping of cells that seam signals of this speed reach; None by default."""
        return None

    def amplifies_rounding(self, t: float) -> bool:
        """Return whether perturbations may grow; by default they may on an infinite wave."""
        return math.isinf(max(map(abs, self.support(t))))

    @property
    def has_energy(self) -> bool:
        """Whether the energy of the wave's rings is known."""
        return self.lattice.conserves_energy

    def energy(self, lattice: NumericLattice, f: Array, v: Array) -> float:
        """Return the kinetic and potential energy of a ring."""
        with np.errstate(all="ignore"):
            return lattice.energy(f, v)

    def far_field(self, sites: Sites, t: float) -> Array | None:
        """Return the true far field, (quantities, sites); None if it equals the background."""
        return None

    def values_and_slopes(self, cells: Array, t: float) -> tuple[Array, Array, Array, Array]:
        """Return the first quantity of wave and background, then the slopes of both per cell."""
        points = [cells + shift for shift in (0.0, SLOPE_STEP, -SLOPE_STEP)]
        results = []
        for function in (self.strain, self.background):
            value, upper, lower = (np.asarray(function(point, t)[0]) for point in points)
            results += [value, (upper - lower) / (2.0 * SLOPE_STEP)]
        return results[0], results[2], results[1], results[3]

    def stretch_range(self, times: Sequence[float]) -> Array | None:
        """Return smallest and largest stretch of the bonds over all times; None if not known."""
        return None

    @property
    def far_speed(self) -> float | None:
        """Speed of sound far from the wave; None, the default, if the wave cannot feed a window."""
        return None

    @property
    def far_fastest(self) -> float:
        """Largest group velocity of linear waves far from the wave."""
        raise NotImplementedError

    @property
    def far_rates(self) -> tuple[Array, Array]:
        """Growth of each field far from the wave, per cell and per unit of time."""
        raise NotImplementedError

    def extent(self, times: Sequence[float], tolerance: float) -> tuple[float, float]:
        """Return the ends of a wave with a `far_speed`, in cells from the frame's origin.

        Beyond them the wave is at all times negligible for errors up to ``tolerance``.
        """
        raise NotImplementedError

    def rigid_fields(self, offsets: Array, t: float) -> tuple[Array, Array]:
        """Return fields and slopes per cell at ``offsets`` from the frame's origin at time t.

        The growth of the far field from cell to cell is subtracted from both.
        """
        raise NotImplementedError

    def rest_slopes(self, ring: InitialCells) -> list[float]:
        """Return the slope of each bond's force far from the wave: in the ring's first cell."""
        corner = (0,) * ring.lattice.dimension
        return [float(slopes[corner]) for slopes in ring.slopes]


FARTHEST_CELL = 2.0**53
"""Largest cell number up to which all whole numbers are exact doubles."""


def nearest_cell(speed: float, t: float) -> int:
    """Return the cell nearest to a frame's origin at time t; ValueError beyond `FARTHEST_CELL`.

    >>> nearest_cell(2.0, -0.25), nearest_cell(2.0, 0.25)
    (0, 1)
    """
    position = speed * t + 0.5
    if not abs(position) < FARTHEST_CELL:
        raise ValueError(f"t must leave c t within 2^53 sites, got t = {t:g} (end earlier)")
    return math.floor(position)


def largest_group_velocity(lattice: NumericLattice, slopes: list[float], axis: int = 0) -> float:
    """Return max |dw/dk| along an axis over all branches, for forces with these slopes."""
    k = np.linspace(0.0, np.pi, WAVENUMBER_COUNT)
    w = _frequencies(lattice, slopes, k, axis)
    return float(np.max(np.abs(np.diff(w, axis=0)))) / float(k[1])


def _frequencies(lattice: NumericLattice, slopes: Sequence[float], k: Array, axis: int) -> Array:
    """Return the frequencies of waves along an axis, (wavenumbers, branches); 0 if imaginary."""
    waves = np.zeros((k.size, lattice.dimension))
    waves[:, axis] = k
    return np.sqrt(np.maximum(lattice.squared_frequencies(waves, slopes), 0.0))


def sound_speed(lattice: NumericLattice, slopes: Sequence[float], near: float) -> float:
    """Return the speed of infinitely long waves along the first axis that is nearest to ``near``.

    ``slopes`` are those of the bonds' forces. The speed is extrapolated from waves of three
    lengths.
    """
    k = LONG_WAVENUMBER * np.array([1.0, 2.0, 4.0])
    speeds = _frequencies(lattice, slopes, k, 0) / k[:, np.newaxis]
    one, two, four = speeds
    finer, coarser = (4.0 * one - two) / 3.0, (4.0 * two - four) / 3.0
    limits = (16.0 * finer - coarser) / 15.0
    return float(limits[np.argmin(np.abs(limits - near))])


SLOPE_STEP = 1e-3
"""Half step, in cells, of the central differences for slopes; waves are much longer."""

LONG_WAVENUMBER = 0.02
"""Smallest wavenumber from which the speed of sound is extrapolated; errors are below 1e-11."""

WAVENUMBER_COUNT = 1025
"""Number of wavenumbers in 0 .. pi; group velocities are difference quotients between them."""
