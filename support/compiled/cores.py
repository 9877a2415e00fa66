"""How many cores this process may use: one where it is a worker beside others."""

import multiprocessing
import os
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

_alone = False


def keep_to_one_core() -> None:
    """From now on no work of this process is shared by threads: its other cores have their own."""
    global _alone
    _alone = True


def is_worker() -> bool:
    """Whether this process works beside others: one that was started by another, or said so."""
    return _alone or multiprocessing.parent_process() is not None


def usable_cores() -> int:
    """Threads that pay in this process: one in a worker process, else the cores.

    >>> usable_cores() >= 1
    True
    """
    if is_worker():
        return 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def other_core() -> ThreadPoolExecutor:
    """The one thread that shares the work of a kernel with its caller."""
    return _thread_of(os.getpid())


@lru_cache(maxsize=1)
def _thread_of(_: int) -> ThreadPoolExecutor:
    """Of one process: in a fork of it there are no threads."""
    return ThreadPoolExecutor(1, thread_name_prefix="core")
