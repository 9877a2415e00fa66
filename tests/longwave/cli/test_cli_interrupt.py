"""Long requests are announced before they start; Ctrl-C ends them with one line and status 130."""

from typing import Any

import pytest


@pytest.mark.parametrize(
    ("words", "announced"),
    [
        (
            ["verify", "--only", "rational_3", "--only", "rational_40", "--max-time", "none"],
            "2 forms to be checked: about",
        ),
        pytest.param(
            ["verify", "mutations", "--only", "rational_12"],
            "the misprints of rational_12: about",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_a_long_request_is_announced_and_ends_on_ctrl_c(
    words: list[str], announced: str, press_ctrl_c: Any
) -> None:
    done = press_ctrl_c(words, 1.0)
    assert done.status == 130
    assert done.announced.startswith(announced)
    assert len(done.errors.splitlines()) == 1, done.errors
    assert ": interrupted (after " in done.errors
    if "rational_3" in words:
        assert "PROVED" in done.out
