"""`longwave prove --solve`: text, JSON, LaTeX, problem files, certificates and limits."""

import json
from pathlib import Path

import pytest

from longwave.__main__ import main
from longwave.verify.problem_file import problem_texts

Output = pytest.CaptureFixture[str]

KDV = ["--equation", "u_t + 6*u*u_x + u_xxx", "--solution", "u = a*sech(k*(x - c*t))**2"]

FILE = """
[[problem]]
name = "speed"
equation = "u_t + 6*u*u_x + u_xxx"
solution = "u = a*sech(k*(x - c*t))**2"
parameters = "k: k>0; a: a>0"
solve = "c, a"
expect = "PROVED"

[[problem]]
name = "none"
variant_of = "speed"
solution = "u = a*sech(k*(x - c*t))"
solve = "c"
expect = "REFUTED"
"""


def test_each_case_has_a_line_and_a_proof_has_status_0(capsys: Output) -> None:
    assert main(["prove", *KDV, "--parameters", "k: k>0", "--solve", "c,a"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "PROVED statement: holds if and only if",
        "    c = 4*k**2, a = 2*k**2",
        "    a = 0 (trivial)",
    ]


def test_no_admissible_value_has_status_1_and_a_witness(capsys: Output) -> None:
    assert main(["prove", *KDV, "--parameters", "k: k>0; a: a<0", "--solve", "c,a"]) == 1
    first, point = capsys.readouterr().out.splitlines()
    assert first == "REFUTED statement: holds for no value of c, a"
    assert point.startswith("    at a = -")


def test_files_have_names_to_solve_for_and_their_proofs_are_written(
    tmp_path: Path, capsys: Output
) -> None:
    path, proofs = tmp_path / "mine.toml", tmp_path / "proofs.json"
    path.write_text(FILE, encoding="utf-8")
    assert [str(text.problem().statement.solve_for) for text in problem_texts(path)] == [
        "(c, a)",
        "(c,)",
    ]
    assert main(["prove", str(path), "--output", str(proofs)]) == 0
    text = capsys.readouterr().out
    assert "PROVED speed: holds if and only if c = 4*k**2, a = 2*k**2\n" in text
    assert "REFUTED none: holds for no value of c\n" in text
    assert main(["check", str(proofs)]) == 0
    assert "speed: accepted" in capsys.readouterr().out
    assert main(["prove", str(path), "--json"]) == 0
    first, second = json.loads(capsys.readouterr().out)
    assert first["cases"][0]["values"] == {"c": "4*k**2", "a": "2*k**2"}
    assert first["cases"][0]["assumptions"][0].startswith("for all real k, t, x with k > 0")
    assert (second["cases"], second["complete"]) == ([], True)


def test_the_sentences_say_whether_there_are_others(capsys: Output) -> None:
    main(["prove", *KDV, "--solve", "c,a", "--latex", "--parameters", "k: k>0; a: a>0"])
    assert capsys.readouterr().out.endswith(
        "There are no other values of $c, a$ with which it does.\n"
    )
    main(["prove", *KDV, "--solve", "c", "--latex", "--parameters", "a: a<0; k: k>0"])
    assert capsys.readouterr().out == "There are no values of $c$ with which it holds.\n"


def test_a_wrong_name_is_shown_and_status_2(capsys: Output) -> None:
    assert main(["prove", *KDV, "--solve", "c,q"]) == 2
    assert capsys.readouterr().err.splitlines() == [
        "error: solve: expected a parameter (a, k, c), got 'q' (column 3)",
        "    c,q",
        "      ^",
    ]
    assert main(["prove", *KDV, "--solve", "c," * 100_000]) == 2
    assert len(capsys.readouterr().err) < 400


def test_past_the_limit_it_is_undecided(capsys: Output) -> None:
    assert main(["prove", *KDV, "--solve", "c", "--limit", "0.01"]) == 1
    assert "UNDECIDED statement: no verdict within 0.01 s" in capsys.readouterr().out
