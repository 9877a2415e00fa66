"""`python -m reports`: what is left when LaTeX is missing, exit statuses, one-line errors."""

from pathlib import Path

import pytest
import xarray as xr

from reports import __main__ as command_line
from reports.engine import EngineMissingError
from verify.verdict import Outcome, Verdict

SOUND = Verdict("kink", "defocusing mKdV", "exact", Outcome.PROVED, "", 0.0)
UNSOUND = Verdict("kink", "defocusing mKdV", "exact", Outcome.UNDECIDED, "too hard")


@pytest.fixture
def without_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    """No lattice is run and nothing is drawn; the source is one line."""
    run = xr.Dataset(attrs={"blow_up": ""})
    monkeypatch.setattr(command_line, "report_scenes", dict)
    monkeypatch.setattr(command_line, "run_scenes", lambda *_: {"one": run})
    monkeypatch.setattr(command_line, "check_all", lambda: [SOUND])
    monkeypatch.setattr(command_line, "write_figures", lambda *_: [])

    def write_source(_e: object, _v: object, folder: Path, _w: object) -> Path:
        (folder / "longwave.tex").write_text("source")
        return folder / "longwave.tex"

    monkeypatch.setattr(command_line, "write_source", write_source)
    monkeypatch.setattr(command_line, "ensure_engine", lambda say: None)
    monkeypatch.setattr(command_line, "compile_pdf", lambda tex: tex.with_suffix(".pdf"))


def test_it_ends_with_the_path(
    without_runs: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert command_line.main(["--output", str(tmp_path)]) == 0
    assert capsys.readouterr().out.rstrip().endswith(f"{tmp_path}/longwave.pdf")


def test_without_latex_the_source_is_left_and_one_line_says_what_to_install(
    without_runs: None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def missing(say: object) -> None:
        raise EngineMissingError("no LaTeX engine: install latexmk")

    monkeypatch.setattr(command_line, "ensure_engine", missing)
    assert command_line.main(["--output", str(tmp_path)]) == 1
    assert capsys.readouterr().err == "error: no LaTeX engine: install latexmk\n"
    assert (tmp_path / "longwave.tex").exists()


def test_a_form_that_does_not_stand_fails_the_report(
    without_runs: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command_line, "check_all", lambda: [SOUND, UNSOUND])
    assert command_line.main(["--output", str(tmp_path)]) == 1


def test_a_run_that_blew_up_fails_the_report(
    without_runs: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = xr.Dataset(attrs={"blow_up": "at t = 1, site 2"})
    monkeypatch.setattr(command_line, "run_scenes", lambda *_: {"one": run})
    assert command_line.main(["--output", str(tmp_path)]) == 1


def test_bad_workers_are_one_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert command_line.main(["--workers", "0", "--output", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error == "error: workers must be at least 1, got 0 (2 is usual)\n"
