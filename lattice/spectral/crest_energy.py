"""By how much the lattices of one ring differ that do not feel each other, for any lattice.

`lattice.spectral.ring` says why that must be known: steps that do not resolve how a crest passes
the sites, in the frame that moves with it, make all these lattices run alike. The energy of a crest
tells them apart. Where the ring is sampled too coarsely to hold the waves of number 2 pi of the
energy, its spectrum is continued as it falls.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.numeric_lattice import NumericBond, NumericLattice
from longwave.lattice.spectral.field_ring import FieldRing, modes_of, values_of
from longwave.lattice.spectral.lattice_ring import ring_stretches, wavenumbers
from longwave.lattice.spectral.ring import CREST_REACH, DENSITY, TAIL

Array = NDArray[np.float64]

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

    Of a lattice of strains the kinetic energy is taken for as much as the potential one.
    """
    stored = np.zeros(state.counts)
    for bond, stretch in zip(lattice.bonds, ring_stretches(lattice, state), strict=True):
        offset = np.array(bond.offset)
        with np.errstate(all="ignore"):
            stored += bond.force.potential(stretch + offset) - bond.force.potential(offset)
        stored -= bond.force(offset) * stretch
    if not all(map(_pulls_back, lattice.bonds)):
        return 2.0 * stored
    masses = np.array(lattice.masses).reshape(-1, *(1,) * stored.ndim)
    return np.asarray(stored + 0.5 * np.sum(masses * state.v**2, axis=0))


def _pulls_back(bond: NumericBond) -> bool:
    """Whether it pulls at each displacement as much as that stretches it."""
    here = {(entry.shift, entry.field): entry.weight for entry in bond.stretch}
    there = {
        (tuple(-step for step in entry.shift), entry.field): -entry.weight for entry in bond.action
    }
    return here == there


def _largest_crest(energy: Array, state: FieldRing, axis: int) -> float:
    """The largest energy of a crest, averaged over some sites of the axis."""
    k = wavenumbers(state)
    modes = modes_of(energy[None])
    near = np.exp(-0.5 * (CREST_REACH * k[axis]) ** 2)
    modes *= near.reshape([-1 if other == axis else 1 for other in range(energy.ndim)])
    return float(np.max(values_of(modes, state.counts[-1])))
