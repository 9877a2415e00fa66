"""Splitting schemes on a ring, several steps at a time while a block of sites is in the L1 cache.

The sites are laid out in rows of ``LANES``: site ``l R + r`` of a ring of ``8 R`` sites stands in
row r, lane l (dimension-lifted transposition; Henretty et al., CC 2011), and rows past the ring's
end repeat those at its beginning with the lanes moved by one. All stages of a few steps are done in
one passage over the rows: a front of blocks goes up, and in each block stage k stops one row short
of stage k - 1 (time skewing; Wonnacott, IPDPS 2000), for it needs the row above. A letter says in
which block a stage is done on a row, here with 16 rows, 5 stages and 4 rows a block::

    row 15 | D
        14 | D  D
        13 | D  D  D
        12 | D  D  D  D
        11 | C  D  D  D  D
        10 | C  C  D  D  D        block D: stage 0 on rows 12 .. 15, stage 1 on 11 .. 14, and so on;
         9 | C  C  C  D  D        these rows are in the cache for all five stages
         8 | C  C  C  C  D
         7 | B  C  C  C  C
         6 | B  B  C  C  C
         5 | B  B  B  C  C        each stage leaves one more row at either end untrue; at the end
         4 | B  B  B  B           the ring's own rows, here 6 .. 10, are true: 2 stages + 1 rows
         3 | A  B  B              are repeated beside them
         2 | A  A
         1 | A
         0 |
           +---------------
     stage   0  1  2  3  4

Nothing is computed twice except the rows about the seam, and nothing is copied except those.

A ring whose size is not divisible by ``LANES``, or that is too short for one step's stages, is left
to `plain.advance_plain`; `fits` tells.

A long ring is advanced on two cores, an arc of it on each, together with the sites about it that
its steps reach (a stage reaches one site on either side), so the two need to meet after a number of
steps only. What is computed twice is computed alike: the result is that of one core, to the bit.
"""

import multiprocessing
import os
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lattice.kernels.vector import LANES, pair, stage
from solutions.run.jit import njit

Array = NDArray[np.float64]

ROWS = 256
"""Rows by which a block moves up. 64 to 512 cost the same to 5 %; `benchmarks/lattice_constants.py`
measures this and the other constants of the room."""

STAGES = 28
"""Stages done in a passage, or one step's if they are more (13 to 52 cost the same to 5 %)."""

ALIGNMENT = 8
"""Doubles in a line of the cache."""

_jit = njit(cache=True, error_model="numpy", nogil=True)


def fits(size: int, stages: int) -> bool:
    """Whether a ring of ``size`` sites can be advanced in rows with ``stages`` stages a step.

    >>> fits(4096, 14), fits(4100, 14), fits(112, 14)
    (True, False, False)
    """
    return size % LANES == 0 and size // LANES > stages


@_jit
def _aligned(rows: int) -> Array:
    size = rows * LANES
    raw = np.zeros(size + ALIGNMENT)
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
def _repeat(rows: Array, first: int, height: int) -> None:
    """Fill the rows before and after the ring's, which stand at ``first`` and the next ones."""
    turn = LANES * height
    for r in range(first - 1, -1, -1):
        for lane in range(LANES):
            rows[LANES * r + lane] = rows[turn + LANES * r + (lane - 1) % LANES]
    for r in range(first + height, rows.size // LANES):
        for lane in range(LANES):
            rows[LANES * r + lane] = rows[LANES * r - turn + (lane + 1) % LANES]


@_jit
def _pass(
    y: Array, s: Array, forces: Array, drifts: Array, kicks: Array, *constants: float | None
) -> None:
    """All stages once over the rows; each leaves one more row at either end untrue."""
    total, stages = y.size // LANES, kicks.size
    forces[:] = 0.0
    for low in range(0, total, ROWS):
        high = min(low + ROWS, total)
        for k in range(0, stages, 2):
            first, past = max(low - k, k + 1), high - k
            both = max(first, k + 3) if k + 1 < stages else past
            if first < min(both, past):
                stage(y, s, forces, drifts, kicks, k, first, min(both, past), *constants)
            if both < past:
                pair(y, s, forces, drifts, kicks, k, both, past, *constants)


@_jit
def advance_blocked(
    ring_y: Array, ring_s: Array, drifts: Array, kicks: Array, steps: int, *constants: float | None
) -> None:
    """Advance the ring (y, s) in place by ``steps`` steps of a drift-kick splitting.

    As `plain.advance_plain`, for rings that `fits` admits: ``drifts`` (one longer than
    ``kicks``) and ``kicks`` are already multiplied by the time step.
    """
    stages = kicks.size
    height = ring_y.size // LANES
    together = max(1, min(STAGES, height - 1) // stages)
    most = together * stages
    last = drifts[stages]
    joint = drifts[:stages].copy()
    joint[0] += last
    a, b = np.empty(most), np.empty(most)
    for k in range(most):
        a[k] = joint[k % stages]
        b[k] = kicks[k % stages]
    y, s = _aligned(height + 2 * most + 1), _aligned(height + 2 * most + 1)
    forces = _aligned(2 * most)
    _to_rows(ring_y - last * ring_s, y)
    _to_rows(ring_s, s)
    first, done = 0, 0
    while done < steps:
        block = min(together, steps - done) * stages
        _repeat(y, first, height)
        _repeat(s, first, height)
        used = LANES * (height + 2 * block + 1)
        _pass(y[:used], s[:used], forces, a[:block], b[:block], *constants)
        first = block + 1
        done += block // stages
    for rows, ring in ((y, ring_y), (s, ring_s)):
        _repeat(rows, first, height)
        _from_rows(rows, ring)
    ring_y += last * ring_s


Ring = tuple[Array, Array]
Work = tuple[Array, Array, int, float, float | None, float | None]

LEAST_SITES = 16_384
"""Sites from which on the second core pays: 1.5 to 1.8 times as fast up to 65 536, on idle cores
(`benchmarks/lattice_constants.py`)."""

MEETING = 64
"""Most steps between two meetings."""


def pays(size: int) -> bool:
    """Whether a ring of that size is advanced on two cores.

    Not in a worker process: there the other core has work of its own.
    """
    if size < LEAST_SITES:
        return False
    return (os.cpu_count() or 1) > 1 and multiprocessing.parent_process() is None


@lru_cache(maxsize=1)
def _other_core() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(1, thread_name_prefix="arc")


def advance_on_two_cores(
    ring_y: Array,
    ring_s: Array,
    drifts: Array,
    kicks: Array,
    steps: int,
    *constants: *tuple[float, float | None, float | None],
) -> None:
    """Advance the ring (y, s) in place, as `advance_blocked` does with the same arguments.

    At least 4 (``MEETING`` stages + ``LANES``) sites.
    """
    last = drifts[-1]
    joint = drifts.copy()
    joint[0], joint[-1] = drifts[0] + last, 0.0
    ring, other = (ring_y - last * ring_s, ring_s.copy()), (ring_y.copy(), ring_s.copy())
    middle, done = ring_y.size // 2, 0
    while done < steps:
        block = min(MEETING, steps - done)
        work = (joint, kicks, block, *constants)
        waiting = _other_core().submit(_advance_arc, ring, other, middle, ring_y.size, work)
        _advance_arc(ring, other, 0, middle, work)
        waiting.result()
        ring, other = other, ring
        done += block
    ring_y[:], ring_s[:] = ring[0] + last * ring[1], ring[1]


def _advance_arc(ring: Ring, result: Ring, first: int, past: int, work: Work) -> None:
    """Put the sites ``first`` .. ``past - 1`` of the advanced ring into ``result``."""
    _, kicks, steps, *_ = work
    reach = steps * kicks.size + 1
    total = LANES * -(-(past - first + 2 * reach) // LANES)
    places = np.arange(first - reach, first - reach + total) % ring[0].size
    y, s = (values[places] for values in ring)
    advance_blocked(y, s, *work)
    for values, found in zip((y, s), result, strict=True):
        found[first:past] = values[reach : reach + past - first]
