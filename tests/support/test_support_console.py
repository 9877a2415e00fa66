"""What is said of long work where no bar is seen."""

import time
from itertools import chain, repeat

import pytest
from rich.console import Console

from longwave.cli import statements
from longwave.support.console import QUIET, progress_bar
from longwave.verify.published import chosen

PATIENCE = 600.0


def said_of(capsys: pytest.CaptureFixture[str], wanted: str) -> str:
    said, end = "", time.monotonic() + PATIENCE
    while wanted not in said and time.monotonic() < end:
        time.sleep(0.01)
        said += capsys.readouterr().err
    return said


def test_work_that_was_not_foreseen_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    clock = chain([0.0], repeat(2 * QUIET)).__next__
    with progress_bar("name", "the work", Console(stderr=True), clock):
        said = said_of(capsys, "the work")
    assert said == "the work: takes more than some seconds (Ctrl-C stops it)\n"


def test_announced_and_quick_work_is_not_told_again(capsys: pytest.CaptureFixture[str]) -> None:
    clock = chain(repeat(0.0, 2), repeat(2 * QUIET)).__next__
    with progress_bar("name", "the work", Console(stderr=True), clock) as (_, tell):
        tell(20.0)
        time.sleep(0.5)
    assert capsys.readouterr().err == "the work: about 20 s (Ctrl-C stops it)\n"
    with progress_bar("name", "the work", Console(stderr=True), repeat(0.0).__next__):
        time.sleep(0.3)
    assert capsys.readouterr().err == ""


def test_many_statements_are_told_before_they_are_read(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(statements, "MANY", 0)
    name = next(iter(chosen(()))).name
    statements.read_problems(chosen([name]))
    assert "to be read and decided: takes more" in capsys.readouterr().err
