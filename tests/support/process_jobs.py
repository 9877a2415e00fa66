"""Jobs that fail, in a module that a fresh interpreter imports quickly; scripts with jobs."""

import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path


def killed() -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def sleeping(file: Path, seconds: float) -> None:
    """Start a program that sleeps, write its process number to a file, and wait for it."""
    os.setpgrp()
    with subprocess.Popen(["sleep", str(seconds)]) as program:
        file.with_suffix(".draft").write_text(str(program.pid))
        file.with_suffix(".draft").rename(file)


def endless(tell: Callable[[float], None]) -> None:
    while True:
        tell(0.5)


CLUSTER = """
from longwave.support.dask_cluster import _outcome
from longwave.support.processes import Job

print(_outcome(Job(len, ("four",), seconds=60.0)))
"""

POOL = """
if __name__ == "__main__":
    from longwave.support.processes import Job, LocalWorkers, in_order

    workers = LocalWorkers(1)
    print(*in_order([Job(len, ("four",))], workers))
    workers.stop()
"""
"""Scripts that print 4, the length of a text, from a worker of a cluster or a pool."""
