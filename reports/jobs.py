"""Jobs in several processes, with their progress reported as one number."""

import multiprocessing as mp
from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import FIRST_EXCEPTION, Future, ProcessPoolExecutor, wait
from ctypes import c_double
from dataclasses import dataclass
from typing import Any, TypeVar

from verify.pool import ignore_interrupt, stopping

Key = TypeVar("Key", bound=Hashable)
Progress = Callable[[float], None]

POLL = 0.2
"""Seconds between two looks at the progress."""

_shares: Any = None


@dataclass(frozen=True)
class Job:
    """A call to make in a worker process, and about how many seconds it takes.

    With ``tells``, the function is called with a further argument: a function to be told the
    share of the work that is done, 0 .. 1. All parts must be picklable.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    weight: float
    tells: bool = False

    def run(self, progress: Progress) -> Any:
        """Make the call and return what it returns."""
        told = (progress,) if self.tells else ()
        found = self.function(*self.arguments, *told)
        progress(1.0)
        return found


def run_jobs(jobs: Mapping[Key, Job], workers: int, progress: Progress) -> dict[Key, Any]:
    """Do all jobs in `workers` processes, the longest first; return the results under their keys.

    `progress` is called from time to time with the share of the work done, 0 .. 1. The first
    failing job's exception is raised here and the jobs not yet begun are dropped.

    Raises ValueError unless workers >= 1.
    """
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
    context = mp.get_context("spawn")
    ordered = sorted(jobs, key=lambda key: jobs[key].weight, reverse=True)
    weights = [jobs[key].weight for key in ordered]
    shares: Any = context.Array(c_double, len(jobs), lock=False)

    def report() -> None:
        done = sum(weight * share for weight, share in zip(weights, shares, strict=True))
        progress(min(1.0, done / sum(weights)))

    with ProcessPoolExecutor(workers, context, _begin, (shares,)) as pool, stopping(pool):
        found = {key: pool.submit(_do, i, jobs[key]) for i, key in enumerate(ordered)}
        _watch(set(found.values()), report)
    progress(1.0)
    return {key: found[key].result() for key in jobs}


def _watch(pending: set[Future[Any]], report: Callable[[], None]) -> None:
    """Wait for the jobs, reporting meanwhile; cancel the rest and raise when one fails."""
    while pending:
        done, pending = wait(pending, POLL, FIRST_EXCEPTION)
        report()
        for job in done:
            if job.exception() is not None:
                for other in pending:
                    other.cancel()
                job.result()


def _begin(shares: Any) -> None:
    """Keep the array of progress shares in this worker process; leave Ctrl-C to the parent."""
    global _shares
    _shares = shares
    ignore_interrupt()


def _do(place: int, job: Job) -> Any:
    """Do one job in a worker process, writing its progress at its place."""

    def progress(share: float) -> None:
        _shares[place] = share

    return job.run(progress)
