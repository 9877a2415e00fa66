"""Long requests are announced before they begin; Ctrl-C ends them in one line with status 130."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

HOUSE = Path(__file__).parents[3]


def interrupted(words: list[str], seconds: float) -> tuple[int, str, list[str]]:
    """Status, stdout and lines on stderr of a command; Ctrl-C comes some time after its word."""
    running = subprocess.Popen(
        [sys.executable, "-m", *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=HOUSE,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    assert running.stderr is not None
    first = running.stderr.readline()
    time.sleep(seconds)
    running.send_signal(signal.SIGINT)
    try:
        out, errors = running.communicate(timeout=60)
    finally:
        running.kill()
    return running.returncode, out, [first, *errors.splitlines()]


@pytest.mark.parametrize(
    ("words", "announced"),
    [
        (
            ["verify", "--only", "rational_3", "--only", "rational_40"],
            "2 forms to be checked: about",
        ),
        (["verify", "mutations", "--only", "rational_12"], "the misprints of rational_12: about"),
    ],
)
def test_a_long_request_is_announced_and_ends_on_ctrl_c(words: list[str], announced: str) -> None:
    status, out, errors = interrupted(words, 4.0)
    assert status == 130
    assert len(errors) == 2, errors
    assert errors[0].startswith(announced)
    assert ": interrupted (after " in errors[1]
    if "rational_3" in words:
        assert "PROVED" in out
