"""Inputs one after another in one fork, which costs a tenth of a fork for each.

Most inputs are refused within a millisecond, and a fork of a large process takes 20. A series ends
with the first input that is not plainly good: one that takes long or much memory, announces
something, leaves a thread or a process, or has a fault. That one is run again in a fork of its own
(`fuzz_server.py`), and what it does there counts. A fault that it has only in a series is one too:
something was left behind by the inputs before it.
"""

from __future__ import annotations

import contextlib
import json
import multiprocessing
import os
import resource
import select
import signal
import sys
import threading
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn

from searches.fuzz_inputs import FuzzCase
from searches.fuzz_server import (
    STILL,
    Ending,
    FuzzServer,
    WriteWatcher,
    announced,
    call_longwave,
    confine,
    enter,
    faults_of,
    forked,
    lay_out,
    megabytes_of,
    runs,
    seconds_of,
    tree_of,
)

LENGTH = 100
"""Inputs of one fork at most."""

QUICK_SECONDS, QUICK_MEGABYTES = 1.5, 300.0
"""What an input may take in a series; above, it is run alone."""


WAITING = ("wave_",)
"""How the threads are called that wait for points of a wave (`solutions/points.py`)."""

ENDING = 0.2
"""Seconds in which the thread of a command that has ended may end."""


def endings(server: FuzzServer, cases: Sequence[FuzzCase]) -> Iterator[Ending]:
    """Yield the endings of the inputs, in their order."""
    done = 0
    while done < len(cases):
        good, faults = _series(server, cases[done : done + LENGTH])
        yield from good
        done += len(good)
        if faults is not None:
            yield _alone(server, cases[done], faults)
            done += 1


def _alone(server: FuzzServer, case: FuzzCase, faults: Sequence[str]) -> Ending:
    """Return the ending of an input that was not plainly good in a series."""
    ending = server.ending(case)
    if "slow" in ending.kinds or "hangs" in ending.kinds:
        ending = server.ending(case)  # once more, before a busy machine is blamed on it
    if ending.faults or not faults:
        return ending
    return ending.blamed([f"{fault} (only after other inputs)" for fault in faults])


def _series(
    server: FuzzServer, cases: Sequence[FuzzCase]
) -> tuple[list[Ending], Sequence[str] | None]:
    """Return the good endings of the first ones, and the faults of the next, or None."""
    place = server.folder / "case"
    reading, writing = os.pipe()
    child = forked()
    if child == 0:
        os.close(reading)
        _run_and_exit(server.command or call_longwave, cases, place, writing)
    os.close(writing)
    try:
        return _watch(child, reading, place, server.anonymous)
    finally:
        os.close(reading)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)  # it may have no session of its own yet
        os.waitpid(child, 0)


# --- in the fork ----------------------------------------------------------------------------------


def _run_and_exit(
    command: Callable[[list[str]], int], cases: Sequence[FuzzCase], place: Path, pipe: int
) -> NoReturn:
    """Run inputs until one is not plainly good; each is a line in the pipe."""
    watchers: list[WriteWatcher] = []
    try:
        confine()

        def watch(event: str, arguments: tuple[Any, ...]) -> None:
            for one in watchers:
                one(event, arguments)

        sys.addaudithook(watch)
        surroundings = dict(os.environ)
        for case in cases:
            lay_out(case, place)
            enter(case, place)
            begun = _used()
            watchers.append(watcher := WriteWatcher(case, place))
            status: int | None = None
            try:
                status = command(list(case.words))
            except BaseException:
                traceback.print_exc()
            sys.stdout.flush()
            sys.stderr.flush()
            watchers.clear()
            os.close(watcher.report)
            *_, faults = faults_of(case, place, 1 if status is None else status)
            good = status is not None and not faults and not announced(place)
            line = json.dumps([good, status, _used() - begun, faults]) + "\n"
            os.write(pipe, line.encode("ascii"))
            if not good or not _is_alone() or os.environ != surroundings:
                break
    finally:
        os._exit(0)


def _used() -> float:
    """Return the processor time of this process and of its children that have ended."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def _is_alone() -> bool:
    """Return whether this process has neither children nor threads but those that wait for work."""
    for thread in threading.enumerate():
        if thread is not threading.main_thread() and not thread.name.startswith(WAITING):
            thread.join(ENDING)
            if thread.is_alive():
                return False
    return not (multiprocessing.active_children() or len([*tree_of(os.getpid())]) > 1)


# --- in the parent --------------------------------------------------------------------------------


def _watch(
    child: int, pipe: int, place: Path, start: float
) -> tuple[list[Ending], Sequence[str] | None]:
    """Read what a series tells until it ends or its input is to be run alone."""
    good: list[Ending] = []
    poller = select.poll()
    poller.register(pipe, select.POLLIN)
    unread = b""
    used = megabytes = 0.0
    moved = time.monotonic()
    while True:
        if poller.poll(25):
            content = os.read(pipe, 1 << 16)
            if not content:
                return good, None if good else []
            *lines, unread = (unread + content).split(b"\n")
            for line in lines:
                fine, status, seconds, faults = json.loads(line)
                if not fine:
                    return good, faults
                good.append(Ending(status, "", "", seconds, megabytes, False, False, ()))
                megabytes = 0.0
            used, moved = seconds_of(child), time.monotonic()
        megabytes = max(megabytes, megabytes_of(child, start))
        still = not runs(child) and time.monotonic() > moved + STILL
        long = announced(place) or seconds_of(child) > used + QUICK_SECONDS
        if still or long or megabytes > QUICK_MEGABYTES:
            return good, []
