"""The LaTeX engine: nothing is installed, errors quote the log, shell escape stays off."""

import subprocess
from pathlib import Path

import pytest

from longwave.reports import engine


def test_without_an_engine_nothing_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command that runs apt as root would surprise its user; `make latex` says what it does."""
    monkeypatch.setattr(engine.shutil, "which", {"apt-get": "/usr/bin/apt-get"}.get)
    monkeypatch.setattr(engine.subprocess, "run", None)
    with pytest.raises(
        engine.EngineMissingError, match=r"^no LaTeX engine: install latexmk [^\n]*$"
    ):
        engine.ensure_engine()


def test_latex_runs_without_shell_escape(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ran: list[list[str]] = []

    def run(command: list[str], directory: Path) -> subprocess.CompletedProcess[str]:
        ran.append(command)
        assert directory == tmp_path
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(engine, "run_quietly", run)
    assert engine.compile_pdf(tmp_path / "a.tex") == tmp_path / "a.pdf"
    assert any("-no-shell-escape" in word for word in ran[0])


def test_a_failed_compile_quotes_the_log(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "a.log").write_text("noise\n./a.tex:7: Undefined control sequence.\n")

    def run(command: list[str], directory: Path) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(command, 12, "", "")

    monkeypatch.setattr(engine, "run_quietly", run)
    with pytest.raises(engine.CompileError, match=r"a\.tex:7: Undefined"):
        engine.compile_pdf(tmp_path / "a.tex")
