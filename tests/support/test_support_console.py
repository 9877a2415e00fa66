"""Output for other programs, and the announcement of statements before they are read."""

import json

import numpy as np
import pytest

from longwave.cli import statements
from longwave.support.console import print_json
from longwave.verify.published import chosen

Output = pytest.CaptureFixture[str]


def test_json_output_is_valid_json(capsys: Output) -> None:
    print_json({"a": [np.nan, 1.0], "b": np.array([np.inf, 2.0]), "c": np.int64(3), "d": (1, "x")})
    told = capsys.readouterr().out
    assert "NaN" not in told
    assert json.loads(told) == {"a": [None, 1.0], "b": [None, 2.0], "c": 3, "d": [1, "x"]}


def test_many_statements_are_announced_before_they_are_read(
    monkeypatch: pytest.MonkeyPatch, capsys: Output
) -> None:
    monkeypatch.setattr(statements, "READING_SECONDS", 60.0)
    name = next(iter(chosen(()))).name
    statements.read_problems(chosen([name]))
    assert "1 statements to be read: about 60 s" in capsys.readouterr().err
