"""`make bench`: prints where its tables are, and fails if a case fails."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks import studies
from longwave.reports.build import STUDY_TABLES
from longwave.reports.studies.effects import EffectCost
from longwave.reports.studies.hard_cases import HardCase
from longwave.reports.studies.lattice_cost import CostPoint, PeakError, ScalingPoint
from longwave.support.processes import Key

HARD = HardCase("what", "how much", 0.5, 0.1)
FOUND = {
    ("precision", ""): [CostPoint("crest", "rk4", 1e-3, 0.1)],
    ("scaling", ""): [ScalingPoint("window", x, x**4) for x in (10.0, 20.0)],
    ("rk4", ""): [ScalingPoint("error figure", x, 0.1 + x) for x in (0.25, 0.0)],
    ("windows", ""): [ScalingPoint("window", x, 1 / x) for x in (1024.0, 2048.0)],
    ("hard", "one"): HARD,
    ("effect", "a force"): EffectCost(8, 3e-10, 0.8, ((1e-7, 0.02), (1e-11, 0.07))),
    **{("peak", eps): PeakError(2, eps, eps**2, 1e-9, 1.0, "stencil") for eps in (0.1, 0.05)},
}


def measure(found: Mapping[Key, Any], folder: Path, monkeypatch: pytest.MonkeyPatch) -> int:
    """Run the command with these findings and without figures."""
    monkeypatch.setattr(studies, "run_jobs", lambda *_: found)
    monkeypatch.setattr(studies, "write_figures", lambda *_: [folder / "figure.pdf"])
    return studies.main(["--output", str(folder)])


def test_the_command_prints_where_its_tables_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Catches a table that is not written, and one without rows that is told."""
    assert measure(FOUND, tmp_path, monkeypatch) == 0
    output = capsys.readouterr().out
    for name in ("precision", "scaling", "rk4", "window", "peak", "hard_case", "effect"):
        path = tmp_path / "tables" / f"{name}_table.tex"
        assert str(path) in output
        assert "toprule" in path.read_text()
    assert "long_table" not in output
    assert "figure.pdf" in output
    assert {path.stem for path in (tmp_path / "tables").iterdir()} == set(STUDY_TABLES)


def test_a_case_that_fails_is_its_exit_status(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    wrong = FOUND | {("hard", "one"): replace(HARD, measured=1.0)}
    assert measure(wrong, tmp_path, monkeypatch) == 1
