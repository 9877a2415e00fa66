"""Splitting schemes on a ring of two dimensions, by machine code that is written for its lattice.

All stages of a few steps are done in one sweep over the rows, each some rows behind the one before,
so that the rows about the front stay in the cache. Rows past the ring's ends repeat those at the
other: each stage leaves some at either end untrue. A large ring is swept on two cores, an arc of
rows on each; what is computed twice is computed alike.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.kernels.native_code import aligned, native_functions
from longwave.lattice.kernels.plane_flow import PlaneFlow, plane_flow
from longwave.support.compiled.cores import other_core, usable_cores

if TYPE_CHECKING:
    from longwave.lattice.numeric_lattice import NumericLattice

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
        from longwave.lattice.kernels.plane_code import sweep_text

        return sweep_text(flow, lanes, count)

    key = f"{flow!r} {lanes} {count}"
    [sweep] = native_functions(__name__, key, written, {"sweep": _ARGUMENTS})
    return sweep


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
    middle = f.shape[1] // 2
    ends = [(0, middle), (middle, f.shape[1])] if _pays(f.size) else [(0, f.shape[1])]
    arcs = [_Arc(flow, numbers, f.shape, arc, each) for arc in ends]
    f -= last * v
    for arc in arcs:
        arc.take(f, v)
    for begun in range(0, total, each):
        for arc in arcs:
            arc.repeat(arcs)
        parts = [np.ascontiguousarray(part[begun : begun + each]) for part in weights]
        waiting = [other_core().submit(arc.sweep, *parts) for arc in arcs[1:]]
        arcs[0].sweep(*parts)
        for one in waiting:
            one.result()
    for arc in arcs:
        arc.give(f, v)
    f += last * v


def _together(flow: PlaneFlow, shape: tuple[int, ...], total: int) -> int:
    """The stages of a sweep."""
    halo = max(1, flow.rise + flow.fall)
    return max(1, min(STAGES, shape[1] // (HALO * halo), total))


def _pays(size: int) -> bool:
    """Whether a ring of that size is swept on two cores; not in a worker process."""
    return size >= LEAST_CELLS and usable_cores() > 1


class _Arc:
    """The rows ``first`` .. ``past - 1`` of a ring, with those about them that stages reach."""

    def __init__(
        self,
        flow: PlaneFlow,
        numbers: tuple[float, ...],
        shape: tuple[int, ...],
        ends: tuple[int, int],
        each: int,
    ) -> None:
        fields, height, self._columns = shape
        self._flow, (self._first, self._past) = flow, ends
        lanes = LANES if self._columns >= 2 * LANES else 1
        beside = -(-flow.acted // lanes) - (-flow.stretched // lanes)
        self._margin = -(-beside * lanes // LANES) * LANES
        pitch = -(-self._columns // LANES) * LANES + 2 * self._margin
        self._below = each * flow.fall
        held = np.arange(self._first - self._below, self._past + each * flow.rise)
        self._rings = aligned(2, fields, held.size, pitch)
        self._forces = aligned(each, max(flow.kept, 1), pitch)
        self._numbers = np.array([*numbers, 0.0])
        self._run = _sweep(flow, lanes, len(numbers))
        inside = (held >= self._first) & (held < self._past)
        self._repeated, self._repeating = np.flatnonzero(~inside), held[~inside] % height

    @property
    def _own(self) -> Array:
        """Positions and velocities of the arc's own cells."""
        rows = slice(self._below, self._below + self._past - self._first)
        return self._rings[:, :, rows, self._margin : self._margin + self._columns]

    def take(self, f: Array, v: Array) -> None:
        """Take the arc's rows of a ring."""
        for own, values in zip(self._own, (f, v), strict=True):
            own[:] = values[:, self._first : self._past]

    def give(self, f: Array, v: Array) -> None:
        """Put the arc's rows into a ring."""
        for own, values in zip(self._own, (f, v), strict=True):
            values[:, self._first : self._past] = own

    def repeat(self, arcs: Sequence[_Arc]) -> None:
        """Make the rows about the arc's own repeat those of the arcs that own them."""
        for arc in arcs:
            its = (self._repeating >= arc._first) & (self._repeating < arc._past)
            rows = self._repeating[its] - arc._first + arc._below
            self._rings[:, :, self._repeated[its]] = arc._rings[:, :, rows]

    def sweep(self, drifts: Array, kicks: Array) -> None:
        """Do all stages on the arc's rows, which the others' must be repeated about."""
        flow, stages = self._flow, kicks.size
        beyond = self._below - stages * flow.fall
        rings, pitch = self._rings, self._rings.shape[-1]
        self._forces[:] = 0.0
        begin = 8 * (self._margin + beyond * pitch)
        self._run(
            *(ring.ctypes.data + begin for ring in rings),
            self._forces.ctypes.data + 8 * self._margin,
            *(values.ctypes.data for values in (drifts, kicks, self._numbers)),
            rings[0, 0].size,
            pitch,
            self._forces[0].size,
            self._columns,
            self._past - self._first + stages * (flow.fall + flow.rise),
            stages,
        )
