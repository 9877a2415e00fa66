"""Splitting schemes on a ring of any chain, by machine code that is written for it.

A stage is one drift and one kick, ``f += a v`` and ``v += b f''``. Cells are laid out in rows of
``LANES``, each a vector of doubles: lane l of N cells begins at the cell ``l N // LANES``
(dimension-lifted transposition; Henretty et al., CC 2011), so neighbouring cells stand in
neighbouring rows, stencils need no shuffles, and lanes may share one cell. Rows past the ring's end
repeat those at its beginning with the lanes moved by one.

All stages of a few steps are done in one passage over the rows: a front of blocks goes up, and in
each block a stage stops some rows short of the stage before, for it needs the rows above (time
skewing; Wonnacott, IPDPS 2000). A letter says in which block a stage is done on a row, here with 16
rows, 5 stages of nearest neighbours and 4 rows a block::

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

A long ring is advanced on two cores, an arc of it on each, together with the cells about it that
its stages reach, so the two need to meet after a number of steps only. What is computed twice is
computed alike: the result is that of one core, to the bit.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.kernels.native_code import ALIGNMENT, aligned, native_functions
from longwave.lattice.kernels.streams import Flow, varied_flow
from longwave.support.compiled.cores import other_core, usable_cores

if TYPE_CHECKING:
    from longwave.lattice.numeric_lattice import NumericLattice

Array = NDArray[np.float64]
Places = NDArray[np.int64]

LANES = 8
"""Cells per row: one vector of 512 bits, which is also a line of the cache."""

ROWS = 256
"""Rows by which a block moves up. 64 to 512 cost the same to 5 %; `benchmarks/lattice_constants.py`
measures this and the other constants."""

LEAST_ROWED = 32
"""Cells from which on they are laid out in rows of ``LANES``."""

STAGES = 28
"""Most stages done in a passage (13 to 52 cost the same to 5 %)."""

HALO = 4
"""The rows that a passage repeats at the ends are at most this part of the ring's own."""

MOST_KEPT = 12
"""Values that two stages together may keep from row to row: with the 15 of next-nearest neighbours
in the strain one stage alone is a fifth faster, with the 10 of three fields a seventh slower
on registers of eight doubles (`benchmarks/same_lattice.py`)."""

LEAST_SHARED = 16_384
"""Cells, times fields, from which on the second core pays: 1.5 to 1.8 times as fast up to 65 536,
on idle cores (`benchmarks/lattice_constants.py`)."""

MEETING = 64
"""Most steps between two meetings of the cores."""

DOUBLED = 0.2
"""Most cells that both cores compute, in units of all."""

_PASSAGES = (*[ctypes.c_void_p] * 8, *[ctypes.c_int64] * 6)
_MOVE = (*[ctypes.c_void_p] * 5, *[ctypes.c_int64] * 2)


def _together(flow: Flow) -> int:
    """The stages that go up the rows together."""
    return 2 if flow.kept(2) <= MOST_KEPT else 1


@lru_cache(maxsize=64)
def _machine_code(flow: Flow, lanes: int, count: int) -> list[Callable[..., None]]:
    """`passages`, `to_rows` and `from_rows`; on disk they are found by what is written here."""

    def written() -> str:
        from longwave.lattice.kernels.row_code import passage_text

        return passage_text(flow, lanes, _together(flow), ROWS, count)

    key = f"{flow!r} {lanes} {_together(flow)} {ROWS} {count}"
    functions = {"passages": _PASSAGES, "to_rows": _MOVE, "from_rows": _MOVE}
    return native_functions(__name__, key, written, functions)


class _Arc:
    """The cells ``first`` .. ``past - 1`` of a ring of ``size``, in rows, and room to advance them.

    ``below`` and ``above`` more cells lie beside them, whose values are untrue at the end; without
    any the arc is the whole ring.
    """

    def __init__(
        self, flow: Flow, numbers: Array, size: int, own: tuple[int, int], beside: tuple[int, int]
    ) -> None:
        (first, past), (below, above) = own, beside
        count = past - first + below + above
        self._lanes = lanes = LANES if count >= LEAST_ROWED else 1
        self._height = height = -(-count // lanes)
        together, halo = _together(flow), max(1, flow.skew + flow.below)
        self._each = max(1, min(STAGES, height // (HALO * halo)))
        self._each -= self._each % together if self._each > together else 0
        self._below, self._size = self._each * flow.below, size
        self._rows = self._below + height + self._each * flow.skew
        margin = together * flow.skew * lanes
        self._plane = margin + self._rows * lanes + ALIGNMENT
        planes = [aligned(flow.fields * self._plane) for _ in range(2)]
        carried = aligned((self._each + together) * flow.kept(together) * lanes)
        local = np.arange(lanes + 1) * count // lanes
        starts, lengths = (first - below + local[:-1]) % size, np.diff(local)
        inner = [np.clip(end - local[:-1], 0, lengths) for end in (below, below + past - first)]
        whole = [np.zeros(lanes, np.int64), np.full(lanes, height)]
        repeats = self._repeats(local[:-1], count)
        self._held: list[Any] = [*planes, carried, numbers, starts, *inner, *whole, *repeats]
        self._copies = repeats[0].size
        at = [array.ctypes.data for array in self._held]
        self._planes = [place + 8 * margin for place in at[:2]]
        self._work, self._repeated = (*self._planes, at[2]), (at[3], *at[9:])
        self._own, self._whole = (at[4], *at[5:7]), (at[4], *at[7:9])
        self._passages, self._to_rows, self._from_rows = _machine_code(
            flow, lanes, numbers.size - 1
        )

    def _repeats(self, starts: Places, count: int) -> list[Places]:
        """The places of the rows below and above the arc's own, and from where they are filled."""
        rows = np.r_[0 : self._below, self._below + self._height : self._rows]
        cells = (starts + (rows[:, None] - self._below)) % count
        lane = np.searchsorted(starts, cells, side="right") - 1
        target = rows[:, None] * self._lanes + np.arange(self._lanes)
        source = (self._below + cells - starts[lane]) * self._lanes + lane
        return [target.ravel(), source.ravel()]

    def _move(
        self, kind: Callable[..., None], ring: Array, plane: int, places: tuple[int, ...]
    ) -> None:
        """Copy cells of the fields of a ring to their rows, or back."""
        begin, stride = ring.ctypes.data, ring.strides[0]
        plane += 8 * self._below * self._lanes
        for row in range(len(ring)):
            rows = plane + 8 * row * self._plane
            kind(begin + row * stride, rows, *places, self._size, self._height)

    def load(self, f: Array, v: Array) -> None:
        """Take the cells of the ring."""
        self._move(self._to_rows, f, self._planes[0], self._whole)
        self._move(self._to_rows, v, self._planes[1], self._whole)

    def rest(self, resting: Array, fields: int) -> None:
        """Take what differs from cell to cell, as positions after the ``fields`` that move."""
        plane = self._planes[0] + 8 * fields * self._plane
        self._move(self._to_rows, resting, plane, self._whole)

    def store(self, f: Array, v: Array) -> None:
        """Put the arc's own cells where they belong in the ring."""
        self._move(self._from_rows, f, self._planes[0], self._own)
        self._move(self._from_rows, v, self._planes[1], self._own)

    def run(self, drifts: Array, kicks: Array, stages: int) -> None:
        """So many stages, their weights in turn."""
        each, period = self._each, kicks.size
        weights = [np.resize(given, period + each) for given in (drifts, kicks)]
        begins = [array.ctypes.data for array in weights]

        def passages(count: int, length: int, begun: int) -> None:
            self._passages(
                *self._work,
                *(begin + 8 * begun for begin in begins),
                *self._repeated,
                self._copies,
                self._plane,
                self._rows,
                length,
                count,
                period,
            )

        passages(stages // each, each, 0)
        if stages % each:
            passages(1, stages % each, stages // each * each % period)


class ChainKernel:
    """What advances rings of ``size`` cells of a chain, with room that is used again.

    Rings (f, v) have the shape (fields, cells) and rows that are contiguous.
    """

    def __init__(self, lattice: NumericLattice, size: int) -> None:
        ordered, variation, shares = lattice.cellwise
        self._flow, numbers, units = varied_flow(ordered, variation)
        self._numbers = np.array([*numbers, 0.0])
        self._resting = shares * np.array(units)[:, None] if units else np.empty((0, size))
        self._fields, self._size = len(lattice.fields), size
        self._arcs: list[_Arc] = []
        self._between = 0

    def advance(self, f: Array, v: Array, drifts: Array, kicks: Array, steps: int) -> None:
        """Advance in place by a drift-kick splitting.

        ``drifts`` (one longer than ``kicks``) and ``kicks`` are already multiplied by the time
        step; the last drift of a step and the first of the next are done as one.
        """
        last, joint = drifts[-1], drifts[:-1].copy()
        joint[0] += last
        if steps > 0:
            f -= last * v
            self.advance_stages(f, v, joint, kicks, steps * kicks.size)
            f += last * v

    def advance_stages(self, f: Array, v: Array, drifts: Array, kicks: Array, stages: int) -> None:
        """So many stages, ``f += drift v`` and ``v += kick f''``, their weights in turn."""
        for name, ring in (("f", f), ("v", v)):
            if ring.dtype != np.float64 or not ring.flags.c_contiguous:
                raise ValueError(
                    f"{name} must be contiguous doubles, got {ring.dtype} with strides "
                    f"{ring.strides} (np.ascontiguousarray makes them)"
                )
        between = self._stages_between(kicks.size)
        if between != self._between or not self._arcs:
            self._arcs, self._between = self._made(between), between
        first, *others = self._arcs
        if not others:
            first.load(f, v)
            first.run(drifts, kicks, stages)
            first.store(f, v)
            return
        for done in range(0, stages, between):
            work = drifts, kicks, min(between, stages - done)
            self._on_both(_Arc.load, f, v)
            self._on_both(_Arc.run, *work)
            self._on_both(_Arc.store, f, v)

    def _stages_between(self, period: int) -> int:
        """Stages between two meetings of two cores; 0 if one does all.

        One in a worker process: there the other core has work of its own.
        """
        if self._size * self._fields < LEAST_SHARED or usable_cores() < 2:
            return 0
        reach = 2 * max(1, self._flow.skew + self._flow.below) * period
        return min(MEETING, int(DOUBLED * self._size) // reach) * period

    def _made(self, between: int) -> list[_Arc]:
        half = self._size // 2
        ends = [(0, half), (half, self._size)] if between else [(0, self._size)]
        beside = between * self._flow.below, between * self._flow.skew
        arcs = [_Arc(self._flow, self._numbers, self._size, own, beside) for own in ends]
        for arc in arcs:
            arc.rest(self._resting, self._fields)
        return arcs

    def _on_both(self, do: Callable[..., None], *values: Any) -> None:
        """Have the arcs do the same, each on a core."""
        here, there = self._arcs
        waiting = other_core().submit(do, there, *values)
        do(here, *values)
        waiting.result()
