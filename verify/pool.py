"""Worker processes that end with their command on Ctrl-C, without a word of their own."""

import signal
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
