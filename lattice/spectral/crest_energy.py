"""Spread of a crest's energy between the lattices of one ring, one for each value of x mod 1.

These lattices do not interact. If a wave is hardly longer than the site spacing, its energy depends
a little on the position of its crest between two sites. Each lattice keeps its energy for ever, so
in some of them the waves are slightly larger and faster. In the frame of the wave the difference
changes its phase once per site (wavenumbers near 2 pi). Steps too long to resolve that average it
out, so that all waves run alike, and a run with a somewhat shorter step does not show it either.
The energy of a crest does. If the ring is sampled too coarsely for the energy's modes of wavenumber
2 pi, its spectrum is extrapolated.
"""

from __future__ import annotations

import math

import numpy as np

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.spectral.field_ring import TAIL_DIVISOR, FieldRing, modes_of, values_of
from longwave.lattice.spectral.lattice_ring import ring_stretches, wavenumbers
from longwave.support.real_arrays import Array

DENSITY = 4.5
"""Number of points per site that resolves the energy's modes of wavenumbers near 2 pi: 2 for the
strain, as many again for the cubic part of the force, and some spare."""

CREST_REACH = 4.0
"""Standard deviation, in sites, of the Gaussian by which a crest's energy is averaged; waves for
which the spread matters are no longer than that."""

MOST_POINTS = 2**21
"""Largest number of points on which the energy is computed."""


def crest_energy_spread(lattice: NumericLattice, state: FieldRing, axis: int) -> float:
    """Return the relative spread of a crest's energy between the lattices, one for each x mod 1.

    ``x`` is the coordinate along ``axis``.

    >>> from longwave.derive import LATTICES
    >>> from longwave.lattice.numeric_lattice import numeric_lattice
    >>> chain = numeric_lattice(LATTICES["fput"], {"K2": 1, "K3": 0, "K4": 1})
    >>> def spread(width):
    ...     x = 120.0 * (np.arange(600) / 600 - 0.5)
    ...     u = np.exp(-(x / width) ** 2)[None]
    ...     ring = FieldRing(0.0, (-60.0,), (120.0,), u, 2 * x / width**2 * u)
    ...     return crest_energy_spread(chain, ring, 0)
    >>> [f"{spread(width):.0e}" for width in (1.5, 2.0, 3.0)]
    ['6e-03', '3e-04', '1e-08']
    """
    counts = list(state.counts)
    points = DENSITY * state.circumferences[axis]
    counts[axis] = max(2 * counts[axis], math.ceil(points))
    if math.prod(counts) > MOST_POINTS:
        counts[axis] = 2 * state.counts[axis]
    dense = state.sampled(tuple(counts))
    energy = _energy(lattice, dense)
    magnitudes = np.abs(np.fft.rfft(energy, axis=axis, norm="forward"))
    spectrum = np.sum(magnitudes, axis=tuple(a for a in range(magnitudes.ndim) if a != axis))
    k = 2.0 * math.pi / state.circumferences[axis] * np.arange(spectrum.size)
    crest = _largest_crest(energy, dense, axis)
    if not crest > 0.0:
        return 0.0
    top = 2.0 * math.pi
    if k[-1] >= top + 1.0 / CREST_REACH:
        near = np.exp(-0.5 * (CREST_REACH * (k - top)) ** 2)
        return float(2.0 * np.sum(near * spectrum)) / crest
    tail = float(2.0 * np.sum(spectrum[-max(spectrum.size // TAIL_DIVISOR, 1) :])) / crest
    return float(min(tail, 1.0) ** (top / k[-1]))


def _energy(lattice: NumericLattice, state: FieldRing) -> Array:
    """Return the energy at each point, minus that of the mean strain and the conserved linear part.

    For a lattice of strains, whose mean is in the state, the kinetic energy is assumed equal to the
    potential one.
    """
    stored, has_displacements = np.zeros(state.counts), lattice.conserves_energy
    for bond, stretch in zip(lattice.bonds, ring_stretches(lattice, state), strict=True):
        mean = 0.0 if has_displacements else float(np.mean(stretch))
        offset = np.array(bond.offset + mean)
        with np.errstate(all="ignore"):
            stored += bond.force.potential(stretch + bond.offset) - bond.force.potential(offset)
        stored -= bond.force(offset) * (stretch - mean)
    if not has_displacements:
        return 2.0 * stored
    masses = np.array(lattice.masses).reshape(-1, *(1,) * stored.ndim)
    return np.asarray(stored + 0.5 * np.sum(masses * state.v**2, axis=0))


def _largest_crest(energy: Array, state: FieldRing, axis: int) -> float:
    """Return the maximum of the energy averaged along the axis (`CREST_REACH`)."""
    k = wavenumbers(state)
    modes = modes_of(energy[None])
    near = np.exp(-0.5 * (CREST_REACH * k[axis]) ** 2)
    modes *= near.reshape([-1 if other == axis else 1 for other in range(energy.ndim)])
    return float(np.max(values_of(modes, state.counts[-1])))
