"""Catches: usage dumps, messages of several lines, a wrong exit status, in any room's command."""

from importlib import import_module

import pytest

from derive.__main__ import main
from derive.command_line import fail

COMMANDS = {
    "derive.__main__": "main",
    "verify.cli.verdicts": "verdicts_command",
    "verify.cli.certificates": "certificate_command",
    "verify.cli.mutations": "mutations_command",
    "verify.cli.run": "run_command",
    "verify.cli.accuracy": "accuracy_command",
    "reports.__main__": "main",
    "reports.bench": "main",
    "reports.figures.__main__": "main",
}


@pytest.mark.parametrize("module", COMMANDS)
def test_an_unknown_option_is_one_line(module: str, capsys: pytest.CaptureFixture[str]) -> None:
    command = getattr(import_module(module), COMMANDS[module])
    try:
        status = command(["--bogus"])
    except SystemExit as stop:
        status = stop.code
    error = capsys.readouterr().err
    assert status == 2
    assert error.startswith("error: ")
    assert error.count("\n") == 1
    assert "--help)" in error


def test_a_message_of_several_lines_is_told_in_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert fail("one\n  two") == 2
    assert capsys.readouterr().err == "error: one two\n"


def test_two_dashes_are_no_value(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--k2", "--"]) == 2
    assert capsys.readouterr().err.startswith("error: K2 must be a rational number, got '--'")
