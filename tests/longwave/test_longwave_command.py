"""The command `longwave`: dispatch, help, and one clear line for a wrong word."""

import subprocess
import sys

import pytest

from longwave import __main__ as command_line


@pytest.mark.parametrize("argv", [[], ["--help"], ["-h"]])
def test_help_names_every_command(argv: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert command_line.main(argv or ["--help"]) == 0
    printed = capsys.readouterr().out
    assert all(word in printed for word in ("derive", "verify", "run", "report"))


def test_a_wrong_word_is_one_line_and_status_2(capsys: pytest.CaptureFixture[str]) -> None:
    assert command_line.main(["vreify"]) == 2
    error = capsys.readouterr().err
    known = "derive, verify, run, report"
    assert error == f"error: COMMAND must be a known one, got vreify (one of {known})\n"


def test_the_rest_of_the_line_goes_to_the_room(monkeypatch: pytest.MonkeyPatch) -> None:
    got: list[list[str]] = []
    monkeypatch.setattr(command_line, "command", lambda word: lambda argv: got.append(argv) or 3)
    assert command_line.main(["run", "scene.toml", "--quiet"]) == 3
    assert got == [["scene.toml", "--quiet"]]


@pytest.mark.parametrize("word", ["derive", "verify", "run", "report"])
def test_every_command_exists(word: str) -> None:
    assert callable(command_line.command(word))


def test_it_runs_as_a_module() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "longwave", "--version"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("longwave ")
