"""Catches: Ctrl-C reported in several lines; a finished command that is killed by the signal."""

import os
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from longwave.support.interruption import interrupted

LATE = """
import os, signal, sys
from longwave.support.interruption import interruptible

class Press:
    def __del__(self, kill=os.kill, process=os.getpid(), number=signal.SIGINT):
        kill(process, number)

press = Press()  # deleted as Python ends, when it has forgotten all handlers
sys.exit(interruptible("late", lambda: 3, whole_process=True))
"""


def test_an_interruption_is_reported_in_one_line_for_any_file_name(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert interrupted("longwave run", "2 snapshots are kept in out\n\x1b[31m.nc") == 130
    assert capsys.readouterr().err == (
        "longwave run: interrupted (2 snapshots are kept in out\\n\\x1b[31m.nc)\n"
    )


def test_ctrl_c_while_python_exits_keeps_the_status() -> None:
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    late = [sys.executable, "-c", LATE]
    ended = subprocess.run(late, capture_output=True, text=True, env=environment, timeout=600)
    assert (ended.returncode, ended.stdout, ended.stderr) == (3, "", "")


WAITING = """
import sys, time
from pathlib import Path
from longwave.support.file_lock import locked
from longwave.support.interruption import interruptible

def work():
    with locked(Path(sys.argv[1])):
        print("begun", flush=True)
        time.sleep(600)

sys.exit(interruptible("waiting", work, whole_process=True))
"""


@pytest.mark.parametrize("in_background", [False, True])
def test_a_scheduler_ends_a_command_as_ctrl_c_does(in_background: bool, tmp_path: Path) -> None:
    """Also for a background command of a script, where Ctrl-C is ignored; no lock remains."""
    running = subprocess.Popen(
        [sys.executable, "-c", WAITING, str(tmp_path / "lock")],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])},
        preexec_fn=partial(
            signal.signal,
            signal.SIGINT,
            signal.SIG_IGN if in_background else signal.default_int_handler,
        ),
    )  # fmt: skip
    assert running.stdout is not None
    assert running.stdout.readline() == "begun\n"
    running.terminate()
    _, errors = running.communicate(timeout=600)
    assert (running.returncode, errors) == (143, "waiting: interrupted\n")
    assert not list(tmp_path.iterdir())


FORKED = """
import os, signal, sys, time
from longwave.support.interruption import interruptible

def work():
    child = os.fork()
    if child == 0:
        print(signal.getsignal(signal.SIGTERM) is signal.SIG_DFL, flush=True)
        os._exit(0)
    os.waitpid(child, 0)
    return 0

sys.exit(interruptible("forking", work, whole_process=True))
"""


def test_a_fork_is_ended_by_the_signal_that_its_parent_sends() -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    words = [sys.executable, "-c", FORKED]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, timeout=600)
    assert (done.returncode, done.stdout, done.stderr) == (0, "True\n", "")
