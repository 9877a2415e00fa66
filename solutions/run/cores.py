"""How many cores this process may use: one where it is a worker beside others."""

import multiprocessing
import os

__all__ = ["keep_to_one_core", "usable_cores"]

_alone = False


def keep_to_one_core() -> None:
    """From now on no work of this process is shared by threads: its other cores have their own."""
    global _alone
    _alone = True


def usable_cores() -> int:
    """Threads that pay in this process: one in a worker process, else the cores.

    >>> usable_cores() >= 1
    True
    """
    if _alone or multiprocessing.parent_process() is not None:
        return 1
    return os.cpu_count() or 1
