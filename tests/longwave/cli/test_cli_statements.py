"""Statements on the command line and in files: verdicts, exit statuses, limits, hostile input."""

import json
import os
import time
from collections.abc import Iterable, Iterator
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest

from longwave.__main__ import main
from longwave.cli import statements as command
from longwave.cli.statements import STAGES, decide_statements
from longwave.support.processes import LocalWorkers
from longwave.verify.problem_file import FILE_BYTES, StatedProblem, problem_texts
from longwave.verify.proof import check_certificate, prover
from longwave.verify.proof.statement_text import read_statement

Output = pytest.CaptureFixture[str]

KDV = "u_t + 6*u*u_x + u_xxx"
SOLITON, MISPRINT = "u = 2*k**2*sech(k*(x - 4*k**2*t))**2", "u = 2*k**2*sech(k*(x + 4*k**2*t))**2"
STATED = ["--equation", KDV, "--parameters", "k: k>0", "--solution"]
LOGARITHM = "u_x*(x + I) + conjugate(u) - log(x - I) - 1"
UNDECIDED = ["--equation", LOGARITHM, "--solution", "u = log(x + I)"]

FILE = f"""
[[problem]]
name = "soliton"
equation = "{KDV}"
solution = "{SOLITON}"
parameters = "k: k>0"
source = "a book"
expect = "PROVED"

[[problem]]
name = "misprint"
equation = ["{KDV}"]
solution = ["{MISPRINT}"]
parameters = "k: k>0"
expect = "REFUTED"

[[problem]]
equation = "u_x - 1"
solution = "u = sqrt(x**2)"
domain = "x > 0"
"""


def written(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize(
    ("words", "status", "verdict"),
    [
        ([*STATED, SOLITON], 0, "PROVED"),
        ([*STATED, MISPRINT], 1, "REFUTED"),
        (UNDECIDED, 1, "UNDECIDED"),
    ],
)
def test_exit_status_and_json_agree_with_the_verdict(
    words: list[str], status: int, verdict: str, capsys: Output
) -> None:
    assert main(["prove", *words, "--json"]) == status
    (record,) = json.loads(capsys.readouterr().out)
    assert record["verdict"] == verdict
    assert {"name", "reason", "witness", "seconds", "assumptions", "statement"} <= set(record)
    assert bool(record["witness"]) == (verdict == "REFUTED")
    assert bool(record["assumptions"]) == (verdict == "PROVED")
    assert record["reason"]
    assert "u_{x" in record["statement"]


def test_a_printed_refutation_has_its_witness_and_a_hint(capsys: Output) -> None:
    assert main(["prove", *STATED, MISPRINT]) == 1
    first, point, hint = capsys.readouterr().out.splitlines()
    assert first.startswith("REFUTED statement: residual ")
    assert point.startswith("    at k = ")
    right = "u = 2*k**2*sech(k*(x - 4*k**2*t))**2"
    assert hint == f"    it holds with -4*k**2*t in the place of 4*k**2*t: {right}"


def test_a_printed_proof_has_its_scope_and_its_poles(capsys: Output) -> None:
    assert main(["prove", "--equation", "u_x*x + u", "--solution", "u = a/x"]) == 0
    assert capsys.readouterr().out.splitlines() == [
        "PROVED statement: for all real a, x, wherever the formulas are smooth",
        "    possibly not smooth: pole where x = 0",
    ]


def test_options_may_be_repeated_and_begin_with_a_sign(capsys: Output) -> None:
    words = ["--equation", "-u_t + v_x", "--equation", "v_t - u_x = 0"]
    words += ["--solution", "u = x + t", "--solution", "v = x + t", "--domain", "t > 0; x > t"]
    assert main(["prove", *words]) == 0
    assert "t > 0, x > t" in capsys.readouterr().out


def test_a_file_is_decided_in_order_and_compared_with_what_it_expects(
    tmp_path: Path, capsys: Output
) -> None:
    path = written(tmp_path, FILE)
    assert main(["prove", path, "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [r["name"] for r in records] == ["soliton", "misprint", "mine 3"]
    assert [r["verdict"] for r in records] == ["PROVED", "REFUTED", "PROVED"]
    assert [r.get("source") for r in records] == ["a book", None, None]
    assert main(["prove", path]) == 0
    assert capsys.readouterr().out.endswith(": 2 proved exactly; 1 refuted\n")
    wrong = written(tmp_path, FILE.replace('expect = "REFUTED"', 'expect = "UNDECIDED"'))
    assert main(["prove", wrong]) == 1
    assert "    expected was UNDECIDED\n" in capsys.readouterr().out


def test_without_an_expectation_only_a_proof_has_status_0(tmp_path: Path, capsys: Output) -> None:
    assert main(["prove", written(tmp_path, FILE.replace('expect = "REFUTED"', ""))]) == 1
    capsys.readouterr()


def test_certificates_are_written_and_can_be_checked(tmp_path: Path, capsys: Output) -> None:
    saved = tmp_path / "c.json"
    assert main(["prove", written(tmp_path, FILE), "--output", str(saved)]) == 0
    assert [check_certificate(c) != "" for c in json.loads(saved.read_text("utf-8"))] == [
        True,
        True,
    ]
    capsys.readouterr()
    assert main(["check", str(saved)]) == 0
    assert capsys.readouterr().out.count(": accepted\n") == 2


def test_the_latex_is_a_sentence_with_the_digest_of_the_certificate(
    tmp_path: Path, capsys: Output
) -> None:
    saved = tmp_path / "c.json"
    assert main(["prove", *STATED, SOLITON, "--latex", "--output", str(saved)]) == 0
    sentence = capsys.readouterr().out
    (certificate,) = json.loads(saved.read_text("utf-8"))
    assert f"certificate \\texttt{{{certificate['digest'][:16]}}}" in sentence
    assert "\\[ u_{t} + 6 u u_{x} + u_{xxx} = 0 \\]" in sentence
    assert main(["prove", *STATED, MISPRINT, "--latex"]) == 1
    assert "does not satisfy" in capsys.readouterr().out
    assert main(["prove", *UNDECIDED, "--latex"]) == 1
    assert capsys.readouterr().out.startswith("% statement: UNDECIDED: ")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            ["--equation", KDV],
            "--equation must be given with --solution and no file, got no --solution",
        ),
        (["--solution", SOLITON], "got no --equation"),
        ([*STATED, SOLITON, "a.toml"], "got a.toml as well"),
        (["a.toml", "kink"], "FILE must end in .toml, got kink (a closed form: longwave verify"),
        (["a.toml", "--domain", "t > 0"], "--domain must not be given with a FILE.toml, got both"),
        (["a.toml", "--parameters", "k: k>0"], "--parameters must not be given with a FILE.toml"),
        (["a.toml", "--json", "--latex"], "--json must not be given with --latex, got both"),
        (["--limit", "3"], "--equation or FILE.toml must be given, got neither"),
        ([*STATED, SOLITON, "--export", "coq"], "--export must be given with --output FILE"),
        ([*STATED, SOLITON, "--export", "coq", "--solve", "k"], "--solve must not be given with"),
        ([*STATED, SOLITON, "--limit", "0"], "--limit must be 0.01 to 1e+06 seconds, got 0"),
        ([*STATED, SOLITON, "--limit", "nan"], "--limit must be 0.01 to 1e+06 seconds, got nan"),
        ([*STATED, SOLITON, "--limit", "x"], "'x' is not a valid float"),
        (["nowhere.toml"], "nowhere.toml"),
        ([*STATED, SOLITON, "--output", "/nowhere/c.json"], "/nowhere/c.json"),
    ],
)
def test_wrong_options_are_one_line_and_status_2(
    words: list[str], message: str, capsys: Output
) -> None:
    assert main(["prove", *words]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("error: ")
    assert output.err.count("\n") == 1
    assert message in output.err


def test_a_wrong_formula_is_printed_with_a_marker(capsys: Output) -> None:
    assert main(["prove", *STATED, "u = 2*k**2*sehc(k*x)"]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.splitlines() == [
        "error: solution: expected a known function, got 'sehc' (did you mean sech?);"
        " write 'u = 2*k**2*sech(k*x)' (column 12)",
        "    u = 2*k**2*sehc(k*x)",
        "               ^",
    ]


TABLE = '[[problem]]\nequation = "u_x - 1"\nsolution = "u = x"\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "must hold [[problem]] tables and nothing else, got nothing"),
        ("[problem]\nx = 1", "must hold [[problem]] tables and nothing else"),
        (TABLE + "[other]\n", "must hold [[problem]] tables and nothing else, got 'problem', 'ot"),
        ("problem = [1]", "problem 1 must be a table, got 1"),
        ("x = ", "problem file must be a TOML file, got"),
        ("x = " + "[" * 100_000, "problem file must be nested at most 100 deep, got"),
        (
            TABLE + "solutoin = 1",
            "problem 1: keys must be known ones, got 'solutoin' (did",
        ),
        (TABLE.replace("equation", "name"), "problem 1: equation must be text or a list"),
        (
            TABLE.replace('"u = x"', "3"),
            "problem 1: solution must be text or a list of texts, got 3",
        ),
        (TABLE.replace('"u = x"', "[]"), "problem 1: solution must be text or a list of texts"),
        (TABLE + "domain = 3", "problem 1: domain must be text, got 3"),
        (TABLE + 'name = "a\\u0000b"', "problem 1: name must be one printable line"),
        (TABLE + 'expect = "TRUE"', "problem 1: expect must be one of PROVED, REFUTED, UNDECIDED"),
        (TABLE + 'expect = "proved"', "problem 1: expect must be one of PROVED, REFUTED, UNDEC"),
        (TABLE + TABLE.replace("u = x", "u = y*"), "problem 2 (mine 2): solution: expected a num"),
        (TABLE.replace("u = x", "u = \\u0445"), "problem 1 (mine 1): solution: expected a formula"),
    ],
)
def test_a_wrong_file_names_the_problem_and_the_key(
    text: str, message: str, tmp_path: Path, capsys: Output
) -> None:
    assert main(["prove", written(tmp_path, text)]) == 2
    error = capsys.readouterr().err
    assert message in error.splitlines()[0]
    assert len(error.splitlines()) in (1, 3, 4)


def test_a_file_that_is_not_there_is_named(capsys: Output) -> None:
    assert main(["prove", "nowhere.toml"]) == 2
    assert capsys.readouterr().err.startswith(
        "error: FILE.toml must be usable, got nowhere.toml: No such file or directory (check the"
    )


def test_a_file_that_is_too_long_or_not_text_is_refused(tmp_path: Path, capsys: Output) -> None:
    for content, message in (
        (b"#" * (FILE_BYTES + 1), "must have at most"),
        (b"\xff\xfe", "problem file must be a text in UTF-8, got"),
    ):
        path = tmp_path / "mine.toml"
        path.write_bytes(content)
        assert main(["prove", str(path)]) == 2
        error = capsys.readouterr().err
        assert message in error
        assert error.count("\n") == 1


def problem(
    equation: str = "u_x - 1", solution: str = "u = x", name: str = "mine"
) -> StatedProblem:
    return StatedProblem(read_statement(equation, solution, name=name))


PATIENCE = 60.0
"""Seconds in which even a loaded machine ends what would go on for ever."""


def slow(_: Any, tell: Any) -> Any:
    tell("equation 1 of 3")
    while True:
        time.sleep(0.01)


@pytest.mark.slow
def test_a_statement_past_its_limit_is_undecided_with_its_last_stage(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def find_witness(*given: Any) -> Any:
        return slow(*given)

    monkeypatch.setattr(command, "answer", find_witness)
    begun = time.monotonic()
    ((_, verdict),) = decide_statements([problem()], 1.0)
    assert time.monotonic() - begun < PATIENCE
    assert verdict.outcome == "UNDECIDED"
    expected = "last stage: equation 1 of 3, looking for a counterexample"
    assert verdict.detail == f"no verdict within 1 s ({expected})"


def test_the_stages_are_functions_of_the_prover() -> None:
    for name in STAGES:
        assert hasattr(prover, name), name


@pytest.mark.slow
def test_an_unresponsive_process_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    def deaf(_: Any, tell: Any) -> Any:
        tell("equation 2 of 2")
        while True:
            try:
                time.sleep(10)
            except BaseException:
                continue

    monkeypatch.setattr(command, "answer", deaf)
    monkeypatch.setattr(command, "GRACE_SECONDS", 0.2)
    begun = time.monotonic()
    verdicts = dict(decide_statements([problem(), problem()], 1.0))
    assert time.monotonic() - begun < PATIENCE
    expected = "no verdict within 1 s (last stage: equation 2 of 2)"
    assert [verdicts[place].detail for place in (0, 1)] == [expected] * 2


def test_a_crash_costs_its_own_statement_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = command.answer

    def fragile(statement: Any, tell: Any) -> Any:
        if statement.name == "dies":
            os._exit(9)
        if statement.name == "raises":
            raise KeyError("a\nb")
        if statement.name == "swells":
            bytearray(10 * command.MOST_MEMORY)
        return whole(statement, tell)

    monkeypatch.setattr(command, "answer", fragile)
    given = [problem(name=name) for name in ("dies", "raises", "swells", "mine")]
    verdicts = dict(decide_statements(given, 30.0))
    assert [verdicts[place].outcome for place in range(4)] == [*["UNDECIDED"] * 3, "PROVED"]
    assert verdicts[0].detail == "the process broke off (last stage: start)"
    assert verdicts[1].detail.startswith("the prover failed (KeyError: ")
    assert verdicts[2].detail == "no verdict within 2000 MB of memory"


@pytest.mark.slow
def test_a_refutation_stays_if_the_search_for_a_hint_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    def hang(*_: Any) -> Any:
        while True:
            time.sleep(0.01)

    monkeypatch.setattr(command, "with_hint", hang)
    monkeypatch.setattr(command, "HINT_SECONDS", 0.3)
    ((_, verdict),) = decide_statements([problem("u_x - 2")], 30.0)
    assert verdict.outcome == "REFUTED"


def test_four_processes_decide_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each process waits until all have started."""
    whole, all_here = command.answer, get_context("fork").Barrier(4)

    def waiting(statement: Any, tell: Any) -> Any:
        all_here.wait(PATIENCE)
        return whole(statement, tell)

    monkeypatch.setattr(command, "answer", waiting)
    verdicts = dict(
        decide_statements([problem()] * 4, 2 * PATIENCE, workers=LocalWorkers(4, isolated=True))
    )
    assert [verdicts[place].outcome for place in range(4)] == ["PROVED"] * 4


def test_there_is_no_hint_without_time_for_it() -> None:
    given = [problem(KDV, MISPRINT)]
    (hinted,) = (verdict for _, verdict in decide_statements(given, 30.0))
    (bare,) = (verdict for _, verdict in decide_statements(given, 30.0, hinting=0.0))
    assert hinted.hint
    assert (bare.outcome, bare.hint) == (hinted.outcome, "")


def test_ctrl_c_prints_what_is_decided(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Output
) -> None:
    whole = command.decide_statements

    def stopped(problems: Any, limit: float, **_: float) -> Any:
        yield from whole(problems[:1], limit)
        raise KeyboardInterrupt

    monkeypatch.setattr(command, "decide_statements", stopped)
    assert main(["prove", written(tmp_path, FILE)]) == 130
    output = capsys.readouterr()
    assert output.out.startswith("PROVED soliton: ")
    assert output.err == "longwave prove: interrupted (after 1 of 3 statements)\n"


def test_the_time_for_reading_is_announced_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The library's formulas take seconds to read, which once showed no progress."""
    shown: list[tuple[str, int]] = []

    def tracked(items: Iterable[Any], count: int, words: str) -> Iterator[Any]:
        shown.append((words, count))
        yield from items

    monkeypatch.setattr(command, "tracked", tracked)
    assert main(["prove", written(tmp_path, FILE)]) == 0
    assert shown == [("reading", 3), ("deciding", 3)]


def test_problems_are_read_without_deciding(tmp_path: Path) -> None:
    problems = [text.problem() for text in problem_texts(Path(written(tmp_path, FILE)))]
    assert [p.expect for p in problems] == ["PROVED", "REFUTED", ""]
    assert [p.statement.name for p in problems] == ["soliton", "misprint", "mine 3"]


def test_long_work_is_announced_once(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(command, "SECONDS_BEFORE_NOTICE", 0.0)
    words = ["prove", "--equation", "u_t + u_x", "--solution", "u = sin(x - t)", "--limit", "30"]
    assert main(words) == 0
    announced = "1 statement to be decided: at most 30 s more (Ctrl-C stops it)\n"
    assert capsys.readouterr().err == announced
