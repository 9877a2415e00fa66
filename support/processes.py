"""Jobs in processes of this machine, which can be killed; their limits of time and memory."""

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
"""What a job of a study is called by: a kind and a subject."""

Subject = TypeVar("Subject", bound=Hashable)
Progress = Callable[[float], None]

POLL = 0.2
"""Seconds between two looks at the progress."""

TELLING = 0.1
"""Least seconds between two shares that a job tells."""

PATIENCE = 1.0
"""Seconds in which a process that is told to end may write what it has."""


ENDED = "the process broke off"


class OutOfTime(BaseException):
    """The limit has passed; what catches every Exception does not catch this."""


class LostProcess(Exception):
    """A process ended under its job: it was killed, or had no memory."""


@dataclass(frozen=True)
class Job:
    """A call to make in a process, and about how many seconds it takes: its ``weight``.

    With ``tells``, the function is called with a further argument: a function to be told the
    share of the work that is done, 0 .. 1, or whatever else is to be known before the end. After
    ``seconds`` of the clock the process is killed; it may take ``memory`` bytes more than it has.
    A job that ``gives_way`` ends, by Cancelled from what it tells, when its process is given
    another. All parts must be picklable, but where the process is a fork.
    """

    function: Callable[..., Any]
    arguments: tuple[Any, ...] = ()
    weight: float = 1.0
    tells: bool = False
    seconds: float = math.inf
    memory: int | None = None
    gives_way: bool = False

    def run(self, tell: Callable[[Any], None]) -> Any:
        """Make the call and return what it returns."""
        return self.function(*self.arguments, *((tell,) if self.tells else ()))


@dataclass(eq=False)
class Call:
    """A job given to workers: what it told last, and in the end its value or its error.

    The error is OutOfTime past the job's seconds, and LostProcess where the process ended.
    """

    job: Job
    told: Any = None
    value: Any = None
    error: BaseException | None = None

    def result(self) -> Any:
        """The value; raises the error."""
        if self.error is not None:
            raise self.error
        return self.value


class Workers(Protocol):
    """Processes that do jobs, here or on a cluster."""

    @property
    def count(self) -> int:
        """Jobs that are done at once."""

    def submit(self, job: Job) -> Call:
        """Have a job done."""

    def ended(self, seconds: float) -> list[Call]:
        """The calls that have ended; if there are none, they are waited for so long."""

    def stop(self) -> None:
        """End all work within two seconds."""


def as_ended(
    jobs: Iterable[tuple[Subject, Job]],
    workers: Workers,
    look: Callable[[Mapping[Call, Subject]], object] = lambda _: None,
) -> Iterator[tuple[Subject, Call]]:
    """Do all jobs as `in_turn` does, and stop the workers, also after an error or Ctrl-C."""
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
    """Do all jobs, each taken when a worker has less than ``ahead``; keys and calls as they end.

    ``look`` is shown the calls under way from time to time.
    """
    waiting, running = iter(jobs), dict[Call, Subject]()
    while True:
        for key, job in islice(waiting, max(0, ahead * workers.count - len(running))):
            running[workers.submit(job)] = key
        if not running:
            return
        for call in workers.ended(POLL):
            yield running.pop(call), call
        look(running)


def in_order(jobs: Iterable[Job], workers: Workers) -> Iterator[Any]:
    """What the jobs return, in their order; raises what the first failing one raises."""
    early: dict[int, Any] = {}
    place = 0
    for found, call in as_ended(enumerate(jobs), workers):
        early[found] = call.result()
        while place in early:
            yield early.pop(place)
            place += 1


def run_jobs(jobs: Mapping[Subject, Job], workers: int, progress: Progress) -> dict[Subject, Any]:
    """Do all jobs in `workers` processes, the longest first; return the results under their keys.

    `progress` is called from time to time with the share of the work done, 0 .. 1. The first
    failing job's exception is raised here and the other jobs are dropped.

    Raises ValueError unless workers >= 1.
    """
    if workers < 1:
        raise ValueError(f"workers must be at least 1, got {workers} (2 is usual)")
    ordered = sorted(jobs.items(), key=lambda item: item[1].weight, reverse=True)
    whole = sum(job.weight for _, job in ordered)
    found, shares = dict[Subject, Any](), dict.fromkeys(jobs, 0.0)

    def report(running: Mapping[Call, Subject]) -> None:
        shares.update((key, call.told or 0.0) for call, key in running.items())
        progress(min(1.0, sum(job.weight * shares[key] for key, job in ordered) / whole))

    for key, call in as_ended(ordered, LocalWorkers(workers), report):
        found[key], shares[key] = call.result(), 1.0
    progress(1.0)
    return {key: found[key] for key in jobs}


def run_apart(job: Job) -> Call:
    """The call of one job in a process of its own, at its end."""
    ((_, call),) = as_ended([(0, job)], LocalWorkers(1, apart=True))
    return call


def run_program(command: Sequence[str], folder: Path, seconds: float) -> tuple[int, str]:
    """Exit status of a program that is run in a folder, and all that it printed.

    After ``seconds`` it is killed, with what it has started, and OutOfTime raised.
    """
    status, printed = run_apart(Job(_program, (command, folder), seconds=seconds)).result()
    return status, printed


def _program(command: Sequence[str], folder: Path) -> tuple[int, str]:
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


# here: the side of the command


@dataclass(eq=False)
class _Worker:
    """A process, the pipe to it, and what it was given: the job it does, and those behind it."""

    process: Any
    pipe: Connection
    calls: deque[tuple[Call, float]] = field(default_factory=deque)
    """With the moments until which they may take."""

    def end(self, patience: float) -> None:
        """Wait so long for its end, and kill it with what it has started."""
        self.process.join(patience)
        _kill_group(self.process.pid)
        self.process.kill()
        self.process.join()
        self.pipe.close()


class LocalWorkers:
    """Processes of this machine, begun when they are needed and replaced when they are lost.

    They leave Ctrl-C to this process and end with it, however it ends. Each is a fresh interpreter
    that calls ``begin`` first and is kept for further jobs; or ``apart``, for one job alone: a fork
    of this process, which has nothing to import, where there are forks.
    """

    def __init__(
        self, count: int, begin: Callable[[], None] | None = None, *, apart: bool = False
    ) -> None:
        self.count, self._begin, self._apart = count, begin, apart
        self._workers: list[_Worker] = []
        self._ended: list[Call] = []

    def start(self, job: Job | None = None) -> _Worker:
        """Begin a process, for this ``job`` alone if there is one."""
        forked = job is not None and hasattr(os, "fork")
        context: Any = mp.get_context("fork" if forked else "spawn")
        ours, theirs = context.Pipe()
        given = (theirs, ours if forked else None, self._begin, job)
        process = context.Process(target=_serve, args=given)
        with _interrupts_blocked(), warnings.catch_warnings(), _without_script(), _safe_path():
            warnings.simplefilter("ignore", DeprecationWarning)  # of a fork beside threads
            process.start()
        theirs.close()
        self._workers.append(_Worker(process, ours))
        return self._workers[-1]

    def submit(self, job: Job) -> Call:
        """Have a job done, behind another one if all processes are at work."""
        call = Call(job)
        self._give(call)
        return call

    def _give(self, call: Call) -> None:
        worker = min(self._workers, key=lambda worker: len(worker.calls), default=None)
        if self._apart:
            worker = self.start(call.job)
        elif worker is None or (worker.calls and len(self._workers) < self.count):
            worker = self.start()
        try:
            if not self._apart:
                worker.pipe.send(call.job)
        except OSError:
            self._drop(worker, LostProcess(ENDED))
            self._give(call)
        else:
            worker.calls.append((call, time.monotonic() + call.job.seconds))

    def ended(self, seconds: float) -> list[Call]:
        """The calls that have ended; if there are none, they are waited for so long."""
        ends = [worker.calls[0][1] for worker in self._workers if worker.calls]
        longest = 0.0 if self._ended else min([seconds, *(end - time.monotonic() for end in ends)])
        ready = wait([worker.pipe for worker in self._workers], max(0.0, longest))
        for worker in [worker for worker in self._workers if worker.pipe in ready]:
            while worker in self._workers and worker.pipe.poll():
                self._read(worker)
        for worker in self._workers[:]:
            if worker.calls and time.monotonic() > worker.calls[0][1]:
                self._drop(worker, OutOfTime())
        found, self._ended = self._ended, []
        return found

    def _read(self, worker: _Worker) -> None:
        try:
            kind, said = worker.pipe.recv()
        except (EOFError, OSError):
            self._drop(worker, LostProcess(ENDED), PATIENCE)
            return
        except Exception as error:  # what cannot be read here
            kind, said = "error", error
        call, _ = worker.calls[0]
        setattr(call, kind, said)
        if kind != "told":
            self._ended.append(worker.calls.popleft()[0])
            if self._apart:
                self._drop(worker, None, PATIENCE)

    def _drop(self, worker: _Worker, error: BaseException | None, patience: float = 0.0) -> None:
        """End a process; what it was at has the error, and what was behind is given to another."""
        self._workers.remove(worker)
        worker.end(patience)
        for place, (call, _) in enumerate(worker.calls):
            if place:
                self._give(call)
            else:
                call.error = error
                self._ended.append(call)

    def stop(self) -> None:
        """Tell all processes to end, and kill those that do not."""
        workers, self._workers = self._workers, []
        for worker in workers:
            worker.process.terminate()
        end = time.monotonic() + PATIENCE
        for worker in workers:
            worker.end(max(0.0, end - time.monotonic()))


@contextmanager
def _safe_path() -> Iterator[None]:
    """Start interpreters that do not look for the standard library in the folder they start in."""
    before = os.environ.get("PYTHONSAFEPATH")
    os.environ["PYTHONSAFEPATH"] = "1"
    try:
        yield
    finally:
        if before is None:
            del os.environ["PYTHONSAFEPATH"]
        else:
            os.environ["PYTHONSAFEPATH"] = before


@contextmanager
def _without_script() -> Iterator[None]:
    """Start a process that does not run a user's script again, as a new interpreter would.

    No job is a function of a script; what is begun with ``python -m`` is a module, and stays.
    """
    main = sys.modules["__main__"]
    if main.__spec__ is None:
        sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _interrupts_blocked() -> Iterator[None]:
    """Block Ctrl-C while a process is started, which inherits that: it ends with its command.

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


def _kill_group(leader: int) -> None:
    """Kill what a process has started, if it is the leader of a group of its own."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(leader, signal.SIGKILL)


# there: the side of the process


def _serve(
    pipe: Connection,
    other: Connection | None,
    begin: Callable[[], None] | None,
    job: Job | None,
) -> None:
    """Do this ``job``, or those that come through the pipe, whose ``other`` end a fork has too."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if other is not None:
        other.close()
        gc.freeze()  # what the parent left may wait, at its end, for threads that are not here
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
        os._exit(1)  # at once: it was told to end


def _receive(pipe: Connection, inbox: SimpleQueue[bytes]) -> None:
    """In a thread: take what comes, and end with the parent."""
    inbox.put(bytes(1000))  # the thread has its memory by now, and a limit of it may follow
    with suppress(EOFError, OSError):
        while True:
            inbox.put(pipe.recv_bytes())
    _kill_group(os.getpid())
    os._exit(1)


def _do(job: Job, pipe: Connection, inbox: SimpleQueue[bytes]) -> bool:
    """Do a job and send what came of it; whether the process can do others."""
    last = -math.inf

    def give_way() -> None:
        if job.gives_way and not inbox.empty():
            raise Cancelled

    def tell(what: Any) -> None:
        nonlocal last
        give_way()
        if not isinstance(what, float) or time.monotonic() > last + TELLING:
            last = time.monotonic()
            pipe.send(("told", what))

    kind, usable = "value", True
    try:
        give_way()
        if job.memory is not None:
            limit_memory(job.memory)
        found = job.run(tell)
    except BaseException as error:
        kind, found, usable = "error", error, isinstance(error, Exception | Cancelled)
        if isinstance(error, Exception):
            error.add_note("".join(traceback.format_tb(error.__traceback__)))
    print(end="", flush=True)
    try:
        pipe.send((kind, found))
    except Exception as error:  # it cannot be pickled
        pipe.send(("error", RuntimeError(f"{type(error).__name__}: {error}")))
    return usable


# limits


def limit_memory(beyond: int) -> None:
    """Let this process take so many bytes more than it has, where the system can say and do so."""
    with suppress(ImportError, OSError, ValueError):
        import resource  # where there is fork

        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[0])
        most = pages * resource.getpagesize() + beyond
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def limit_processor(seconds: int) -> None:
    """Have this process killed after so many more seconds of the processor, where there is fork."""
    with suppress(ImportError, OSError, ValueError):
        import resource

        signal.signal(signal.SIGXCPU, signal.SIG_DFL)
        end = int(time.process_time()) + seconds
        resource.setrlimit(resource.RLIMIT_CPU, (end, end + 1))


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
    signal.setitimer(timer, seconds, POLL)
    try:
        yield
    finally:
        over = True
        signal.setitimer(timer, 0.0)
        signal.signal(number, before)
    if late:
        raise OutOfTime
