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
from collections.abc import Callable, Hashable, Iterable, Iterator
from functools import cached_property, lru_cache, partial
from itertools import chain, product
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.kernels.active_cells import (
    MARGIN,
    SHARE,
    moving_cells,
    seems_still,
    shortest_arc,
)
from longwave.lattice.kernels.streams import FUNCTIONS, StagePlan, rows_of, varied_stage_plan
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

PAGE = 512
"""Doubles in a page of memory."""

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

HALO = 24
"""The rows that a passage repeats at the ends are at most this part of the ring's own, if so many
are enough for the stages that go together: with 8 rings of 1024 to 4096 cells cost 3 to 4 % more,
with 4 as much again."""

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

LEAST_SEARCHED = 200_000
"""Cells times stages from which on those that move are looked for."""

WORDS = 1 + max(FUNCTIONS.values())
"""Words of a call: which function, and as many as the one with most arguments takes."""

MOST_SCRIPTS = 8
"""Scripts that a kernel keeps: a march in pieces asks for a few of them, again and again."""

_SCRIPT = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64)

Call = tuple[Any, ...]
"""One of ``FUNCTIONS`` and what it is given; arrays stand for where they begin."""


def _together(flow: StagePlan) -> int:
    """The stages that go up the rows of a chain together.

    One where a force has functions: they wait for their own sums, and a processor looks no further
    ahead than to the next stage's, so rows of one stage alone overlap more.
    """
    functions = any(stream.law.program for stream in flow.streams)
    return 2 if flow.kept(2) <= MOST_KEPT and not functions else 1


@lru_cache(maxsize=64)
def _machine_code(
    flow: StagePlan, lanes: int, count: int, columns: int
) -> Callable[[int, int], None]:
    """What makes the calls of a script; on disk it is found by what is written here."""
    together, block = _together(flow), ALONG if columns else ROWS

    def written() -> str:
        from longwave.lattice.kernels.row_code import passage_text

        return passage_text(flow, lanes, together, block, count, columns)

    key = f"{flow!r} {lanes} {together} {block} {count} {columns}"
    [script] = native_functions(__name__, key, written, {"script": _SCRIPT})
    return script


def _aligned(size: int) -> Array:
    """Zeros that begin at a line of the cache."""
    raw = np.zeros(size + ALIGNMENT)
    offset = (-(raw.ctypes.data // 8)) % ALIGNMENT
    return raw[offset : offset + size]


def _spaced(size: int, count: int) -> int:
    """Doubles from one array to the next of ``count`` that hold ``size``, apart within a page.

    A processor takes a load for one of what was just stored if both are as far into their pages.
    """
    apart = PAGE // count // ALIGNMENT * ALIGNMENT
    return size + (apart - size) % PAGE


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


def _layout(flow: StagePlan, count: int, columns: int) -> _Layout:
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


class _Script:
    """Calls that are made one after the other, while other threads may run."""

    def __init__(self, code: Callable[[int, int], None], calls: Iterable[Call]) -> None:
        self._code, self._calls = code, list(calls)
        self._words = np.zeros((len(self._calls), WORDS), np.int64)
        for row, (name, *given) in zip(self._words, self._calls, strict=True):
            words = [word if isinstance(word, int) else word.ctypes.data for word in given]
            row[: 1 + len(words)] = [*FUNCTIONS].index(name), *words
        self._at = self._words.ctypes.data

    def __call__(self) -> None:
        self._code(self._at, len(self._calls))


class _Arc:
    """The cells, or rows, ``first`` .. ``past - 1`` of a ring, and room to advance them.

    ``below`` and ``above`` more lie beside them, whose values are untrue at the end; without any
    the arc is the whole ring.
    """

    def __init__(
        self,
        flow: StagePlan,
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
        most = min(layout.most, layout.height // halo) if halo else layout.most
        self._each = max(together, most - most % together)
        repeated = 0 if ended else self._each
        self._below = repeated * layout.below
        self._rows = self._below + layout.height + repeated * layout.skew
        edge = layout.edge * layout.lanes
        margin = together * layout.skew * pitch + edge
        self._plane = _spaced(margin + self._rows * pitch + ALIGNMENT, 2 * flow.fields)
        both, kept = 2 * flow.fields * self._plane, (self._each + together) * layout.kept
        planes, carried = np.split(_aligned(both + kept * pitch + edge), [both])
        repeats = self._repeats()
        self._held = planes
        self._planes = [data[margin:].ctypes.data for data in np.split(planes, 2)]
        self._work = (*self._planes, carried[edge:])
        self._repeated = (numbers, *repeats, repeats[0].size)
        self._code = _machine_code(
            flow, layout.lanes, numbers.size - 1, self._columns and self._columns % LANES + LANES
        )

    def script(self, *calls: Iterator[Call]) -> _Script:
        """These calls of the arc's functions."""
        return _Script(self._code, chain.from_iterable(calls))

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
        self,
        way: Literal["to_rows", "from_rows"],
        planes: Iterable[tuple[int, Array]],
        *ranges: tuple[int, int],
    ) -> Iterator[Call]:
        """Copy what is at the ``ranges`` of the arc from rings of fields to planes, or back."""
        layout, starts = self._layout, self._layout.starts[:-1]
        at: tuple[Places, ...]
        for (begin, end), (plane, rings) in product(ranges, planes):
            if self._columns:
                at = starts, np.zeros_like(starts), np.full_like(starts, layout.vectors)
                runs, size = self._runs(begin, end), self._columns
            else:
                lengths = layout.vectors if way == "to_rows" else np.diff(layout.starts)
                ends = (
                    np.minimum(np.maximum(place - starts, 0), lengths) for place in (begin, end)
                )
                at = (self._first + starts) % self._size, *ends
                runs, size = [(0, 0, 1)], self._size
            for row, own, count in runs:
                for field, ring in enumerate(rings):
                    there = ring.ctypes.data + row * ring.strides[0]
                    here = plane + 8 * (field * self._plane + (self._below + own) * layout.pitch)
                    counts = layout.vectors, count, self._columns, layout.pitch
                    yield way, there, here, *at, size, *counts

    def _runs(self, begin: int, end: int) -> list[tuple[int, int, int]]:
        """Return where cells, or rows, begin in the ring and in the arc, and how many they are."""
        found = []
        while begin < end:
            row = (self._first + begin) % self._size
            count = min(end - begin, self._size - row)
            found.append((row, begin, count))
            begin += count
        return found

    def _both(self, f: Array, v: Array) -> Iterator[tuple[int, Array]]:
        return zip(self._planes, (f, v), strict=True)

    def drift(self, f: Array, v: Array, length: float) -> Iterator[Call]:
        """``f += length v`` of the arc's own in the ring."""
        for (first, _, count), (there, speeds) in product(
            self._runs(*self._own), list(zip(f, v, strict=True))
        ):
            at = (ring.ctypes.data + first * ring.strides[0] for ring in (there, speeds))
            yield "drift", *at, np.array([length]), count * (self._columns or 1)

    def load(self, f: Array, v: Array) -> Iterator[Call]:
        """Take all of it from the ring."""
        return self._move("to_rows", self._both(f, v), (0, self._count))

    def rest(self, resting: Array, fields: int) -> Iterator[Call]:
        """Take what differs from cell to cell, as positions after the ``fields`` that move."""
        plane = self._planes[0] + 8 * fields * self._plane
        return self._move("to_rows", [(plane, resting)], (0, self._count))

    def store(self, f: Array, v: Array) -> Iterator[Call]:
        """Put the arc's own where it belongs in the ring."""
        return self._move("from_rows", self._both(f, v), self._own)

    def show(self, f: Array, v: Array) -> Iterator[Call]:
        """Put into the ring what another arc needs beside its own."""
        (first, past), (below, above) = self._own, self._beside
        ends = (first, first + above), (past - below, past)
        return self._move("from_rows", self._both(f, v), *ends)

    def look(self, f: Array, v: Array) -> Iterator[Call]:
        """Take from the ring what is beside the arc's own."""
        (first, past), count = self._own, self._count
        return self._move("to_rows", self._both(f, v), (0, first), (past, count))

    def run(self, drifts: Array, kicks: Array, begun: int, stages: int) -> Iterator[Call]:
        """So many stages, their weights in turn from ``begun`` on."""
        each, period, layout = self._each, len(kicks), self._layout
        whole = stages // each * each
        for done, count, length in ((0, stages // each, each), (whole, 1, stages - whole)):
            if count * length:
                asked = min(period, count * length)
                turn = (begun + done + np.arange(asked + each)) % period
                weights = drifts[turn], kicks[turn]
                counts = self._plane, layout.pitch, layout.width, self._rows, length, count, asked
                yield "passages", *self._work, *weights, *self._repeated, *counts


class RingKernel:
    """Advances rings of ``shape``, cells of a chain or rows and columns, with room used again.

    Rings (f, v) have the shape (fields, *shape) and rows that are contiguous.
    """

    def __init__(self, lattice: NumericLattice, *shape: int) -> None:
        ordered, variation, shares = lattice.cellwise
        self._flow, numbers, units = varied_stage_plan(ordered, variation)
        self._numbers = np.array([*numbers, 0.0])
        rows = shares * np.array(units)[:, None] if units else np.empty((0, *shape))
        self._resting = np.ascontiguousarray(rows)  # whatever the order of the deviations
        self._fields, self._shape = len(lattice.fields), tuple(map(int, shape))
        self._arcs: list[_Arc] = []
        self._between = 0
        self._scripts: dict[Hashable, tuple[Array, Array, list[list[_Script]]]] = {}
        self._active: tuple[int, int, _Arc] | None = None
        self._moved_from_rest: NDArray[np.bool_] | None = None

    def advance(self, f: Array, v: Array, drifts: Array, kicks: Array, steps: int) -> None:
        """Advance in place by a drift-kick splitting.

        ``drifts`` (one longer than ``kicks``) and ``kicks`` are already multiplied by the time
        step; the last drift of a step and the first of the next are done as one.
        """
        last, joint = float(drifts[-1]), drifts[:-1].copy()
        joint[0] += last
        if steps > 0:
            self.advance_stages(f, v, joint, kicks, steps * kicks.size, last)

    def advance_stages(
        self, f: Array, v: Array, drifts: Array, kicks: Array, stages: int, ahead: float = 0.0
    ) -> None:
        """So many stages, ``f += drift v`` and ``v += kick f''``, their weights in turn.

        Positions are ``ahead`` of the velocities before and after. Where drifts are damped or
        fields are kicked from outside, each row of ``kicks`` has the `StagePlan.weights`.
        """
        for name, ring in (("f", f), ("v", v)):
            if ring.dtype != np.float64 or not ring.flags.c_contiguous:
                raise ValueError(
                    f"{name} must be contiguous doubles, got {ring.dtype} with strides "
                    f"{ring.strides} (np.ascontiguousarray makes them)"
                )
        if self._is_mostly_still(f, v, kicks, stages):
            self._advance_active(f, v, drifts, kicks, stages, ahead)
        else:
            self._advance_whole(f, v, drifts, kicks, stages, ahead)

    def _advance_whole(
        self, f: Array, v: Array, drifts: Array, kicks: Array, stages: int, ahead: float
    ) -> None:
        """Advance all cells."""
        between = self._stages_between(len(kicks))
        if between != self._between or not self._arcs:
            self._arcs, self._between = self._made(between), between
            self._scripts.clear()
        asked = id(f), id(v), drifts.tobytes(), kicks.tobytes(), stages, ahead
        found = self._scripts.get(asked)
        if found is None:
            if len(self._scripts) == MOST_SCRIPTS:
                self._scripts.clear()
            written = self._written(f, v, drifts, kicks, stages, ahead)
            found = self._scripts[asked] = f, v, list(written)
        for scripts in found[-1]:
            _on_cores(scripts)

    def _is_mostly_still(self, f: Array, v: Array, kicks: Array, stages: int) -> bool:
        """Return whether so few cells of a chain move that they are worth finding."""
        size = self._shape[0]
        if len(self._shape) > 1 or size < 4 * MARGIN or stages * size < LEAST_SEARCHED:
            return False
        if 2 * max(self._reach) > MARGIN:
            return False
        return seems_still(f, v) and self._arc_of_active(f, v, kicks) is not None

    def _advance_active(
        self, f: Array, v: Array, drifts: Array, kicks: Array, stages: int, ahead: float
    ) -> None:
        """Advance the cells that move, as far as they need no others; then find them again."""
        done, arc = 0, None
        while done < stages and (found := self._arc_of_active(f, v, kicks)):
            if found[0] is not arc:
                arc = found[0]
                store = arc.script(arc.store(f, v))
                begin = [arc.drift(f, v, -ahead)] if ahead and not done else []
                arc.script(*begin, arc.load(f, v))()
            count = min(found[1], stages - done)
            arc.script(arc.run(drifts, kicks, done, count))()
            store()
            done += count
        if done < stages:
            drifts, kicks = np.roll(drifts, -done, axis=0), np.roll(kicks, -done, axis=0)
            self._advance_whole(f, v, drifts, kicks, stages - done, 0.0)
        for part in (self._arcs if arc is None or done < stages else [arc]) if ahead else ():
            part.script(part.drift(f, v, ahead))()

    def _arc_of_active(self, f: Array, v: Array, kicks: Array) -> tuple[_Arc, int] | None:
        """Return an arc with all cells that move, and for how many stages it has them all.

        None if it would be larger than `SHARE` of the ring.
        """
        size = self._shape[0]
        first, past = shortest_arc(moving_cells(f, v) | self._sources(kicks))
        begin, end, arc = self._active or (0, 0, None)
        below, above = (first - begin) % size, (end - past) % size
        if (
            arc is None
            or below + past - first + above != end - begin
            or min(below, above) < MARGIN // 2
        ):
            begin, end, below, above = first - MARGIN, past + MARGIN, MARGIN, MARGIN
            if end - begin > SHARE * size / (2 if self._stages_between(len(kicks)) else 1):
                return None
            arc = self._arc((begin, end), (0, 0))
            self._active = begin, end, arc
        return arc, min(below, above) // max(1, *self._reach)

    def _sources(self, kicks: Array) -> NDArray[np.bool_]:
        """Return the cells of a chain that begin to move from rest, found by one stage of it."""
        if self._moved_from_rest is None:
            f, v = np.zeros((2, self._fields, *self._shape))
            weights = np.linspace(0.5, 1.0, kicks[:1].size).reshape(kicks[:1].shape)
            self._advance_whole(f, v, np.ones(1), weights, 1, 0.0)
            self._moved_from_rest = moving_cells(f, v)
        return self._moved_from_rest

    def _written(
        self, f: Array, v: Array, drifts: Array, kicks: Array, stages: int, ahead: float
    ) -> Iterator[list[_Script]]:
        """What each arc does between two meetings."""
        work = [partial(_Arc.load, f=f, v=v)]
        between = self._between or max(stages, 1)
        for done in range(0, stages, between):
            work += [partial(meet, f=f, v=v) for meet in (_Arc.show, _Arc.look) if done]
            length = min(between, stages - done)
            work.append(partial(_Arc.run, drifts=drifts, kicks=kicks, begun=done, stages=length))
        work.append(partial(_Arc.store, f=f, v=v))
        if ahead:
            back, on = (partial(_Arc.drift, f=f, v=v, length=by) for by in (-ahead, ahead))
            work = [back, *work, on]
        for together in [[do] for do in work] if self._between else [work]:
            yield [arc.script(*(do(arc) for do in together)) for arc in self._arcs]

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
        return [self._arc(own, beside) for own in ends]

    def _arc(self, own: tuple[int, int], beside: tuple[int, int]) -> _Arc:
        """Return an arc with what differs from cell to cell."""
        arc = _Arc(self._flow, self._numbers, self._shape, own, beside)
        if len(self._resting):
            arc.script(arc.rest(self._resting, self._fields))()
        return arc


def _on_cores(scripts: list[_Script]) -> None:
    """Each on a core."""
    here, *others = scripts
    waiting = [other_core().submit(there) for there in others]
    here()
    for one in waiting:
        one.result()
