"""Catches: Ctrl-C told in several lines; a command that did its work and dies of the signal."""

import os
import subprocess
import sys
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


def test_an_interruption_is_told_in_one_line_whatever_a_file_is_called(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert interrupted("longwave run", "2 snapshots are kept in out\n\x1b[31m.nc") == 130
    assert capsys.readouterr().err == (
        "longwave run: interrupted (2 snapshots are kept in out\\n\\x1b[31m.nc)\n"
    )


def test_ctrl_c_while_python_ends_leaves_the_status() -> None:
    root = Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": str(root)}
    late = [sys.executable, "-c", LATE]
    ended = subprocess.run(late, capture_output=True, text=True, env=environment, timeout=600)
    assert (ended.returncode, ended.stdout, ended.stderr) == (3, "", "")
