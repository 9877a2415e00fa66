"""Jobs in worker processes that end with their command on Ctrl-C; limits of time and memory."""

import multiprocessing as mp
import os
import signal
import sys
import threading
from collections.abc import Callable, Hashable, Iterator, Mapping
from concurrent.futures import FIRST_EXCEPTION, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager, suppress
from ctypes import c_double
from dataclasses import dataclass
from multiprocessing.context import SpawnContext
from pathlib import Path
from typing import Any, TypeVar

Key = tuple[str, object]
"""What a job of a study is called by: a kind and a subject."""

Subject = TypeVar("Subject", bound=Hashable)
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


def run_jobs(jobs: Mapping[Subject, Job], workers: int, progress: Progress) -> dict[Subject, Any]:
    """Do all jobs in `workers` processes, the longest first; return the results under their keys.

    `progress` is called from time to time with the share of the work done, 0 .. 1. The first
    failing job's exception is raised here and the jobs not yet begun are dropped.

    Raises ValueError unless workers >= 1.
    """
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
    context = pool_context()
    ordered = sorted(jobs, key=lambda key: jobs[key].weight, reverse=True)
    weights = [jobs[key].weight for key in ordered]
    shares: Any = context.Array(c_double, len(jobs), lock=False)

    def report() -> None:
        done = sum(weight * share for weight, share in zip(weights, shares, strict=True))
        progress(min(1.0, done / sum(weights)))

    with ProcessPoolExecutor(workers, context, _begin, (shares,)) as pool, stopping(pool):
        with starting_workers():
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


def ignore_interrupt() -> None:
    """Leave Ctrl-C to the parent; for workers to call first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def pool_context() -> SpawnContext:
    """Where a pool takes fresh interpreters from.

    A command that is ended while it works leaves the locks of its pool to Python's tracker, which
    removes them; that it does so is nothing to warn of.
    """
    if os.name == "posix":
        from multiprocessing.resource_tracker import ensure_running

        given = sys.warnoptions[:]
        sys.warnoptions.append("ignore:resource_tracker:UserWarning")  # an option of its process
        try:
            ensure_running()
        finally:
            sys.warnoptions[:] = given
    return mp.get_context("spawn")


@contextmanager
def starting_workers() -> Iterator[None]:
    """Block Ctrl-C while processes are started, which inherit that: they end with their command.

    Else one that is still importing would show where it was interrupted.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def stopping(pool: ProcessPoolExecutor) -> Iterator[None]:
    """On Ctrl-C in the body, drop the jobs and end the workers instead of waiting for them."""
    try:
        yield
    except (KeyboardInterrupt, GeneratorExit):
        workers = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.kill()
        raise


class OutOfTime(BaseException):
    """The limit has passed; what catches every Exception does not catch this."""


def limit_memory(beyond: int) -> None:
    """Let this process take so many bytes more than it has, where the system can say and do so."""
    import resource  # where there is fork

    with suppress(OSError, ValueError):
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + beyond
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


@contextmanager
def time_limit(seconds: float, passing: bool = False) -> Iterator[None]:
    """Raise OutOfTime in what runs inside after ``seconds``; only a main thread can be stopped.

    They are seconds of the processor, or with ``passing`` of the clock. What is raised in a
    finalizer or in a callback of compiled code is lost there, so it is raised again and again, and
    at the latest at the end of the body.

    >>> with time_limit(10.0):
    ...     print("done")
    done
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    late = over = False

    def stop(*_: object) -> None:
        nonlocal late
        late = True
        if not over:
            raise OutOfTime

    timer, number = signal.ITIMER_PROF, signal.SIGPROF
    if passing:
        timer, number = signal.ITIMER_REAL, signal.SIGALRM
    before = signal.signal(number, stop)
    signal.setitimer(timer, seconds, POLL)
    try:
        yield
    finally:
        over = True
        signal.setitimer(timer, 0.0)
        signal.signal(number, before)
    if late:
        raise OutOfTime
