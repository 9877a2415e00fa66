"""Splitting schemes on a ring, several steps at a time while a tile of sites is in the L1 cache.

The sites are laid out in rows of ``LANES``: site ``l R + r`` of a ring of ``4 R`` sites stands in
row r, lane l (dimension-lifted transposition; Henretty et al., CC 2011). A tile is a block of rows
with a halo of one row for each stage on either side. All stages of a few steps are done on the
tile, the trusted rows shrinking by one at each end and stage; then its rows are written to a second
ring. The halos are computed twice, about a tenth of the work; memory is touched once per tile.

A ring whose size is not divisible by ``LANES``, or that is shorter than the halo, is left to
`stencil.advance_composition`; `fits` tells.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from verify.lattice.vector import LANES, stage

Array = NDArray[np.float64]

ROWS = 512
"""Rows of a tile without its halo (measured: 256 and 1024 cost 6 % and 0 % more)."""

STAGES = 56
"""Stages done on a tile at a time, at most (at least one step's)."""

ALIGNMENT = 8
"""Doubles in a line of the cache."""

_jit = njit(cache=True, error_model="numpy", nogil=True)


def fits(size: int, stages: int) -> bool:
    """Whether a ring of ``size`` sites can be advanced by tiles with ``stages`` stages a step.

    >>> fits(4096, 14), fits(4097, 14), fits(32, 14)
    (True, False, False)
    """
    return size % LANES == 0 and size // LANES >= max(stages, 3)


@_jit
def _aligned(rows: int) -> Array:
    size = rows * LANES
    raw = np.empty(size + ALIGNMENT)
    offset = (-(raw.ctypes.data // 8)) % ALIGNMENT
    return raw[offset : offset + size]


@_jit
def _to_rows(ring: Array, rows: Array) -> None:
    height = ring.size // LANES
    for r in range(height):
        for lane in range(LANES):
            rows[LANES * r + lane] = ring[lane * height + r]


@_jit
def _from_rows(rows: Array, ring: Array) -> None:
    height = ring.size // LANES
    for r in range(height):
        for lane in range(LANES):
            ring[lane * height + r] = rows[LANES * r + lane]


@_jit
def _load(tile: Array, ring: Array, first: int, count: int) -> None:
    """Rows first .. first + count - 1 of the ring; past its ends the lanes are shifted by one."""
    height = ring.size // LANES
    for r in range(count):
        row = first + r
        turn = row // height
        row -= turn * height
        for lane in range(LANES):
            tile[LANES * r + lane] = ring[LANES * row + (lane + turn) % LANES]


@_jit
def _advance_tile(
    y: Array,
    s: Array,
    new_y: Array,
    new_s: Array,
    first: int,
    rows: int,
    drifts: Array,
    kicks: Array,
    K2: float,
    K3: float | None,
    K4: float | None,
    tile_y: Array,
    tile_s: Array,
) -> None:
    stages = kicks.size
    height = rows + 2 * stages
    _load(tile_y, y, first - stages, height)
    _load(tile_s, s, first - stages, height)
    for k in range(stages):
        low = LANES * k
        stage(tile_y[low:], tile_s[low:], height - 2 * k, drifts[k], kicks[k], K2, K3, K4)  # type: ignore[call-arg]
    begin, length = LANES * stages, LANES * rows
    new_y[LANES * first : LANES * first + length] = tile_y[begin : begin + length]
    new_s[LANES * first : LANES * first + length] = tile_s[begin : begin + length]


@_jit
def _sweep(
    y: Array,
    s: Array,
    new_y: Array,
    new_s: Array,
    drifts: Array,
    kicks: Array,
    K2: float,
    K3: float | None,
    K4: float | None,
    tile_y: Array,
    tile_s: Array,
) -> None:
    height = y.size // LANES
    for first in range(0, height, ROWS):
        rows = min(ROWS, height - first)
        _advance_tile(y, s, new_y, new_s, first, rows, drifts, kicks, K2, K3, K4, tile_y, tile_s)


@_jit
def advance_tiled(
    ring_y: Array,
    ring_s: Array,
    drifts: Array,
    kicks: Array,
    steps: int,
    K2: float,
    K3: float | None,
    K4: float | None,
) -> None:
    """Advance the ring (y, s) in place by ``steps`` steps of a drift-kick splitting.

    As `stencil.advance_composition`, for rings that `fits` admits: ``drifts`` (one longer than
    ``kicks``) and ``kicks`` are already multiplied by the time step.
    """
    stages = kicks.size
    height = ring_y.size // LANES
    together = max(1, min(STAGES, height) // stages)
    last = drifts[stages]
    y, s, new_y, new_s = (_aligned(height), _aligned(height), _aligned(height), _aligned(height))
    tile_y = _aligned(ROWS + 2 * together * stages)
    tile_s = _aligned(ROWS + 2 * together * stages)
    a, b = np.empty(together * stages), np.empty(together * stages)
    for k in range(together * stages):
        a[k] = drifts[k % stages]
        b[k] = kicks[k % stages]
        if k % stages == 0:
            a[k] += last
    _to_rows(ring_y, y)
    _to_rows(ring_s, s)
    y -= last * s
    done = 0
    while done < steps:
        block = min(together, steps - done)
        _sweep(
            y, s, new_y, new_s, a[: block * stages], b[: block * stages], K2, K3, K4, tile_y, tile_s
        )
        y, new_y = new_y, y
        s, new_s = new_s, s
        done += block
    y += last * s
    _from_rows(y, ring_y)
    _from_rows(s, ring_s)
