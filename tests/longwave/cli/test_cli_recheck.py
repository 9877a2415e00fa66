"""`--export` and `verify recheck`: files, tables and exit status, with mock systems."""

import json
from pathlib import Path

import pytest

from longwave.__main__ import main
from longwave.cli import recheck
from longwave.verify.proof.export.systems import SYSTEMS

TRANSPORT = ("--equation", "u_t + c*u_x", "--solution", "u = sin(x - c*t)")
SYSTEM = ("--equation", "u_x - v", "--equation", "v_x - u")
BOTH = ("--solution", "u = sinh(x + t)", "--solution", "v = cosh(x + t)")


def cardboard(folder: Path, words: str) -> None:
    """Install mock programs that give prescribed answers."""
    for system in SYSTEMS.values():
        program = folder / system.program
        program.write_text(f"#!/bin/sh\n{words}\n")
        program.chmod(0o755)


@pytest.mark.parametrize("system", SYSTEMS)
def test_a_proof_of_a_form_is_written_as_a_script(system: str, tmp_path: Path) -> None:
    file = tmp_path / "script"
    assert main(["verify", "--only", "kink", "--export", system, "--output", str(file)]) == 0
    assert "longwave: kink" in file.read_text()


def test_a_certificate_is_written_as_a_script(tmp_path: Path) -> None:
    saved, file = tmp_path / "c.json", tmp_path / "c.gp"
    assert main(["prove", *TRANSPORT, "--output", str(saved)]) == 0
    words = ["check", str(saved), "--export", "pari", "--output", str(file)]
    assert main(words) == 0
    assert file.read_text().endswith("print(answer(e)))\n")


def test_each_equation_has_its_script(tmp_path: Path) -> None:
    file = tmp_path / "s.gp"
    words = ["prove", *SYSTEM, *BOTH, "--export", "pari", "--output", str(file)]
    assert main(words) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["s_1.gp", "s_2.gp"]


def test_a_refuted_statement_has_no_script(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "s.gp"
    wrong = [*TRANSPORT[:-1], "u = sin(x + c*t)"]
    assert main(["prove", *wrong, "--export", "pari", "--output", str(file)]) == 2
    assert "no proof" in capsys.readouterr().err
    assert not file.exists()


def test_a_script_needs_a_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["verify", "--only", "kink", "--export", "coq"]) == 2
    assert "--output" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "expected", "status"),
    [("echo accepted", "accepted", 0), ("echo rejected", "rejected", 1), ("", "no answer", 0)],
)
def test_the_table_has_the_answers_of_the_systems(
    words: str,
    expected: str,
    status: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    cardboard(tmp_path, words)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    assert main(["verify", "recheck", "--only", "kink", "--json"]) == status
    (entry,) = json.loads(capsys.readouterr().out)
    assert entry["name"] == "kink"
    assert set(entry["answers"].values()) == {expected}
    assert entry["premises"][:3] == ["A > 0", "a > 0", "c > 0"]
    assert [words for words in entry["premises"] if words.endswith("is not 0")]


def test_an_accepted_script_names_its_premises(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    cardboard(tmp_path, "echo accepted")
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    assert main(["verify", "recheck", "--only", "kink"]) == 0
    message = " ".join(capsys.readouterr().out.split())
    assert "A > 0; a > 0; c > 0; 1 more" in message
    assert "accepted means proved if the premises hold" in message
    file = str(tmp_path / "kink.v")
    assert main(["verify", "--only", "kink", "--export", "coq", "--output", file]) == 0
    assert (
        "if accepted, proved provided that A > 0; a > 0; c > 0; 1 more" in capsys.readouterr().err
    )


def test_a_missing_system_is_reported_and_never_accepts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("LONGWAVE_NO_APT", "1")
    assert main(["verify", "recheck", "--only", "kink"]) == 0
    message = capsys.readouterr()
    assert "not installed: pari-gp, maxima, coq" in message.err
    assert "accepted" not in message.out


def test_an_unknown_name_is_an_error_and_installs_nothing(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(recheck, "install_systems", lambda: pytest.fail("installed first"))
    assert main(["verify", "recheck", "--only", "no such wave"]) == 2
    assert "name must be a statement or equation of the library" in capsys.readouterr().err
    assert main(["verify", "recheck", "--only", "kinck"]) == 2
    assert "(did you mean kink?)" in capsys.readouterr().err


def test_a_statement_is_accepted_only_if_all_of_its_equations_are() -> None:
    worst = recheck.worst_of
    assert worst(["accepted", "accepted"]) == "accepted"
    assert worst(["accepted", "no answer"]) == "no answer"
    assert worst(["no answer", "rejected"]) == "rejected"
    assert worst([]) == "no answer"
