"""Sweeps on worker processes, local and on a Dask cluster, some of which are killed."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from longwave.runs import sweep
from longwave.runs.run_store import RunStore
from longwave.runs.sweep import SweepState, run_sweep
from longwave.runs.sweep_dataset import sweep_dataset
from longwave.runs.sweep_file import Sweep, sweep_of
from longwave.runs.sweep_workers import sweep_workers

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


def children(process: int, named: str = "") -> list[int]:
    command = ["pgrep", "-P", str(process), "-f", named]
    found = subprocess.run(command, capture_output=True, text=True)
    return [int(line) for line in found.stdout.split()]


@pytest.mark.parametrize(
    ("processes", "scheduler", "message"),
    [
        (0, None, "--processes must be 1 to 1024, got 0"),
        (2, "tcp://127.0.0.1:1", "--processes must not be given with --scheduler, got 2"),
    ],
)
def test_impossible_workers_are_refused(
    processes: int, scheduler: str | None, message: str
) -> None:
    with pytest.raises(ValueError, match=message), sweep_workers(processes, scheduler):
        pass


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> np.ndarray[Any, Any]:
    """Return the strains of 24 cells, from local processes of which one is killed."""
    sweep, store = soliton_sweep(24), RunStore(tmp_path_factory.mktemp("local"))
    killed: list[int] = []

    def kill(_: SweepState) -> None:
        if not killed:
            killed.append(children(os.getpid(), "spawn_main")[0])
            os.kill(killed[0], signal.SIGKILL)

    with sweep_workers(2, None) as workers:
        state = run_sweep(sweep, store, workers, kill)
    assert killed
    assert (state.done, state.faults) == (24, 0)
    found = sweep_dataset(sweep, store)
    assert set(found.status.values) == {"done"}
    return found.strain.values


@pytest.mark.slow
def test_cells_of_a_killed_process_are_run_again(
    plain: np.ndarray[Any, Any], tmp_path: Path
) -> None:
    from longwave.scenes.engines import scene_run

    sweep = soliton_sweep(24)
    for cell in (0, 11, 23):
        expected = scene_run.run(sweep.scene(cell)).strain.values
        np.testing.assert_array_equal(plain[cell], expected)


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


@contextmanager
def dask_process(kind: str, *words: str, **environment: str) -> Iterator[None]:
    """Start ``dask scheduler`` or ``dask worker``; stop it at the end of the context."""
    command = [sys.executable, "-m", f"distributed.cli.dask_{kind}", *words, "--no-dashboard"]
    house = str(Path(__file__).parents[2])
    begun = subprocess.Popen(
        command,
        env={**os.environ, "PYTHONPATH": house, **environment},
        stderr=subprocess.DEVNULL,
    )
    try:
        yield
    finally:
        begun.terminate()
        try:
            begun.wait(20)
        except subprocess.TimeoutExpired:  # a worker without a scheduler may wait for its own tasks
            begun.kill()
            begun.wait(600)


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """Return the address of a scheduler without workers."""
    file = tmp_path / "scheduler.json"
    words = ["--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file)]
    with dask_process("scheduler", *words):
        while not (file.exists() and (text := file.read_text(encoding="utf-8"))):
            time.sleep(0.1)
        yield json.loads(text)["address"]


def dask_worker(scheduler: str, **environment: str) -> AbstractContextManager[None]:
    return dask_process("worker", scheduler, "--nthreads", "1", "--no-nanny", **environment)


def wait_for_worker(scheduler: str) -> None:
    from distributed import Client

    with Client(scheduler, set_as_default=False) as client:
        client.wait_for_workers(1, timeout=600)


@pytest.mark.slow
def test_workers_without_the_stores_folder_send_their_packs(
    scheduler: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: Any
) -> None:
    """Workers with and without the folder give the same runs, even if they start late."""
    caplog.set_level("INFO", "longwave.store")
    saved: list[bytes] = []
    keep = sweep.write_sealed

    def counted(path: Path, pack: bytes, **options: Any) -> None:
        saved.append(pack)
        keep(path, pack, **options)

    monkeypatch.setattr(sweep, "write_sealed", counted)
    with sweep_workers(None, scheduler) as workers, dask_worker(scheduler):
        assert "the cluster has no workers" in caplog.text
        monkeypatch.chdir(tmp_path)
        for folder, sent in (("seen", False), ("/proc/self/cwd/unseen", True)):
            store = RunStore(folder)
            state = run_sweep(soliton_sweep(3), store, workers)
            assert (state.done, state.faults) == (3, 0)
            assert bool(saved) == sent
            assert set(sweep_dataset(soliton_sweep(3), store).status.values) == {"done"}
    assert not (Path(__file__).parents[2] / "unseen").exists()


@pytest.mark.slow
def test_a_lost_scheduler_ends_the_sweep_in_one_line(scheduler: str, tmp_path: Path) -> None:
    def shut(_: SweepState) -> None:
        with Client(scheduler, set_as_default=False) as client:
            client.shutdown()

    from distributed import Client

    message = pytest.raises(ValueError, match=r"^workers must run cells, .* \(check that the")
    with dask_worker(scheduler), sweep_workers(None, scheduler) as workers, message:
        run_sweep(soliton_sweep(24), RunStore(tmp_path), workers, shut)
    assert list((tmp_path / "packs").iterdir())


ANOTHER = """
from importlib import metadata
version = metadata.version
metadata.version = lambda package: "0" if package == "ducc0" else version(package)
"""
NONE = "import sys; sys.modules['longwave.runs'] = None\n"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("site", "message"), [(ANOTHER, "with versions: ducc0 0, here ducc0"), (NONE, "longwave.runs")]
)
def test_workers_with_another_longwave_or_none_are_refused(
    site: str, message: str, scheduler: str, tmp_path: Path
) -> None:
    (tmp_path / "sitecustomize.py").write_text(site)
    path = os.pathsep.join([str(tmp_path), os.environ.get("PYTHONPATH", "")])
    with dask_worker(scheduler, PYTHONPATH=path):
        wait_for_worker(scheduler)
        with pytest.raises(ValueError, match=rf"^[^\n]*{message}[^\n]*\(install [^\n]*$"):
            sweep_workers(None, scheduler).__enter__()


@pytest.mark.slow
def test_an_unreachable_cluster_is_reported_within_seconds() -> None:
    begun = time.monotonic()
    with pytest.raises(ValueError, match="--scheduler must be the address of a Dask scheduler"):
        sweep_workers(None, "tcp://127.0.0.1:9").__enter__()
    assert time.monotonic() - begun < 120


@pytest.mark.parametrize(("address", "why"), [("nowhere", "missing port"), ("foo://b:1", "scheme")])
def test_a_client_is_made_from_an_address_only(
    address: str, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A client made from another object prints a traceback when it is closed."""
    monkeypatch.delattr("distributed.Client.__init__")
    with pytest.raises(ValueError, match=f"^--scheduler must be the address .*{why}"):
        sweep_workers(None, address).__enter__()


@pytest.mark.slow
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_ctrl_c_keeps_what_is_done_and_ends_the_workers(
    number: int, status: int, tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_text(
        'scene = "toda_soliton"\n[grid]\neps = {from = 0.1, to = 0.2, count = 5000}\n'
    )
    command = [sys.executable, "-m", "longwave", "sweep", "mine.toml", "--processes", "2"]
    house = Path(__file__).parents[2]
    running = subprocess.Popen(  # a job in the background of a shell ignores Ctrl-C: not this one
        command,
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(house)},
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=partial(signal.signal, signal.SIGINT, signal.SIG_DFL),
    )
    packs = tmp_path / "mine.store" / "packs"
    stop = threading.Timer(400, running.kill)  # cold caches on a loaded machine took more than 100
    stop.start()
    while running.poll() is None and not (packs.is_dir() and len(list(packs.iterdir())) > 2):
        time.sleep(0.1)
    workers = children(running.pid)
    running.send_signal(number)
    message = running.communicate()[1].splitlines()
    stop.cancel()
    assert running.returncode == status
    assert "interrupted" in message[-1]
    assert not list((tmp_path / "mine.store").glob(".*.sweep"))
    assert "of 5000 cells are saved" in message[-1]
    deadline = time.monotonic() + 120
    while any(Path(f"/proc/{worker}").exists() for worker in workers):
        assert time.monotonic() < deadline
        time.sleep(0.1)
