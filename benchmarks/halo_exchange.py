"""A ring in blocks, one for each process, that exchange halos by MPI, against two threads.

The paper's chain. A process holds its block and a halo on either side, wide enough for the steps
between two exchanges: each of a step's stages leaves untrue what it reaches at either end. Block
and halos are advanced as a ring of their own by the kernel that advances whole rings. The ways run
in turn, each in processes of its own, and the least time of each counts. Blocks must end with the
bits of the ring that is advanced in as many calls; `integrate` makes calls of another length, by
which sites may differ as by rounding.

    pip install mpi4py mpich distributed
    python benchmarks/halo_exchange.py [--sites 100000 1000000 10000000] [--every 64]
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from large_rings import STEP, state
from problem import CONSTANTS, Array

from longwave.lattice import integrate
from longwave.lattice.dynamics import Dynamics
from longwave.lattice.kernels.streams import stage_plan
from longwave.lattice.schemes import REDUCED_PHASE_6
from longwave.support.compiled.cores import keep_to_one_core

LATTICE, SCHEME, PROCESSES = CONSTANTS.lattice, REDUCED_PHASE_6, "2"
WORK = 200_000_000
"""Sites times steps of a run, or two exchanges if these are more."""

Found = tuple[Array, float, float]
"""Positions at the end, seconds, and those of them that exchanges took, with their waits."""


def halo(every: int) -> int:
    """Return the number of cells at either end of a block that are wrong after so many steps."""
    flow, _ = stage_plan(LATTICE)
    return every * SCHEME.stages * max(flow.skew, flow.below)


def by_integrate(sites: int, steps: int, _: int) -> Found:
    """Advance the ring by `integrate`, which checks and returns the snapshots."""
    begun = time.perf_counter()
    found = integrate(LATTICE, state(sites), [steps * STEP], step=STEP, measure_error=False)
    return found.f[-1, 0], time.perf_counter() - begun, 0.0


def by_calls(sites: int, steps: int, every: int) -> Found:
    """Advance the ring by the kernel alone, ``every`` steps a call."""
    start, dynamics = state(sites), Dynamics(LATTICE)
    begun = time.perf_counter()
    for _ in range(steps // every):
        dynamics.advance(SCHEME, start.f, start.v, STEP, every)
    return start.f[0], time.perf_counter() - begun, 0.0


def by_one_thread(sites: int, steps: int, every: int) -> Found:
    """Run `by_calls` on one core."""
    keep_to_one_core()
    return by_calls(sites, steps, every)


def by_blocks(sites: int, steps: int, every: int) -> Found | None:
    """Advance one block in each process, with one thread; the first returns the whole ring."""
    from mpi4py import MPI

    keep_to_one_core()
    world, dynamics, width, waited = MPI.COMM_WORLD, Dynamics(LATTICE), halo(every), 0.0
    before, after = ((world.rank + by) % world.size for by in (-1, 1))
    first, past = (block * sites // world.size for block in (world.rank, world.rank + 1))
    f, v = (np.pad(ring[:, first:past], ((0, 0), (width, width))) for ring in state(sites).arrays)
    world.Barrier()
    begun = time.perf_counter()
    for _ in range(steps // every):
        entered = time.perf_counter()
        for cells in (f[0], v[0]):
            low, high = cells[width : 2 * width], cells[-2 * width : -width]
            world.Sendrecv(low, before, recvbuf=cells[-width:], source=after)
            world.Sendrecv(high, after, recvbuf=cells[:width], source=before)
        waited += time.perf_counter() - entered
        dynamics.advance(SCHEME, f, v, STEP, every)
    world.Barrier()
    spent = time.perf_counter() - begun
    blocks = world.gather(f[0, width:-width])
    return None if blocks is None else (np.concatenate(blocks), spent, waited)


WAYS = {
    "one thread": by_one_thread,
    "two threads": by_calls,
    "two threads, integrate": by_integrate,
    "two processes": by_blocks,
}


def in_processes(way: str, *counts: int) -> Found:
    """Return the result of a method run in processes of its own."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "found.npz"
        mpi = ["mpiexec", "-n", PROCESSES] if WAYS[way] is by_blocks else []
        words = [*mpi, sys.executable, __file__, "--way", way, str(path), *map(str, counts)]
        subprocess.run(words, check=True)
        with np.load(path) as found:
            return found["cells"], float(found["spent"]), float(found["waited"])


def leave(way: str, path: str, *counts: str) -> None:
    """Find it in this process, and leave it at the path."""
    WAYS[way](1000, 1, 1)  # loads the machine code
    found = WAYS[way](*map(int, counts))
    if found is not None:
        np.savez(path, **dict(zip(("cells", "spent", "waited"), found, strict=True)))


def compare(sites: int, every: int, rounds: int) -> None:
    """Print a row for each way."""
    steps = every * max(2, WORK // (sites * every))
    print(f"{sites} sites, {steps} steps, {every} a call; halos of {halo(every)} cells")
    found = {way: in_processes(way, sites, steps, every) for way in WAYS}
    for _ in range(rounds - 1):
        for way, best in found.items():
            found[way] = min(best, in_processes(way, sites, steps, every), key=lambda one: one[1])
    ring, threads, _ = found["two threads"]
    for way, (cells, spent, waited) in found.items():
        away = float(np.max(np.abs(cells - ring)))
        agree = "the same bits" if away == 0.0 else f"sites differ by up to {away:.0e}"
        print(
            f"  {way:22s} {sites * steps / spent / 1e6:5.0f} million site steps a second, "
            f"{threads / spent:.2f} of two threads; exchanges {waited / spent:.1%}; {agree}"
        )


def dask_seconds(exchanges: int = 200) -> float:
    """Return seconds of an exchange between two Dask workers: each takes both results."""
    from distributed import Client

    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        workers = list(client.scheduler_info()["workers"])
        ends = client.map(np.zeros, [halo(1)] * 2, pure=False)
        begun = time.perf_counter()
        for _ in range(exchanges):
            ends = [client.submit(np.add, *ends, workers=one, pure=False) for one in workers]
        client.gather(ends)
        return (time.perf_counter() - begun) / exchanges


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Blocks with halos against threads.")
    parser.add_argument("--sites", type=int, nargs="+", default=[10**5, 10**6, 10**7])
    parser.add_argument("--every", type=int, nargs="+", default=[64], help="steps an exchange")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--dask", action="store_true", help="only time an exchange by Dask")
    parser.add_argument("--way", nargs=5, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.way:
        leave(*options.way)
    elif options.dask:
        print(f"an exchange between two Dask workers: {dask_seconds() * 1e3:.2f} ms")
    else:
        for sites in options.sites:
            for every in options.every:
                compare(sites, every, options.rounds)
    return 0


if __name__ == "__main__":
    sys.exit(main())
