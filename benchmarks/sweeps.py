"""What a sweep costs beyond its cells, and what a second core gives.

    python benchmarks/sweeps.py bookkeeping [CELLS]   # 10 000 small cells on all cores
    python benchmarks/sweeps.py speed [SCENES] [END]  # 400 to t = 8000: loops, 1 and 2 processes

Shares are of processor time, which a loaded machine changes little; the speed-up is of the clock
and needs two idle cores. A worker takes two seconds to start, which the speed-up of short sweeps
holds: longer scenes, to t = END, show what is left of it.
"""

from __future__ import annotations

import multiprocessing as mp
import resource
import sys
import tempfile
import time
from pathlib import Path

from runs.run_file import run_any_scene
from runs.run_store import RunStore
from runs.sweep import SweepState, run_sweep
from runs.sweep_dataset import write_sweep
from runs.sweep_file import Sweep, sweep_of
from runs.sweep_workers import LocalWorkers
from solutions.run.cores import keep_to_one_core

SCENE = {
    "wave": "soliton_sech",
    "eps": 0.1,
    "t0": 0,
    "curve_points": 11,
    "tolerance": 1e-3,
    "lattice": {"K2": 1, "K4": 1},
    "parameters": {"A": 1},
    "domain": {"compared": 60},
}


def sweep_of_solitons(count: int, end: float) -> Sweep:
    """So many cells over the soliton's height; each takes 0.03 s of a processor to t = 50,
    0.08 s to t = 8000."""
    heights = {"from": 0.5, "to": 1, "count": count}
    scene = SCENE | {"snapshots": [0, end]}
    return sweep_of({"scene": scene, "grid": {"parameters.A": heights}})


def resident(process: int | str = "self") -> float:
    """Megabytes that a process has in memory."""
    pages = int(Path(f"/proc/{process}/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 1e6


def bookkeeping(count: int) -> None:
    """Print what a sweep takes beyond the cells' own processor time, and its memory on the way."""
    sweep, workers = sweep_of_solitons(count, 50.0), LocalWorkers(mp.cpu_count())
    marks = dict.fromkeys((0.1, 0.5, 1.0), False)

    def look(state: SweepState) -> None:
        for share, seen in marks.items():
            if not seen and state.done >= share * state.cells and workers._pool is not None:
                marks[share] = True
                held = [f"{resident(pid):.0f}" for pid in workers._pool._processes]
                print(f"{share:.0%} done: {resident():.0f} MB here, workers {', '.join(held)} MB")

    with tempfile.TemporaryDirectory() as folder:
        store = RunStore(folder)
        begun, spent = time.perf_counter(), time.process_time()
        try:
            state = run_sweep(sweep, store, workers, look)
        finally:
            workers.stop()
        here = time.process_time() - spent
        again = time.process_time()
        write_sweep(sweep, store, Path(folder) / "out.nc")
        written = time.process_time() - again
        again = time.process_time()
        found = run_sweep(sweep, store, LocalWorkers(1)).found
        resumed = time.process_time() - again
    own = state.processor_seconds
    there = state.worker_seconds - own
    print(f"{state.done} cells in {time.perf_counter() - begun:.0f} s: {own:.1f} s of a processor")
    print(f"beyond them: in workers {there:.2f} s, {there / own:.2%}; here {here:.2f} s,")
    print(f"{here / own:.2%}; writing the data set {written:.2f} s, {written / own:.2%}")
    print(f"in all {(there + here + written) / own:.2%}; finding {found} again {resumed:.2f} s")


def bare(sweep: Sweep) -> tuple[float, float]:
    """Seconds and processor seconds of a plain loop of runs; the first imports what they need."""
    keep_to_one_core()
    begun, spent = time.perf_counter(), time.process_time()
    for cell in range(len(sweep)):
        run_any_scene(sweep.scene(cell))
    return time.perf_counter() - begun, time.process_time() - spent


def on_processes(sweep: Sweep, count: int) -> tuple[float, float]:
    """Seconds of a sweep with so many workers, start and data set included, and of the processor.

    The latter is that of the workers in the cells' batches.
    """
    workers = LocalWorkers(count)
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        try:
            state = run_sweep(sweep, RunStore(folder), workers)
        finally:
            workers.stop()
        write_sweep(sweep, RunStore(folder), Path(folder) / "out.nc")
        return time.perf_counter() - begun, state.worker_seconds


def speed(count: int, end: float) -> None:
    """Print a sweep's time with one and with two processes beside that of a plain loop."""
    sweep = sweep_of_solitons(count, end)
    with mp.get_context("spawn").Pool(1) as pool:
        clock, spent = pool.apply(bare, (sweep,))
    print(f"plain loop: {clock:.1f} s, {1e3 * spent / count:.1f} ms of a processor each")
    with mp.get_context("spawn").Pool(2) as pool:
        at_once = max(clock for clock, _ in pool.map(bare, [sweep, sweep], chunksize=1))
    print(
        f"two such loops at once: {at_once:.1f} s, so a second core gives {2 * clock / at_once:.2f}"
    )
    one, by_one = on_processes(sweep, 1)
    print(
        f"one process: {one:.1f} s, {one / clock:.3f} of the loop; "
        f"{1e3 * by_one / count:.1f} ms each, {by_one / spent:.3f} of the loop"
    )
    two, by_two = on_processes(sweep, 2)
    print(
        f"two processes: {two:.1f} s, {one / two:.2f} times as fast as one; "
        f"{1e3 * by_two / count:.1f} ms each, {by_two / spent:.3f} of the loop"
    )


if __name__ == "__main__":
    kind, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 0
    if kind == "speed":
        speed(count or 400, float(sys.argv[3]) if len(sys.argv) > 3 else 8000.0)
    else:
        bookkeeping(count or 10_000)
