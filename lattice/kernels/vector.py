"""The fused stages of a splitting scheme on rows of sites, as vector code and as plain loops.

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
"""

import os
from functools import lru_cache
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from solutions.run.jit import Intrinsic, njit

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


WRITER = "lattice.kernels.vector_code"
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
        from lattice.kernels import vector_code

        kinds = (y, s, forces, drifts, kicks, level, first, past, K2, K3, K4)
        return vector_code.stages(together, kinds)

    return Intrinsic(stages, needs=WRITER, otherwise=(plain_stage, plain_pair)[together - 1])


stage, pair = plain_stage, plain_pair
if not _told_plain():
    stage, pair = _vector_stages(1), _vector_stages(2)
