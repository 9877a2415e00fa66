"""Detection of a blown-up state: fields that are not finite, unstable bonds, runaway stretches."""

from __future__ import annotations

import numpy as np

from longwave.lattice.numeric_lattice import ROUNDED_SQUARE, NumericLattice, zone_wavenumbers
from longwave.lattice.state import GROWTH, BlowUp, State
from longwave.support.real_arrays import Array, Mask

GRID_WAVENUMBERS = {1: 33, 2: 9, 3: 5}
"""Number of wavenumbers per axis, keyed by dimension, for checking the stability of a cell."""

BATCH_CELLS = 4096
"""Number of cells checked in one batch: about 10 MB for two fields."""

MIN_SQUARE = 1e-300
"""Lower bound of the largest squared frequency, so that the stability threshold is never 0."""


def find_blow_up(lattice: NumericLattice, state: State, amplitude: float | None) -> BlowUp | None:
    """Return the first blow-up criterion that the state meets, or None if the state is sound.

    First criterion: a value is not finite. Three more apply if ``amplitude`` is given, the largest
    abs(stretch - offset) of a bond at the start: the slope of a bond's force is not finite; waves
    grow in the uniform lattice whose bonds all have the slopes of one cell; or the largest
    abs(stretch - offset) exceeds ``GROWTH * amplitude``.
    """
    broken = ~np.all(np.isfinite(state.f) & np.isfinite(state.v), axis=0)
    if broken.any():
        return _blow_up_at("the fields are not finite", state, broken)
    if amplitude is None:
        return None
    with np.errstate(all="ignore"):
        stretches = lattice.stretches(state.f)
    slopes = lattice.slopes(stretches)
    overstretched = ~np.all(np.isfinite(slopes), axis=0)
    if overstretched.any():
        return _blow_up_at("a bond is stretched beyond its force", state, overstretched)
    if not lattice.is_stable([float(np.min(slope)) for slope in slopes]):
        unstable = _unstable_cells(lattice, slopes)
        if unstable.any():
            return _blow_up_at("a bond is stretched to where waves grow", state, unstable)
    bond_stretches = zip(lattice.bonds, stretches, strict=True)
    amplitudes = np.max([np.abs(stretch - bond.offset) for bond, stretch in bond_stretches], axis=0)
    large = amplitudes > GROWTH * amplitude
    if large.any():
        return _blow_up_at(f"the largest stretch has grown {GROWTH:g}-fold", state, large)
    return None


def _unstable_cells(lattice: NumericLattice, slopes: list[Array]) -> Mask:
    """Return a mask of the cells whose slopes, repeated in every cell, give an unstable lattice."""
    units = np.eye(len(slopes))
    waves = zone_wavenumbers(lattice.dimension, GRID_WAVENUMBERS[lattice.dimension])
    matrices = np.array([lattice.dynamical_matrix(waves, list(unit)) for unit in units])
    flat = np.stack([slope.ravel() for slope in slopes])
    masks = []
    for batch in np.array_split(flat, -(-flat.shape[1] // BATCH_CELLS), axis=1):
        squares = np.linalg.eigvals(np.einsum("bc,bwij->cwij", batch, matrices)).real
        squares = squares.reshape(batch.shape[1], -1)
        lowest = -ROUNDED_SQUARE * np.maximum(squares.max(axis=1), MIN_SQUARE)
        masks.append(squares.min(axis=1) < lowest)
    return np.concatenate(masks).reshape(slopes[0].shape)


def _blow_up_at(criterion: str, state: State, mask: Mask) -> BlowUp:
    """Return a `BlowUp` at the first cell, in site order, where the mask is set."""
    first = np.argmax(np.roll(mask, -state.left, axis=0) if state.left else mask)
    return BlowUp(criterion, state.t, state.left + int(first))
