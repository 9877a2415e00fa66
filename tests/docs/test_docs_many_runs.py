"""The session of the page on many runs, typed into one shell: it prints what the page says."""

import doctest
import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

from snippets import SLOW, Command, commands, snippets

HOUSE = Path(__file__).parents[2]
PAGE = HOUSE / "docs" / "many-runs.md"
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
MARK = "=== the next command"


def typed(session: list[Command], folder: Path) -> list[str]:
    """What each command of a session prints, on both outputs, typed into one shell."""
    lines = ["exec 2>&1", *(f"echo '{MARK}'\n{command.line}" for command in session)]
    unwanted = ("PYTHONPATH", "VIRTUAL_ENV")
    environment = {name: value for name, value in os.environ.items() if name not in unwanted}
    source = folder / "source"
    kept = shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__", "tests", "docs")
    shutil.copytree(HOUSE, source, ignore=kept)
    shell = subprocess.Popen(
        ["bash"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=folder,
        env=environment | {"SOURCE": str(source), "COLUMNS": "200"},
        start_new_session=True,
    )
    try:
        out, _ = shell.communicate("\n".join([*lines, "kill $(jobs -p)", ""]), timeout=1200)
    finally:
        os.killpg(shell.pid, signal.SIGKILL)
    return out.split(f"{MARK}\n")[1:]


@pytest.mark.slow
def test_the_session_prints_what_the_page_says(tmp_path: Path) -> None:
    session: list[Command] = []
    for snippet in snippets(PAGE.read_text(encoding="utf-8")):
        if snippet.kind == "console":
            session += commands(snippet.text)
        else:
            (tmp_path / snippet.caption).write_text(snippet.text, encoding="utf-8")
    printed = typed(session, tmp_path)
    assert len(printed) == len(session), printed[-1]
    check = doctest.OutputChecker().check_output
    for command, text in zip(session, printed, strict=True):
        got = SLOW.sub("", text)
        assert check(command.output, got, FLAGS), f"{command.line}\n{got}"
