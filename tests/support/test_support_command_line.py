"""Catches: usage dumps, messages of several lines, a wrong exit status, in any command."""

import resource
import signal
from importlib import import_module

import click
import pytest

from longwave.derive.__main__ import main
from longwave.support.command_line import fail, limit_options, run_words

COMMANDS = {
    "longwave.derive.__main__": ("",),
    "longwave.verify.__main__": ("", "mutations", "accuracy"),
    "longwave.reports.__main__": ("",),
}


@pytest.mark.parametrize(
    ("module", "word"), [(module, word) for module, words in COMMANDS.items() for word in words]
)
def test_an_unknown_option_is_one_line(
    module: str, word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert import_module(module).main([*word.split(), "--bogus"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert error.count("\n") == 1
    assert f"{word} --help)" in error


def test_a_message_of_several_lines_becomes_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert fail("one\n  two") == 2
    assert capsys.readouterr().err == "error: one two\n"


def test_a_long_word_of_a_file_is_cut(capsys: pytest.CaptureFixture[str]) -> None:
    assert fail(f"scheme must be a known one, got '{'x' * 3000}' (one of rk4)") == 2
    assert 150 < len(capsys.readouterr().err) < 250


def test_two_dashes_are_not_a_value(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--k2", "--"]) == 2
    assert capsys.readouterr().err.startswith(
        "error: K2: expected a number, a name or '(', got the end"
    )


def test_limits_inside_another_process_do_not_affect_it() -> None:
    """Catches: a memory limit or timer that stays, or that ends the caller of the command."""
    before = resource.getrlimit(resource.RLIMIT_DATA)

    @click.command()
    @limit_options
    def command() -> int:
        assert resource.getrlimit(resource.RLIMIT_DATA) == before
        assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
        return 0

    assert run_words(command, "command", ["--max-memory", "1M", "--max-time", "1s"]) == 0
