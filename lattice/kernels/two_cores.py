"""A long ring on two cores: each advances one arc of it.

An arc is advanced together with the sites about it that its steps reach (a stage reaches one site
on either side), so the two need to meet after a number of steps only. What is computed twice is
computed alike: the result is that of one core, to the bit.
"""

import multiprocessing
import os
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lattice.kernels.blocked import advance_tiled
from lattice.kernels.vector import LANES

Array = NDArray[np.float64]
Ring = tuple[Array, Array]
Work = tuple[Array, Array, int, float, float | None, float | None]

SITES = 16_384
"""Sites from which on the second core pays (measured: 1.5 to 1.8 times as fast up to 65 536)."""

TOGETHER = 64
"""Most steps between two meetings."""


def pays(size: int) -> bool:
    """Whether a ring of that size is advanced on two cores.

    Not in a worker process: there the other core has work of its own.
    """
    if size < SITES:
        return False
    return (os.cpu_count() or 1) > 1 and multiprocessing.parent_process() is None


@lru_cache(maxsize=1)
def _other_core() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(1, thread_name_prefix="arc")


def advance_on_arcs(
    ring_y: Array,
    ring_s: Array,
    drifts: Array,
    kicks: Array,
    steps: int,
    *constants: *tuple[float, float | None, float | None],
) -> None:
    """Advance the ring (y, s) in place, as `tiled.advance_tiled` does with the same arguments.

    At least 4 (``TOGETHER`` stages + ``LANES``) sites.
    """
    last = drifts[-1]
    joint = drifts.copy()
    joint[0], joint[-1] = drifts[0] + last, 0.0
    ring, other = (ring_y - last * ring_s, ring_s.copy()), (ring_y.copy(), ring_s.copy())
    middle, done = ring_y.size // 2, 0
    while done < steps:
        block = min(TOGETHER, steps - done)
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
    advance_tiled(y, s, *work)
    for values, found in zip((y, s), result, strict=True):
        found[first:past] = values[reach : reach + past - first]
