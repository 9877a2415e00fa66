"""By how much the lattices of one ring differ, each of which stands at one x mod 1.

They do not feel each other. A wave that is hardly longer than the distance of sites has, by the
place of its crest between two sites, a little more or less energy, which each of the lattices keeps
for ever: its waves are a little larger and faster. In the frame of the wave such a difference turns
its phase once a site (the wave numbers near 2 pi). Steps that do not resolve that average it,
whatever their length, and all waves run alike: a run with a shorter step does not show it. The
energy of a crest tells the lattices apart. Where the ring is sampled too coarsely to hold the
energy's waves of number 2 pi, its spectrum is continued as it falls.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.numeric_lattice import NumericLattice
from longwave.lattice.spectral.field_ring import TAIL, FieldRing, modes_of, values_of
from longwave.lattice.spectral.lattice_ring import ring_stretches, wavenumbers

Array = NDArray[np.float64]

DENSITY = 4.5
"""Points per site that hold the energy's waves of numbers near 2 pi: 2 for the strain, as many
again for the cubic part of the force, and some."""

CREST_REACH = 4.0
"""Sites over which the energy of a crest is summed: the waves that matter are no longer."""

MOST_POINTS = 2**21
"""Points on which an energy is formed at most."""


def crest_energy_spread(lattice: NumericLattice, state: FieldRing, axis: int) -> float:
    """The relative spread of a crest's energies between the lattices at each x mod 1 of an axis.

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
    wanted = DENSITY * state.circumferences[axis]
    counts[axis] = max(2 * counts[axis], math.ceil(wanted))
    if math.prod(counts) > MOST_POINTS:
        counts[axis] = 2 * state.counts[axis]
    dense = state.sampled(tuple(counts))
    energy = _energy(lattice, dense)
    size = np.abs(np.fft.rfft(energy, axis=axis, norm="forward"))
    size = np.sum(size, axis=tuple(other for other in range(size.ndim) if other != axis))
    k = 2.0 * math.pi / state.circumferences[axis] * np.arange(size.size)
    crest = _largest_crest(energy, dense, axis)
    if not crest > 0.0:
        return 0.0
    top = 2.0 * math.pi
    if k[-1] >= top + 1.0 / CREST_REACH:
        near = np.exp(-0.5 * (CREST_REACH * (k - top)) ** 2)
        return float(2.0 * np.sum(near * size)) / crest
    share = float(2.0 * np.sum(size[-max(size.size // TAIL, 1) :])) / crest
    return float(min(share, 1.0) ** (top / k[-1]))


def _energy(lattice: NumericLattice, state: FieldRing) -> Array:
    """The energy at each point beyond that of the mean strain, whose linear part is conserved.

    Of a lattice of strains, whose mean is in the state, the kinetic energy is taken for as much as
    the potential one.
    """
    stored, moving = np.zeros(state.counts), lattice.conserves_energy
    for bond, stretch in zip(lattice.bonds, ring_stretches(lattice, state), strict=True):
        mean = 0.0 if moving else float(np.mean(stretch))
        offset = np.array(bond.offset + mean)
        with np.errstate(all="ignore"):
            stored += bond.force.potential(stretch + bond.offset) - bond.force.potential(offset)
        stored -= bond.force(offset) * (stretch - mean)
    if not moving:
        return 2.0 * stored
    masses = np.array(lattice.masses).reshape(-1, *(1,) * stored.ndim)
    return np.asarray(stored + 0.5 * np.sum(masses * state.v**2, axis=0))


def _largest_crest(energy: Array, state: FieldRing, axis: int) -> float:
    """The largest energy of a crest, averaged over some sites of the axis."""
    k = wavenumbers(state)
    modes = modes_of(energy[None])
    near = np.exp(-0.5 * (CREST_REACH * k[axis]) ** 2)
    modes *= near.reshape([-1 if other == axis else 1 for other in range(energy.ndim)])
    return float(np.max(values_of(modes, state.counts[-1])))
