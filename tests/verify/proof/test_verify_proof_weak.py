"""Weak solutions: conditions at a jump or corner, with speeds known from the literature."""

import json
from pathlib import Path

import pytest
import sympy as sp

from longwave.__main__ import main
from longwave.verify.problem_file import problem_texts
from longwave.verify.proof import check_certificate
from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.stored_verdict import checked_again, verdict_record
from longwave.verify.proof.text_prover import answer, prove

BURGERS = "u_t + diff(u**2/2, x)"
HOLM = "diff(u, t) - diff(u, x, x, t) + diff(3*u**2/2 + u_x**2/2, x) - diff(u**2/2, x, x, x)"
PROCESI = "diff(u, t) - diff(u, x, x, t) + diff(2*u**2, x) - diff(u**2/2, x, x, x)"
SHOCK, PEAKON = "u = (1 - sign(x - s*t))/2", "u = a*exp(-abs(x - s*t))"


@pytest.mark.parametrize(
    ("equation", "solution", "solve", "expected"),
    [
        (BURGERS, SHOCK, "s", ["s = 1/2"]),
        ("u_t + 3*diff(u**2/2, x) = 0", SHOCK, "s", ["s = 3/2"]),
        ("-u_t = diff(u**2/2, x)", SHOCK, "s", ["s = 1/2"]),
        ("u_t - (diff(u**3, x) - diff(u, x))", SHOCK, "s", ["s = 0"]),
        ("diff(u**2, t) + diff(2*u**3/3, x)", SHOCK, "s", ["s = 2/3"]),
        (BURGERS, "u = (a + b)/2 - (a - b)/2*sign(x - s*t)", "s",
         ["a = b (trivial)", "s = (a + b)/2"]),
        (HOLM, PEAKON, "s", ["a = 0 (trivial)", "s = a"]),
        (PROCESI, PEAKON, "s", ["a = 0 (trivial)", "s = a"]),
        ("u_tt - c**2*u_xx", "u = abs(x - b*t)", "b", ["b = c", "b = -c"]),
        ("u_t + diff(u**2/2, x) + u_y", "u = (1 - sign(x - s*t - 2*y))/2", "s", ["s = -3/2"]),
        ("u_t + diff(v, x) ;; v_t + diff(u, x)",
         "u = sign(x - s*t) ;; v = s*sign(x - s*t)", "s", ["s = 1", "s = -1"]),
    ],
)  # fmt: skip
def test_the_speed_of_a_jump(equation: str, solution: str, solve: str, expected: list[str]) -> None:
    verdict = prove(equation, solution, solve=solve, weak=True)
    assert verdict.outcome == "PROVED", verdict.detail
    front, _, answer = verdict.detail.partition(": holds if and only if ")
    assert front.startswith("as a weak solution across x = ")
    assert sorted(answer.split("; or ")) == sorted(expected)
    assert verdict.heading == f"PROVED {front}"
    for certificate in verdict.certificates:
        assert check_certificate(certificate)


@pytest.mark.parametrize(
    ("equation", "solution", "outcome"),
    [
        (BURGERS, "u = (1 - sign(x - t/2))/2", "PROVED"),
        (BURGERS, "u = (1 - sign(t - 2*x))/2", "PROVED"),
        (BURGERS, "u = (1 - sign(t - 3*x))/2", "REFUTED"),
        (BURGERS, "u = sign(x**2 - t)", "REFUTED"),
        (BURGERS, "u = (1 + sign(t - 2*x))/2", "PROVED"),
        (BURGERS, "u = (1 - sign(x - 3*t))/2", "REFUTED"),
        (HOLM, "u = a*exp(-abs(x - a*t))", "PROVED"),
        (HOLM, PEAKON, "REFUTED"),
        (HOLM, "u = a*exp(-2*abs(x - a*t))", "REFUTED"),
        ("u_t + c*u_x", "u = sign(x - c*t)", "PROVED"),
        ("u_t + c*u_x", "u = abs(x - c*t)*tanh(x - c*t)", "PROVED"),
        ("u_t + diff(u_x**2/2, x)", "u = sign(x)", "REFUTED"),
        ("u_t + diff(u**2/2, x) - u_xx", "u = 1 - sign(x - t)", "REFUTED"),
    ],
)
def test_a_jump_at_a_known_speed(equation: str, solution: str, outcome: str) -> None:
    verdict = prove(equation, solution, weak=True)
    assert verdict.outcome == outcome, verdict.detail
    if outcome == "PROVED":
        assert "in the sense of distributions" in verdict.assumptions[0]
        assert "nothing said" not in verdict.heading


@pytest.mark.parametrize(
    ("equation", "solution", "more", "words"),
    [
        ("u_t + u*u_x", SHOCK, {}, "must be a sum of derivatives"),
        ("u_t + x*u_x", "u = sign(x)", {}, "must be a sum of derivatives"),
        (BURGERS, "u = x/t", {}, "must jump at one plane, got none"),
        (BURGERS, "u = sign(x - t) + sign(x + t)", {}, "must jump at one plane"),
        (BURGERS, "u = sign(x**2 - 1)", {}, "must jump at one plane"),
        (BURGERS, "u = sqrt((x - t)**2)", {}, "abs and sign alone"),
        (BURGERS, "u = sign(x - t)/x", {}, "shown to be smooth"),
        (BURGERS, "u = sign(x - t)*sqrt(1 + x**2)", {}, "a side must consist of"),
        (BURGERS, "u = sign(k*x - m*t)", {}, "must jump at one plane"),
        (HOLM.replace("u_x**2/2", "u_xx"), PEAKON, {}, "first ones alone"),
        (BURGERS, SHOCK, {"domain": "x > 0", "solve": "s"}, "the domain must be left out"),
        (BURGERS, "u = sign(x - 3*t)", {"domain": "x > 1"}, "it is not decided"),
        ("u_t + c*u_x", "u = sign(x - c*t)", {"parameters": "c: complex"}, "must be real"),
        ("u_t + 2*u_x", "u = exp(-abs(x - s*t))", {"solve": "s"}, "the sides are not shown"),
    ],
)
def test_what_is_not_decided(
    equation: str, solution: str, more: dict[str, str], words: str
) -> None:
    verdict = prove(equation, solution, weak=True, **more)
    assert verdict.outcome == "UNDECIDED"
    assert words in verdict.detail


def test_the_command_and_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    given = ["prove", "--weak", "--equation", BURGERS, "--solution", SHOCK, "--solve", "s"]
    assert main(given) == 0
    printed = " ".join(capsys.readouterr().out.split())
    front = "PROVED as a weak solution across x = s*t: statement: holds if and only if s = 1/2"
    assert printed == front
    assert main([*given, "--json"]) == 0
    (record,) = json.loads(capsys.readouterr().out)
    assert (record["verdict"], record["sides"]) == ("PROVED", "as a weak solution across x = s*t")
    assert main([*given, "--latex"]) == 0
    assert "that, as a weak solution across x = t/2," in capsys.readouterr().out
    file = tmp_path / "shocks.toml"
    text = f'[[problem]]\nequation = "{BURGERS}"\nsolution = "u = 1 - sign(x - t)"\nweak = '
    file.write_text(text + "true", encoding="utf-8")
    assert main(["prove", str(file)]) == 0
    assert "as a weak solution across x = t" in " ".join(capsys.readouterr().out.split())
    file.write_text(text + '"yes"', encoding="utf-8")
    with pytest.raises(ValueError, match="weak must be true or false, got 'yes'"):
        problem_texts(file)


def test_a_verdict_on_a_weak_solution_is_not_taken_from_a_file() -> None:
    statement = read_statement(BURGERS, "u = 1 - sign(x - t)", weak=True)
    assert checked_again(statement, verdict_record(answer(statement))) is None


def test_formulas_of_sympy_are_not_taken() -> None:
    x = sp.Symbol("x")
    with pytest.raises(ValueError, match="must be left out with SymPy objects"):
        prove(sp.Function("u")(x).diff(x), x, weak=True)
