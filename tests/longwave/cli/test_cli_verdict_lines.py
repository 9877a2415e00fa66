"""Many statements: unreadable ones, and verdicts that later runs reuse."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from longwave.__main__ import main
from longwave.cli import statements
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import decide_statement
from longwave.verify.proof.stored_verdict import FROM_FILE, checked_again, verdict_record

Output = pytest.CaptureFixture[str]

RIGHT = 'equation = "u_x - 1"\nsolution = "u = x"'
WRONG = 'equation = "u_x - 1"\nsolution = "u = 2*x"'
OPEN = 'equation = "u_x*(x + I) + conjugate(u) - log(x - I) - 1"\nsolution = "u = log(x + I)"'
UNREADABLE = 'equation = "u_x - 1"\nsolution = "u = 2*/x"'


def written(folder: Path, *problems: str) -> str:
    path = folder / "mine.toml"
    path.write_text("\n".join(f"[[problem]]\n{text}" for text in problems), encoding="utf-8")
    return str(path)


def test_all_unreadable_statements_are_named_at_once(tmp_path: Path, capsys: Output) -> None:
    file = written(tmp_path, UNREADABLE, RIGHT, UNREADABLE)
    assert main(["prove", file]) == 2
    out, err = capsys.readouterr()
    assert not out
    assert "problem 1" in err
    assert "problem 3" in err
    assert err.count("^") == 2
    assert "2 of 3 statements cannot be read" in err
    assert "--keep-going" in err


def test_the_others_are_decided_and_the_unreadable_are_never_true_or_false(
    tmp_path: Path, capsys: Output
) -> None:
    file = written(tmp_path, UNREADABLE, RIGHT)
    assert main(["prove", file, "--keep-going", "--json"]) == 1
    unreadable, proved = json.loads(capsys.readouterr().out)
    assert [unreadable["verdict"], proved["verdict"]] == ["UNREADABLE", "PROVED"]
    assert "problem 1" in unreadable["reason"]
    assert "column" in unreadable["reason"]
    assert main(["prove", file, "--keep-going"]) == 1
    assert "1 unreadable" in capsys.readouterr().out
    assert main(["prove", file, "--keep-going", "--latex"]) == 1
    assert capsys.readouterr().out.startswith("% mine 1: UNREADABLE")


@pytest.fixture
def decided(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Return the list to which the names of newly decided statements are appended."""
    names: list[str] = []
    decide = statements.decide_statements

    def counted(problems: Any, *args: Any, **options: Any) -> Any:
        names.extend(problem.statement.name for problem in problems)
        return decide(problems, *args, **options)

    monkeypatch.setattr(statements, "decide_statements", counted)
    return names


def plain(verdict: dict[str, Any]) -> dict[str, Any]:
    """Return a verdict without the entries that differ between runs."""
    return verdict | {"seconds": 0.0, "reason": verdict["reason"].removeprefix(FROM_FILE)}


def test_an_interrupted_run_is_resumed_from_its_verdicts(
    tmp_path: Path, capsys: Output, decided: list[str]
) -> None:
    """Catches: a line truncated by a kill, and verdicts that the next run does not find."""
    file, lines = written(tmp_path, RIGHT, WRONG, OPEN), tmp_path / "verdicts.jsonl"
    words = ["prove", file, "--json", "--lines", str(lines)]
    assert main(words) == 1
    first = json.loads(capsys.readouterr().out)
    assert main(words) == 1
    assert [plain(one) for one in json.loads(capsys.readouterr().out)] == [*map(plain, first)]
    assert decided == ["mine 1", "mine 2", "mine 3"]
    lines.write_text(lines.read_text(encoding="utf-8")[:-20], encoding="utf-8")
    assert main(words) == 1
    found = json.loads(capsys.readouterr().out)
    assert [one["verdict"] for one in found] == [one["verdict"] for one in first]
    assert len(decided) == 4
    assert main(words) == 1
    assert len(decided) == 4
    assert main([*words, "--limit", "30"]) == 1
    assert len(decided) == 7


def forged_outcome(records: dict[str, Any]) -> None:
    records["mine 2"] |= {"verdict": "PROVED", "witness": None}


def forged_certificate(records: dict[str, Any]) -> None:
    records["mine 2"] |= {"verdict": "PROVED", "certificates": records["mine 1"]["certificates"]}


def forged_refutation(records: dict[str, Any]) -> None:
    records["mine 1"] |= {"verdict": "REFUTED", "witness": {"x": "1"}, "certificates": []}


@pytest.mark.parametrize("forge", [forged_outcome, forged_certificate, forged_refutation])
def test_a_forged_verdict_is_not_believed(
    forge: Callable[[dict[str, Any]], None], tmp_path: Path, capsys: Output
) -> None:
    file, lines = written(tmp_path, RIGHT, WRONG), tmp_path / "verdicts.jsonl"
    words = ["prove", file, "--json", "--lines", str(lines)]
    main(words)
    records = {r["name"]: r for r in map(json.loads, lines.read_text().splitlines())}
    forge(records)
    lines.write_text("".join(json.dumps(one) + "\n" for one in records.values()))
    capsys.readouterr()
    assert main(words) == 1
    found = json.loads(capsys.readouterr().out)
    assert [one["verdict"] for one in found] == ["PROVED", "REFUTED"]


def test_other_files_are_left_alone(tmp_path: Path, capsys: Output) -> None:
    file = written(tmp_path, RIGHT)
    before = Path(file).read_text(encoding="utf-8")
    assert main(["prove", file, "--lines", file]) == 2
    assert "file of verdicts" in capsys.readouterr().err
    assert Path(file).read_text(encoding="utf-8") == before
    lines = tmp_path / "verdicts.jsonl"
    lines.touch()
    lines.chmod(0o666)
    assert main(["prove", file, "--lines", str(lines)]) == 2
    assert "nobody else may write" in capsys.readouterr().err


LIES: dict[str, Any] = {
    "reason": "solved for good",
    "hint": "it holds with 7*x in the place of x",
    "seconds": 1e9,
    "assumptions": ["for all complex x"],
    "singularities": ["a lie"],
    "statement": "u = 7",
    "equation": "u = 7",
}


def test_texts_from_the_verdict_file_are_not_shown(tmp_path: Path, capsys: Output) -> None:
    """Catches: a scope, a reason, a hint or positions that come from the file of verdicts."""
    file, lines = written(tmp_path, RIGHT, WRONG, OPEN), tmp_path / "verdicts.jsonl"
    words = ["prove", file, "--lines", str(lines)]
    main([*words, "--json"])
    right = json.loads(capsys.readouterr().out)
    assert right[1]["hint"]
    records = [json.loads(line) | LIES for line in lines.read_text().splitlines()]
    lines.write_text("".join(json.dumps(one) + "\n" for one in records))
    assert main([*words, "--json"]) == 1
    proved, refuted, undecided = json.loads(capsys.readouterr().out)
    assert (plain(proved), plain(refuted)) == (plain(right[0]), plain(right[1]))
    assert undecided["reason"] == f"{FROM_FILE}solved for good"
    assert undecided["seconds"] < 100
    main(words)
    assert "7*x" not in capsys.readouterr().out


def test_a_hint_of_another_statement_is_not_shown(tmp_path: Path, capsys: Output) -> None:
    other = RIGHT.replace("1", "3").replace("= x", "= 3*x")
    file, lines = written(tmp_path, other, WRONG), tmp_path / "verdicts.jsonl"
    words = ["prove", file, "--lines", str(lines), "--json"]
    main(words)
    capsys.readouterr()
    proved, refuted = (json.loads(line) for line in lines.read_text().splitlines())
    refuted["hint_certificates"] = proved["certificates"]
    lines.write_text("".join(json.dumps(one) + "\n" for one in (proved, refuted)))
    assert main(words) == 1
    assert json.loads(capsys.readouterr().out)[1]["hint"] == ""


def test_complex_witnesses_and_functions_are_checked_again() -> None:
    for texts in [
        ("u_x - c*u", "u = exp(abs(c)*x)", "c: complex"),
        ("u_tt - c*u_xx", "u = f(x - c*t)", "f: function"),
    ]:
        statement = read_statement(*texts)
        verdict = decide_statement(statement)
        assert verdict.outcome == "REFUTED", verdict.detail
        again = checked_again(statement, json.loads(json.dumps(verdict_record(verdict))))
        assert again is not None
        assert (again.detail, again.witness) == (verdict.detail, verdict.witness)
        moved = dict.fromkeys(verdict.witness or {}, "x + I")
        assert checked_again(statement, verdict_record(verdict) | {"witness": moved}) is None
