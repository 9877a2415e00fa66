"""Worker processes that end with their command on Ctrl-C, and work that ends with its time."""

import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager


def ignore_interrupt() -> None:
    """Leave Ctrl-C to the parent; for workers to call first."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def stopping(pool: ProcessPoolExecutor) -> Iterator[None]:
    """On Ctrl-C in the body, drop the jobs and end the workers instead of waiting for them."""
    try:
        yield
    except (KeyboardInterrupt, GeneratorExit):
        workers = list((pool._processes or {}).values())
        pool.shutdown(wait=False, cancel_futures=True)
        for worker in workers:
            worker.terminate()
        raise


__all__ = ["OutOfTime", "time_limit"]


class OutOfTime(BaseException):
    """The limit has passed; what catches every Exception does not catch this."""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise OutOfTime in what runs inside after ``seconds``; only a main thread can be stopped.

    >>> with time_limit(10.0):
    ...     print("done")
    done
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(*_: object) -> None:
        raise OutOfTime

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
