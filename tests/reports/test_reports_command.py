"""`python -m reports`: what is left when LaTeX is missing, exit statuses, one-line errors."""

from pathlib import Path
from typing import Any

import pytest
import xarray as xr

from longwave.reports import build
from longwave.reports.__main__ import main
from longwave.reports.engine import EngineMissingError
from longwave.reports.studies.hard_cases import HardCase
from longwave.reports.studies.lattice_runs import SceneRun
from longwave.reports.studies.proofs import ProofRecord, PublishedVerdict
from longwave.scenes.description.named_scenes import load_scene
from longwave.support.processes import Key
from longwave.verify.evidence.mutations import MutationCount, Survivor
from longwave.verify.published import chosen
from longwave.verify.verdict import Outcome


def findings(
    outcome: Outcome = Outcome.PROVED,
    blow_up: str = "",
    undecided: int = 0,
    fails: bool = False,
    library: Outcome = Outcome.PROVED,
    scenes: dict[str, SceneRun] | None = None,
) -> dict[Key, Any]:
    """Return findings of a report: one proof, run, count of misprints and published solution."""
    survivors = (Survivor("term", Outcome.UNDECIDED, "too hard"),) * undecided
    (text,) = chosen(["kdv_one_soliton"])
    found: dict[Key, Any] = {
        ("run", "one"): xr.Dataset(attrs={"blow_up": blow_up}),
        ("proof", "kink"): ProofRecord("kink", "exact", outcome, 0.1, 1000, 0.1, True),
        ("mutants", "kink"): MutationCount("kink", 8, survivors, 0.1),
        ("hard", "one"): HardCase("what", "how much", 0.5, 1.0 if fails else 0.1),
        ("library", "KdV"): [PublishedVerdict(text, library, 0.1)],
    }
    return found | {("scene", name): scene for name, scene in (scenes or {}).items()}


@pytest.fixture
def without_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Replace computing and drawing, such that the source is one line."""
    monkeypatch.setattr(build, "run_jobs", lambda *_: findings())
    monkeypatch.setattr(build, "all_jobs", lambda *_: {})
    monkeypatch.setattr(build, "write_figures", lambda *_: [])

    def write_source(_found: object, folder: Path, _full: bool, _wrote: object) -> Path:
        (folder / "longwave.tex").write_text("source")
        return folder / "longwave.tex"

    monkeypatch.setattr(build, "write_source", write_source)
    monkeypatch.setattr(build, "ensure_engine", lambda: None)
    monkeypatch.setattr(build, "compile_pdf", lambda tex: tex.with_suffix(".pdf"))


def test_an_older_report_is_overwritten_if_that_is_asked_for(
    without_work: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "longwave.tex").write_text("older")
    assert main(["--output", str(tmp_path)]) == 2
    assert "which has one (--force overwrites it)" in capsys.readouterr().err
    assert (tmp_path / "longwave.tex").read_text() == "older"
    assert main(["--output", str(tmp_path), "--force"]) == 0
    assert (tmp_path / "longwave.tex").read_text() == "source"


def test_the_output_ends_with_the_path(
    without_work: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--output", str(tmp_path)]) == 0
    assert capsys.readouterr().out.rstrip().endswith(f"{tmp_path}/longwave.pdf")


@pytest.fixture
def without_latex(without_work: None, monkeypatch: pytest.MonkeyPatch) -> None:
    def missing() -> None:
        raise EngineMissingError("no LaTeX engine: install latexmk")

    monkeypatch.setattr(build, "ensure_engine", missing)


def test_without_latex_the_source_is_left_and_one_line_says_what_to_install(
    without_latex: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--output", str(tmp_path)]) == 1
    assert capsys.readouterr().err == (
        "error: no LaTeX engine: install latexmk; only the source is written\n"
    )
    assert (tmp_path / "longwave.tex").exists()


def test_what_it_takes_is_refused_before_an_engine_is_looked_for(
    without_latex: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--output", str(tmp_path), "--max-memory", "1G"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: the report must fit 1 GB, got about 1.")


@pytest.mark.parametrize(
    "found",
    [
        findings(Outcome.UNDECIDED),
        findings(blow_up="at t = 1, site 2"),
        findings(undecided=1),
        findings(fails=True),
        findings(library=Outcome.UNDECIDED),
        findings(scenes={"one": SceneRun(load_scene("toda_soliton"), None, "blew up")}),
    ],
    ids=["form", "blow-up", "misprint", "hard case", "published solution", "other lattice"],
)
def test_a_failed_finding_fails_the_report(
    without_work: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, found: dict[Key, Any]
) -> None:
    monkeypatch.setattr(build, "run_jobs", lambda *_: found)
    assert main(["--output", str(tmp_path)]) == 1


def test_bad_workers_are_one_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["--workers", "0", "--output", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error == "error: workers must be at least 1, got 0 (2 is usual)\n"


def test_it_is_written_into_the_working_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    folders: list[Path] = []
    monkeypatch.setattr(build, "write_report", lambda output, *_, **__: folders.append(output))
    assert main([]) == 0
    assert folders == [Path("longwave-report")]
