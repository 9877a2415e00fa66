"""Catches: a watched command that outlives its watcher, or a status that is not passed on."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.conftest import PATIENCE

HOUSE = Path(__file__).parents[2]

COMMAND = """
import os, sys, time
from longwave.support.interruption import interruptible

def work():
    print(os.getpid(), os.getppid(), flush=True)
    {work}
    return 3

sys.argv[1:] = ["--max-time", "none"]
sys.exit(interruptible("command", work, whole_process=True))
"""


def started(work: str) -> tuple[subprocess.Popen[str], int]:
    """Start a command with a limit; return it and the process that does its work."""
    running = subprocess.Popen(
        [sys.executable, "-P", "-c", COMMAND.format(work=work)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(HOUSE)},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )  # fmt: skip
    assert running.stdout is not None
    worker, parent = map(int, running.stdout.readline().split())
    assert parent == running.pid
    return running, worker


def test_the_status_is_that_of_the_command() -> None:
    running, _ = started("print('done')")
    assert running.stdout is not None
    assert running.stdout.read() == "done\n"  # what was read ahead with the first line, too
    assert running.communicate(timeout=PATIENCE)[1] == ""
    assert running.returncode == 3


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_is_passed_on(number: int, status: int) -> None:
    running, _ = started("time.sleep(600)")
    running.send_signal(number)
    out, errors = running.communicate(timeout=PATIENCE)
    assert (running.returncode, out, errors) == (status, "", "command: interrupted\n")


@pytest.mark.slow
def test_a_command_ends_with_its_watcher() -> None:
    running, worker = started("time.sleep(600)")
    running.kill()
    _, errors = running.communicate(timeout=PATIENCE)  # until the worker has closed them too
    assert errors == "command: interrupted\n"
    end = time.monotonic() + PATIENCE
    while Path(f"/proc/{worker}").exists() and time.monotonic() < end:
        time.sleep(0.02)
    assert not Path(f"/proc/{worker}").exists()


def test_a_crash_is_passed_on() -> None:
    running, _ = started("os.kill(os.getpid(), 11)")
    running.communicate(timeout=PATIENCE)
    assert running.returncode == -signal.SIGSEGV


SHARED = """
import os, signal, time
from longwave.support.supervision import memory_in_use, processes_of

held = b"1" * 50_000_000
child = os.fork()
if child == 0:
    time.sleep(600)
assert child in processes_of(os.getpid())
alone, twice = memory_in_use(child), memory_in_use(os.getpid(), enough=1e15)
once = memory_in_use(os.getpid())
os.kill(child, signal.SIGKILL)
os.waitpid(child, 0)
assert twice >= alone + len(held)
assert once < twice - len(held) // 2
"""


def test_memory_is_that_of_all_processes_and_shared_pages_count_once() -> None:
    command = [sys.executable, "-P", "-c", SHARED]
    done = subprocess.run(
        command, capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(HOUSE)}
    )
    assert (done.returncode, done.stderr) == (0, "")
