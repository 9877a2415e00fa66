"""Where a sweep's batches are done: in processes of this machine, or on a Dask cluster.

A worker must run the code that the keys of its cells are of.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from typing import TYPE_CHECKING

from longwave.runs.run_store import code_that_matters
from longwave.support.compiled.cores import usable_cores
from longwave.support.dask_cluster import DaskWorkers
from longwave.support.processes import LocalWorkers, Workers
from longwave.support.provenance import changed_parts, provenance

if TYPE_CHECKING:
    from distributed import Client

MOST_PROCESSES = 1024


@contextmanager
def sweep_workers(processes: int | None, scheduler: str | None) -> Iterator[Workers]:
    """Workers here, by default one for each core, or those of a cluster.

    Raises ValueError in one line as `check_workers` does, and for a cluster that does not answer,
    or has workers that would make other runs than this process.
    """
    check_workers(processes, scheduler)
    workers: Workers = (
        DaskWorkers(scheduler, "longwave.runs.sweep_workers:code_here", check_cluster)
        if scheduler is not None
        else LocalWorkers(processes or usable_cores(), use_one_thread)
    )
    try:
        yield workers
    finally:
        workers.stop()


def check_workers(processes: int | None, scheduler: str | None) -> None:
    """Raise ValueError in one line for both at once, and for less than one process."""
    if scheduler is not None and processes is not None:
        raise ValueError(
            f"--processes must not be given with --scheduler, got {processes} (leave one out)"
        )
    if processes is not None and not 1 <= processes <= MOST_PROCESSES:
        raise ValueError(
            f"--processes must be 1 to {MOST_PROCESSES}, got {processes} (one a core is usual)"
        )


def use_one_thread() -> None:
    """Have linear algebra leave the other cores to the other workers; before NumPy is imported."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")


DIGEST = "digest"

TOLD = ("code", "versions")
"""Parts of `provenance` that say in what codes differ."""

LONGEST = 200
"""Characters of that."""


@lru_cache
def code_here() -> Mapping[str, str]:
    """What this process computes runs by, and the digest of it that is in their keys."""
    made = provenance()
    return {DIGEST: code_that_matters()} | {name: made[name] for name in TOLD}


def check_code(asked: Mapping[str, str]) -> None:
    """Raise ValueError if this process would make other runs than the keys of ``asked`` say."""
    _check(asked, code_here(), socket.gethostname())


def check_cluster(client: Client) -> None:
    """Raise ValueError if a worker of the cluster would make other runs than this process."""
    for address, there in client.run(code_here).items():
        _check(code_here(), there, address)


def _check(asked: Mapping[str, str], there: Mapping[str, str], where: str) -> None:
    if there[DIGEST] == asked[DIGEST]:
        return
    lines = [line for name in TOLD for line in changed_parts(name, asked[name], there[name])]
    told = "; ".join(lines).replace(", was ", ", here ")
    raise ValueError(
        f"workers must have the longwave and the packages of this machine, whose digest is in the "
        f"keys of runs, got {where} with {told[:LONGEST]} (install the same there, or start again "
        "where sources changed)"
    )
