"""Sweeps on worker processes, here and on a Dask cluster of this machine, some of them killed."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from runs.run_store import RunStore
from runs.sweep import SweepState, run_sweep
from runs.sweep_dataset import sweep_dataset
from runs.sweep_file import Sweep, sweep_of
from runs.sweep_workers import DaskWorkers, LocalWorkers, sweep_workers

SOLITON = {
    "wave": "soliton_sech",
    "eps": 0.1,
    "t0": 0,
    "snapshots": [0, 50],
    "curve_points": 3,
    "lattice": {"K2": 1, "K4": 1},
    "parameters": {"A": 1},
    "scheme": {"step": 0.25},
    "domain": {"kind": "window", "sites": 2048, "compared": 20},
}


def soliton_sweep(count: int) -> Sweep:
    return sweep_of(
        {"scene": SOLITON, "grid": {"parameters.A": {"from": 0.5, "to": 1, "count": count}}}
    )


def children(process: int) -> list[int]:
    found = subprocess.run(["pgrep", "-P", str(process)], capture_output=True, text=True)
    return [int(line) for line in found.stdout.split()]


@pytest.mark.parametrize(
    ("processes", "scheduler", "told"),
    [
        (0, None, "--processes must be 1 to 1024, got 0"),
        (2, "tcp://127.0.0.1:1", "--processes must not be given with --scheduler, got 2"),
    ],
)
def test_workers_that_cannot_be_are_refused(
    processes: int, scheduler: str | None, told: str
) -> None:
    with pytest.raises(ValueError, match=told), sweep_workers(processes, scheduler):
        pass


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> np.ndarray[Any, Any]:
    """The strains of 24 cells, by processes of this machine of which one is killed on the way."""
    sweep, store = soliton_sweep(24), RunStore(tmp_path_factory.mktemp("local"))
    killed: list[int] = []

    def kill(_: SweepState) -> None:
        if not killed and workers._pool is not None:
            killed.append(next(iter(workers._pool._processes)))
            os.kill(killed[0], signal.SIGKILL)

    workers = LocalWorkers(2)
    try:
        state = run_sweep(sweep, store, workers, kill)
    finally:
        workers.stop()
    assert killed
    assert (state.done, state.faults) == (24, 0)
    found = sweep_dataset(sweep, store)
    assert set(found.status.values) == {"done"}
    return found.strain.values


@pytest.mark.slow
def test_a_killed_process_costs_a_repeat(plain: np.ndarray[Any, Any], tmp_path: Path) -> None:
    from runs.run_file import run_any_scene

    sweep = soliton_sweep(24)
    for cell in (0, 11, 23):
        wanted = run_any_scene(sweep.scene(cell)).strain.values
        np.testing.assert_array_equal(plain[cell], wanted)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning:distributed", "ignore::ResourceWarning")
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_a_dask_cluster_gives_the_same_bits_though_a_worker_is_killed(
    plain: np.ndarray[Any, Any], dask_cluster: Any, tmp_path: Path
) -> None:
    sweep, store = soliton_sweep(24), RunStore(tmp_path)
    killed: list[int] = []

    def kill(_: SweepState) -> None:
        if not killed:
            killed.append(dask_cluster.workers[0].process.process.pid)
            os.kill(killed[0], signal.SIGKILL)

    with sweep_workers(None, dask_cluster.scheduler_address) as workers:
        assert workers.count == 2
        state = run_sweep(sweep, store, workers, kill)
    assert killed
    assert (state.done, state.faults) == (24, 0)
    found = sweep_dataset(sweep, store)
    assert set(found.status.values) == {"done"}
    np.testing.assert_array_equal(found.strain.values, plain)


@pytest.mark.slow
def test_a_cluster_that_does_not_answer_is_told_within_seconds() -> None:
    begun = time.monotonic()
    with pytest.raises(ValueError, match="--scheduler must be the address of a Dask scheduler"):
        DaskWorkers("tcp://127.0.0.1:9")
    assert time.monotonic() - begun < 30


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done_and_ends_the_workers(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(
        'scene = "toda_soliton"\n[grid]\neps = {from = 0.1, to = 0.2, count = 5000}\n'
    )
    command = [sys.executable, "-m", "longwave", "sweep", "mine.toml", "--processes", "2"]
    house = Path(__file__).parents[2]
    running = subprocess.Popen(
        command,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(house)},
        stderr=subprocess.PIPE,
        text=True,
    )
    packs = tmp_path / "mine.store" / "packs"
    stop = threading.Timer(100, running.kill)
    stop.start()
    while running.poll() is None and not (packs.is_dir() and len(list(packs.iterdir())) > 2):
        time.sleep(0.1)
    workers = children(running.pid)
    running.send_signal(signal.SIGINT)
    told = running.communicate()[1].splitlines()
    stop.cancel()
    assert running.returncode == 130
    assert "interrupted" in told[-1]
    assert "of 5000 cells are kept" in told[-1]
    deadline = time.monotonic() + 20
    while any(Path(f"/proc/{worker}").exists() for worker in workers):
        assert time.monotonic() < deadline
        time.sleep(0.1)
