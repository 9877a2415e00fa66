"""Hostile statements: a one-line answer within seconds, little memory, no code executed."""

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from longwave.__main__ import main
from tests.verify.proof.hostile_texts import FILES, generated, written

HOUSE = Path(__file__).parents[3]
SAMPLE = 60
SECONDS, MEGABYTES = 5.0, 500.0

SCRIPT = """
import difflib  # which makes a named tuple from a text
import json, re, sys, time
from pathlib import Path
from longwave.derive.algebra.formula_text import FormulaError
from searches.peak_memory import peak_bytes
from tests.verify.proof.hostile_texts import FILES, generated, written
from longwave.verify.proof.statement_text import read_statement

evaluated = []

def watch(event, arguments):
    if event in ("os.system", "subprocess.Popen", "os.exec", "socket.connect"):
        evaluated.append(event)
    if event == "compile" and arguments[1] in ("<string>", "<stdin>"):
        evaluated.append(str(arguments[0]))

texts = [*written(), *generated(300)][int(sys.argv[1])::int(sys.argv[2])]
read_statement("u_t + 6*u*u_x", "u = sin(k*x)", "k: k>0", "t > 0")
sys.addaudithook(watch)
answers = []
for given in texts:
    begun = time.process_time()
    try:
        read_statement(*given)
        said = "read"
    except FormulaError as error:
        said = str(error)
    answers.append([said, time.process_time() - begun])
memory = peak_bytes() / 1e6
print(json.dumps({"answers": answers, "evaluated": evaluated, "memory": memory}))
"""


def answered(first: int, step: int) -> dict[str, Any]:
    words = [sys.executable, "-c", SCRIPT, str(first), str(step)]
    done = subprocess.run(words, capture_output=True, text=True, cwd=HOUSE, check=True)
    assert done.stderr == ""
    return dict(json.loads(done.stdout))


def check(found: dict[str, Any]) -> None:
    assert found["evaluated"] == []
    assert found["memory"] < MEGABYTES
    for answer, seconds in found["answers"]:
        assert seconds < SECONDS, answer
        assert "\n" not in answer
        assert answer.isprintable()
        assert len(answer) < 300, answer


def test_there_are_as_many_as_are_promised() -> None:
    assert len({*written(), *generated(300)}) >= 600


@pytest.mark.slow
def test_a_sample_costs_one_line_each() -> None:
    step = len([*written(), *generated(300)]) // SAMPLE
    found = answered(7, step)
    assert len(found["answers"]) >= SAMPLE
    assert sum(seconds for _, seconds in found["answers"]) < SECONDS
    check(found)


@pytest.mark.slow
def test_all_cost_one_line_each() -> None:
    found = answered(0, 1)
    refused = [answer for answer, _ in found["answers"] if answer != "read"]
    assert len(refused) > 600
    check(found)


@pytest.mark.slow
def test_the_command_answers_a_third_of_them(capsys: pytest.CaptureFixture[str]) -> None:
    """The answer is a message with the position and status 2, or a verdict within the limit."""
    for equation, solution, parameters, domain in [*written()][::3]:
        words = ["prove", "--equation", equation, "--solution", solution, "--limit", "2", "--json"]
        words += ["--parameters", parameters] if parameters else []
        words += ["--domain", domain] if domain else []
        status = main(words)
        output = capsys.readouterr()
        if status == 2:
            assert output.out == ""
            message, *picture = output.err.splitlines()
            assert message.startswith("error: ")
            assert len(picture) in (0, 2)
            assert output.err.isascii()
        else:
            assert status in (0, 1)
            (record,) = json.loads(output.out)
            assert record["seconds"] < SECONDS


@pytest.mark.slow
def test_a_hostile_file_costs_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One file has keys with 50 000 dots, for which tomllib needs minutes and gigabytes."""
    path = tmp_path / "hostile.toml"
    for content in FILES:
        path.write_bytes(content.encode("utf-8", "surrogatepass"))
        begun = time.process_time()
        status = main(["prove", str(path), "--limit", "2", "--json"])
        assert time.process_time() - begun < SECONDS, content[:100]
        output = capsys.readouterr()
        if status == 2:
            message, *picture = output.err.splitlines()
            assert message.startswith("error: "), content[:100]
            assert len(picture) in (0, 2)
        else:
            assert status in (0, 1)
            assert json.loads(output.out)
