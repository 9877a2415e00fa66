"""The LaTeX engine: when apt is used, what is said, that shell escape stays off."""

import subprocess
from pathlib import Path

import pytest

from longwave.reports import engine


@pytest.fixture
def no_engine(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """A machine without LaTeX, with apt-get, as root; returns the commands that were run."""
    ran: list[list[str]] = []
    there = {"apt-get": "/usr/bin/apt-get"}

    def run(command: list[str], directory: Path | None = None) -> subprocess.CompletedProcess[str]:
        ran.append(command)
        if "install" in command:
            there.update(dict.fromkeys(("latexmk", "pdflatex", "kpsewhich"), "/usr/bin/found"))
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.delenv(engine.NO_APT, raising=False)
    monkeypatch.setattr(engine.shutil, "which", there.get)
    monkeypatch.setattr(engine.os, "geteuid", lambda: 0)
    monkeypatch.setattr(engine, "run_quietly", run)
    return ran


def test_it_says_so_before_it_installs(no_engine: list[list[str]]) -> None:
    said: list[str] = []

    def say(line: str) -> None:
        assert not no_engine
        said.append(line)

    engine.ensure_engine(say)
    assert len(said) == 1
    assert engine.NO_APT in said[0]
    installs = [command for command in no_engine if "install" in command]
    assert len(installs) == 1
    assert {*engine.APT_PACKAGES, f"-oDPkg::Lock::Timeout={engine.LOCKED}"} <= set(installs[0])


def test_the_environment_variable_forbids_apt(
    no_engine: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(engine.NO_APT, "1")
    with pytest.raises(engine.EngineMissingError, match="install latexmk") as caught:
        engine.ensure_engine(print)
    assert "\n" not in str(caught.value)
    assert no_engine == []


def test_without_root_sudo_must_ask_for_no_password(
    no_engine: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(engine.os, "geteuid", lambda: 1000)
    assert engine.apt_prefix() is None


def test_a_failing_apt_is_one_line(
    no_engine: list[list[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    def fails(command: list[str]) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(command, 100, "", "E: one\nE: no network")

    monkeypatch.setattr(engine, "run_quietly", fails)
    with pytest.raises(engine.EngineMissingError, match="no network"):
        engine.apt_install([])


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
