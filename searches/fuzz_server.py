"""Inputs run in warm processes: everything is imported once, and each input has a fork of its own.

What is watched: the processor time of the fork and of what it starts, its memory beyond the start,
files opened for writing, what is printed, and the exit status.  Times are the processor's, so that
other work on the machine makes no fault; what waits for nothing is told by its standing still.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import io
import multiprocessing.util
import os
import pkgutil
import re
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NoReturn

from searches.fuzz_inputs import NAMED, FuzzCase
from searches.fuzz_seeds import LATTICES

SECONDS, MEGABYTES = 5.0, 1000.0
"""What an input may take: of the processor unless it is announced, of memory beyond the start."""

AFTER_ANNOUNCEMENT = 0.5
"""Seconds of the processor until an announced input is stopped by Ctrl-C."""

END_SECONDS = 2.0 * (os.cpu_count() or 1)
"""Seconds of the processor until a command and its workers end after Ctrl-C: 2 s of the clock on
all cores."""

STILL = 5.0
"""Seconds of the clock without any of the processor after which an input hangs."""

PATIENCE = 120.0
"""Seconds of the clock after which an input is given up whatever it does."""

LONGEST_LINE = 700
"""Characters of an error; the longest good one lists all shipped scenes."""

ANNOUNCED = re.compile(r"\(Ctrl-C (?:stops|ends) it\)")
UNREADABLE = re.compile(r"\d+ of \d+ statements cannot be read \(.*\)")
FORBIDDEN = ("os.system", "os.exec", "os.posix_spawn", "pty.spawn", "ftplib.connect")
"""Events of what no input may bring about."""

WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
STARTED_HERE = ("--completion", "report", "recheck", "doctor", "animate", "explore")
"""Commands that start programs of others: bash, LaTeX, PARI/GP, ffmpeg."""


USUAL_OUTPUTS = {"plot": (".png",), "animate": (".mp4", ".gif"), "sweep": (".store", ".nc")}
"""What a command writes beside its input unless it is told where."""


@dataclass(frozen=True)
class Ending:
    """Ending of an input; ``status`` is negative for a signal, None for what had to be killed."""

    status: int | None
    out: str
    errors: str
    seconds: float
    megabytes: float
    announced: bool
    stopped: bool
    faults: tuple[str, ...]

    @property
    def kinds(self) -> set[str]:
        """The first words of the faults."""
        return {fault.partition(":")[0] for fault in self.faults}

    def blamed(self, faults: Sequence[str]) -> Ending:
        """Return the same with these faults."""
        return replace(self, faults=tuple(faults))


def warm_up() -> None:
    """Import what commands import, so that a fork begins with it."""
    caches = str(Path(tempfile.gettempdir()) / "longwave-fuzz-caches")
    os.environ |= {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
    os.environ |= {
        "LONGWAVE_NO_APT": "1",
        "BROWSER": "true",
        "NUMBA_CACHE_DIR": caches,
        "MPLCONFIGDIR": caches,
    }
    from longwave.__main__ import main

    for room in ("derive", "solutions", "lattice", "verify", "scenes", "runs"):
        inside = importlib.import_module(f"longwave.{room}").__path__
        for module in pkgutil.walk_packages(inside, f"longwave.{room}."):
            importlib.import_module(module.name)
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        for name, text in {**NAMED, "lattice.toml": LATTICES[0]}.items():
            Path(name).write_text(text, encoding="utf-8")
        for line in (
            *("list", "derive lattice.toml", "derive mass_dimer --envelope k=pi", "derive toda"),
            *("run small.toml", "run toda_soliton --output run.nc", "run rogue_cn_k_0.5"),
            *("verify --only kink --output c.json", "check c.json"),
            *("prove problems.toml --limit 5", "plot small.toml --output picture.png"),
            *("verify --only kink --method residual", "list waves", "doctor"),
        ):
            words = io.StringIO()
            with contextlib.redirect_stdout(words), contextlib.redirect_stderr(words):
                main(line.split())


class FuzzServer:
    """Runs inputs in a folder of its own; use it in a ``with`` after `warm_up`.

    ``command`` takes the words and returns the exit status: that of longwave, unless it is given.
    """

    def __init__(self, command: Callable[[list[str]], int] | None = None) -> None:
        self.command = command

    def __enter__(self) -> FuzzServer:
        self.folder = Path(tempfile.mkdtemp(prefix="longwave-fuzz-"))
        gc.collect()
        gc.freeze()  # else a fork that collects copies all that it looks at
        self.anonymous = kilobytes_of(os.getpid())
        return self

    def __exit__(self, *_: object) -> None:
        shutil.rmtree(self.folder, ignore_errors=True)

    def ending(self, case: FuzzCase) -> Ending:
        """Run an input and say how it ended."""
        place = self.folder / "case"
        lay_out(case, place)
        child = forked()
        if child == 0:
            _run_and_exit(self.command or call_longwave, case, place)
        watcher = _watch(child, place, self.anonymous)
        out, errors, found = faults_of(case, place, watcher.status, watcher.stopped)
        faults = [*watcher.faults, *found]
        return Ending(
            watcher.status, out, errors, watcher.seconds, watcher.megabytes, watcher.announced,
            watcher.stopped, tuple(dict.fromkeys(faults)),
        )  # fmt: skip


# --- in the fork ----------------------------------------------------------------------------------


def _run_and_exit(command: Callable[[list[str]], int], case: FuzzCase, place: Path) -> NoReturn:
    """Run the command in its own session and folder; end this process."""
    status = 1
    try:
        confine()
        enter(case, place)
        sys.addaudithook(WriteWatcher(case, place))
        status = command(list(case.words))
        multiprocessing.util._exit_function()  # type: ignore[attr-defined]
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(BaseException):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status & 255)


def confine() -> None:
    """Give this process a session and limits of its own."""
    os.setsid()
    signal.signal(signal.SIGINT, signal.default_int_handler)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (2 * 10**9, 2 * 10**9))


def enter(case: FuzzCase, place: Path) -> None:
    """Go to the case's folder, and let what is printed go to files beside it."""
    os.chdir(place / "work")
    for number, path in ((0, Path(os.devnull)), (1, place / "out"), (2, place / "err")):
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC if number else os.O_RDONLY
        opened = os.open(path, flags)
        os.dup2(opened, number)
        os.close(opened)
    sys.stdin, sys.stdout, sys.stderr = (
        open(number, mode, encoding="utf-8", closefd=False, errors="backslashreplace")  # noqa: SIM115
        for number, mode in ((0, "r"), (1, "w"), (2, "w"))
    )
    sys.argv = ["longwave", *case.words]


def call_longwave(words: list[str]) -> int:
    """Return the exit status of the command line."""
    from longwave.__main__ import main
    from longwave.support.request_limits import request_limits

    try:
        with request_limits(memory=1e6 * MEGABYTES):  # as on a machine that has twice as much
            return main(words)
    except SystemExit as end:
        return end.code if isinstance(end.code, int) else int(end.code is not None)


class WriteWatcher:
    """Notes files that are written outside the folder, and programs that are started."""

    def __init__(self, case: FuzzCase, place: Path) -> None:
        self.report = os.open(place / "watched", os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        self.process = os.getpid()
        named = {os.path.realpath(word) for word in case.words if 0 < len(word) < 200}
        parents = {os.path.dirname(path) for path in named if not os.path.isdir(path)}
        self.place = os.path.realpath(place.parent)
        self.allowed = (str(place / "work"), *named, *parents)
        self.elsewhere = (os.path.realpath(tempfile.gettempdir()), "/dev/null", "/dev/shm")
        self.may_start = bool(set(case.words) & set(STARTED_HERE))

    def __call__(self, event: str, arguments: tuple[Any, ...]) -> None:
        """Note an event if no input may bring it about."""
        if event in FORBIDDEN or (event == "subprocess.Popen" and not self.may_start):
            self.note(f"started a program: {event} {str(arguments)[:100]}")
        path = _written(event, arguments)
        if path is not None and not self._is_allowed(path):
            self.note(f"wrote elsewhere: {event} {path}")

    def _is_allowed(self, path: str) -> bool:
        full = os.path.realpath(path)
        allowed = self.allowed if _within(full, self.place) else self.allowed + self.elsewhere
        return any(_within(full, one) for one in allowed)

    def note(self, line: str) -> None:
        """Keep a line for the parent."""
        os.write(self.report, line.encode("utf-8", "backslashreplace") + b"\n")


def _within(path: str, folder: str) -> bool:
    return path == folder or path.startswith(folder.rstrip("/") + "/")


def _written(event: str, arguments: tuple[Any, ...]) -> str | None:
    """Return the path that an event changes, if it is one of those."""
    if event == "open":
        path, _, flags = arguments
        writes = isinstance(flags, int) and flags & WRITES
        if not isinstance(path, str | bytes | os.PathLike) or not writes:
            return None
        return os.fsdecode(path)
    if event in ("os.mkdir", "os.remove", "os.rmdir", "os.truncate", "shutil.rmtree"):
        return os.fsdecode(arguments[0]) if not isinstance(arguments[0], int) else None
    if event in ("os.rename", "os.link", "os.symlink"):
        return os.fsdecode(arguments[1])
    return None


# --- in the parent --------------------------------------------------------------------------------


def lay_out(case: FuzzCase, place: Path) -> None:
    """Make an empty folder with the case's files."""
    shutil.rmtree(place, ignore_errors=True)
    work = place / "work"
    work.mkdir(parents=True)
    for name, content in case.files.items():
        (work / name).write_bytes(content)


def forked() -> int:
    """Fork the process; return 0 within the fork."""
    sys.stdout.flush()
    sys.stderr.flush()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)  # threads here; the fork has one
        return os.fork()


@dataclass
class _Watched:
    status: int | None = None
    seconds: float = 0.0
    megabytes: float = 0.0
    announced: bool = False
    stopped: bool = False
    faults: tuple[str, ...] = ()


def _watch(child: int, place: Path, start: float) -> _Watched:
    """Look at a fork until it ends or has to be killed."""
    found = _Watched()
    begun = moved = time.monotonic()
    stopped_at = announced_at = 0.0
    handle = os.pidfd_open(child)
    poller = select.poll()
    poller.register(handle, select.POLLIN)
    try:
        while not poller.poll(25):
            now, used = time.monotonic(), seconds_of(child)
            if used > found.seconds or runs(child):
                found.seconds, moved = used, now
            found.megabytes = max(found.megabytes, megabytes_of(child, start))
            if not found.announced and announced(place):
                found.announced, announced_at = True, used
            fault = _excess(found, now - begun, now - moved, used - stopped_at)
            if fault:
                found.faults = (fault,)
                return found
            long = used > announced_at + AFTER_ANNOUNCEMENT or now > moved + 2 * AFTER_ANNOUNCEMENT
            if found.announced and not found.stopped and long:
                found.stopped, stopped_at = True, used
                with contextlib.suppress(ProcessLookupError):
                    os.killpg(child, signal.SIGINT)
    finally:
        found.announced = found.announced or announced(place)
        os.close(handle)
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        _, status, usage = os.wait4(child, 0)
    found.status = os.waitstatus_to_exitcode(status)
    found.seconds = usage.ru_utime + usage.ru_stime
    if found.seconds > SECONDS and not found.announced:
        found.faults = (f"slow: {found.seconds:.1f} s of the processor",)
    return found


def _excess(found: _Watched, passed: float, still: float, since_stop: float) -> str:
    """Return the limit that is exceeded, in words; "" for none."""
    if found.megabytes > MEGABYTES:
        return f"memory: more than {MEGABYTES:g} MB"
    if found.stopped and since_stop > END_SECONDS:
        return f"Ctrl-C: no end {END_SECONDS:g} s after it"
    if found.seconds > SECONDS and not found.announced:
        return f"slow: more than {SECONDS:g} s of the processor"
    if still > STILL or passed > PATIENCE:
        return f"hangs: {passed:.0f} s of the clock, {found.seconds:.1f} s of the processor"
    return ""


def tree_of(process: int) -> Iterator[int]:
    """Yield a process and all that it has started."""
    yield process
    with contextlib.suppress(OSError):
        for task in os.listdir(f"/proc/{process}/task"):
            text = Path(f"/proc/{process}/task/{task}/children").read_text(encoding="ascii")
            for child in text.split():
                yield from tree_of(int(child))


def seconds_of(process: int) -> float:
    """Return the processor time of a process and of all that it has started."""
    ticks = 0
    for one in tree_of(process):
        with contextlib.suppress(OSError, IndexError):
            status = Path(f"/proc/{one}/stat").read_text(encoding="utf-8", errors="replace")
            ticks += sum(map(int, status.rpartition(")")[2].split()[11:15]))
    return ticks / os.sysconf("SC_CLK_TCK")


def runs(process: int) -> bool:
    """Return whether a process, or one that it has started, waits for nothing but the processor."""
    for one in tree_of(process):
        with contextlib.suppress(OSError, IndexError):
            status = Path(f"/proc/{one}/stat").read_text(encoding="utf-8", errors="replace")
            if status.rpartition(")")[2].split()[0] in "RD":
                return True
    return False


def megabytes_of(process: int, start: float) -> float:
    """Return memory beyond the start; too little for a process that was not forked from here."""
    return sum(max(0.0, kilobytes_of(one) - start) for one in tree_of(process)) / 1000


def kilobytes_of(process: int) -> float:
    """Return the memory of a process that no other has."""
    with contextlib.suppress(OSError):
        text = Path(f"/proc/{process}/status").read_text(encoding="utf-8", errors="replace")
        return float(sum(map(int, re.findall(r"Rss(?:Anon|Shmem):\s*(\d+)", text))))
    return 0.0


def announced(place: Path) -> bool:
    """Return whether a duration of the input was announced."""
    return any(ANNOUNCED.search(_text(place / name)[:100_000]) for name in ("err", "out"))


def _text(path: Path) -> str:
    with contextlib.suppress(OSError), path.open("rb") as file:
        return file.read(3_000_000).decode("utf-8", "backslashreplace")
    return ""


def faults_of(
    case: FuzzCase, place: Path, status: int | None, stopped: bool = False
) -> tuple[str, str, list[str]]:
    """Return both outputs, and the faults of outputs, status and files."""
    out, errors = (_text(place / name) for name in ("out", "err"))
    return out, errors, [*_said(status, stopped, out, errors), *_files(case, place)]


def _said(status: int | None, stopped: bool, out: str, errors: str) -> Iterator[str]:
    """Yield faults of status and words."""
    if status is not None and status < 0:
        yield f"died: signal {-status}"
    elif status is not None and status not in (0, 1, 2) and not (status == 130 and stopped):
        yield f"status: {status}"
    if "Traceback (most recent call last)" in errors + out:
        yield f"traceback: {errors.strip().splitlines()[-1][:200]}"
        return
    if "Warning" in errors:
        yield f"warning: {errors[errors.index('Warning') - 30 :][:100]!r}"
    lines = errors.splitlines()
    pictures = status == 2  # the part of a formula that is meant, below the error
    messages = [line for line in lines if not ANNOUNCED.search(line)]
    messages = [line for line in messages if not (pictures and line.startswith("    "))]
    if status == 2 and not _are_errors(messages):
        yield f"lines: {len(messages)} for status 2: {messages[:2]}"
    if status == 130 and not (messages and messages[-1].count("interrupted")):
        yield f"lines: no word of the interruption: {messages[-2:]}"
    if any(len(line) > LONGEST_LINE for line in lines):
        yield f"long: a line of {max(map(len, lines))} characters"
    strange = sorted({sign for sign in out + errors if not sign.isprintable() and sign != "\n"})
    if strange:
        yield f"signs: {strange[:5]}"


def _are_errors(messages: Sequence[str]) -> bool:
    """Return whether there is one error, or one for each unreadable statement and their number."""
    several = bool(messages) and UNREADABLE.fullmatch(messages[-1]) is not None
    errors = messages[:-1] if several else messages
    alone = several or len(errors) == 1
    return bool(errors) and alone and all(line.startswith("error: ") for line in errors)


def _files(case: FuzzCase, place: Path) -> Iterator[str]:
    """Yield faults of files: what was written elsewhere, over an input, or half."""
    yield from sorted(set(_text(place / "watched").splitlines()))
    for name, content in case.files.items():
        path = place / "work" / name
        is_unchanged = path.is_file() and path.read_bytes() == content
        if not is_unchanged and "--force" not in case.words:
            yield f"overwritten: {name}"
    named = {word.strip("/") for word in case.words}
    for path in (place / "work").rglob("*"):
        top = path.relative_to(place / "work").parts[0]
        stems = [name.rpartition(".")[0] for name in case.files]
        suffixes = USUAL_OUTPUTS.get(case.words[0] if case.words else "", ())
        usual = {stem + suffix for stem in stems for suffix in suffixes}
        known = top in {*case.files, *usual, "longwave-report"}
        run = top.removesuffix(".checkpoint")  # that Ctrl-C stopped
        if not known and not any(word.split("/")[0] in (top, run) for word in named):
            stem = top.partition(".")[0].rpartition("_")[0]
            if not stem or not any(word.startswith(stem) for word in named):
                yield f"left behind: {path.relative_to(place / 'work')}"
