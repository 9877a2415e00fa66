"""Jobs on a Dask cluster, given the address of its scheduler; `dask.distributed` is an extra.

Dask's processes run what they send each other: whoever can reach a scheduler can run code on all of
them, and on its clients (docs/trust.md). This module adds nothing to that: an unexpected answer is
an error of its job, in one line.
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

CONNECT_SECONDS = 15.0
"""Seconds in which a scheduler must answer."""

COUNT_INTERVAL = 2.0
"""Seconds between two counts of a cluster's workers."""

START_SECONDS = 60.0
"""Seconds allowed for an interpreter to start and to end, in addition to the seconds of its job."""

Outcome = tuple[Any, Any, BaseException | None]
"""Outcome of a call: last message, value and error."""


class DaskWorkers:
    """Workers of a Dask cluster; Dask replaces a lost worker and repeats its jobs."""

    def __init__(self, address: str, digest: str, check: Callable[["Client"], None]) -> None:
        """Connect to the scheduler, and ``check`` that workers compute the same as this process.

        ``digest`` is the MODULE:NAME of an object that the workers must have. Raises ValueError as
        `_connected` and ``check`` do.
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
                f"--scheduler must have workers that report their code, got "
                f"{type(error).__name__}: {one_line(error)[:100]} (install the same there)"
            ) from None
        self.count = 1
        self._looked, self._are_gone = -math.inf, False
        self._look()

    def submit(self, job: Job) -> Call:
        """Submit a job; Dask repeats it on another worker if its worker is lost."""
        call = Call(job)
        try:
            self._futures[call] = self._client.submit(_outcome, job, pure=False)
            self._futures[call].add_done_callback(lambda _: self._answered.put(call))
        except Exception as error:  # such as a lost scheduler
            call.error = error
            self._answered.put(call)
        return call

    def ended(self, seconds: float) -> list[Call]:
        """Return one call that has ended, or none after ``seconds``."""
        from distributed import KilledWorker

        self._look()
        try:
            call = self._answered.get(timeout=seconds)
        except Empty:
            return []
        try:
            if call.error is None:
                call.message, call.value, call.error = _checked(self._futures.pop(call).result())
        except KilledWorker:
            call.error = LostProcess("the cluster lost several workers to it")
        except (Exception, SystemExit, GeneratorExit) as error:
            call.error = error if isinstance(error, Exception) else _no_outcome(error)
        return [call]

    def _look(self) -> None:
        """Count the workers; if there are none, log it and wait, as others may come."""
        if time.monotonic() < self._looked + COUNT_INTERVAL:
            return
        try:
            threads: dict[str, int] = self._client.nthreads()
        except OSError as error:  # the scheduler is lost, and with it every answer
            for call in self._futures:
                call.error = call.error or error
                self._answered.put(call)
            return
        if not threads and not self._are_gone:
            LOG.info("the cluster has no workers: waiting for some (Ctrl-C stops it)")
        self._looked, self._are_gone = time.monotonic(), not threads
        self.count = max(1, sum(threads.values()))

    def stop(self) -> None:
        """Drop jobs that have not begun and leave the cluster."""
        self._client.close(timeout=PATIENCE)


def _checked(answer: Any) -> Outcome:
    """Return the answer if it is a call's outcome. Raises TypeError otherwise."""
    match answer:
        case (message, value, None | Exception() | OutOfTime() | Cancelled() as error):
            return message, value, error
    raise _no_outcome(answer)


def _no_outcome(answer: object) -> TypeError:
    """Return the TypeError for a worker's answer that is not an `Outcome`."""
    return TypeError(f"a worker must answer with an outcome, got {type(answer).__name__}")


def _connected(address: str, needed: str) -> "Client":
    """Return a client of the cluster, after checking that its workers have the object ``needed``.

    Raises ValueError in one line if `dask.distributed` is not installed, if no scheduler answers,
    and if a worker lacks longwave, which its first task would need.
    """
    try:
        from distributed import Client
        from distributed.comm.addressing import get_address_host_port
    except ImportError:
        raise ValueError(
            "--scheduler needs dask.distributed, got none (pip install 'longwave[cluster]')"
        ) from None
    try:
        get_address_host_port(address)  # a client of a wrong address fails late, with a traceback
        client = Client(address, timeout=CONNECT_SECONDS, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        why = one_line(error)[:100]
        raise ValueError(
            f"--scheduler must be the address of a Dask scheduler that answers within "
            f"{CONNECT_SECONDS:g} s, got {address[:100]}: {why} (such as tcp://127.0.0.1:8786, "
            "or tls://... with the certificates of Dask's configuration)"
        ) from None
    for name in ("client", "utils"):  # their traceback of a lost scheduler is reported by callers
        logging.getLogger(f"distributed.{name}").setLevel(logging.CRITICAL)
    for worker, result in client.run(resolve_name, needed, on_error="return").items():
        if isinstance(result, Exception):
            client.close()
            raise ValueError(
                f"--scheduler must have workers with this longwave, got {worker}: "
                f"{type(result).__name__}: {str(result)[:100]} (install it there)"
            )
    return client


def _outcome(job: Job) -> Outcome:
    """Do a job in a worker; a job with limits gets a new interpreter that enforces them."""
    if job.memory is None and job.seconds == math.inf:
        return None, job.run(lambda _: None), None
    root = str(Path(__file__).absolute().parents[2])
    paths = [root, *filter(None, [os.environ.get("PYTHONPATH")])]
    try:
        done = subprocess.run(
            [sys.executable, "-P", "-m", __name__],  # import nothing from the worker's folder
            input=pickle.dumps(job),
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(paths)},
            timeout=job.seconds + START_SECONDS,
            check=True,
        )
        outcome: Outcome = pickle.loads(done.stdout)
    except (subprocess.SubprocessError, pickle.UnpicklingError, EOFError) as error:
        return None, None, LostProcess(f"the process broke off ({type(error).__name__})")
    return outcome


def main() -> None:
    """Read a job from stdin, do it within its limits, and write its outcome to stdout."""
    call = run_apart(pickle.load(sys.stdin.buffer))
    sys.stdout.buffer.write(pickle.dumps((call.message, call.value, call.error)))


if __name__ == "__main__":
    main()
