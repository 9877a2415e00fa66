"""The table of the search for dishonest estimates."""

import math
from pathlib import Path

import pytest

from longwave.reports.__main__ import main
from longwave.reports.sections.costs import estimate_table, reason_table
from longwave.reports.studies.estimates import Judged, estimate_rows, judged_findings


def judged(index: int, verdict: str, true: float, reason: str = "") -> Judged:
    return Judged(
        1, index, "wave_cn", "", "stencil", 1e-4, verdict, 1e-5, true, 1e-9, reason, 1.0, 2.0, 0, ""
    )


FOUND = [
    judged(0, "honest", 2e-6),
    judged(1, "dishonest", 4e-5),
    judged(2, "refused", math.nan, "eps must be below 0.12, got 0.2 (50 % less)"),
    judged(3, "refused", math.nan, "eps must be below 0.11, got 0.3 (50 % less)"),
]


def test_the_table_counts_verdicts_and_shows_the_worst_ratio() -> None:
    lines = estimate_table(estimate_rows(FOUND)).splitlines()
    (total,) = [line for line in lines if line.startswith("all &")]
    assert total.startswith("all & 4 & 1 & 1 & -- & 2 & -- & -- &")
    assert "$4.0$" in total
    assert any(line.startswith(r"wave\_cn & 4") for line in lines)


def test_reasons_that_differ_in_numbers_are_one() -> None:
    text = reason_table(FOUND)
    assert r"2 & eps must be below N, got N (N \% less)" in text


def test_without_scenes_there_is_no_table() -> None:
    assert estimate_table(estimate_rows([])) == reason_table([]) == reason_table(FOUND[:1]) == ""


def test_what_the_search_wrote_is_tabled_in_the_order_of_the_scenes(tmp_path: Path) -> None:
    path = tmp_path / "found.jsonl"
    path.write_text("".join(one.json() + "\n" for one in reversed(FOUND)))
    found = judged_findings(path)
    assert list(found) == [("estimate", index) for index in range(4)]
    assert estimate_table(estimate_rows(found.values())) == estimate_table(estimate_rows(FOUND))


@pytest.mark.parametrize("text", ["no json", '{"seed": 1}', "[1]"])
def test_another_file_is_refused_before_anything_is_run(
    text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "found.jsonl"
    path.write_text(text)
    assert main(["--output", str(tmp_path / "report"), "--estimates", str(path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(
        "error: --estimates must be a file written by `python -m searches.estimates"
    )
