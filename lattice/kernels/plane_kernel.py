"""Splitting schemes on a ring of two dimensions, by machine code that is written for its lattice.

All stages of a few steps are done in one sweep over the rows, each some rows behind the one before,
so that the rows about the front stay in the cache. Rows past the ring's ends repeat those at the
other: each stage leaves some at either end untrue. A large ring is swept on two cores, an arc of
rows on each; what is computed twice is computed alike.
"""

from __future__ import annotations

import ctypes
import multiprocessing
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lattice.kernels.native_code import native_function
from lattice.kernels.plane_flow import PlaneFlow, plane_flow

if TYPE_CHECKING:
    from lattice.numeric_lattice import NumericLattice

Array = NDArray[np.float64]

LANES = 8
"""Cells of a row in a vector, or 1 of shorter rows."""

STAGES = 14
"""Most stages of a sweep: 13 and 28 cost the same to 10 % with 64 to 2048 columns, 7 more."""

HALO = 4
"""The rows that a sweep repeats at the ends are at most this part of the ring's own."""

LEAST_CELLS = 32_768
"""Cells from which on the second core pays."""

_ARGUMENTS = (*[ctypes.c_void_p] * 6, *[ctypes.c_int64] * 6)


@lru_cache(maxsize=64)
def _sweep(flow: PlaneFlow, lanes: int, count: int) -> Callable[..., None]:
    """The machine code; on disk it is found by what it is written from."""

    def written() -> str:
        from lattice.kernels.plane_code import sweep_text

        return sweep_text(flow, lanes, count)

    return native_function(__name__, f"{flow!r} {lanes} {count}", written, "sweep", _ARGUMENTS)


def advance_plane(
    lattice: NumericLattice, f: Array, v: Array, drifts: Array, kicks: Array, steps: int
) -> None:
    """Advance the ring (f, v), of shape (fields, rows, columns), in place by a splitting.

    ``drifts`` (one longer than ``kicks``) and ``kicks`` are already multiplied by the time step;
    the last drift of a step and the first of the next are done as one.
    """
    if steps == 0:
        return
    last, joint = drifts[-1], drifts[:-1].copy()
    joint[0] += last
    total = steps * kicks.size
    flow, numbers = plane_flow(lattice)
    each = _together(flow, f.shape, total)
    weights = [np.resize(part, total) for part in (joint, kicks)]
    ring, other = (f - last * v, v.copy()), (np.empty_like(f), np.empty_like(v))
    middle = f.shape[1] // 2
    arcs = [(0, middle), (middle, f.shape[1])] if _pays(f.size) else [(0, f.shape[1])]
    workers = [_Arc(flow, numbers, f.shape, arc, each) for arc in arcs]
    for begun in range(0, total, each):
        parts = [np.ascontiguousarray(part[begun : begun + each]) for part in weights]
        waiting = [_other_core().submit(arc.sweep, ring, other, *parts) for arc in workers[1:]]
        workers[0].sweep(ring, other, *parts)
        for one in waiting:
            one.result()
        ring, other = other, ring
    f[:], v[:] = ring[0] + last * ring[1], ring[1]


def _together(flow: PlaneFlow, shape: tuple[int, ...], total: int) -> int:
    """The stages of a sweep."""
    halo = max(1, flow.rise + flow.fall)
    return max(1, min(STAGES, shape[1] // (HALO * halo), total))


def _pays(size: int) -> bool:
    """Whether a ring of that size is swept on two cores; not in a worker process."""
    if size < LEAST_CELLS:
        return False
    return (os.cpu_count() or 1) > 1 and multiprocessing.parent_process() is None


@lru_cache(maxsize=1)
def _other_core() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(1, thread_name_prefix="rows")


class _Arc:
    """The rows ``arc`` of a ring, with those about them that so many stages reach."""

    def __init__(
        self,
        flow: PlaneFlow,
        numbers: tuple[float, ...],
        shape: tuple[int, ...],
        arc: tuple[int, int],
        each: int,
    ) -> None:
        self._flow, self._arc = flow, arc
        fields, self._height, self._columns = shape
        self._lanes = LANES if self._columns >= 2 * LANES else 1
        self._margin = -(-max(flow.reach, 1) // LANES) * LANES
        self._pitch = -(-self._columns // LANES) * LANES + 2 * self._margin
        most = arc[1] - arc[0] + each * (flow.rise + flow.fall)
        self._f, self._v = (_aligned((fields, most, self._pitch)) for _ in range(2))
        self._forces = _aligned((each, max(flow.kept, 1), self._pitch))
        self._numbers = np.array([*numbers, 0.0])
        self._run = _sweep(flow, self._lanes, len(numbers))

    def sweep(
        self, ring: tuple[Array, Array], result: tuple[Array, Array], drifts: Array, kicks: Array
    ) -> None:
        """Put the arc's rows, advanced by all stages, into the ``result``."""
        flow, (first, past), stages = self._flow, self._arc, kicks.size
        rows = np.arange(first - stages * flow.fall, past + stages * flow.rise) % self._height
        inner = slice(self._margin, self._margin + self._columns)
        self._forces[:] = 0.0
        for held, values in zip((self._f, self._v), ring, strict=True):
            held[:, : rows.size, inner] = values[:, rows]
        begin = 8 * self._margin
        self._run(
            *(held.ctypes.data + begin for held in (self._f, self._v, self._forces)),
            *(values.ctypes.data for values in (drifts, kicks, self._numbers)),
            self._f[0].size,
            self._pitch,
            self._forces[0].size,
            self._columns,
            rows.size,
            stages,
        )
        own = slice(stages * flow.fall, stages * flow.fall + past - first)
        for held, found in zip((self._f, self._v), result, strict=True):
            found[:, first:past] = held[:, own, inner]


def _aligned(shape: tuple[int, ...]) -> Array:
    size = int(np.prod(shape))
    raw = np.zeros(size + LANES)
    offset = (-(raw.ctypes.data // 8)) % LANES
    return raw[offset : offset + size].reshape(shape)
