"""Splitting schemes on a ring of any chain, by machine code that is written for it.

As `lattice.kernels.blocked` does for the FPUT lattice in its strain: cells in rows of lanes, all
stages of a few steps in one passage over the rows, a block at a time while it is in the cache. Lane
l begins at the cell ``l N // lanes``, so any number of cells is laid out; lanes may share one.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from longwave.lattice.kernels.native_code import ALIGNMENT, aligned, native_function
from longwave.lattice.kernels.streams import Flow, varied_flow

if TYPE_CHECKING:
    from longwave.lattice.numeric_lattice import NumericLattice

Array = NDArray[np.float64]
Places = NDArray[np.int64]

LANES = 8
"""Cells per row, one vector of 512 bits."""

LEAST_ROWED = 32
"""Cells from which on they are laid out in rows of ``LANES``."""

STAGES = 28
"""Most stages done in a passage."""

HALO = 4
"""The rows that a passage repeats at the ends are at most this part of the ring's own."""

MOST_KEPT = 12
"""Values that two stages together may keep from row to row: with the 15 of next-nearest neighbours
in the strain one stage alone is a fifth faster, with the 10 of three fields a seventh slower
on registers of eight doubles (`benchmarks/same_lattice.py`)."""

_ARGUMENTS = (*[ctypes.c_void_p] * 8, *[ctypes.c_int64] * 6)


def _together(flow: Flow) -> int:
    """The stages that go up the rows together."""
    return 2 if flow.kept(2) <= MOST_KEPT else 1


@lru_cache(maxsize=64)
def _passages(flow: Flow, lanes: int, count: int) -> Callable[..., None]:
    """The machine code; on disk it is found by what it is written from."""

    def written() -> str:
        from longwave.lattice.kernels.row_code import passage_text

        return passage_text(flow, lanes, _together(flow), count)

    key = f"{flow!r} {lanes} {_together(flow)} {count}"
    return native_function(__name__, key, written, "passages", _ARGUMENTS)


class Layout(NamedTuple):
    """Where cells stand: ``cells`` (rows, lanes) is the cell of every place.

    The ring's own rows begin at ``first``, after the ones that repeat what is below them. ``home``
    is the place of each cell there, ``target`` and ``source`` are what is repeated from where.
    """

    cells: Places
    home: Places
    target: Places
    source: Places


@lru_cache(maxsize=16)
def _layout(size: int, lanes: int, below: int, above: int) -> Layout:
    height = -(-size // lanes)
    starts = np.arange(lanes) * size // lanes
    rows = np.arange(below + height + above)
    cells = (starts + (rows[:, None] - below)) % size
    lane = np.searchsorted(starts, np.arange(size), side="right") - 1
    home = (below + np.arange(size) - starts[lane]) * lanes + lane
    outside = (rows < below) | (rows >= below + height)
    places = np.arange(cells.size).reshape(cells.shape)
    target = places[outside].ravel()
    return Layout(cells, home, target, home[cells[outside].ravel()])


def advance_chain(
    lattice: NumericLattice, f: Array, v: Array, drifts: Array, kicks: Array, steps: int
) -> None:
    """Advance the ring (f, v), of shape (fields, cells), in place by a drift-kick splitting.

    ``drifts`` (one longer than ``kicks``) and ``kicks`` are already multiplied by the time step;
    the last drift of a step and the first of the next are done as one.
    """
    last, joint = drifts[-1], drifts[:-1].copy()
    joint[0] += last
    if steps > 0:
        f -= last * v
        advance_stages(lattice, f, v, joint, kicks, steps * kicks.size)
        f += last * v


def advance_stages(
    lattice: NumericLattice, f: Array, v: Array, drifts: Array, kicks: Array, stages: int
) -> None:
    """So many stages, ``f += drift v`` and ``v += kick f''``, their weights in turn."""
    ordered, variation, shares = lattice.cellwise
    flow, numbers, units = varied_flow(ordered, variation)
    resting = shares * np.array(units)[:, None] if units else f[:0]
    size = f.shape[1]
    lanes = LANES if size >= LEAST_ROWED else 1
    height, halo = -(-size // lanes), max(1, flow.skew + flow.below)
    each = max(1, min(STAGES, height // (HALO * halo), stages))
    together = _together(flow)
    each -= each % together if each > together else 0
    layout = _layout(size, lanes, each * flow.below, each * flow.skew)
    margin = together * flow.skew * lanes
    plane = margin + layout.cells.size + ALIGNMENT
    rings = [aligned(flow.fields * plane) for _ in range(2)]
    planes = [ring[: flow.fields * plane].reshape(flow.fields, plane) for ring in rings]
    for held, ring in zip(planes, (np.vstack([f, resting]), v), strict=True):
        held[: len(ring), margin : margin + layout.cells.size] = ring[:, layout.cells.ravel()]
    repeated = kicks.size + each
    a, b = (np.ascontiguousarray(np.resize(weights, repeated)) for weights in (drifts, kicks))
    carried = aligned((each + together) * flow.kept(together) * lanes)
    numbers_array = np.array([*numbers, 0.0])
    passages = _passages(flow, lanes, len(numbers))

    def run(count: int, length: int, begun: int) -> None:
        passages(
            *(ring.ctypes.data + 8 * margin for ring in rings),
            carried.ctypes.data,
            a.ctypes.data + 8 * begun,
            b.ctypes.data + 8 * begun,
            numbers_array.ctypes.data,
            layout.target.ctypes.data,
            layout.source.ctypes.data,
            layout.target.size,
            plane,
            layout.cells.shape[0],
            length,
            count,
            kicks.size,
        )

    run(stages // each, each, 0)
    run(int(stages % each > 0), stages % each, stages // each * each % kicks.size)
    for held, ring in zip(planes, (f, v), strict=True):
        ring[:] = held[: len(ring), margin + layout.home]
