"""`longwave verify mutations`: counts, reasons, exit statuses."""

import json

import pytest

from longwave.cli import verdicts as command
from longwave.verify.__main__ import main
from longwave.verify.evidence.mutations import MutationCount, Survivor
from longwave.verify.verdict import Outcome

Output = pytest.CaptureFixture[str]


def test_counts_and_survivors_are_printed(capsys: Output) -> None:
    assert main(["mutations", "--only", "kink", "--only", "rational_1"]) == 0
    output = capsys.readouterr().out
    rows = {line.split()[1]: line.split() for line in output.splitlines() if "│" in line}
    assert rows["kink"][3:10:2] == ["8", "7", "1", "0"]
    assert rows["total"][3:10:2] == ["26", "23", "3", "0"]
    assert "kink: PROVED (symmetry U to -U): term" in output
    assert output.count("rational_1: PROVED (constant): term") == 2


def test_json_has_the_counts(capsys: Output) -> None:
    assert main(["mutations", "--only", "soliton_sech", "--json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)
    assert record["mutants"] == record["refuted"] + record["proved"]
    assert record["survivors"][0]["reason"] == "symmetry U to -U"


def test_an_undecided_mutant_gives_status_1(
    capsys: Output, monkeypatch: pytest.MonkeyPatch
) -> None:
    left = Survivor("term x: dropped", Outcome.UNDECIDED, "9 terms are left")
    monkeypatch.setattr(command, "count_mutants", lambda form: MutationCount("kink", 8, (left,), 0))
    assert main(["mutations", "--only", "kink"]) == 1
    assert "kink: UNDECIDED (9 terms are left): term x: dropped" in capsys.readouterr().out
