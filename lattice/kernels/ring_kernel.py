"""Splitting schemes on a ring of any chain or plane, by compiled code generated for the lattice.

A stage is one drift and one kick, ``f += a v`` and ``v += b f''``. Cells are laid out in rows of
``LANES``, each a vector of doubles: lane l of N cells begins at the cell ``l N // LANES``
(dimension-lifted transposition; Henretty et al., CC 2011). Neighbouring cells are then in
neighbouring rows, stencils need no shuffles, and adjacent lanes may share one cell. Rows past the
ring's end repeat those at its beginning with the lanes moved by one.

All stages of a few steps are done in one pass over the rows. A front of blocks moves up; in each
block a stage stops some rows below the stage before, because it needs the rows above (time skewing;
Wonnacott, IPDPS 2000). A letter says in which block a stage is done on a row, here with 16 rows, 5
stages of nearest neighbours and 4 rows a block::

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
         5 | B  B  B  C  C        each stage leaves one more row at either end invalid; at the end
         4 | B  B  B  B           the ring's own rows, here 6 .. 10, are valid: 2 stages + 1 rows
         3 | A  B  B              are repeated next to them
         2 | A  A
         1 | A
         0 |
           +---------------
     stage   0  1  2  3  4

In a plane, "row" means a row of its cells. It is laid out in vectors as a chain is; ghost vectors
at either end repeat those at the other end with the lanes moved by one.

A large ring is advanced on two cores, one half each. Each half includes the neighbouring cells that
its stages reach, so that the two exchange data only after a number of stages. Cells that both
compute get identical values: the result is that of one core, to the bit.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Hashable, Iterable, Iterator
from functools import cached_property, lru_cache, partial
from itertools import chain, product
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np

from longwave.lattice.kernels.active_cells import (
    ALONE_FRACTION,
    RESTING_MARGIN,
    moving_cells,
    seems_still,
    shortest_arc,
)
from longwave.lattice.kernels.streams import FUNCTIONS, StagePlan, rows_of, varied_stage_plan
from longwave.support.compiled.cores import other_core, usable_cores
from longwave.support.compiled.native_code import native_functions
from longwave.support.real_arrays import Array, Indices, Mask

if TYPE_CHECKING:
    from longwave.lattice.numeric_lattice import NumericLattice

LANES = 8
"""Number of cells per row, a vector of 512 bits, which is also a cache line."""

LINE_DOUBLES = 8
"""Number of doubles in a cache line."""

PAGE_DOUBLES = 512
"""Number of doubles in a page of memory."""

BLOCK_ROWS = 256
"""Number of rows in a block: 64 to 512 cost the same to 5 % (`benchmarks/lattice_constants.py`)."""

MIN_LANED_CELLS = 32
"""Fewest cells for which cells are laid out in rows of ``LANES``."""

MAX_STAGES = 28
"""Largest number of stages done in one pass (13 to 52 cost the same to 5 %)."""

PLANE_BLOCK_ROWS = 4
"""Number of rows in a block of a plane: 1 to 16 cost the same to 5 %."""

CACHED_DOUBLES = 65_536
"""Largest number of doubles in the plane's rows of one pass: half of the second-level cache."""

MIN_HALO_RATIO = 24
"""Least ratio of the ring's own rows to the rows repeated at its ends in a pass, if that leaves
room for enough fused stages: with 8, rings of 1024 to 4096 cells cost 3 to 4 % more, with 4 as much
again."""

MAX_CARRIED = 12
"""Largest number of values carried from row to row by two fused stages. With the 15 values of
next-nearest neighbours in the strain one stage alone is a fifth faster, with the 10 of three fields
a seventh slower, on registers of eight doubles (`benchmarks/same_lattice.py`)."""

MIN_SHARED_VALUES = 16_384
"""Smallest product of cells and fields for which a second core is used: up to 65 536 it is 1.5 to
1.8 times as fast."""

MIN_SHARED_WORK = 1_000_000
"""Smallest product of cells, fields and stages between two synchronisations for a second core."""

MAX_STEPS_APART = 64
"""Largest number of steps between two synchronisations of the cores."""

MAX_REPEATED_FRACTION = 0.2
"""Largest fraction of cells that both cores compute."""

MIN_SEARCHED_WORK = 200_000
"""Smallest product of cells and stages for which the kernel searches for the moving cells."""

CALL_WORDS = 1 + max(FUNCTIONS.values())
"""Number of words of a call: one for the function, and as many as the longest arguments take."""

MAX_SCRIPTS = 8
"""Largest number of scripts that a kernel caches: a time march uses a few of them repeatedly."""

_SCRIPT = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64)

Call = tuple[Any, ...]
"""Name of one of ``FUNCTIONS``, then its arguments; arrays are passed by address."""


def _together(flow: StagePlan) -> int:
    """Return the number of stages of a chain that are fused row by row.

    It is 1 if the force contains functions: their latency is hidden better by several rows of one
    stage than by stages that depend on each other.
    """
    functions = any(stream.law.program for stream in flow.streams)
    return 2 if flow.carried_values(2) <= MAX_CARRIED and not functions else 1


@lru_cache(maxsize=64)
def _machine_code(
    flow: StagePlan, lanes: int, count: int, columns: int
) -> Callable[[int, int], None]:
    """Return the compiled function that runs scripts; cached on disk, keyed by ``flow``."""
    together, block = _together(flow), PLANE_BLOCK_ROWS if columns else BLOCK_ROWS

    def generate_text() -> str:
        from longwave.lattice.kernels.row_code import passage_text

        return passage_text(flow, lanes, together, block, count, columns)

    key = f"{flow!r} {lanes} {together} {block} {count} {columns}"
    [script] = native_functions(__name__, key, generate_text, {"script": _SCRIPT})
    return script


def _aligned(size: int) -> Array:
    """Return an array of zeros that begins at a cache line."""
    raw = np.zeros(size + LINE_DOUBLES)
    offset = (-(raw.ctypes.data // 8)) % LINE_DOUBLES
    return raw[offset : offset + size]


def _spaced(size: int, count: int) -> int:
    """Return the distance, in doubles, between ``count`` arrays of ``size`` doubles each.

    Their offsets in pages differ: a processor mistakes a load for one of a recent store if both
    have the same offset.
    """
    page_offset = PAGE_DOUBLES // count // LINE_DOUBLES * LINE_DOUBLES
    return size + (page_offset - size) % PAGE_DOUBLES


class _Layout(NamedTuple):
    """Memory layout of the cells of a chain, or rows of a plane, and the reach of a stage.

    Lanes begin at the cells ``starts`` and are ``vectors`` long. A row has ``width`` vectors and
    ``edge`` ghost vectors at either end; there are ``height`` rows. In a pass of at most ``most``
    stages each stays ``skew`` rows behind the one before, leaves ``below`` rows invalid at the
    lower end, and carries ``carried`` values from row to row.
    """

    lanes: int
    starts: Indices
    vectors: int
    width: int
    edge: int
    height: int
    skew: int
    below: int
    carried: int
    together: int
    most: int

    @property
    def across(self) -> int:
        """Number of vectors from one row to the next."""
        return self.width + 2 * self.edge

    @property
    def pitch(self) -> int:
        """Number of doubles from one row to the next."""
        return self.across * self.lanes


def _layout(flow: StagePlan, count: int, columns: int) -> _Layout:
    """Return the layout of ``count`` cells of a chain (``columns`` is 0) or rows of a plane."""
    across = columns or count
    lanes = LANES if across >= MIN_LANED_CELLS else 1
    starts, vectors = np.arange(lanes + 1) * across // lanes, -(-across // lanes)
    if not columns:
        together = _together(flow)
        ends = flow.skew, flow.below, flow.carried_values(together), together, MAX_STAGES
        return _Layout(lanes, starts, vectors, 1, 0, vectors, *ends)
    rows = rows_of(flow)
    most = CACHED_DOUBLES // (2 * flow.fields * lanes * vectors * rows.skew)
    ends = rows.skew, rows.below, sum(rows.depths), 1, min(MAX_STAGES, most)
    return _Layout(lanes, starts, vectors, vectors, rows.margin, count, *ends)


class _Script:
    """A list of compiled calls, made one after the other with the interpreter lock released."""

    def __init__(self, code: Callable[[int, int], None], calls: Iterable[Call]) -> None:
        self._code, self._calls = code, list(calls)
        self._words = np.zeros((len(self._calls), CALL_WORDS), np.int64)
        for row, (name, *arguments) in zip(self._words, self._calls, strict=True):
            words = [word if isinstance(word, int) else word.ctypes.data for word in arguments]
            row[: 1 + len(words)] = [*FUNCTIONS].index(name), *words
        self._at = self._words.ctypes.data

    def __call__(self) -> None:
        self._code(self._at, len(self._calls))


class _Arc:
    """Cells (or rows) ``first`` .. ``past - 1`` of a ring, with working memory to advance them.

    ``beside`` is the number of additional cells (``below``, ``above``) at its ends, whose values
    are invalid at the end of a pass; (0, 0) if the arc is the whole ring.
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
        halo = 0 if ended else MIN_HALO_RATIO * max(1, layout.skew + layout.below)
        most = min(layout.most, layout.height // halo) if halo else layout.most
        self._each = max(together, most - most % together)
        repeated = 0 if ended else self._each
        self._below = repeated * layout.below
        self._rows = self._below + layout.height + repeated * layout.skew
        edge = layout.edge * layout.lanes
        margin = together * layout.skew * pitch + edge
        self._plane = _spaced(margin + self._rows * pitch + LINE_DOUBLES, 2 * flow.fields)
        both, carried_size = 2 * flow.fields * self._plane, (self._each + together) * layout.carried
        planes, carried = np.split(_aligned(both + carried_size * pitch + edge), [both])
        repeats = self._repeats()
        self._planes_memory = planes
        self._planes = [data[margin:].ctypes.data for data in np.split(planes, 2)]
        self._work = (*self._planes, carried[edge:])
        self._repeated = (numbers, *repeats, repeats[0].size)
        self._code = _machine_code(
            flow, layout.lanes, numbers.size - 1, self._columns and self._columns % LANES + LANES
        )

    def script(self, *calls: Iterator[Call]) -> _Script:
        """Return a script of the given calls."""
        return _Script(self._code, chain.from_iterable(calls))

    def _repeats(self) -> list[Indices]:
        """Return the indices, in cells or vectors, of ghost rows and of the rows they copy."""
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
        """Yield calls that copy the cells in ``ranges`` between rings and the arc's memory."""
        layout, starts = self._layout, self._layout.starts[:-1]
        at: tuple[Indices, ...]
        for (begin, end), (plane, rings) in product(ranges, planes):
            if self._columns:
                at = starts, np.zeros_like(starts), np.full_like(starts, layout.vectors)
                runs, size = self._runs(begin, end), self._columns
            else:
                lengths = layout.vectors if way == "to_rows" else np.diff(layout.starts)
                ends = (np.minimum(np.maximum(cell - starts, 0), lengths) for cell in (begin, end))
                at = (self._first + starts) % self._size, *ends
                runs, size = [(0, 0, 1)], self._size
            for row, own, count in runs:
                for field, ring in enumerate(rings):
                    there = ring.ctypes.data + row * ring.strides[0]
                    here = plane + 8 * (field * self._plane + (self._below + own) * layout.pitch)
                    counts = layout.vectors, count, self._columns, layout.pitch
                    yield way, there, here, *at, size, *counts

    def _runs(self, begin: int, end: int) -> list[tuple[int, int, int]]:
        """Return contiguous runs of cells or rows: (first in the ring, first in the arc, count)."""
        runs = []
        while begin < end:
            row = (self._first + begin) % self._size
            count = min(end - begin, self._size - row)
            runs.append((row, begin, count))
            begin += count
        return runs

    def _both(self, f: Array, v: Array) -> Iterator[tuple[int, Array]]:
        """Pair the addresses of the arc's positions and velocities with ``f`` and ``v``."""
        return zip(self._planes, (f, v), strict=True)

    def drift(self, f: Array, v: Array, length: float) -> Iterator[Call]:
        """Yield calls of ``f += length v`` for the arc's own cells in the ring."""
        for (first, _, count), (there, speeds) in product(
            self._runs(*self._own), list(zip(f, v, strict=True))
        ):
            at = (ring.ctypes.data + first * ring.strides[0] for ring in (there, speeds))
            yield "drift", *at, np.array([length]), count * (self._columns or 1)

    def load(self, f: Array, v: Array) -> Iterator[Call]:
        """Yield calls that load the arc, ghost cells included, from the ring."""
        return self._move("to_rows", self._both(f, v), (0, self._count))

    def load_deviations(self, resting: Array, fields: int) -> Iterator[Call]:
        """Yield calls that load the deviations, ``resting``, after the arc's moving ``fields``."""
        plane = self._planes[0] + 8 * fields * self._plane
        return self._move("to_rows", [(plane, resting)], (0, self._count))

    def store(self, f: Array, v: Array) -> Iterator[Call]:
        """Yield calls that store the arc's own cells in the ring."""
        return self._move("from_rows", self._both(f, v), self._own)

    def store_shared(self, f: Array, v: Array) -> Iterator[Call]:
        """Yield calls that store in the ring the cells that the other arc needs."""
        (first, past), (below, above) = self._own, self._beside
        ends = (first, first + above), (past - below, past)
        return self._move("from_rows", self._both(f, v), *ends)

    def load_ghosts(self, f: Array, v: Array) -> Iterator[Call]:
        """Yield calls that load the arc's ghost cells from the ring."""
        (first, past), count = self._own, self._count
        return self._move("to_rows", self._both(f, v), (0, first), (past, count))

    def run(self, drifts: Array, kicks: Array, begun: int, stages: int) -> Iterator[Call]:
        """Yield calls of ``stages`` stages; the cyclic weights are used from index ``begun`` on."""
        each, period, layout = self._each, len(kicks), self._layout
        whole = stages // each * each
        for done, count, length in ((0, stages // each, each), (whole, 1, stages - whole)):
            if count * length:
                used = min(period, count * length)
                turn = (begun + done + np.arange(used + each)) % period
                weights = drifts[turn], kicks[turn]
                counts = self._plane, layout.pitch, layout.width, self._rows, length, count, used
                yield "passages", *self._work, *weights, *self._repeated, *counts


class RingKernel:
    """Compiled time steps of rings (fields, *shape), C contiguous; reuses its working memory."""

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
        self._cached_arc: tuple[int, int, _Arc] | None = None
        self._moved_from_rest: Mask | None = None

    def advance(self, f: Array, v: Array, drifts: Array, kicks: Array, steps: int) -> None:
        """Advance in place by a drift-kick splitting.

        ``drifts`` (one longer than ``kicks``) and ``kicks`` include the time step. The last drift
        of a step is merged with the first of the next step.
        """
        last, joint = float(drifts[-1]), drifts[:-1].copy()
        joint[0] += last
        if steps > 0:
            self.advance_stages(f, v, joint, kicks, steps * kicks.size, last)

    def advance_stages(
        self, f: Array, v: Array, drifts: Array, kicks: Array, stages: int, ahead: float = 0.0
    ) -> None:
        """Advance in place by ``stages`` stages ``f += drift v``, ``v += kick f''``.

        Weights are used cyclically. Positions are ahead of the velocities by a drift ``ahead``
        before and after. If drifts are damped or there are external pulses, each row of ``kicks``
        has the `StagePlan.weights`.
        """
        for name, ring in (("f", f), ("v", v)):
            if ring.dtype != np.float64 or not ring.flags.c_contiguous:
                raise ValueError(
                    f"{name} must be contiguous doubles, got {ring.dtype} with strides "
                    f"{ring.strides} (np.ascontiguousarray makes them)"
                )
        if self._may_be_still(f, v, stages) and (moving := self._moving_arc(f, v, kicks)):
            self._advance_moving(f, v, drifts, kicks, stages, ahead, moving)
        else:
            self._advance_whole(f, v, drifts, kicks, stages, ahead)

    def _advance_whole(
        self, f: Array, v: Array, drifts: Array, kicks: Array, stages: int, ahead: float
    ) -> None:
        """Advance all cells."""
        self._divide(len(kicks))
        key = id(f), id(v), drifts.tobytes(), kicks.tobytes(), stages, ahead
        cached = self._scripts.get(key)
        if cached is None:
            if len(self._scripts) == MAX_SCRIPTS:
                self._scripts.clear()
            steps_of_scripts = self._scripts_between(f, v, drifts, kicks, stages, ahead)
            cached = self._scripts[key] = f, v, list(steps_of_scripts)
        for scripts in cached[-1]:
            _on_cores(scripts)

    def _divide(self, period: int) -> None:
        """Divide the ring into arcs, one for each core; keep existing arcs that still fit."""
        between = self._stages_between(period)
        if between != self._between or not self._arcs:
            self._arcs, self._between = self._build_arcs(between), between
            self._scripts.clear()

    def _may_be_still(self, f: Array, v: Array, stages: int) -> bool:
        """Return whether it is worth searching a chain for the cells that move."""
        size = self._shape[0]
        if len(self._shape) > 1 or size < 4 * RESTING_MARGIN or stages * size < MIN_SEARCHED_WORK:
            return False
        return 2 * max(self._reach) <= RESTING_MARGIN and seems_still(f, v)

    def _advance_moving(
        self,
        f: Array,
        v: Array,
        drifts: Array,
        kicks: Array,
        stages: int,
        ahead: float,
        moving: tuple[_Arc, int] | None,
    ) -> None:
        """Advance the moving cells only; find them anew before waves can leave their arc."""
        self._divide(len(kicks))
        self._drift(f, v, -ahead)
        done, arc = 0, None
        while moving is not None and done < stages:
            if moving[0] is not arc:
                arc = moving[0]
                store = arc.script(arc.store(f, v))
                arc.script(arc.load(f, v))()
            count = min(moving[1], stages - done)
            arc.script(arc.run(drifts, kicks, done, count))()
            store()
            done += count
            moving = self._moving_arc(f, v, kicks) if done < stages else None
        if done < stages:
            drifts, kicks = np.roll(drifts, -done, axis=0), np.roll(kicks, -done, axis=0)
            self._advance_whole(f, v, drifts, kicks, stages - done, 0.0)
        self._drift(f, v, ahead)

    def _drift(self, f: Array, v: Array, length: float) -> None:
        """Advance all positions by ``length`` times the velocities."""
        for arc in self._arcs if length else ():
            arc.script(arc.drift(f, v, length))()

    def _moving_arc(self, f: Array, v: Array, kicks: Array) -> tuple[_Arc, int] | None:
        """Return an arc with all moving cells, and the stages it lasts for; None if too large."""
        size = self._shape[0]
        first, past = shortest_arc(moving_cells(f, v) | self._sources(kicks))
        begin, end, arc = self._cached_arc or (0, 0, None)
        below, above = (first - begin) % size, (end - past) % size
        if (
            arc is None
            or below + past - first + above != end - begin
            or min(below, above) < RESTING_MARGIN // 2
        ):
            below = above = RESTING_MARGIN
            begin, end = first - below, past + above
            if end - begin > ALONE_FRACTION * size / (2 if self._stages_between(len(kicks)) else 1):
                return None
            arc = self._arc((begin, end), (0, 0))
            self._cached_arc = begin, end, arc
        return arc, min(below, above) // max(1, *self._reach)

    def _sources(self, kicks: Array) -> Mask:
        """Return a mask of the cells of a chain at rest that one stage sets in motion."""
        if self._moved_from_rest is None:
            f, v = np.zeros((2, self._fields, *self._shape))
            weights = np.random.default_rng(0).uniform(0.5, 1.0, kicks[:1].shape)  # none cancel
            self._advance_whole(f, v, np.ones(1), weights, 1, 0.0)
            self._moved_from_rest = moving_cells(f, v)
        return self._moved_from_rest

    def _scripts_between(
        self, f: Array, v: Array, drifts: Array, kicks: Array, stages: int, ahead: float
    ) -> Iterator[list[_Script]]:
        """Yield the scripts of all arcs from one synchronisation to the next."""
        work = [partial(_Arc.load, f=f, v=v)]
        between = self._between or max(stages, 1)
        for done in range(0, stages, between):
            work += [
                partial(meet, f=f, v=v) for meet in (_Arc.store_shared, _Arc.load_ghosts) if done
            ]
            length = min(between, stages - done)
            work.append(partial(_Arc.run, drifts=drifts, kicks=kicks, begun=done, stages=length))
        work.append(partial(_Arc.store, f=f, v=v))
        if ahead:
            back, on = (partial(_Arc.drift, f=f, v=v, length=by) for by in (-ahead, ahead))
            work = [back, *work, on]
        for together in [[do] for do in work] if self._between else [work]:
            yield [arc.script(*(do(arc) for do in together)) for arc in self._arcs]

    def _stages_between(self, period: int) -> int:
        """Return the number of stages between two synchronisations of two cores; 0 for one core."""
        cells = math.prod(self._shape) * self._fields
        if cells < MIN_SHARED_VALUES or usable_cores() < 2:
            return 0
        most = int(MAX_REPEATED_FRACTION * self._shape[0]) // (2 * max(1, sum(self._reach)))
        stages = min(MAX_STEPS_APART * period, most)
        return stages if stages * cells >= MIN_SHARED_WORK else 0

    @cached_property
    def _reach(self) -> tuple[int, int]:
        """Numbers of cells (in a plane, rows) above and below a cell that a stage depends on."""
        flow = self._flow if len(self._shape) == 1 else rows_of(self._flow)
        return flow.skew, flow.below

    def _build_arcs(self, between: int) -> list[_Arc]:
        """Build one arc, or two for two cores, and load the deviations of cells."""
        size, half = self._shape[0], self._shape[0] // 2
        skew, below = self._reach
        ends = [(0, half), (half, size)] if between else [(0, size)]
        ghosts = between * below, between * skew
        return [self._arc(own, ghosts) for own in ends]

    def _arc(self, own: tuple[int, int], ghosts: tuple[int, int]) -> _Arc:
        """Return an arc of the cells ``own`` with ``ghosts`` at its ends; load its deviations."""
        arc = _Arc(self._flow, self._numbers, self._shape, own, ghosts)
        if len(self._resting):
            arc.script(arc.load_deviations(self._resting, self._fields))()
        return arc


def _on_cores(scripts: list[_Script]) -> None:
    """Run each script on a core of its own and wait for all."""
    here, *others = scripts
    waiting = [other_core().submit(there) for there in others]
    here()
    for one in waiting:
        one.result()
