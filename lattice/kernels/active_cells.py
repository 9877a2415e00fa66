"""Moving part of a ring: a wave entering a chain at rest costs only as much as its own length.

A cell stays at rest while its fields and velocities, and those of the cells that act on it, are 0.
The exceptions are *sources*, cells driven from outside or by rounding errors of forces at rest;
they count as moving.
"""

from __future__ import annotations

import numpy as np

from longwave.support.real_arrays import Array, Mask

RESTING_MARGIN = 256
"""Number of cells at rest that are advanced at either end of the moving ones: 128 to 512 take the
same time to 20 % for a struck chain of 4096 grains."""

SAMPLED_CELLS = 16
"""Number of cells that `seems_still` checks before all cells are checked."""

ALONE_FRACTION = 0.5
"""Largest fraction of moving cells in a ring for which only its moving part is advanced."""


def seems_still(f: Array, v: Array) -> bool:
    """Return whether at least half of some evenly spaced cells of (fields, cells) are at rest."""
    sample = slice(None, None, max(1, f.shape[1] // SAMPLED_CELLS))
    moving = f[:, sample].any(axis=0) | v[:, sample].any(axis=0)
    return bool(2 * np.count_nonzero(moving) <= moving.size)


def moving_cells(f: Array, v: Array) -> Mask:
    """Return a mask of the cells with a nonzero field or velocity; shape (cells,)."""
    return np.logical_or(f.any(axis=0), v.any(axis=0))


def shortest_arc(cells: Mask) -> tuple[int, int]:
    """Return the first cell of the shortest arc with all True cells, and the arc's end.

    The end is one past the last cell, beyond the ring's size if the arc crosses the ring's end.
    Both are 0 if no cell is True.

    >>> shortest_arc(np.array([True, False, False, False, True, True]))
    (4, 7)
    """
    indices = np.flatnonzero(cells)
    if not indices.size:
        return 0, 0
    distances = np.diff(indices, append=indices[0] + cells.size)
    widest = int(distances.argmax())
    first, last = int(indices[(widest + 1) % indices.size]), int(indices[widest])
    return first, last + 1 if last >= first else last + 1 + cells.size
