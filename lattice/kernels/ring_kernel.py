"""Splitting schemes on a ring of any chain or plane, by machine code that is written for it.

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

In a plane, "row" is a row of its cells. It is laid out in vectors as a chain is, and closed by
vectors beside it that repeat those at its other end with the lanes moved by one.

A large ring is advanced on two cores, an arc of it on each, together with the cells about it that
its stages reach, so the two need to meet after a number of stages only. What is computed twice is
computed alike: the result is that of one core, to the bit.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.kernels.streams import Flow, rows_of, varied_flow
from longwave.support.compiled.cores import other_core, usable_cores
from longwave.support.compiled.native_code import native_functions

if TYPE_CHECKING:
    from longwave.lattice.numeric_lattice import NumericLattice

Array = NDArray[np.float64]
Places = NDArray[np.int64]

LANES = 8
"""Cells per row: one vector of 512 bits, which is also a line of the cache."""

ALIGNMENT = 8
"""Doubles in a line of the cache."""

ROWS = 256
"""Rows by which a block moves up. 64 to 512 cost the same to 5 %; `benchmarks/lattice_constants.py`
measures this and the other constants."""

LEAST_ROWED = 32
"""Cells from which on they are laid out in rows of ``LANES``."""

STAGES = 28
"""Most stages done in a passage (13 to 52 cost the same to 5 %)."""

ALONG = 4
"""The same of a plane: 1 to 16 cost the same to 5 %."""

CACHED = 65_536
"""Most doubles of a plane's rows between the first stage of a passage and the last: half of the
second cache."""

HALO = 4
"""The rows that a passage repeats at the ends are at most this part of the ring's own."""

MOST_KEPT = 12
"""Values that two stages together may keep from row to row: with the 15 of next-nearest neighbours
in the strain one stage alone is a fifth faster, with the 10 of three fields a seventh slower
on registers of eight doubles (`benchmarks/same_lattice.py`)."""

LEAST_SHARED = 16_384
"""Cells, times fields, from which on the second core pays: 1.5 to 1.8 times as fast up to 65 536,
on idle cores (`benchmarks/lattice_constants.py`)."""

LEAST_WORK = 1_000_000
"""Cells, times fields and stages, between two meetings from which on it does."""

MEETING = 64
"""Most steps between two meetings of the cores."""

DOUBLED = 0.2
"""Most cells that both cores compute, in units of all."""

DRIFTED = 16_384
"""Cells that are drifted at a time."""

_PASSAGES = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 8, *[ctypes.c_int64] * 8)
_MOVE = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 5, *[ctypes.c_int64] * 5)


def _together(flow: Flow) -> int:
    """The stages that go up the rows of a chain together."""
    return 2 if flow.kept(2) <= MOST_KEPT else 1


@lru_cache(maxsize=64)
def _machine_code(flow: Flow, lanes: int, count: int, columns: int) -> list[Callable[..., None]]:
    """`passages`, `to_rows` and `from_rows`; on disk they are found by what is written here."""
    together, block = _together(flow), ALONG if columns else ROWS

    def written() -> str:
        from longwave.lattice.kernels.row_code import passage_text

        return passage_text(flow, lanes, together, block, count, columns)

    key = f"{flow!r} {lanes} {together} {block} {count} {columns}"
    functions = {"passages": _PASSAGES, "to_rows": _MOVE, "from_rows": _MOVE}
    return native_functions(__name__, key, written, functions)


def _aligned(size: int) -> Array:
    """Zeros that begin at a line of the cache."""
    raw = np.zeros(size + ALIGNMENT)
    offset = (-(raw.ctypes.data // 8)) % ALIGNMENT
    return raw[offset : offset + size]


def _drift(f: Array, v: Array, length: float) -> None:
    """``f += length v`` of contiguous rings, without room for all of ``length v``."""
    f, v = f.reshape(-1), v.reshape(-1)
    for begin in range(0, f.size, DRIFTED):
        f[begin : begin + DRIFTED] += length * v[begin : begin + DRIFTED]


class _Layout(NamedTuple):
    """How cells of a chain, or rows of a plane, are laid out, and what a stage does to them.

    Lanes begin at the cells ``starts`` and are ``vectors`` long. Of these a row has ``width``, and
    ``edge`` more at either end; there are ``height`` rows. In a passage of at most ``most`` stages
    each stays ``skew`` rows behind the one before, leaves ``below`` untrue at the lower end, and
    keeps so many rows.
    """

    lanes: int
    starts: Places
    vectors: int
    width: int
    edge: int
    height: int
    skew: int
    below: int
    kept: int
    together: int
    most: int

    @property
    def across(self) -> int:
        """Vectors from row to row."""
        return self.width + 2 * self.edge

    @property
    def pitch(self) -> int:
        """Doubles from row to row."""
        return self.across * self.lanes


def _layout(flow: Flow, count: int, columns: int) -> _Layout:
    """Of so many cells of a chain without ``columns``, or rows of a plane."""
    across = columns or count
    lanes = LANES if across >= LEAST_ROWED else 1
    starts, vectors = np.arange(lanes + 1) * across // lanes, -(-across // lanes)
    if not columns:
        together = _together(flow)
        ends = flow.skew, flow.below, flow.kept(together), together, STAGES
        return _Layout(lanes, starts, vectors, 1, 0, vectors, *ends)
    rows = rows_of(flow)
    most = CACHED // (2 * flow.fields * lanes * vectors * rows.skew)
    ends = rows.skew, rows.below, sum(rows.depths), 1, min(STAGES, most)
    return _Layout(lanes, starts, vectors, vectors, rows.margin, count, *ends)


class _Arc:
    """The cells, or rows, ``first`` .. ``past - 1`` of a ring, and room to advance them.

    ``below`` and ``above`` more lie beside them, whose values are untrue at the end; without any
    the arc is the whole ring.
    """

    def __init__(
        self,
        flow: Flow,
        numbers: Array,
        shape: tuple[int, ...],
        own: tuple[int, int],
        beside: tuple[int, int],
    ) -> None:
        (first, past), (below, above) = own, beside
        self._size, self._columns = (*shape, 0)[:2]
        self._first, self._count = first - below, past - first + below + above
        self._own, self._beside = (below, self._count - above), beside
        self._layout = layout = _layout(flow, self._count, self._columns)
        pitch, together = layout.pitch, layout.together
        ended = self._columns > 0 and below + above > 0
        halo = 0 if ended else HALO * max(1, layout.skew + layout.below)
        self._each = max(1, min(layout.most, layout.height // halo if halo else layout.most))
        self._each -= self._each % together if self._each > together else 0
        repeated = 0 if ended else self._each
        self._below = repeated * layout.below
        self._rows = self._below + layout.height + repeated * layout.skew
        edge = layout.edge * layout.lanes
        margin = together * layout.skew * pitch + edge
        self._plane = margin + self._rows * pitch + ALIGNMENT
        planes = [_aligned(flow.fields * self._plane) for _ in range(2)]
        carried = _aligned((self._each + together) * layout.kept * pitch + edge)
        repeats = self._repeats()
        self._held: list[Any] = [*planes, carried, numbers, *repeats]
        self._copies = repeats[0].size
        at = [array.ctypes.data for array in self._held]
        self._planes = [place + 8 * margin for place in at[:2]]
        self._work, self._repeated = (*self._planes, at[2] + 8 * edge), at[3:]
        self._passages, self._to_rows, self._from_rows = _machine_code(
            flow, layout.lanes, numbers.size - 1, self._columns and self._columns % LANES + LANES
        )

    def _repeats(self) -> list[Places]:
        """The places of the rows below and above the arc's own, and from where they are filled.

        They are cells of a chain, vectors of a plane.
        """
        layout = self._layout
        rows = np.r_[0 : self._below, self._below + layout.height : self._rows]
        if self._columns:
            source = self._below + (rows - self._below) % layout.height
            each = np.arange(-layout.edge, layout.width + layout.edge)
            return [(row[:, None] * layout.across + each).ravel() for row in (rows, source)]
        starts = layout.starts[:-1]
        cells = (starts + (rows[:, None] - self._below)) % self._count
        lane = np.searchsorted(starts, cells, side="right") - 1
        target = rows[:, None] * layout.lanes + np.arange(layout.lanes)
        source = (self._below + cells - starts[lane]) * layout.lanes + lane
        return [target.ravel(), source.ravel()]

    def _move(
        self, kind: Callable[..., None], rings: Array, plane: int, begin: int, end: int
    ) -> None:
        """Copy what is at ``begin`` .. ``end - 1`` in the arc from its fields' rings, or back."""
        layout, starts = self._layout, self._layout.starts[:-1]
        moved: tuple[Places, ...]
        if self._columns:
            moved = starts, np.zeros_like(starts), np.full_like(starts, layout.vectors)
            runs, size = self._runs(begin, end), self._columns
        else:
            lengths = layout.vectors if kind is self._to_rows else np.diff(layout.starts)
            ends = (np.clip(place - starts, 0, lengths) for place in (begin, end))
            moved = (self._first + starts) % self._size, *ends
            runs, size = [(0, 0, 1)], self._size
        at = [array.ctypes.data for array in moved]
        for row, own, count in runs:
            for field, ring in enumerate(rings):
                there = ring.ctypes.data + row * ring.strides[0]
                here = plane + 8 * (field * self._plane + (self._below + own) * layout.pitch)
                counts = layout.vectors, count, self._columns, layout.pitch
                kind(there, here, *at, size, *counts)

    def _runs(self, begin: int, end: int) -> list[tuple[int, int, int]]:
        """The rows of a plane where they begin in the ring and in the arc, and how many."""
        found = []
        while begin < end:
            row = (self._first + begin) % self._size
            count = min(end - begin, self._size - row)
            found.append((row, begin, count))
            begin += count
        return found

    def _move_both(
        self, kind: Callable[..., None], f: Array, v: Array, *ranges: tuple[int, int]
    ) -> None:
        for begin, end in ranges:
            for rings, plane in zip((f, v), self._planes, strict=True):
                self._move(kind, rings, plane, begin, end)

    def load(self, f: Array, v: Array) -> None:
        """Take all of it from the ring."""
        self._move_both(self._to_rows, f, v, (0, self._count))

    def rest(self, resting: Array, fields: int) -> None:
        """Take what differs from cell to cell, as positions after the ``fields`` that move."""
        plane = self._planes[0] + 8 * fields * self._plane
        self._move(self._to_rows, resting, plane, 0, self._count)

    def store(self, f: Array, v: Array) -> None:
        """Put the arc's own where it belongs in the ring."""
        self._move_both(self._from_rows, f, v, self._own)

    def show(self, f: Array, v: Array) -> None:
        """Put into the ring what another arc needs beside its own."""
        (first, past), (below, above) = self._own, self._beside
        self._move_both(self._from_rows, f, v, (first, first + above), (past - below, past))

    def look(self, f: Array, v: Array) -> None:
        """Take from the ring what is beside the arc's own."""
        (first, past), count = self._own, self._count
        self._move_both(self._to_rows, f, v, (0, first), (past, count))

    def run(self, drifts: Array, kicks: Array, begun: int, stages: int) -> None:
        """So many stages, their weights in turn from ``begun`` on."""
        each, period, layout = self._each, kicks.size, self._layout
        weights = [np.resize(np.roll(given, -begun), period + each) for given in (drifts, kicks)]
        begins = [array.ctypes.data for array in weights]

        def passages(count: int, length: int, begun: int) -> None:
            self._passages(
                *self._work,
                *(begin + 8 * begun for begin in begins),
                *self._repeated,
                self._copies,
                self._plane,
                layout.pitch,
                layout.width,
                self._rows,
                length,
                count,
                period,
            )

        passages(stages // each, each, 0)
        if stages % each:
            passages(1, stages % each, stages // each * each % period)


class RingKernel:
    """Advances rings of ``shape``, cells of a chain or rows and columns, with room used again.

    Rings (f, v) have the shape (fields, *shape) and rows that are contiguous.
    """

    def __init__(self, lattice: NumericLattice, *shape: int) -> None:
        ordered, variation, shares = lattice.cellwise
        self._flow, numbers, units = varied_flow(ordered, variation)
        self._numbers = np.array([*numbers, 0.0])
        self._resting = shares * np.array(units)[:, None] if units else np.empty((0, *shape))
        self._fields, self._shape = len(lattice.fields), tuple(map(int, shape))
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
            _drift(f, v, -last)
            self.advance_stages(f, v, joint, kicks, steps * kicks.size)
            _drift(f, v, last)

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
        self._on_cores(_Arc.load, f, v)
        between = between or max(stages, 1)
        for done in range(0, stages, between):
            for meet in (_Arc.show, _Arc.look) if done else ():
                self._on_cores(meet, f, v)
            self._on_cores(_Arc.run, drifts, kicks, done, min(between, stages - done))
        self._on_cores(_Arc.store, f, v)

    def _stages_between(self, period: int) -> int:
        """Stages between two meetings of two cores; 0 if one does all.

        One in a worker process: there the other core has work of its own.
        """
        cells = math.prod(self._shape) * self._fields
        if cells < LEAST_SHARED or usable_cores() < 2:
            return 0
        most = int(DOUBLED * self._shape[0]) // (2 * max(1, sum(self._reach)))
        found = min(MEETING * period, most)
        return found if found * cells >= LEAST_WORK else 0

    @cached_property
    def _reach(self) -> tuple[int, int]:
        """The cells of a chain, or rows, above and below that a stage feels."""
        flow = self._flow if len(self._shape) == 1 else rows_of(self._flow)
        return flow.skew, flow.below

    def _made(self, between: int) -> list[_Arc]:
        size, half = self._shape[0], self._shape[0] // 2
        skew, below = self._reach
        ends = [(0, half), (half, size)] if between else [(0, size)]
        beside = between * below, between * skew
        arcs = [_Arc(self._flow, self._numbers, self._shape, own, beside) for own in ends]
        for arc in arcs:
            arc.rest(self._resting, self._fields)
        return arcs

    def _on_cores(self, do: Callable[..., None], *values: Any) -> None:
        """Have the arcs do the same, each on a core."""
        here, *others = self._arcs
        waiting = [other_core().submit(do, there, *values) for there in others]
        do(here, *values)
        for one in waiting:
            one.result()
