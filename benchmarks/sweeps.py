"""Cost of a sweep beyond its cells, and gain by a second core.

    python benchmarks/sweeps.py bookkeeping [CELLS]   # 10 000 small cells on all cores
    python benchmarks/sweeps.py speed [SCENES] [END]  # 400 to t = 16000: a loop, 1 and 2 processes
    python benchmarks/sweeps.py million [CELLS]       # 1 000 000, of which all but 1000 are there

Shares are of processor time, which a loaded machine changes little; the speed-up is of the clock
and needs two idle cores. A worker takes two seconds to start, which the speed-up of short sweeps
holds: longer scenes, to t = END, show what is left of it.
"""

from __future__ import annotations

import os
import resource
import sys
import tempfile
import time
from multiprocessing import active_children
from pathlib import Path
from statistics import median

import xarray as xr

from longwave.runs.run_pack import DONE, CellRecord, write_pack
from longwave.runs.run_store import RunStore
from longwave.runs.store_packs import new_pack
from longwave.runs.sweep import SweepState, run_sweep
from longwave.runs.sweep_cells import Cell, run_cells
from longwave.runs.sweep_dataset import cell_run, write_sweep
from longwave.runs.sweep_file import Sweep, sweep_of
from longwave.runs.sweep_workers import use_one_thread
from longwave.scenes.engines import scene_run
from longwave.support.compiled.cores import keep_to_one_core
from longwave.support.processes import Job, LocalWorkers, in_order

TEN = 10
"""Scenes that are run in one way before it is the other's turn."""

TOKEN = "token"
"""The file by which a worker knows the store."""

ROUNDS = 3
"""Sweeps on one process and on two, in turn."""

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
    """Return a sweep of so many cells over the soliton's height.

    Each takes 0.03 s of a processor to t = 50, 0.16 s to t = 16000.
    """
    heights = {"from": 0.5, "to": 1, "count": count}
    scene = SCENE | {"snapshots": [0, end]}
    return sweep_of({"scene": scene, "grid": {"parameters.A": heights}})


def resident(process: int | str = "self") -> float:
    """Return the resident memory of a process in megabytes."""
    pages = int(Path(f"/proc/{process}/statm").read_text(encoding="ascii").split()[1])
    return pages * resource.getpagesize() / 1e6


def bookkeeping(count: int) -> None:
    """Print what a sweep takes beyond the cells' own processor time, and its memory on the way."""
    sweep = sweep_of_solitons(count, 50.0)
    workers = LocalWorkers(os.cpu_count() or 1, use_one_thread)
    marks = dict.fromkeys((0.1, 0.5, 1.0), False)

    def look(state: SweepState) -> None:
        for share, is_marked in marks.items():
            if not is_marked and state.done >= share * state.cells:
                marks[share] = True
                memories = [f"{resident(one.pid):.0f}" for one in active_children() if one.pid]
                print(
                    f"{share:.0%} done: {resident():.0f} MB here, workers {', '.join(memories)} MB"
                )

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
        found = run_sweep(sweep, store, LocalWorkers(1)).stored
        resumed = time.process_time() - again
    own = state.processor_seconds
    there = state.worker_seconds - own
    print(f"{state.done} cells in {time.perf_counter() - begun:.0f} s: {own:.1f} s of a processor")
    print(f"beyond them: in workers {there:.2f} s, {there / own:.2%}; here {here:.2f} s,")
    print(f"{here / own:.2%}; writing the data set {written:.2f} s, {written / own:.2%}")
    print(f"in all {(there + here + written) / own:.2%}; finding {found} again {resumed:.2f} s")


def side_by_side(sweep: Sweep) -> tuple[float, float]:
    """Return processor seconds of a scene in a plain loop of runs, and in a worker's batches.

    Tens of scenes go to the one and to the other in turn, in one process that has done both
    before: what the machine gives changes within a minute by more than the two differ.
    """
    keep_to_one_core()
    spent, number = [0.0, 0.0], [0, 0]
    with tempfile.TemporaryDirectory() as folder:
        store = RunStore(folder)
        (Path(folder) / TOKEN).touch()
        for place in range(-2, len(sweep) // TEN):
            scenes = [sweep.scene(TEN * max(place, 0) + i) for i in range(TEN)]
            cells = [Cell(i, store.key(scene), scene) for i, scene in enumerate(scenes)]
            begun = time.process_time()
            if place % 4 in (1, 2):
                run_cells(cells, Path(folder), TOKEN)
            else:
                for scene in scenes:
                    scene_run.run(scene)
            if place >= 0:
                spent[place % 4 in (1, 2)] += time.process_time() - begun
                number[place % 4 in (1, 2)] += TEN
    return spent[0] / number[0], spent[1] / number[1]


def on_processes(sweep: Sweep, count: int) -> float:
    """Return seconds of a sweep with so many workers, their start and the data set included."""
    workers = LocalWorkers(count, use_one_thread)
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        try:
            run_sweep(sweep, RunStore(folder), workers)
        finally:
            workers.stop()
        write_sweep(sweep, RunStore(folder), Path(folder) / "out.nc")
        return time.perf_counter() - begun


def speed(count: int, end: float) -> None:
    """Print what a scene costs beside a plain loop, and how much faster two processes are."""
    sweep = sweep_of_solitons(count, end)
    ((loop, batch),) = in_order([Job(side_by_side, (sweep,))], LocalWorkers(1))
    print(f"a scene: {1e3 * loop:.1f} ms of a processor in a loop, {batch / loop:.3f} of it here")
    ratios = []
    for _ in range(ROUNDS):
        one, two = on_processes(sweep, 1), on_processes(sweep, 2)
        ratios.append(one / two)
        print(f"{count} scenes: {one:.1f} s on one process, {two:.1f} s on two: {one / two:.2f}")
    print(f"two processes are {median(ratios):.2f} times as fast (median)")


MISSED = 1000
"""Cells of the largest sweep that are run."""

PACKED = 5000
"""Cells in a pack of those that are not."""


def fill(sweep: Sweep, store: RunStore) -> None:
    """Write packs in which the cells are done, each with a run of one number, but for some."""
    run = xr.Dataset({"error": ("time", [0.0])})
    missing_step, records = len(sweep) // MISSED, list[CellRecord]()
    for number in range(len(sweep)):
        if number % missing_step:
            key = store.key(sweep.scene(number))
            records.append(CellRecord(key, DONE, "", {"error": 1e-3, "seconds": 1.0}, run))
        if records and (len(records) == PACKED or number == len(sweep) - 1):
            write_pack(new_pack(store.folder), records)
            records.clear()


def million(count: int) -> None:
    """Print what the start, the rest, the data set and one cell of a large sweep take."""
    half = round(count**0.5)
    grid = {
        "parameters.A": {"from": 0.5, "to": 1, "count": half},
        "eps": {"from": 0.1, "to": 0.11, "count": count // half},
    }
    sweep = sweep_of({"scene": SCENE | {"snapshots": [0, 10]}, "grid": grid})

    def report(what: str, begun: float, files: int) -> None:
        taken = time.perf_counter() - begun
        print(f"{what:32s} {taken:8.2f} s {files:7d} files {resident():7.0f} MB", flush=True)

    with tempfile.TemporaryDirectory() as folder:
        store = RunStore(Path(folder) / "store")

        def files() -> int:
            return sum(1 for path in store.folder.rglob("*") if path.is_file())

        begun = time.perf_counter()
        fill(sweep, store)
        report(f"{len(sweep)} cells made", begun, files())
        for what in ("first look, all packs read", "look by the index"):
            begun = time.perf_counter()
            stored_keys = store.stored_runs()
            report(what, begun, files())
        for what in ("resume", "again"):
            begun = time.perf_counter()
            workers = LocalWorkers(os.cpu_count() or 1, use_one_thread)
            try:
                done = run_sweep(sweep, store, workers, stored_keys=stored_keys).done
            finally:
                workers.stop()
            report(f"{what}: {done} run", begun, files())
            stored_keys = store.stored_runs()
        del stored_keys
        begun = time.perf_counter()
        write_sweep(sweep, store, Path(folder) / "out.nc")
        report("data set", begun, files())
        begun = time.perf_counter()
        cell_run(sweep, store, A=half // 2, eps=0)
        report("one cell", begun, files())


if __name__ == "__main__":
    kind, count = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 0
    if kind == "speed":
        speed(count or 400, float(sys.argv[3]) if len(sys.argv) > 3 else 16000.0)
    elif kind == "million":
        million(count or 1_000_000)
    else:
        bookkeeping(count or 10_000)
