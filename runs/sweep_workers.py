"""Where a sweep's batches are done: in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

from longwave.runs.worker_code import check_cluster
from longwave.support.compiled.cores import usable_cores
from longwave.support.dask_cluster import DaskWorkers
from longwave.support.processes import LocalWorkers, Workers

MOST_PROCESSES = 1024


@contextmanager
def sweep_workers(processes: int | None, scheduler: str | None) -> Iterator[Workers]:
    """Workers here, by default one for each core, or those of a cluster.

    Raises ValueError in one line for both at once, for less than one process and for a cluster that
    does not answer, or has workers that would make other runs than this process.
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
        DaskWorkers(scheduler, "longwave.runs.worker_code:code_here", check_cluster)
        if scheduler is not None
        else LocalWorkers(processes or usable_cores(), use_one_thread)
    )
    try:
        yield workers
    finally:
        workers.stop()


def use_one_thread() -> None:
    """Have linear algebra leave the other cores to the other workers; before NumPy is imported."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
