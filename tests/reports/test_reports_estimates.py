"""The table of the search for dishonest estimates."""

import math

from longwave.reports.sections.costs import estimate_table, reason_table
from longwave.reports.studies.estimates import Judged, estimate_rows


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
