"""Jobs in local processes that can be killed, and limits of their time and memory."""

import gc
import math
import multiprocessing as mp
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
import traceback
import warnings
from collections import deque
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from itertools import islice
from multiprocessing.connection import Connection, wait
from pathlib import Path
from queue import SimpleQueue
from types import ModuleType
from typing import Any, Protocol, TypeVar

from longwave.support.request_limits import Cancelled

Key = tuple[str, object]
"""Key of a study's job: kind and subject."""

Subject = TypeVar("Subject", bound=Hashable)
Progress = Callable[[float], None]

POLL_SECONDS = 0.2
"""Seconds between two checks of the progress."""

MESSAGE_INTERVAL = 0.1
"""Least seconds between two fractions of progress that a job reports."""

SAFE_PATH = "PYTHONSAFEPATH"
"""Environment variable that keeps the current folder out of Python's path."""

PATIENCE = 1.0
"""Seconds in which a terminated process may still write its output."""


ENDED = "the process broke off"


class OutOfTime(BaseException):
    """The time limit has passed; not an Exception, so that broad handlers do not catch it."""


class LostProcess(Exception):
    """A process ended during its job: it was killed, or ran out of memory."""


@dataclass(frozen=True)
class Job:
    """A function call to be made in a process; ``weight`` is its approximate duration in seconds.

    If ``tells``, the function gets an additional argument, a callback for the fraction of the work
    done, 0 .. 1, or other messages. After ``seconds`` of wall time the process is killed; it may
    take ``memory`` bytes in addition to the memory it has. A job that ``gives_way`` is ended, by
    Cancelled from its callback, when its process gets another job. All parts must be picklable,
    unless the process is a fork.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    weight: float = 1.0
    tells: bool = False
    seconds: float = math.inf
    memory: int | None = None
    gives_way: bool = False

    def run(self, tell: Callable[[Any], None]) -> Any:
        """Make the call and return its result."""
        return self.function(*self.arguments, *((tell,) if self.tells else ()))


@dataclass(eq=False)
class Call:
    """A submitted job: its last message, then its value or error (OutOfTime, LostProcess, ...)."""

    job: Job
    message: Any = None
    value: Any = None
    error: BaseException | None = None

    def result(self) -> Any:
        """Return the value, or raise the error."""
        if self.error is not None:
            raise self.error
        return self.value


class Workers(Protocol):
    """Protocol of a set of processes that do jobs, on this computer or on a cluster."""

    @property
    def count(self) -> int:
        """Number of jobs that are done concurrently."""

    def submit(self, job: Job) -> Call:
        """Submit a job and return its call."""

    def ended(self, seconds: float) -> list[Call]:
        """Return the calls that have ended; wait up to ``seconds`` until there is one."""

    def stop(self) -> None:
        """End all work within two seconds."""


def as_ended(
    jobs: Iterable[tuple[Subject, Job]],
    workers: Workers,
    look: Callable[[Mapping[Call, Subject]], object] = lambda _: None,
) -> Iterator[tuple[Subject, Call]]:
    """Yield finished calls as `in_turn` does; stop the workers at the end or after an error."""
    try:
        yield from in_turn(jobs, workers, look)
    finally:
        workers.stop()


def in_turn(
    jobs: Iterable[tuple[Subject, Job]],
    workers: Workers,
    look: Callable[[Mapping[Call, Subject]], object] = lambda _: None,
    ahead: int = 1,
) -> Iterator[tuple[Subject, Call]]:
    """Do all jobs, up to ``ahead`` at once per worker; yield (key, finished call) as calls end.

    ``look`` is called from time to time with the running calls and their keys.
    """
    waiting, running = iter(jobs), dict[Call, Subject]()
    while True:
        for key, job in islice(waiting, max(0, ahead * workers.count - len(running))):
            running[workers.submit(job)] = key
        if not running:
            return
        for call in workers.ended(POLL_SECONDS):
            yield running.pop(call), call
        look(running)


def in_order(jobs: Iterable[Job], workers: Workers) -> Iterator[Any]:
    """Yield the results of the jobs in their order; raise the error of the first that fails."""
    results: dict[int, Any] = {}
    next_number = 0
    for number, call in as_ended(enumerate(jobs), workers):
        results[number] = call.result()
        while next_number in results:
            yield results.pop(next_number)
            next_number += 1


def run_jobs(jobs: Mapping[Subject, Job], workers: int, progress: Progress) -> dict[Subject, Any]:
    """Do all jobs in `workers` processes, the longest first; return the results by key.

    `progress` is called from time to time with the fraction of the work done, 0 .. 1. The exception
    of the first failing job is raised, and the other jobs are dropped.

    Raises ValueError unless workers >= 1.
    """
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
    ordered = sorted(jobs.items(), key=lambda item: item[1].weight, reverse=True)
    whole = sum(job.weight for _, job in ordered)
    results, shares = dict[Subject, Any](), dict.fromkeys(jobs, 0.0)

    def report(running: Mapping[Call, Subject]) -> None:
        shares.update((key, call.message or 0.0) for call, key in running.items())
        progress(min(1.0, sum(job.weight * shares[key] for key, job in ordered) / whole))

    for key, call in as_ended(ordered, LocalWorkers(workers), report):
        results[key], shares[key] = call.result(), 1.0
    progress(1.0)
    return {key: results[key] for key in jobs}


def run_apart(job: Job) -> Call:
    """Do one job in a process of its own and return its finished call."""
    ((_, call),) = as_ended([(0, job)], LocalWorkers(1, isolated=True))
    return call


def run_program(command: Sequence[str], folder: Path, seconds: float) -> tuple[int, str]:
    """Run a program in a folder; return its exit status and all that it printed.

    After ``seconds`` it is killed, with its child processes, and OutOfTime is raised.
    """
    status, printed = run_apart(Job(_program, (command, folder), seconds=seconds)).result()
    return status, printed


def _program(command: Sequence[str], folder: Path) -> tuple[int, str]:
    """Run a program in its own process group; return its exit status and output."""
    os.setpgrp()
    done = subprocess.run(
        command,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    return done.returncode, done.stdout.decode(errors="replace")


# in the parent process


@dataclass(eq=False)
class _Worker:
    """A process, its pipe, and its calls: the current one and the queued ones."""

    process: Any
    pipe: Connection
    calls: deque[tuple[Call, float]] = field(default_factory=deque)
    """Calls with their deadlines, as monotonic times."""

    def end(self, patience: float) -> None:
        """Wait ``patience`` seconds for the process to end, then kill it and its children."""
        self.process.join(patience)
        _kill_group(self.process.pid)
        self.process.kill()
        self.process.join()
        self.pipe.close()


class LocalWorkers:
    """Local processes, started when needed and replaced when lost.

    The processes ignore Ctrl-C, which this process handles, and end when this process ends, however
    it ends. Each is a fresh interpreter that calls ``begin`` first and is reused for further jobs.
    If ``isolated``, each does one job only and is, where possible, a fork of this process, which
    needs no imports.
    """

    def __init__(
        self, count: int, begin: Callable[[], None] | None = None, *, isolated: bool = False
    ) -> None:
        self.count, self._begin, self._isolated = count, begin, isolated
        self._workers: list[_Worker] = []
        self._ended: list[Call] = []

    def start(self, job: Job | None = None) -> _Worker:
        """Start a process (for this ``job`` alone if one is given) and return its worker."""
        forked = job is not None and hasattr(os, "fork")
        context: Any = mp.get_context("fork" if forked else "spawn")
        ours, theirs = context.Pipe()
        arguments = (theirs, ours if forked else None, self._begin, job)
        process = context.Process(target=_serve, args=arguments)
        with _interrupts_blocked(), warnings.catch_warnings(), _without_script(), _safe_path():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a fork with threads
            process.start()
        theirs.close()
        self._workers.append(_Worker(process, ours))
        return self._workers[-1]

    def submit(self, job: Job) -> Call:
        """Submit a job; it is queued if all processes are busy."""
        call = Call(job)
        self._give(call)
        return call

    def _give(self, call: Call) -> None:
        """Send a call to the least busy process, or to a new one."""
        worker = min(self._workers, key=lambda worker: len(worker.calls), default=None)
        if self._isolated:
            worker = self.start(call.job)
        elif worker is None or (worker.calls and len(self._workers) < self.count):
            worker = self.start()
        try:
            if not self._isolated:
                worker.pipe.send(call.job)
        except OSError:
            self._drop(worker, LostProcess(ENDED))
            self._give(call)
        else:
            worker.calls.append((call, time.monotonic() + call.job.seconds))

    def ended(self, seconds: float) -> list[Call]:
        """Return the calls that have ended; wait up to ``seconds`` until there is one."""
        ends = [worker.calls[0][1] for worker in self._workers if worker.calls]
        longest = 0.0 if self._ended else min([seconds, *(end - time.monotonic() for end in ends)])
        ready = wait([worker.pipe for worker in self._workers], max(0.0, longest))
        for worker in [worker for worker in self._workers if worker.pipe in ready]:
            while worker in self._workers and worker.pipe.poll():
                self._read(worker)
        for worker in self._workers[:]:
            if worker.calls and time.monotonic() > worker.calls[0][1]:
                self._drop(worker, OutOfTime())
        calls, self._ended = self._ended, []
        return calls

    def _read(self, worker: _Worker) -> None:
        """Receive a message, value or error from a process."""
        try:
            kind, content = worker.pipe.recv()
        except (EOFError, OSError):
            self._drop(worker, LostProcess(ENDED), PATIENCE)
            return
        except Exception as error:  # it cannot be unpickled
            kind, content = "error", error
        call, _ = worker.calls[0]
        setattr(call, kind, content)
        if kind != "message":
            self._ended.append(worker.calls.popleft()[0])
            if self._isolated:
                self._drop(worker, None, PATIENCE)

    def _drop(self, worker: _Worker, error: BaseException | None, patience: float = 0.0) -> None:
        """End a process; its current call gets ``error``, queued calls go to other processes."""
        self._workers.remove(worker)
        worker.end(patience)
        for position, (call, _) in enumerate(worker.calls):
            if position:
                self._give(call)
            else:
                call.error = error
                self._ended.append(call)

    def stop(self) -> None:
        """Terminate all processes, and kill those that do not end."""
        workers, self._workers = self._workers, []
        for worker in workers:
            worker.process.terminate()
        end = time.monotonic() + PATIENCE
        for worker in workers:
            worker.end(max(0.0, end - time.monotonic()))


@contextmanager
def _safe_path() -> Iterator[None]:
    """Start the processes of the block so that they import nothing from the current folder."""
    before = os.environ.get(SAFE_PATH)
    os.environ[SAFE_PATH] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ[SAFE_PATH]
        else:
            os.environ[SAFE_PATH] = before


@contextmanager
def _without_script() -> Iterator[None]:
    """Start the block's processes without running the user's script, which a spawn would run."""
    main = sys.modules["__main__"]
    if main.__spec__ is None:
        sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Start the processes of the block with Ctrl-C blocked: they would print a traceback."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _kill_group(leader: int) -> None:
    """Kill the processes of the group that the process ``leader`` leads, if there is one."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(leader, signal.SIGKILL)


# in the worker process


def _serve(
    pipe: Connection,
    peer: Connection | None,
    begin: Callable[[], None] | None,
    job: Job | None,
) -> None:
    """Do this ``job``, or jobs from the pipe; a fork closes ``peer``, the parent's end of it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if peer is not None:
        peer.close()
        gc.freeze()  # finalizers of the parent's objects may wait for threads that a fork lacks
    inbox: SimpleQueue[bytes] = SimpleQueue()
    threading.Thread(target=_receive, args=(pipe, inbox), daemon=True).start()
    inbox.get()
    if begin is not None:
        begin()
    if job is not None:
        _do(job, pipe, inbox)
    else:
        while _do(pickle.loads(inbox.get()), pipe, inbox):
            pass
        os._exit(1)  # at once, as requested


def _receive(pipe: Connection, inbox: SimpleQueue[bytes]) -> None:
    """Receive jobs in a thread, and end the process with its parent."""
    inbox.put(bytes(1000))  # the thread has its memory now, so a memory limit may follow
    with suppress(EOFError, OSError):
        while True:
            inbox.put(pipe.recv_bytes())
    _kill_group(os.getpid())
    os._exit(1)


def _do(job: Job, pipe: Connection, inbox: SimpleQueue[bytes]) -> bool:
    """Do a job and send its result; return whether the process can do further jobs."""
    last = -math.inf

    def give_way() -> None:
        if job.gives_way and not inbox.empty():
            raise Cancelled

    def tell(message: Any) -> None:
        nonlocal last
        give_way()
        if not isinstance(message, float) or time.monotonic() > last + MESSAGE_INTERVAL:
            last = time.monotonic()
            pipe.send(("message", message))

    kind, usable = "value", True
    try:
        give_way()
        if job.memory is not None:
            limit_memory(job.memory)
        result = job.run(tell)
    except BaseException as error:
        kind, result, usable = "error", error, isinstance(error, Exception | Cancelled)
        if isinstance(error, Exception):
            error.add_note("".join(traceback.format_tb(error.__traceback__)))
    print(end="", flush=True)
    try:
        pipe.send((kind, result))
    except Exception as error:  # it cannot be pickled
        pipe.send(("error", RuntimeError(f"{type(error).__name__}: {error}")))
    return usable


# limits


def limit_memory(beyond: int) -> None:
    """Limit this process to ``beyond`` bytes more than it has, if the system supports that."""
    with suppress(ImportError, OSError, ValueError):
        import resource  # where there is fork

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + beyond
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def limit_processor(seconds: int) -> None:
    """Kill this process after ``seconds`` more of processor time, if the system supports that."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        end = int(time.process_time()) + seconds
        resource.setrlimit(resource.RLIMIT_CPU, (end, end + 1))


@contextmanager
def time_limit(seconds: float, passing: bool = False) -> Iterator[None]:
    """Raise OutOfTime in the block after ``seconds``; works in a main thread only.

    ``seconds`` are of processor time, or with ``passing`` of wall time. An exception in a finalizer
    or in a callback of compiled code is lost, so OutOfTime is raised repeatedly, and at the latest
    at the end of the block.

    >>> with time_limit(10.0):
    ...     print("done")
    done
    """
    main = threading.current_thread() is threading.main_thread()
    if not (main and hasattr(signal, "setitimer")):
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
    signal.setitimer(timer, seconds, POLL_SECONDS)
    try:
        yield
    finally:
        over = True
        signal.setitimer(timer, 0.0)
        signal.signal(number, before)
    if late:
        raise OutOfTime
