"""Catches: a pipe that blocks, a file read without end, a long quotation, lost limits."""

import io
import math
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

from longwave.__main__ import main
from longwave.support.command_line import MAX_QUOTED
from longwave.support.request_limits import (
    ExpectedCost,
    OverBudgetError,
    check_request,
    current_limits,
    machine_memory,
    request_limits,
)
from longwave.support.user_files import read_toml


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names")
def test_a_pipe_does_not_block(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "scene.toml")
    with pytest.raises(ValueError, match=r"must be a regular file, got .*, a pipe"):
        read_toml(tmp_path / "scene.toml", "scene", 100)
    with pytest.raises(ValueError, match=r"must be a regular file, got .*, a folder"):
        read_toml(tmp_path, "scene", 100)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"a = 1" + b" " * 100, "at most 100 bytes"),
        (b"a = '\xff'", r"text in UTF-8, got .* byte 0xff at 5"),
        (b"a = ", "must be a TOML file, got "),
        (b"a." * 30 + b"a = 1", "must have plain keys"),
    ],
)
def test_unreadable_files_are_reported(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "x.toml"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=message) as raised:
        read_toml(path, "scene", 100)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize("depth", [101, 400, 2000])
def test_deep_nesting_is_refused(tmp_path: Path, depth: int) -> None:
    path = tmp_path / "x.toml"
    path.write_text("a = " + "[" * depth + "]" * depth)
    with pytest.raises(ValueError, match="nested at most 100 deep"):
        read_toml(path, "scene", 10_000)


def test_a_byte_order_mark_and_the_standard_input(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    content = b"\xef\xbb\xbfa = 1"
    path = tmp_path / "x.toml"
    path.write_bytes(content)
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(content)))
    assert read_toml(path, "scene", 100) == read_toml("-", "scene", 100) == {"a": 1}


def test_an_error_quotes_little(capsys: pytest.CaptureFixture[str]) -> None:
    long = "ab cd " * 2000
    for words in (["run", long], ["plot", "x", "--kind", long], ["derive", long], ["prove", long]):
        assert main(words) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1
        assert long[: MAX_QUOTED + 1] not in error


def test_a_limit_holds_in_its_body_alone() -> None:
    before = current_limits()
    assert before.memory_bytes == 0.5 * machine_memory()
    assert before.seconds == math.inf
    with request_limits("1M", "10s"), request_limits(seconds="1min"):
        check_request("it", ExpectedCost(59.0, 1e6), "less")
        with pytest.raises(OverBudgetError, match=r"it must fit 1 MB, got about 2 MB \(less, or "):
            check_request("it", ExpectedCost(0.0, 2e6), "less")
        with pytest.raises(OverBudgetError, match="it must take at most 60 s, got about 2 min"):
            check_request("it", ExpectedCost(120.0), "less")
    assert current_limits() == before
