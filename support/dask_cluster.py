"""Jobs on a Dask cluster by the address of its scheduler; `dask.distributed` is an extra.

Dask's processes run what they send each other: whoever can talk to a scheduler runs code on all of
them, and on its clients (docs/trust.md). Nothing of ours adds to that: an answer that is none of
ours is the error of its job, in one line.
"""

import logging
import math
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from pkgutil import resolve_name
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any

from longwave.support.command_line import one_line
from longwave.support.processes import PATIENCE, Call, Job, LostProcess, OutOfTime, run_apart
from longwave.support.request_limits import Cancelled
from longwave.support.sealed_file import LOG

if TYPE_CHECKING:
    from distributed import Client

CONNECTING = 15.0
"""Seconds in which a scheduler must answer."""

LOOKING = 2.0
"""Seconds between two looks at a cluster."""

BEGINNING = 60.0
"""Seconds for an interpreter to begin and to end, beyond those of its job."""

Outcome = tuple[Any, Any, BaseException | None]
"""Of a call: what it told, its value, its error."""


class DaskWorkers:
    """The workers of a cluster, which replaces them itself and does the jobs of lost ones again."""

    def __init__(self, address: str, digest: str, check: Callable[["Client"], None]) -> None:
        """Connect, and ``check`` that the workers compute what would be computed here.

        They must have what is called ``digest``, MODULE:NAME. Raises ValueError as `_connected`
        does and as the check does.
        """
        self._client = _connected(address, digest)
        self._futures: dict[Call, Any] = {}
        self._answered: SimpleQueue[Call] = SimpleQueue()
        try:
            check(self._client)
        except Exception as error:
            self.stop()
            if isinstance(error, ValueError):
                raise
            raise ValueError(
                f"--scheduler must be of workers that say what they run, got "
                f"{type(error).__name__}: {one_line(error)[:100]} (install the same there)"
            ) from None
        self.count = 1
        self._looked, self._are_gone = -math.inf, False
        self._look()

    def submit(self, job: Job) -> Call:
        """Have a job done, again on another worker if its own is lost."""
        call = Call(job)
        try:
            self._futures[call] = self._client.submit(_outcome, job, pure=False)
            self._futures[call].add_done_callback(lambda _: self._answered.put(call))
        except Exception as error:  # its scheduler is lost, say
            call.error = error
            self._answered.put(call)
        return call

    def ended(self, seconds: float) -> list[Call]:
        """A call that has ended; if there is none, it is waited for so long."""
        from distributed import KilledWorker

        self._look()
        try:
            call = self._answered.get(timeout=seconds)
        except Empty:
            return []
        try:
            if call.error is None:
                call.told, call.value, call.error = _checked(self._futures.pop(call).result())
        except KilledWorker:
            call.error = LostProcess("the cluster lost several workers to it")
        except (Exception, SystemExit, GeneratorExit) as error:
            call.error = error if isinstance(error, Exception) else _no_outcome(error)
        return [call]

    def _look(self) -> None:
        """Count the workers; tell if there are none: others may come."""
        if time.monotonic() < self._looked + LOOKING:
            return
        try:
            threads: dict[str, int] = self._client.nthreads()
        except OSError as error:  # the scheduler is lost, and with it every answer
            for call in self._futures:
                call.error = call.error or error
                self._answered.put(call)
            return
        if not threads and not self._are_gone:
            LOG.info("the cluster has no workers, which are waited for (Ctrl-C stops it)")
        self._looked, self._are_gone = time.monotonic(), not threads
        self.count = max(1, sum(threads.values()))

    def stop(self) -> None:
        """Drop what has not begun and leave the cluster."""
        self._client.close(timeout=PATIENCE)


def _checked(answer: Any) -> Outcome:
    """The answer, which is a call's outcome. Raises TypeError for anything else."""
    match answer:
        case (told, value, None | Exception() | OutOfTime() | Cancelled() as error):
            return told, value, error
    raise _no_outcome(answer)


def _no_outcome(answer: object) -> TypeError:
    return TypeError(f"a worker must answer with an outcome, got {type(answer).__name__}")


def _connected(address: str, needed: str) -> "Client":
    """A client of the cluster, whose workers have what is ``needed``.

    Raises ValueError in one line where `dask.distributed` is not installed, where no scheduler
    answers and where a worker has no longwave: it would end by the first task.
    """
    try:
        from distributed import Client
        from distributed.comm.addressing import get_address_host_port
    except ImportError:
        raise ValueError(
            "--scheduler needs dask.distributed, got none (pip install 'longwave[cluster]')"
        ) from None
    try:
        get_address_host_port(address)  # a client of a wrong one ends late, with a traceback
        client = Client(address, timeout=CONNECTING, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        why = one_line(error)[:100]
        raise ValueError(
            f"--scheduler must be the address of a Dask scheduler that answers within "
            f"{CONNECTING:g} s, got {address[:100]}: {why} (such as tcp://127.0.0.1:8786, "
            "or tls://... with the certificates of Dask's configuration)"
        ) from None
    for name in ("client", "utils"):  # where a lost scheduler is a traceback, which callers tell
        logging.getLogger(f"distributed.{name}").setLevel(logging.CRITICAL)
    for worker, found in client.run(resolve_name, needed, on_error="return").items():
        if isinstance(found, Exception):
            client.close()
            raise ValueError(
                f"--scheduler must be of workers that have this longwave, got {worker}: "
                f"{type(found).__name__}: {str(found)[:100]} (install it there)"
            )
    return client


def _outcome(job: Job) -> Outcome:
    """In a worker: do a job; one that has limits in an interpreter of its own, which ends by them.

    A worker has threads, and may be no parent by `multiprocessing`'s rules.
    """
    if job.memory is None and job.seconds == math.inf:
        return None, job.run(lambda _: None), None
    house = str(Path(__file__).absolute().parents[2])
    paths = [house, *filter(None, [os.environ.get("PYTHONPATH")])]
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-m", __name__],  # what the worker's folder holds is not ours
            input=pickle.dumps(job),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            timeout=job.seconds + BEGINNING,
            check=True,
        )
        found: Outcome = pickle.loads(done.stdout)
    except (subprocess.SubprocessError, pickle.UnpicklingError, EOFError) as error:
        return None, None, LostProcess(f"the process broke off ({type(error).__name__})")
    return found


def main() -> None:
    """Read a job, do it within its limits, and write its outcome."""
    call = run_apart(pickle.load(sys.stdin.buffer))
    sys.stdout.buffer.write(pickle.dumps((call.told, call.value, call.error)))


if __name__ == "__main__":
    main()
