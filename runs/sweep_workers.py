"""Workers of a sweep: processes on this machine, or those of a Dask cluster.

A worker must run the code from which the keys of its cells were computed.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from itertools import chain
from typing import TYPE_CHECKING

from longwave.runs.run_store import code_digest
from longwave.support.compiled.cores import usable_cores
from longwave.support.dask_cluster import DaskWorkers
from longwave.support.processes import LocalWorkers, Workers
from longwave.support.provenance import changed_parts, provenance

if TYPE_CHECKING:
    from distributed import Client

MAX_PROCESSES = 1024
"""Largest accepted number of worker processes."""


@contextmanager
def sweep_workers(processes: int | None, scheduler: str | None) -> Iterator[Workers]:
    """Yield workers on this machine, by default one for each core, or those of a cluster.

    Raises ValueError in one line as `check_workers` does, and if the cluster does not answer or has
    workers with other code.
    """
    check_workers(processes, scheduler)
    workers: Workers = (
        DaskWorkers(scheduler, "longwave.runs.sweep_workers:process_code", check_cluster)
        if scheduler is not None
        else LocalWorkers(processes or usable_cores(), use_one_thread)
    )
    try:
        yield workers
    finally:
        workers.stop()


def check_workers(processes: int | None, scheduler: str | None) -> None:
    """Raise ValueError in one line if both arguments are given or ``processes`` is out of range."""
    if scheduler is not None and processes is not None:
        got = f"{processes} (leave one out)"
        raise ValueError(f"--processes must not be given with --scheduler, got {got}")
    if processes is not None and not 1 <= processes <= MAX_PROCESSES:
        got = f"{processes} (one a core is usual)"
        raise ValueError(f"--processes must be 1 to {MAX_PROCESSES}, got {got}")


def use_one_thread() -> None:
    """Limit BLAS to one thread. Call this before NumPy is imported."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


DIGEST = "digest"
"""Key under which `process_code` returns the digest of the code."""

COMPARED_PARTS = ("code", "versions")
"""Parts of `provenance` that are compared to report how the code of two processes differs."""

MAX_REPORT_CHARACTERS = 200
"""Largest number of characters of the report on how two codes differ."""


@lru_cache
def process_code() -> Mapping[str, str]:
    """Return the code version of this process, and its digest as used in run keys."""
    origin = provenance()
    return {DIGEST: code_digest()} | {name: origin[name] for name in COMPARED_PARTS}


def check_code(expected: Mapping[str, str]) -> None:
    """Raise ValueError if this process runs other code than ``expected``."""
    _check_same_code(expected, process_code(), socket.gethostname())


def check_cluster(client: Client) -> None:
    """Raise ValueError if a worker of the cluster runs other code than this process."""
    for address, worker_code in client.run(process_code).items():
        _check_same_code(process_code(), worker_code, address)


def _check_same_code(expected: Mapping[str, str], actual: Mapping[str, str], worker: str) -> None:
    if actual[DIGEST] == expected[DIGEST]:
        return
    lines = (changed_parts(name, expected[name], actual[name]) for name in COMPARED_PARTS)
    differences = "; ".join(chain.from_iterable(lines)).replace(", was ", ", here ")
    raise ValueError(
        f"workers must have the same longwave and packages as this machine, got {worker} with "
        f"{differences[:MAX_REPORT_CHARACTERS]} (install the same versions there, or start again "
        "if sources changed)"
    )
