"""Number of cores that this process may use: one if it is one of several workers."""

import multiprocessing
import os
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache

_alone = False


def keep_to_one_core() -> None:
    """Use one core from now on: the other cores belong to other processes."""
    global _alone
    _alone = True


def is_worker() -> bool:
    """Return whether this process is a worker: started by another one, or declared as one."""
    return _alone or multiprocessing.parent_process() is not None


def usable_cores() -> int:
    """Return the number of useful threads: one in a worker process, else the number of cores.

    >>> usable_cores() >= 1
    True
    """
    if is_worker():
        return 1
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def other_core() -> ThreadPoolExecutor:
    """Return the executor of the one thread that shares a kernel's work with its caller."""
    return _thread_of(os.getpid())


@lru_cache(maxsize=1)
def _thread_of(_: int) -> ThreadPoolExecutor:
    """Return the executor of this process; a forked process gets a new one, as threads are lost."""
    return ThreadPoolExecutor(1, thread_name_prefix="core")
