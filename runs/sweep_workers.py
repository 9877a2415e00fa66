"""Where a sweep's batches are done: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import multiprocessing as mp
import os
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any, Protocol

from longwave.runs.worker_code import check_cluster
from longwave.support.checkpoint_folder import LOG
from longwave.support.compiled.cores import usable_cores
from longwave.support.dask_cluster import connect
from longwave.support.processes import ignore_interrupt, pool_context

PATIENCE = 1.0
"""Seconds that workers have to pack what they have when the sweep is stopped."""


LOOKING = 2.0
"""Seconds between two looks at a cluster."""


class Promise(Protocol):
    """What will be there: a `Future` of this library or of Dask."""

    def result(self) -> Any:
        """What the call returned; raises what it raised."""

    def add_done_callback(self, told: Callable[[Any], object]) -> Any:
        """Have a function called when the result is there."""


class Workers(Protocol):
    """Processes that make calls."""

    count: int
    """Calls that are made at once."""

    def submit(self, function: Callable[..., Any], *arguments: object) -> Promise:
        """Have a call made."""

    def has_lost(self, error: BaseException) -> bool:
        """Whether a call failed as its worker did: it was killed, or had no memory."""

    def renew(self) -> None:
        """Replace workers that are gone."""

    def look(self) -> None:
        """Tell if there is nobody to work; for who waits to call now and then."""

    def stop(self) -> None:
        """End all work within two seconds; a batch keeps what is done of it."""


class LocalWorkers:
    """Processes of this machine, each with one thread; they end with this one, however it ends."""

    def __init__(self, count: int) -> None:
        self.count = count
        self._pool: ProcessPoolExecutor | None = None

    def submit(self, function: Callable[..., Any], *arguments: object) -> Future[Any]:
        """Have a call made."""
        if self._pool is None:
            self._pool = ProcessPoolExecutor(self.count, pool_context(), _begin)
        return self._pool.submit(function, *arguments)

    def has_lost(self, error: BaseException) -> bool:
        """Whether a process ended under its call."""
        return isinstance(error, BrokenProcessPool)

    def renew(self) -> None:
        """Drop the processes; new ones begin with the next call."""
        self.stop()

    def look(self) -> None:
        """Nothing: processes are begun when they are needed."""

    def stop(self) -> None:
        """Tell the processes to end, and kill those that do not."""
        if self._pool is None:
            return
        processes = list((self._pool._processes or {}).values())
        self._pool.shutdown(wait=False, cancel_futures=True)
        for process in processes:
            process.terminate()
        end = time.monotonic() + PATIENCE
        for process in processes:
            process.join(max(0.0, end - time.monotonic()))
            if process.is_alive():
                process.kill()
        self._pool = None


def _begin() -> None:
    """In a new process: leave Ctrl-C to the parent, and end when that has ended."""
    ignore_interrupt()
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy is imported
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = mp.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


class DaskWorkers:
    """The workers of a Dask cluster; `dask.distributed` comes with the extra ``cluster``."""

    def __init__(self, address: str) -> None:
        self._client = connect(address, "longwave.runs.worker_code:code_here")
        try:
            check_cluster(self._client)
        except ValueError:
            self.stop()
            raise
        self._looked, self._are_gone = time.monotonic() - LOOKING, False
        self.look()
        threads: dict[str, int] = self._client.nthreads()
        self.count = max(1, sum(threads.values()))

    def submit(self, function: Callable[..., Any], *arguments: object) -> Any:
        """Have a call made, again on another worker if its own is lost."""
        return self._client.submit(function, *arguments, pure=False)

    def has_lost(self, error: BaseException) -> bool:
        """Whether several workers were lost under the call."""
        from distributed import KilledWorker

        return isinstance(error, KilledWorker)

    def renew(self) -> None:
        """Nothing: a cluster replaces its workers itself."""

    def look(self) -> None:
        """Tell if the cluster has no workers: others may come."""
        if time.monotonic() < self._looked + LOOKING:
            return
        gone = not self._client.nthreads()
        if gone and not self._are_gone:
            LOG.info("the cluster has no workers, which are waited for (Ctrl-C stops it)")
        self._looked, self._are_gone = time.monotonic(), gone

    def stop(self) -> None:
        """Drop what has not begun and leave the cluster."""
        self._client.close(timeout=PATIENCE)


@contextmanager
def sweep_workers(processes: int | None, scheduler: str | None) -> Iterator[Workers]:
    """Workers here, by default one for each core, or those of a cluster.

    Raises ValueError in one line for both at once, for less than one process and for a cluster that
    does not answer.
    """
    if scheduler is not None and processes is not None:
        raise ValueError(
            f"--processes must not be given with --scheduler, got {processes} (leave one out)"
        )
    if processes is not None and not 1 <= processes <= MOST_PROCESSES:
        raise ValueError(
            f"--processes must be 1 to {MOST_PROCESSES}, got {processes} (one a core is usual)"
        )
    workers: Workers = (
        DaskWorkers(scheduler)
        if scheduler is not None
        else LocalWorkers(processes or usable_cores())
    )
    try:
        yield workers
    finally:
        workers.stop()


MOST_PROCESSES = 1024
