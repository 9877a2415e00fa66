"""What can be wrong with a state, wherever its lattice comes from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.numeric_lattice import ROUNDED, NumericLattice, zone_wavenumbers
from longwave.lattice.state import GROWTH, BlowUp, State

Array = NDArray[np.float64]

WAVES = {1: 33, 2: 9, 3: 5}
"""Of a grid over the zone at which the waves about the bonds of single cells are looked at."""

CELLS = 4096
"""Cells that are looked at at once: some 10 MB for two fields."""

TINY = 1e-300


def find_blow_up(
    lattice: NumericLattice, state: State, initial_amplitude: float | None
) -> BlowUp | None:
    """The first criterion that the state meets, None if it is sound.

    A number that is not finite; then, for a wave, whose largest stretch began with
    ``initial_amplitude`` (less the bond's offset): waves about the bonds of some cell grow, that
    is, the lattice made of such cells is unstable; or the largest stretch has grown by more than
    ``GROWTH``.
    """
    broken = ~np.all(np.isfinite(state.f) & np.isfinite(state.v), axis=0)
    if broken.any():
        return _seen("the fields are not finite", state, broken)
    if initial_amplitude is None:
        return None
    with np.errstate(all="ignore"):
        stretches = lattice.stretches(state.f)
    slopes = lattice.slopes(stretches)
    torn = ~np.all(np.isfinite(slopes), axis=0)
    if torn.any():
        return _seen("a bond is stretched beyond its force", state, torn)
    if not lattice.is_stable([float(np.min(slope)) for slope in slopes]):
        growing = _growing(lattice, slopes)
        if growing.any():
            return _seen("a bond is stretched to where waves grow", state, growing)
    pairs = zip(lattice.bonds, stretches, strict=True)
    moved = np.max([np.abs(stretch - bond.offset) for bond, stretch in pairs], axis=0)
    large = moved > GROWTH * initial_amplitude
    if large.any():
        return _seen(f"the largest stretch has grown {GROWTH:g}-fold", state, large)
    return None


def _growing(lattice: NumericLattice, slopes: list[Array]) -> NDArray[np.bool_]:
    """Whether waves grow in the lattice that has the slopes of a cell everywhere, cell by cell."""
    units = np.eye(len(slopes))
    waves = zone_wavenumbers(lattice.dimension, WAVES[lattice.dimension])
    matrices = np.array([lattice.dynamical_matrix(waves, list(unit)) for unit in units])
    flat = np.stack([slope.ravel() for slope in slopes])
    found = []
    for part in np.array_split(flat, -(-flat.shape[1] // CELLS), axis=1):
        squares = np.linalg.eigvals(np.einsum("bc,bwij->cwij", part, matrices)).real
        squares = squares.reshape(part.shape[1], -1)
        found.append(squares.min(axis=1) < -ROUNDED * np.maximum(squares.max(axis=1), TINY))
    return np.concatenate(found).reshape(slopes[0].shape)


def _seen(criterion: str, state: State, where: NDArray[np.bool_]) -> BlowUp:
    """At the first cell in their order."""
    first = np.argmax(np.roll(where, -state.left, axis=0) if state.left else where)
    return BlowUp(criterion, state.t, state.left + int(first))
