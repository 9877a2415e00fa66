"""Splitting schemes on a ring, several steps at a time while a block of sites is in the L1 cache.

A stage is one drift and one kick,

    y += a s,    s += b D V'(y),

on rows of ``LANES`` sites. Neighbouring sites stand in neighbouring rows, so D needs no shuffles
and every load is aligned. The loop goes up the rows once: the last row's force and how much it rose
there are carried along. The force is taken in units of its highest constant, with which the kick is
multiplied instead, and D as a difference of differences: y^3 + (K2/K4) y and D take one
multiply-add, one product and two subtractions. `plain_stage` says all of that in loops.

Two stages go together, the second one row behind the first: a row then costs two loads and two
stores for both, and what is carried stays in registers. LLVM's own vectoriser does not find this
form; it takes three passes over memory. So it is written in LLVM's language here; the plain loops
take three times as long (`benchmarks/same_lattice.py`, with and without ``LONGWAVE_PLAIN_KERNELS``;
it also tells the share of the processor's multiply-adds). The code says vectors of eight doubles
and multiply-adds that may be contracted; LLVM lowers both to what the processor has: one without
AVX-512 runs the same code in halves, without AVX2 in quarters.

The plain loops are taken, and give the same numbers to the bit, where ``LONGWAVE_PLAIN_KERNELS`` is
set to anything but 0, where numba's compiler is switched off, and where this numba or llvmlite
lacks what the vector code needs; `why_plain` says why, and is empty for the vector code.

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

import os
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from longwave.support.compiled.cores import usable_cores
from longwave.support.compiled.jit import Intrinsic, njit

Array = NDArray[np.float64]

LANES = 8
"""Sites per row: one 512-bit vector of doubles, which is also a line of the cache."""

OPERATIONS = {(False, False): 4, (True, False): 6, (False, True): 6, (True, True): 7}
"""Arithmetic instructions per site and stage, by the presence of (K3, K4).

A fused multiply-add counts once: the drift 1, the force 0, 2, 2 or 3, the kick 3.
"""


@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _multiply_add(factor: float, other: float, term: float) -> float:
    """factor * other + term, rounded once where the processor can."""
    return factor * other + term


@njit(cache=True, error_model="numpy")
def _scaled_force(
    y: float, lower: float, middle: float, K3: float | None, K4: float | None
) -> float:
    """V'(y) in units of its highest constant: y, y (y + lower) or y (y (y + middle) + lower)."""
    if K4 is None:
        return y if K3 is None else y * (y + lower)
    if K3 is None:
        return y * _multiply_add(y, y, lower)
    return y * _multiply_add(y, y + middle, lower)


@njit(cache=True, error_model="numpy")
def plain_stage(
    y: Array,
    s: Array,
    forces: Array,
    drifts: Array,
    kicks: Array,
    level: int,
    first: int,
    past: int,
    K2: float,
    K3: float | None,
    K4: float | None,
) -> None:
    """Drift the rows ``first`` .. ``past - 1`` of (y, s), kick those one row lower.

    All arrays are contiguous, of doubles; the stage is number ``level`` of ``drifts`` and
    ``kicks``. Rows 2 level and 2 level + 1 of ``forces`` hold the force at the row first - 1 less
    that at the row below it, and the former, in the force's units, and at the end those for
    past - 1, so that the next call goes on where this one stopped. 1 <= first <= past; K3 or K4 is
    ``None`` when absent.
    """
    lower, middle, unit = 0.0, 0.0, K2
    if K4 is not None:
        lower, unit = K2 / K4, K4
        if K3 is not None:
            middle = K3 / K4
    elif K3 is not None:
        lower, unit = K2 / K3, K3
    a, b = drifts[level], kicks[level] * unit
    carried = forces[2 * level * LANES : 2 * (level + 1) * LANES]
    size = (past - first) * LANES
    force, rise = np.empty(LANES + size), np.empty(LANES + size)
    rise[:LANES], force[:LANES] = carried[:LANES], carried[LANES:]
    row_y, row_s = y[first * LANES :], s[first * LANES :]
    for i in range(size):
        row_y[i] = _multiply_add(a, row_s[i], row_y[i])
        force[LANES + i] = _scaled_force(row_y[i], lower, middle, K3, K4)
    below = s[(first - 1) * LANES :]
    for i in range(size):
        rise[LANES + i] = force[LANES + i] - force[i]
    for i in range(size):
        below[i] = _multiply_add(b, rise[LANES + i] - rise[i], below[i])
    carried[:LANES], carried[LANES:] = rise[size:], force[size:]


@njit(cache=True, error_model="numpy")
def plain_pair(
    y: Array,
    s: Array,
    forces: Array,
    drifts: Array,
    kicks: Array,
    level: int,
    first: int,
    past: int,
    *constants: float | None,
) -> None:
    """`plain_stage` for ``level``, and for level + 1 one row lower. 2 <= first."""
    plain_stage(y, s, forces, drifts, kicks, level, first, past, *constants)
    plain_stage(y, s, forces, drifts, kicks, level + 1, first - 1, past - 1, *constants)


WRITER = "longwave.lattice.kernels.vector_code"
"""The module that writes the vector code; it needs numba and llvmlite."""


def _told_plain() -> str:
    if os.environ.get("LONGWAVE_PLAIN_KERNELS", "0") not in ("", "0"):
        return "LONGWAVE_PLAIN_KERNELS is set"
    compiles = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
    return "" if compiles else "numba's compiler is switched off"


@lru_cache(maxsize=1)
def why_plain() -> str:
    """Why the plain loops are taken, empty if the vector code is."""
    try:
        import_module(WRITER)
    except (ImportError, AttributeError) as missing:
        lacking = f"this numba or llvmlite lacks what the vector code needs: {missing}"
        return _told_plain() or lacking
    return _told_plain()


def _vector_stages(together: int) -> Any:
    """`plain_stage` or, for 2 stages together, `plain_pair` as vector code."""

    def stages(
        _context: Any,
        y: Any,
        s: Any,
        forces: Any,
        drifts: Any,
        kicks: Any,
        level: Any,
        first: Any,
        past: Any,
        K2: Any,
        K3: Any,
        K4: Any,
    ) -> Any:
        from longwave.lattice.kernels import vector_code

        kinds = (y, s, forces, drifts, kicks, level, first, past, K2, K3, K4)
        return vector_code.stages(together, kinds)

    return Intrinsic(stages, needs=WRITER, otherwise=(plain_stage, plain_pair)[together - 1])


stage, pair = plain_stage, plain_pair
if not _told_plain():
    stage, pair = _vector_stages(1), _vector_stages(2)


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
    return size >= LEAST_SITES and usable_cores() > 1


@lru_cache(maxsize=1)
def _other_core(_: int) -> ThreadPoolExecutor:
    """Of one process: in a fork of it there are no threads."""
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
        waiting = _other_core(os.getpid()).submit(
            _advance_arc, ring, other, middle, ring_y.size, work
        )
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
